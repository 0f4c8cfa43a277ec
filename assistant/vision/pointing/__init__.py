"""Pointing devices: a ball, a light or a wand that cameras locate, and what is shown with them."""
