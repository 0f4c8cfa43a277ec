"""From the typed trees of RAPID to the pseudo-program."""
