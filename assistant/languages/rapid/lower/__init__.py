"""From the pseudo-program to the typed tree of RAPID."""
