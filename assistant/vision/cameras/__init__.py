"""Cameras: projection, files, calibration, and pictures of real and synthetic ones."""
