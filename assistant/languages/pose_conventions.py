"""Poses as controllers and libraries write them, and their conversion: `assistant.pose`.

    pose.convert([600, 0, 400, 0, 0, 1, 0], "rapid", "kuka")
    pose.write(SE3(0.6, 0, 0.4) * SE3.Ry(180, "deg"), "rapid", unit="m")

A row is x, y, z and the numbers of the orientation; `pose_conventions.toml` holds each convention
with its source.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats, finite_rows, norms, reals
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, error
from assistant.base.near_names import near_name
from assistant.program.geometry import Pose
from assistant.program.se3 import (
    AnyPose,
    AnyPoses,
    PoseColumns,
    Unit,
    columns_of,
    mm_of,
    pose_of,
    se3_of,
)

_UNKNOWN: Final = error(
    "TB451", "the convention {name!r} is not known{near}", "write one of {known}"
)
_NO_ROTATION: Final = error(
    "TB452",
    "{what}: row {row} has a quaternion of length {length:.6g}",
    "give a unit quaternion, its parts in the order {order}",
)
_NOT_WRITTEN_SO: Final = error(
    "TB453",
    "`{given}` holds {count} numbers, and a pose of {title} has {wanted}",
    "write {names}",
)
_NO_TEXT: Final = error(
    "TB457",
    "`{given}` is no text",
    "give the pose as text; assistant.pose.read takes numbers in rows",
)
_TOO_LARGE: Final = error(
    "TB458",
    "{what}: row {row} turns by {angle}",
    "give angles of a few turns at most: so large a number has no digits left for a direction",
)
_MOST_TURNED: Final = 1e9
"""Degrees beyond which a float64 says less than 1e-7 degrees of an angle."""
_OFF_UNIT: Final = 1e-3
"""Most that the length of a quaternion may differ from 1; it is normalised."""
_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_NAMED: Final = re.compile(rf"(?<![\w.])([A-Za-z]\w*)(?:\s*[:=]\s*|\s+)({_NUMBER.pattern})")
"""A number with its name before it, such as `X 600` or `W=90`."""
_PARTS: Final = "wxyz"
_POSITION: Final = ("x", "y", "z")


@dataclass(frozen=True, slots=True)
class Convention:
    """How a controller or a library writes a pose; see `pose_conventions.toml`."""

    name: str
    title: str
    form: Literal["quaternion", "angles", "rotation-vector", "matrix"]
    columns: tuple[str, ...]
    source: str
    unit: Unit | None = None
    order: str = ""
    angle: Literal["deg", "rad"] = "deg"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers of a pose, in their order."""
        if self.form == "matrix":
            return tuple(f"r{row}{column}" for row in range(1, 5) for column in range(1, 5))
        return (*_POSITION, *self.columns)


@cache
def conventions() -> Mapping[str, Convention]:
    """The conventions by name, in the order in which they are listed."""
    text = files("assistant.languages").joinpath("pose_conventions.toml").read_text("utf-8")
    return {
        name: Convention(name=name, **row | {"columns": tuple(row["columns"])})
        for name, row in tomllib.loads(text).items()
    }


def convention(name: str) -> Convention:
    """The convention of a name, in any case; raises Refused."""
    known = conventions()
    found = known.get(str(name).lower())
    if found is None:
        close = near_name(str(name).lower(), list(known))
        near = f"; did you mean `{close}`?" if close else ""
        raise Refused(_UNKNOWN(name=str(name)[:40], near=near, known=", ".join(known)))
    return found


def of(given: AnyPose, *, unit: Unit | None = None) -> Pose:
    """Return a pose of any form as a `Pose`.

    given: a `Pose`, an SE3, a matrix (4, 4), or x y z w x y z. unit: of its position, "mm" or "m",
    needed for all but a `Pose`. Raises Refused.
    """
    return pose_of(given, unit=unit)


def columns(given: AnyPoses, *, unit: Unit | None = None) -> PoseColumns:
    """Return poses of any form as positions (n, 3) in mm and unit quaternions (n, 4).

    given: a `Pose`, an SE3 of one or many poses, a matrix (4, 4) or (n, 4, 4), x y z w x y z as
    (7,) or (n, 7), a sequence of any of these, a `Path`, or two columns (n, 3) and (n, 4). unit: of
    the positions of SE3, matrices and rows; a `Pose`, a `Path` and columns are mm. Raises Refused.
    """
    return columns_of(given, unit=unit)


se3 = se3_of


def read(values: ArrayLike, source: str, *, unit: Unit | None = None) -> PoseColumns:
    """Read rows of a convention: positions (n, 3) in mm and unit quaternions (n, 4).

    values: (n, k) or one row, as the convention writes them. source: name of the convention, see
    `conventions()`. unit: of the positions, which has to be stated where the convention is no
    controller's. Raises Refused.
    """
    stated = convention(source)
    unit = stated.unit if unit is None else unit
    scale = mm_of(unit, "values")
    if stated.form == "matrix":
        return columns_of(_matrices(values), unit=unit)
    rows = finite_rows(values, len(stated.names), stated.title)
    return rows[:, :3] * scale, _quaternions(rows[:, 3:], stated)


