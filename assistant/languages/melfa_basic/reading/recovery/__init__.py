"""Lines that are no MELFA-BASIC: what was meant, what is wrong, and what to do."""
