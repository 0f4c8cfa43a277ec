"""A, B, C of a pose in radians and quaternions, a pose at a time: R = Rz(C) Ry(B) Rx(A).

The loop converts one pose a cycle, which plain numbers do several times faster than arrays.
"""

from __future__ import annotations

from math import asin, atan2, copysign, cos, pi, sin, sqrt


def quaternion_of_angles(a: float, b: float, c: float) -> tuple[float, float, float, float]:
    """(w, x, y, z), w not below 0."""
    ca, sa, cb, sb = cos(a / 2), sin(a / 2), cos(b / 2), sin(b / 2)
    cc, sc = cos(c / 2), sin(c / 2)
    w = ca * cb * cc + sa * sb * sc
    x = sa * cb * cc - ca * sb * sc
    y = ca * sb * cc + sa * cb * sc
    z = ca * cb * sc - sa * sb * cc
    return (w, x, y, z) if w >= 0.0 else (-w, -x, -y, -z)


def angles_of_quaternion(w: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A, B, C in radians; where B is a quarter turn, A is all of what A and C turn together."""
    size = sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / size, x / size, y / size, z / size
    sine = 2.0 * (w * y - z * x)
    if abs(sine) > 1.0 - 1e-12:
        b = copysign(pi / 2, sine)
        return 2.0 * atan2(x, w), b, 0.0
    a = atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    c = atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return a, asin(max(-1.0, min(1.0, sine))), c
