"""Calibration of cameras: lens, two cameras to each other, camera and arm."""
