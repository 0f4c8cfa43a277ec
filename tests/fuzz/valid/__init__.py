"""Programs that are valid by the rules of their makers, drawn anew for each seed."""
