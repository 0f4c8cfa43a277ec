"""Cameras: what they project, where they stand, pictures of real and synthetic ones."""
