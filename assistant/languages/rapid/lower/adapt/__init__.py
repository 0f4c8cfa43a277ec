"""The pseudo-program as RAPID can say it, with a finding for each change."""
