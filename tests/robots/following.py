"""Every branch of an arm along a way, followed densely.

Shares nothing with what looks at ways in the program but the closed form of single poses.
"""

from __future__ import annotations

import numpy as np

from assistant.base import rotations

PLACES = 3000


def poses(start, end, part, via=None):
    """Positions (m, 3) and quaternions (m, 4) of a line, or of an arc through a via point.

    start, end: position and quaternion. The tool turns evenly, about one axis.
    """
    (p0, q0), (p1, q1) = start, end
    if via is None:
        p = p0 + part[:, None] * (p1 - p0)
    else:
        a, b = via - p0, p1 - p0
        normal = np.cross(a, b)
        centre = p0 + np.cross(a @ a * b - b @ b * a, normal) / (2.0 * normal @ normal)
        x = p0 - centre
        y = np.cross(normal / np.linalg.norm(normal), x)
        sweep = np.arctan2((p1 - centre) @ y, (p1 - centre) @ x) % (2.0 * np.pi)
        p = centre + np.cos(sweep * part)[:, None] * x + np.sin(sweep * part)[:, None] * y
    if q0 @ q1 < 0.0:
        q1 = -q1
    turn = rotations.multiply(rotations.conjugate(q0), q1)
    half = np.arctan2(np.linalg.norm(turn[1:]), turn[0])
    axis = turn[1:] / max(np.linalg.norm(turn[1:]), 1e-12)
    local = np.hstack([np.cos(half * part)[:, None], np.sin(half * part)[:, None] * axis])
    return p, rotations.multiply(q0, local)


def turning_point(start, via, end):
    """Which part of an arc is behind its via point."""
    a, b = via - start, end - start
    normal = np.cross(a, b)
    centre = start + np.cross(a @ a * b - b @ b * a, normal) / (2.0 * normal @ normal)
    x = start - centre
    y = np.cross(normal / np.linalg.norm(normal), x)
    first, last = (
        np.arctan2((p - centre) @ y, (p - centre) @ x) % (2.0 * np.pi) for p in (via, end)
    )
    return float(first / last)


def followed(arm, start, end, via=None):
    """What each branch comes to that can be had at the start: (k, 2).

    By how many degrees or mm an axis goes beyond its limits at most, in the turns that suit the
    whole way best, infinite where the way ends; and the least angle of axis 5.
    """
    p, q = poses(start, end, np.linspace(0.0, 1.0, PLACES + 1), via)
    joints, excess = arm.solve(p, rotations.canonical(q))
    low, high = arm.limits.T
    out = []
    for branch in range(joints.shape[1]):
        way = joints[:, branch].copy()
        for axis in arm.winding():
            way[axis] = np.unwrap(way[axis], period=360.0)
        turns = 360.0 * np.arange(-3, 4)
        least, most = way.min(axis=1), way.max(axis=1)
        beyond = [
            np.maximum(low[a] - (least[a] + t), most[a] + t - high[a]).min()
            for a, t in ((a, turns if a in arm.winding() else np.zeros(1)) for a in range(len(way)))
        ]
        bend = np.abs(way[4]).min() if arm.arm.spherical else np.inf
        short = excess[branch].max() > 1e-5
        out.append((np.inf if short else max(beyond), bend))
    return np.array(out)
