"""Pointing devices that cameras locate: a ball, a light or a wand, and demonstrations with them."""
