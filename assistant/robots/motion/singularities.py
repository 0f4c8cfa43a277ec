"""Singularities: moves straight through that of the wrist, and the distance of an arm from any.

With axes 4 and 6 in line the two wrist branches meet. A linear move through that point takes axis 5
through 0 and leaves axis 4 where it is, which changes the branch from no flip to flip; to keep the
branch, axis 4 would have to make half a turn at that instant. The distance is the least singular
value of the Jacobian of the tip.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows, Singles, Truths
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.motion import Kind
from assistant.robots.arms.closed_form import SIX_AXIS_BRANCHES
from assistant.robots.robot import CHUNK, Robot

WRIST_PAIRS: Final = SIX_AXIS_BRANCHES // 2
"""Branches 2·pair and 2·pair + 1 differ in the wrist only."""
THROUGH: Final = np.float32(np.sin(np.radians(0.1)))
"""Sine of the least angle of axis 5 on the way that still counts as through the point: a
robot cannot turn axis 4 by half a turn on so short a way."""
_IN_LINE: Final = np.float32(1e-5)
"""Sine of axis 5 below which axis 4 has no defined angle."""

_SMALL: Final = 0.01
"""Largest change of the wrist's bend (see `directions`) in one step that counts as straight, beyond
the least angle of axis 5 that counts.
"""
EVEN: Final = 0.5
"""Largest change of the wrist's bend (see `directions`) in one step that counts as even on the
path.
"""


def directions(joints: Floats) -> Singles:
    """Joints (6, 8, n) deg → (4, 2, n), where the wrist bends to: sin J5 · (cos J4, sin J4)."""
    return np.moveaxis(bends_to(joints[3, ::2], joints[4, ::2]), 0, 1)


def bends_to(four: Floats, five: Floats) -> Singles:
    """(2, ...) where the wrist bends to, of axes 4 and 5 (...) deg."""
    four, bend = np.radians(four), np.sin(np.radians(five))
    return np.stack([bend * np.cos(four), bend * np.sin(four)]).astype(np.float32)


def crossings(bends: Singles, kinds: NDArray[np.uint8]) -> Truths:
    """Which linear and circular moves go through the singularity, (4, n) of each pair.

    bends: (4, 2, n) of `directions`. kinds: (n,) `Kind`.
    """
    n = len(kinds)
    out = np.zeros((WRIST_PAIRS, n), dtype=bool)
    chain = np.cumsum(kinds == Kind.JOINT)
    for pair in range(WRIST_PAIRS):
        bend = bends[pair]
        bent = np.hypot(*bend) > _IN_LINE
        last = np.maximum.accumulate(np.where(bent, np.arange(n), -1))
        before = np.append(-1, last[:-1])
        opposite = _opposite(bend, bend[:, before])
        rows = np.flatnonzero(bent & (before >= 0) & (chain == chain[before]) & opposite)
        near = _near(bend[:, rows], bend[:, before[rows]])
        out[pair, rows] = near | (before[rows] < rows - 1)
    return out


def passes_through(bends: Singles) -> Truths:
    """(k, p - 1) where ways go through the singularity, of their bends (2, k, p)."""
    first, last = bends[..., :-1], bends[..., 1:]
    return _opposite(first, last) & _near(first, last)


def may_pass_through(bends: Singles) -> Truths:
    """(k, p - 1) where ways go through the singularity by poses so far apart that they may as
    well go past it, of their bends (2, k, p).
    """
    return np.asarray(passes_through(bends) & (np.hypot(*np.diff(bends)) > _SMALL))


def steps_without_singularity(steps: Floats, bends: Singles) -> Floats:
    """Steps (k, p - 1, 6) deg between poses on k ways, without what a singularity adds.

    bends: (2, k, p) of the poses. Straight through it axis 4 stays where it is, and with axes 4
    and 6 in line axis 6 does the turn of both, whatever the angles of the two branches are.
    """
    out = steps.copy()
    crossed = passes_through(bends)
    for axis in (3, 5):
        out[..., axis] -= np.where(crossed, 180.0 * np.round(steps[..., axis] / 180.0), 0.0)
    bent = np.hypot(*bends) > _IN_LINE
    in_line = ~(bent[..., :-1] & bent[..., 1:])
    both = steps[..., 3] + steps[..., 5]
    out[..., 3] = np.where(in_line, 0.0, out[..., 3])
    out[..., 5] = np.where(in_line, both - 360.0 * np.round(both / 360.0), out[..., 5])
    return out


def _opposite(first: Singles, last: Singles) -> Truths:
    return np.asarray(first[0] * last[0] + first[1] * last[1] < 0.0)


def _near(first: Singles, last: Singles) -> Truths:
    """True if the straight line between two bends (2, ...) passes near zero."""
    length = np.maximum(np.hypot(*(last - first)), np.float32(1e-12))
    return np.asarray(np.abs(last[0] * first[1] - last[1] * first[0]) / length < THROUGH)


def least_bends(bends: Singles, kinds: NDArray[np.uint8]) -> Singles:
    """Return (4, n) the least sine of axis 5 of each pair on the path to each row.

    bends: (4, 2, n) of `directions`. A linear or circular move that bends the wrist little
    elsewhere is assumed to bend it evenly on the path; of other moves only both ends are checked.
    """
    out = np.hypot(bends[:, 0], bends[:, 1])
    along = np.flatnonzero(kinds[1:] != Kind.JOINT) + 1
    for pair in range(WRIST_PAIRS):
        for start in range(0, len(along), CHUNK):
            rows = along[start : start + CHUNK]
            (x, y), (u, v) = bends[pair][:, rows], bends[pair][:, rows - 1]
            across, up = x - u, y - v
            square = across * across + up * up
            part = -(u * across + v * up) / np.maximum(square, 1e-12)
            part = np.where(square < EVEN * EVEN, np.clip(part, 0.0, 1.0), 1.0)
            way = np.hypot(u + part * across, v + part * up)
            out[pair, rows] = np.minimum(way, np.hypot(u, v))
    return out


def connected_branches(crossed: Truths) -> Rows:
    """Branches that belong together along a run, (8, n), for crossings (4, n).

    Row s says for each move which branch an arm is in that had branch s before the run and
    made joint moves without a change of branch, the others without a jump.
    """
    parity = np.cumsum(crossed, axis=1) & 1
    branch = np.arange(SIX_AXIS_BRANCHES)
    return np.asarray((branch & ~1)[:, None] + ((branch & 1)[:, None] ^ parity[branch // 2]))


_ROWS_AT_ONCE: Final = 16384
"""Rows that are computed at once."""


def jacobian(robot: Robot, joints: Floats, tip: Pose = IDENTITY) -> Floats:
    """(n, a) joints → (n, 6, a): how the tip of a tool moves and turns with each axis.

    Its speed in the base over the reach of the arm, then how it turns; for a radian of an axis, or
    as many mm of one that slides as the arm reaches. tip: in the flange.
    """
    out = robot.jacobian(joints, unit="deg", tool=tip)
    out[:, :3, ~robot.sliding] *= np.degrees(1.0) / robot.reach
    return out


def distance_from_singularity(robot: Robot, joints: Floats, tip: Pose = IDENTITY) -> Floats:
    """(n,) how far joints (n, a) are from a singularity: the least singular value of `jacobian`.

    0 in a singularity, where the tip cannot go some way however fast the axes turn. An arm of less
    than six axes is in one where it loses a way that it has elsewhere. NaN of NaN.
    """
    out = np.full(len(joints), np.nan)
    known = np.flatnonzero(np.isfinite(joints).all(axis=1))
    for start in range(0, len(known), _ROWS_AT_ONCE):
        rows = known[start : start + _ROWS_AT_ONCE]
        matrix = jacobian(robot, joints[rows], tip)
        out[rows] = np.linalg.svd(matrix, compute_uv=False).min(axis=1)
    return out
