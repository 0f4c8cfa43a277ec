"""Kinematics that are learned from what cameras see, and arms that are calibrated by it."""
