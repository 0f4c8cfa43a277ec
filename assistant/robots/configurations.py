"""Arm branches in the vendors' notations: ABB `confdata`, Mitsubishi FLG1 and FLG2.

Both only rename what the neutral columns of a `Path` say, so they need no robot:
cfx bit 1 tells whether the wrist centre is behind the lower arm, which for an arm that
reaches over its back is the elbow that is up, not down; MELFA's B is the elbow below the
line from shoulder to wrist on either side.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.base.arrays import Ints, whole_rows
from assistant.program.motion import UNSTATED

BACK, _DOWN, FLIP = 0, 1, 2
QUADRANTS: Final = slice(3, 6)
TURNING_AXES: Final = (1, 4, 6)
"""The axes whose quadrants a configuration names."""


def to_confdata(configurations: ArrayLike) -> Ints:
    """(n, 6) neutral columns → (n, 4) cf1, cf4, cf6, cfx; an unstated row gives zeros."""
    c = whole_rows(configurations, 6, "configurations")
    stated = c[:, BACK] != UNSTATED
    cfx = 4 * c[:, BACK] + 2 * (c[:, _DOWN] ^ c[:, BACK]) + c[:, FLIP]
    return np.where(stated[:, None], np.column_stack([c[:, QUADRANTS], cfx]), 0)


def from_confdata(confdata: ArrayLike) -> NDArray[np.int8]:
    """(n, 4) cf1, cf4, cf6, cfx → (n, 6) neutral columns; only the low three bits of cfx count."""
    cf = whole_rows(confdata, 4, "configurations")
    cfx = cf[:, 3]
    back = (cfx >> 2) & 1
    down = ((cfx >> 1) & 1) ^ back
    return np.column_stack([back, down, cfx & 1, cf[:, :3]]).astype(np.int8)


def to_flags(configurations: ArrayLike) -> Ints:
    """(n, 6) neutral columns → (n, 2) FLG1, FLG2; an unstated row gives (7, 0)."""
    c = whole_rows(configurations, 6, "configurations")
    stated = c[:, BACK] != UNSTATED
    one = 7 - 4 * c[:, BACK] - 2 * c[:, _DOWN] - c[:, FLIP]
    turns = (c[:, QUADRANTS] + 2) // 4
    shifts = np.array([4 * (axis - 1) for axis in TURNING_AXES])
    two = ((turns & 0xF) << shifts).sum(axis=1)
    return np.where(stated[:, None], np.column_stack([one, two]), (7, 0))


def from_flags(flags: ArrayLike) -> NDArray[np.int8]:
    """(n, 2) FLG1, FLG2 → (n, 6) neutral columns, quadrant 4 · turn for each turning axis."""
    f = whole_rows(flags, 2, "flags")
    one, two = f[:, 0], f[:, 1]
    shifts = np.array([4 * (axis - 1) for axis in TURNING_AXES])
    nibbles = (two[:, None] >> shifts) & 0xF
    turns = np.where(nibbles > 7, nibbles - 16, nibbles)
    bits = [1 - ((one >> bit) & 1) for bit in (2, 1, 0)]
    return np.column_stack([*bits, 4 * turns]).astype(np.int8)
