"""Distances by closed forms, which share nothing with the code that is tried."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from assistant.base.arrays import Floats


def segments(a: Floats, b: Floats, c: Floats, d: Floats) -> float:
    """The distance of the segments from a to b and from c to d.

    The least of where both lines are nearest, if that lies on both, and of the ends.
    """
    u, v, w = b - a, d - c, a - c
    uu, uv, vv = u @ u, u @ v, v @ v
    det = uu * vv - uv * uv
    found = [point_segment(p, c, d) for p in (a, b)] + [point_segment(p, a, b) for p in (c, d)]
    if det > 1e-12 * uu * vv:
        s, t = (uv * (v @ w) - vv * (u @ w)) / det, (uu * (v @ w) - uv * (u @ w)) / det
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            found.append(float(np.linalg.norm(w + s * u - t * v)))
    return min(found)


def point_segment(p: Floats, a: Floats, b: Floats) -> float:
    way = b - a
    part = np.clip((p - a) @ way / (way @ way), 0.0, 1.0)
    return float(np.linalg.norm(p - a - part * way))


def point_box(p: Floats, half: Floats) -> float:
    """Of a point outside a box about the origin."""
    return float(np.linalg.norm(np.maximum(np.abs(p) - half, 0.0)))


def segment_box(a: Floats, b: Floats, half: Floats) -> float:
    """Of a segment that does not enter a box about the origin.

    Between two places where the segment passes a plane of a face the square of the distance is one
    parabola, whose lowest point is its own or at an end.
    """
    way = b - a
    with np.errstate(divide="ignore", invalid="ignore"):
        cuts = np.concatenate([(half - a) / way, (-half - a) / way])
    parts = np.concatenate([[0.0, 1.0], cuts[(cuts > 0.0) & (cuts < 1.0)]])
    parts.sort()
    best = min(point_box(a + t * way, half) for t in parts)
    for low, high in pairwise(parts):
        middle = a + (low + high) / 2.0 * way
        side = np.where(np.abs(middle) > half, np.sign(middle), 0.0)
        rate, off = way * np.abs(side), (a - side * half) * np.abs(side)
        if rate @ rate > 0.0:
            t = np.clip(-(rate @ off) / (rate @ rate), low, high)
            best = min(best, point_box(a + t * way, half))
    return best
