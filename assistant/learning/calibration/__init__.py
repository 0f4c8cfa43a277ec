"""Calibration of arms: small errors of lengths, zeros and base from measured poses."""
