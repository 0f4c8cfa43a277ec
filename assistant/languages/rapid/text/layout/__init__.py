"""The one layout of RAPID texts: tokens, what stands on a line, blanks, indentation."""
