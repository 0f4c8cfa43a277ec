"""The pseudo-program as MELFA-BASIC can say it, with a finding for each change."""
