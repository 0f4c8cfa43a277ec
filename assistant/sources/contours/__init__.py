"""Contours of drawings: chained, ordered and followed as their layers say."""
