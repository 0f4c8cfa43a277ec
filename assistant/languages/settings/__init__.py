"""Settings that are statements of their own: what holds at each line, and what follows from it."""
