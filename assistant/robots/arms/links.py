"""Geometry that the closed forms share."""

from __future__ import annotations

import numpy as np

from assistant.base.arrays import Floats


def zyz(first: Floats, second: Floats, third: Floats) -> Floats:
    """(..., 4) quaternions of Rz(first)·Ry(second)·Rz(third), radians."""
    plus, minus, half = (first + third) / 2.0, (first - third) / 2.0, second / 2.0
    c, s = np.cos(half), np.sin(half)
    return np.stack([c * np.cos(plus), -s * np.sin(minus), s * np.cos(minus), c * np.sin(plus)], -1)


def axis_z(quaternions: Floats) -> tuple[Floats, Floats, Floats]:
    """The flange's own z axis, (n,) a component."""
    w, x, y, z = quaternions.T
    return 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)


def two_links(upper: float, fore: float, distance: Floats) -> tuple[Floats, Floats]:
    """Angles at the elbow and between upper link and line to the wrist, radians, both >= 0.

    Out of reach the arm is stretched or folded towards the wrist.
    """
    cosine = (distance * distance - upper * upper - fore * fore) / (2.0 * upper * fore)
    elbow = np.arccos(np.clip(cosine, -1.0, 1.0))
    return elbow, np.arctan2(fore * np.sin(elbow), upper + fore * np.cos(elbow))


def reach_excess(upper: float, fore: float, distance: Floats) -> Floats:
    """How many mm a wrist at that distance from axis 2 is too far or too near, else 0."""
    far, near = distance - (upper + fore), abs(upper - fore) - distance
    return np.maximum(np.maximum(far, near), 0.0)
