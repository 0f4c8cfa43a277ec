"""By how much a target may be off because its numbers were printed rounded.

Makers print a taught position with two decimals of a millimetre, ABB its quaternion with six
and Mitsubishi its angles with two. What was taught lies within that rounding; numbers that are
longer than that were computed and mean what they say.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats, max_abs
from assistant.base.rotations import to_euler
from assistant.robots.arms.arm import CLOSING
from assistant.robots.arms.five_axis import to_ab

if TYPE_CHECKING:
    from assistant.robots.robot import Robot


POSITION_DECIMALS: Final = (2, 3, 4)
"""Decimals of positions. A position of fewer is no coarser one: 300 is written for 300.00."""
QUATERNION_DECIMALS: Final = (4, 5, 6, 7)
"""Decimals of quaternions."""
TYPED_QUATERNION_UNIT: Final = 1e-6
"""Unit of a quaternion of fewer decimals, which is typed (0.5, 0.7071) and no less meant."""
ANGLE_DECIMALS: Final = (2, 3, 4)
SAME_DECIMAL: Final = 1e-3
"""Of the last decimal, within which a number counts as printed with so many."""


def roundings(robot: Robot, positions: Floats, quaternions: Floats) -> Floats:
    """(n, 2) mm and degrees that targets (n, 3), (n, 4) may be off, as its maker prints them.

    The lengths of what half a unit in the last place of each number adds up to; never less than
    `CLOSING`, which is all for numbers of more decimals.
    """
    out = np.empty((len(positions), 2))
    out[:, 0] = 0.5 * np.sqrt(3.0) * _unit(POSITION_DECIMALS, positions)
    if robot.counts == "quadrants":
        # Half a unit of four parts, and a turn moves the unit quaternion by half its angle.
        unit = np.minimum(
            _unit(QUATERNION_DECIMALS, quaternions, scaled=True), TYPED_QUATERNION_UNIT
        )
        out[:, 1] = np.degrees(2.0) * unit
    else:
        angles = to_ab(positions, quaternions) if robot.five_axis else to_euler(quaternions)
        # Two of the three axes may lie in line, where their rounding adds up.
        out[:, 1] = 0.5 * np.sqrt(5.0) * _unit(ANGLE_DECIMALS, angles)
    if robot.five_axis:  # whose tool lies in the plane from axis 1 through the position
        away = np.maximum(np.hypot(positions[:, 0], positions[:, 1]), CLOSING)
        out[:, 1] += np.degrees(np.minimum(out[:, 0] / away, 1.0))
    return np.maximum(out, CLOSING)


def _unit(decimals: tuple[int, ...], values: Floats, *, scaled: bool = False) -> Floats:
    """(n,) of what place the last decimals of values (n, k) are, 0 where of none of them.

    scaled: the values were made unit length behind the rounding.
    """
    out = np.zeros(len(values))
    rows = np.arange(len(values))
    largest = np.abs(values).argmax(axis=1)[:, None]
    for places in reversed(decimals):
        units = values * 10.0**places
        off = max_abs(units - np.round(units))
        if scaled:
            # The largest part was a whole number of units, a few of which are tried.
            longest = np.take_along_axis(units, largest, axis=1)
            for other in (-1.0, 0.0, 1.0):
                with np.errstate(invalid="ignore", divide="ignore"):
                    stretched = units * ((np.round(longest) + other) / longest)
                off = np.fmin(off, max_abs(stretched - np.round(stretched)))
        out[rows[off < SAME_DECIMAL]] = 10.0**-places
    return out