def write(
    given: AnyPoses, target: str, *, unit: Unit | None = None, to_unit: Unit | None = None
) -> Floats:
    """Write poses of any form as rows (n, k) of a convention.

    given, unit: as of `columns`. target: name of the convention. to_unit: of the positions in the
    rows, a controller's own if it is not stated. Angles are from above -180 to 180 degrees;
    where the middle one is 90 or -90, the others are one turn, and that about z is 0. Raises
    Refused.
    """
    stated = convention(target)
    p, q = columns_of(given, unit=unit)
    there = stated.unit if to_unit is None else to_unit
    p = p / mm_of(there, "the positions to write", written=True)
    if stated.form == "matrix":
        out = np.tile(np.eye(4), (len(p), 1, 1))
        out[:, :3, :3], out[:, :3, 3] = rotations.to_matrix(q), p
        return out.reshape(len(p), 16)
    return np.hstack([p, _orientations(q, stated)])


def convert(
    values: ArrayLike,
    source: str,
    target: str,
    *,
    unit: Unit | None = None,
    to_unit: Unit | None = None,
) -> Floats:
    """Convert rows of one convention to rows (n, k) of another.

    unit: of the given positions, to_unit: of the converted ones; a controller's own if not stated,
    and that of the given ones where `target` is no controller's. Raises Refused.
    """
    poses = read(values, source, unit=unit)
    stated = (to_unit, convention(target).unit, unit, convention(source).unit)
    there = next((one for one in stated if one is not None), None)
    return write(poses, target, to_unit=there)


def parse(text: str, source: str) -> Floats:
    """Read a row (k,) of a convention from text as a program or a page writes it.

    What follows the pose in the text, such as a configuration and external axes, is left out:
    `[[600,0,400],[0,0,1,0],[0,0,0,0],[9E9,…]]`, `(600,0,400,180,0,180)(7,0)`, `{X 600,Y 0,…}` or
    the numbers alone. Raises Refused.
    """
    stated = convention(source)
    if not isinstance(text, str):
        raise Refused(_NO_TEXT(given=repr(text)[:60]))
    wanted = len(stated.names)
    named = {name.lower(): float(number) for name, number in _NAMED.findall(text)}
    if named and all(name.lower() in named for name in stated.names):
        return np.array([named[name.lower()] for name in stated.names])
    shown = "" if named else text.split(")")[0] if ")" in text else text
    numbers = [float(one) for one in _NUMBER.findall(shown)]
    nested = text.lstrip().startswith("[[") or any(mark in text for mark in ")}")
    enough = len(numbers) == wanted or (stated.form == "matrix" and len(numbers) == 12)
    if not enough and not (nested and len(numbers) > wanted):
        fields: dict[str, Any] = {
            "count": len(numbers),
            "wanted": wanted,
            "names": " ".join(stated.names),
        }
        raise Refused(_NOT_WRITTEN_SO(given=text[:60], title=stated.title, **fields))
    return np.array(numbers if enough else numbers[:wanted])


def _matrices(values: ArrayLike) -> Floats:
    """Rows of 16 or 12 numbers, or matrices (…, 4, 4) or (…, 3, 4), as (n, 4, 4)."""
    try:
        given = reals(values)
    except ValueError:
        given = finite_rows(values, 16, "matrix")  # which refuses it
    if given.shape[-2:] not in ((3, 4), (4, 4)):
        twelve = given.shape[-1:] == (12,)
        given = finite_rows(given, 12 if twelve else 16, "matrix")
        given = given.reshape(-1, 3 if twelve else 4, 4)
    given = given.reshape(-1, *given.shape[-2:])
    if given.shape[1] == 3:
        last = np.tile([[[0.0, 0.0, 0.0, 1.0]]], (len(given), 1, 1))
        given = np.concatenate([given, last], axis=1)
    return given


def _quaternions(given: Floats, stated: Convention) -> Floats:
    """Quaternions (n, 4) of orientations (n, 3) or (n, 4) of a convention."""
    degrees = 1.0 if stated.angle == "deg" else np.degrees(1.0)
    if stated.form != "quaternion":
        most = np.abs(given).max(axis=1, initial=0.0)
        wrong = np.flatnonzero(~(most <= _MOST_TURNED / degrees))
        if len(wrong):
            row = int(wrong[0])
            angle = f"{most[row]:.3g} {'degrees' if stated.angle == 'deg' else 'radians'}"
            raise Refused(_TOO_LARGE(what=stated.title, row=row + 1, angle=angle))
    if stated.form == "angles":
        about = [stated.order.index(axis) for axis in "zyx"]
        return rotations.from_euler(given[:, about] * degrees, "ZYX")
    if stated.form == "rotation-vector":
        size = norms(given)
        axis = given / np.where(size > 0.0, size, 1.0)[:, None]
        return rotations.canonical(rotations.about(axis, size * degrees))
    q = given[:, [stated.order.index(part) for part in _PARTS]]
    length = norms(q)
    wrong = np.flatnonzero(~(np.abs(length - 1.0) <= _OFF_UNIT))
    if len(wrong):
        row = int(wrong[0])
        fields: dict[str, Any] = {
            "what": stated.title,
            "row": row + 1,
            "length": float(length[row]),
        }
        raise Refused(_NO_ROTATION(order=" ".join(stated.columns), **fields))
    return rotations.canonical(q)


def _orientations(q: Floats, stated: Convention) -> Floats:
    """Orientations of a convention, (n, 3) or (n, 4), of unit quaternions (n, 4)."""
    degrees = 1.0 if stated.angle == "deg" else np.degrees(1.0)
    if stated.form == "angles":
        zyx = rotations.to_euler(q, "ZYX") / degrees
        return zyx[:, ["zyx".index(axis) for axis in stated.order]]
    if stated.form == "rotation-vector":
        none = np.tile([1.0, 0.0, 0.0, 0.0], (len(q), 1))
        return np.degrees(rotations.turns(none, q)) / degrees + 0.0
    return q[:, [_PARTS.index(part) for part in stated.order]]
