"""Lines and runs of lines as statements of the pseudo-program."""
