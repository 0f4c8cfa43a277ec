"""Arms are calibrated: small errors of lengths, zeros and base out of measured poses."""
