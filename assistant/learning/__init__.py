"""Learning: kinematics from pictures, and the calibration of arms from measured poses."""
