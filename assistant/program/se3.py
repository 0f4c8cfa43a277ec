"""Poses of every form that Python code has them in, as columns: the one conversion of the package.

A form is a `Pose`, an SE3 of spatialmath, a homogeneous matrix, a row of seven numbers, many of
one of these, or columns. A `Pose` is in mm; of numbers that could be mm or m the caller states the
unit, which is never guessed. spatialmath is imported only when an SE3 is made.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats, norms, reals, require_same_length, rows_of
from assistant.base.diagnostics import Refused, error
from assistant.program.geometry import Pose
from assistant.program.motion import Path

if TYPE_CHECKING:
    from spatialmath import SE3

AnyPose: TypeAlias = Any
"""A `Pose`, an SE3, a matrix (4, 4), or x y z w x y z (7,)."""
AnyPoses: TypeAlias = Any
"""Many of these, see `columns_of`."""
Unit = Literal["m", "mm"]
PoseColumns = tuple[Floats, Floats]
"""Positions (n, 3) mm and unit quaternions (n, 4)."""
METRE: Final[Mapping[str, float]] = {"m": 1000.0, "mm": 1.0}
"""mm of each unit."""
_ROUNDING: Final = 1e-5
"""Deviation from a rotation that a matrix of rounded numbers may have."""
_OFF_UNIT: Final = 1e-3
"""Most that the length of a quaternion may differ from 1; it is normalised."""

NO_POSES: Final = error(
    "TB444",
    "{what}: {reason}",
    "give a Pose, an SE3, a matrix (4, 4), or x y z w x y z (7,); many as a list of these, as "
    "(n, 4, 4) or (n, 7), or as two columns, positions (n, 3) and quaternions (n, 4)",
)
NO_UNIT: Final = error(
    "TB445",
    "{what}: nothing says whether the positions are mm or m",
    'write unit="m", as SE3 of roboticstoolbox are, or unit="mm"; or give a Pose, which is in mm: '
    'assistant.pose.of(…, unit="m")',
)
NO_WRITTEN_UNIT: Final = error(
    "TB449",
    "{what}: nothing says whether they are to be mm or m",
    'write to_unit="mm" or to_unit="m"',
)
NO_SUCH_UNIT: Final = error(
    "TB446", "{what}: the unit {unit!r} is not known", 'write {key}="mm" or {key}="m"'
)


def columns_of(poses: AnyPoses, *, unit: Unit | None = None, what: str = "poses") -> PoseColumns:
    """Convert one or many poses of any form to positions (n, 3) mm and unit quaternions (n, 4).

    poses: a `Pose`, an SE3 of one or many poses, a matrix (4, 4) or (n, 4, 4), x y z w x y z as
    (7,) or (n, 7), a sequence of any of these, a `Path`, or two columns (n, 3) and (n, 4). unit: of
    the positions of SE3, matrices and rows; a `Pose`, a `Path` and columns are mm unless a unit of
    the columns is stated. what: names the poses in a finding. Raises Refused, which is a
    ValueError, for anything else, no number, no rotation, and without a unit where one is needed.
    """
    if unit is not None:
        mm_of(unit, what)
    rows, in_mm = stacked(poses, what)
    if unit is None and not in_mm and not are_columns(poses):
        raise Refused(NO_UNIT(what=what))
    scale = mm_of("mm" if in_mm or unit is None else unit, what)
    if rows.ndim == 3:
        return _of_matrices(rows, scale, what)
    positions, quaternions = rows[:, :3], rows[:, 3:]
    _require(np.isfinite(positions).all(axis=1), "no finite position", what)
    length = norms(quaternions)
    _require(np.abs(length - 1.0) <= _OFF_UNIT, "no unit quaternion w x y z", what)
    return positions * scale, rotations.canonical(quaternions)


def pose_of(pose: AnyPose, *, unit: Unit | None = None, what: str = "pose") -> Pose:
    """Convert a single pose of any form, see `columns_of`; a `Pose` stays as it is."""
    if isinstance(pose, Pose):
        columns_of(pose, what=what)
        return pose
    positions, turns = columns_of(pose, unit=unit, what=what)
    if len(positions) != 1:
        raise Refused(NO_POSES(what=what, reason=f"one pose is wanted, not {len(positions)}"))
    return Pose.of(positions[0], turns[0])


def stacked(poses: AnyPoses, what: str = "poses") -> tuple[Floats, bool]:
    """Return poses as rows (n, 7) or matrices (n, 4, 4), and whether they are mm for certain.

    The numbers are those that were given, unproven. Raises Refused for another form.
    """
    if isinstance(poses, Path):
        return np.hstack([poses.positions, poses.quaternions]), True
    if are_columns(poses):
        names = f"{what}, positions", f"{what}, quaternions"
        p, q = rows_of(poses[0], 3, names[0]), rows_of(poses[1], 4, names[1])
        require_same_length(p, q, "positions", "quaternions")
        return np.hstack([p, q]), False
    if isinstance(poses, Pose):
        poses = [poses]
    items: Any = getattr(poses, "A", poses)  # of an SE3 of many poses a list
    in_mm = False
    if isinstance(items, Iterable) and not isinstance(items, np.ndarray | str | bytes):
        items = list(items)
        in_mm = bool(items) and all(isinstance(one, Pose) for one in items)
        items = [each for one in items for each in _singles(one)]
    reason = f"{type(poses).__name__} is no pose"
    try:
        array = reals(items)
    except (TypeError, ValueError):
        raise Refused(NO_POSES(what=what, reason=reason)) from None
    array = array[None] if array.shape in ((4, 4), (7,)) else array
    if array.ndim not in (2, 3) or array.shape[1:] not in ((7,), (4, 4)):
        reason = reason if array.ndim == 0 else f"the shape is {array.shape}"
        raise Refused(NO_POSES(what=what, reason=reason))
    return array, in_mm


def se3_of(positions: ArrayLike | Pose, quaternions: ArrayLike | None = None, *, unit: Unit) -> SE3:
    """Convert positions (n, 3) mm and quaternions (n, 4), or a `Pose`, to an SE3 of n poses.

    unit: of the positions of the SE3. Raises ImportError without spatialmath, which the extra
    `toolbox` brings.
    """
    from spatialmath import SE3

    scale = mm_of(unit, "poses")
    p, q = columns_of(positions if quaternions is None else (positions, quaternions))
    made = np.tile(np.eye(4), (len(p), 1, 1))
    made[:, :3, :3] = rotations.to_matrix(q)
    made[:, :3, 3] = p / scale
    return SE3(list(made), check=False)


def _singles(one: Any) -> list[Any]:
    """The poses that an element of a sequence holds, each as numbers."""
    if isinstance(one, Pose):
        return [(*one.position, *one.quaternion)]
    found = getattr(one, "A", one)
    return found if isinstance(found, list) and hasattr(one, "A") else [found]


def are_columns(poses: Any) -> bool:
    """True for two columns, (…, 3) and (…, 4)."""
    if not isinstance(poses, tuple | list) or len(poses) != 2:
        return False
    if any(hasattr(one, "A") or isinstance(one, Pose) for one in poses):
        return False
    try:
        return [np.shape(one)[-1:] for one in poses] == [(3,), (4,)]
    except (TypeError, ValueError):  # an uneven list, or no numbers
        return False


def mm_of(unit: object, what: str, *, written: bool = False) -> float:
    """Return the mm of a unit of lengths; raise Refused for another one and for None.

    written: it is the unit of a result, `to_unit`.
    """
    if unit is None:
        raise Refused((NO_WRITTEN_UNIT if written else NO_UNIT)(what=what))
    if not isinstance(unit, str) or unit not in METRE:
        key = "to_unit" if written else "unit"
        raise Refused(NO_SUCH_UNIT(what=what, unit=str(unit)[:40], key=key))
    return METRE[unit]


def _of_matrices(given: Floats, scale: float, what: str) -> PoseColumns:
    _require(np.isfinite(given).all(axis=(1, 2)), "a number that is not finite", what)
    last = (np.abs(given[:, 3] - (0.0, 0.0, 0.0, 1.0)) <= _ROUNDING).all(axis=1)
    _require(last, "a last row of its matrix other than 0 0 0 1", what)
    turn = given[:, :3, :3]
    off = np.abs(np.einsum("nij,nkj->nik", turn, turn) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    _require((off <= _ROUNDING) & (np.linalg.det(turn) > 0.0), "no rotation in its matrix", what)
    return given[:, :3, 3] * scale, rotations.canonical(rotations.from_matrix(turn))


def _require(good: Any, fault: str, what: str) -> None:
    """Raise Refused for the first row, (n,), that is not good."""
    wrong = np.flatnonzero(~np.asarray(good))
    if len(wrong):
        row = f"pose {wrong[0] + 1}" if len(good) > 1 else "the pose"
        raise Refused(NO_POSES(what=what, reason=f"{row} has {fault}"))
