"""Joint angles of one arm on another: where they put its flange, solved anew."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats, rows_of
from assistant.robots.arms.placed import Placed
from assistant.robots.robot import IN_LINE, Robot

OTHER_SIDE: Final = 1e6
"""What another side of shoulder, elbow or wrist counts as: more than any angle."""


def joints_on_other_arm(joints: ArrayLike, source: Robot, arm: Robot) -> Floats:
    """Joints (n, a) of an arm → those (n, b) with which another one's flange is where its was.

    In the nearest branch: where the axis that is the farthest from where the source has it is the
    least away; of arms whose angles cannot be compared, on the same sides of shoulder, elbow and
    wrist, then near home. A row is NaN where the other arm does not reach within its limits.
    """
    given = rows_of(joints, len(source.axes), "joints")
    positions, quaternions = source.fk(given)
    alike = type(source.arm) is type(arm.arm) and arm.arm.named
    alike = alike and not isinstance(arm.arm, Placed)
    home = np.tile(arm.home, (len(given), 1))
    wanted = (_counted_by(arm, source.chained(given)) if alike else home)[:, None]
    found, _ = arm.ik(positions, quaternions)
    found = _with_whole_turns(_in_line(found, wanted, arm), wanted, arm)
    away = np.abs(found - wanted).max(axis=2)
    if source.arm.named and arm.arm.named and not alike:
        n, branches, axes = found.shape
        each = np.nan_to_num(found).reshape(-1, axes)
        shape = arm.arm.shape(arm.chained(each)).reshape(n, branches, -1)
        own = source.arm.shape(source.chained(given))
        away += OTHER_SIDE * np.count_nonzero(shape != own[:, None], axis=2)
    away = np.where(arm.inside(found), away, np.inf)
    rows, branch = np.arange(len(given)), away.argmin(axis=1)
    out: Floats = found[rows, branch]
    good = np.isfinite(away[rows, branch])
    good[good] = arm.closes(out[good], positions[good], quaternions[good])
    out[~good] = np.nan
    return out


def _counted_by(arm: Robot, values: Floats) -> Floats:
    """Values (n, a) of a chain that two arms have in common → joints of one, which changes them."""
    values[:, ~arm.sliding] = np.degrees(values[:, ~arm.sliding])
    values -= arm.zero
    if arm.coupling:
        values[:, 2] -= arm.coupling * values[:, 1]
    return values


def _in_line(joints: Floats, wanted: Floats, arm: Robot) -> Floats:
    """Axis 4 as wanted where axes 4 and 6 are in line and only their sum counts."""
    if not arm.arm.spherical:
        return joints
    out = joints.copy()
    line = np.abs(joints[..., 4]) < IN_LINE
    fourth = np.clip(np.broadcast_to(wanted[..., 3], line.shape), *arm.limits[3])
    out[..., 5] += np.where(line, joints[..., 3] - fourth, 0.0)
    out[..., 3] = np.where(line, fourth, joints[..., 3])
    return out


def _with_whole_turns(joints: Floats, wanted: Floats, arm: Robot) -> Floats:
    """Joints (n, b, a), each axis so many whole turns on that it is nearest to wanted in limits."""
    low, high = arm.limits.T
    least, most = np.ceil((low - joints) / 360.0), np.floor((high - joints) / 360.0)
    turns = np.where(most >= least, np.clip(np.round((wanted - joints) / 360.0), least, most), 0.0)
    return np.asarray(joints + 360.0 * np.where(arm.sliding, 0.0, turns))
