"""Poses in columns from and to SE3 of spatialmath, which is imported only when one is made.

The caller states the units; they are never guessed. roboticstoolbox counts in metres.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats, reals, require_same_length, rows_of
from assistant.program.geometry import Pose

if TYPE_CHECKING:
    from spatialmath import SE3

Unit = Literal["m", "mm"]
METRE: Final[Mapping[str, float]] = {"m": 1000.0, "mm": 1.0}
"""mm of each unit."""


def columns_of(poses: Any, *, unit: Unit) -> tuple[Floats, Floats]:
    """Convert SE3 of one or many poses, a sequence of them, or (4, 4) or (n, 4, 4) to columns.

    Positions (n, 3) mm and unit quaternions (n, 4). Raises ValueError for any other input, KeyError
    for another unit.
    """
    given = _matrices(poses)
    if given.ndim != 3 or given.shape[1:] != (4, 4) or not np.isfinite(given).all():
        raise ValueError("poses are SE3, or matrices (n, 4, 4) of finite numbers")
    turns = rotations.canonical(rotations.from_matrix(given[:, :3, :3]))
    return given[:, :3, 3] * METRE[unit], turns


def pose_of(pose: Any, *, unit: Unit) -> Pose:
    """A single one; raises ValueError for many."""
    positions, turns = columns_of(pose, unit=unit)
    if len(positions) != 1:
        raise ValueError(f"one pose is wanted, not {len(positions)}")
    return Pose.of(positions[0], turns[0])


def se3_of(positions: ArrayLike, quaternions: ArrayLike, *, unit: Unit) -> SE3:
    """Positions (n, 3) mm and quaternions (n, 4), or one of each → an SE3 of n poses in a unit.

    Raises ImportError without spatialmath, which the extra `toolbox` brings.
    """
    from spatialmath import SE3

    p, q = rows_of(positions, 3, "positions"), rows_of(quaternions, 4, "quaternions")
    require_same_length(p, q, "positions", "quaternions")
    made = np.tile(np.eye(4), (len(p), 1, 1))
    made[:, :3, :3] = rotations.to_matrix(rotations.canonical(q))
    made[:, :3, 3] = p / METRE[unit]
    return SE3(list(made), check=False)


def _matrices(poses: Any) -> Floats:
    items = getattr(poses, "A", poses)  # of an SE3 of many poses a list
    if isinstance(items, Iterable) and not isinstance(items, np.ndarray):
        found = [getattr(one, "A", one) for one in items]
        items = [each for one in found for each in (one if isinstance(one, list) else [one])]
    array = reals(items)
    return array[None] if array.ndim == 2 else array
