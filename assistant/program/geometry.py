"""Poses, frames, tools and targets: where things are, in millimetres and unit quaternions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.program import rotations
from assistant.program.arrays import Floats

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

UNUSED_AXIS: Final = float("nan")
"""An external axis that a target does not name (9E9 in RAPID, absent in MELFA-BASIC)."""


@dataclass(frozen=True, slots=True)
class Pose:
    """Position in mm and orientation as a unit quaternion (w, x, y, z)."""

    position: Vector = (0.0, 0.0, 0.0)
    quaternion: Quaternion = (1.0, 0.0, 0.0, 0.0)

    def __matmul__(self, other: Pose) -> Pose:
        """The pose `other`, given in this one's frame, in this one's own frame."""
        (x, y, z), (a, b, c) = self.position, _turned(self.quaternion, other.position)
        aw, ax, ay, az = self.quaternion
        bw, bx, by, bz = other.quaternion
        turned = (
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        )
        moved = float(x + a) + 0.0, float(y + b) + 0.0, float(z + c) + 0.0
        return Pose(moved, _canonical(turned))

    def inverse(self) -> Pose:
        w, x, y, z = self.quaternion
        back = w, -x, -y, -z
        a, b, c = _turned(back, self.position)
        return Pose((0.0 - float(a), 0.0 - float(b), 0.0 - float(c)), _canonical(back))

    def moved(self, points: Floats) -> Floats:
        """Points (n, 3) of this frame, in its own frame."""
        turned = rotations.rotate(np.array(self.quaternion), points)
        return np.asarray(turned + np.array(self.position))

    def offset(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Pose:
        """Moved along its own axes (mm); negative z backs off along the tool."""
        return self @ Pose((x, y, z))

    @staticmethod
    def of(position: Floats, quaternion: Floats) -> Pose:
        x, y, z = (float(v) + 0.0 for v in position)
        q1, q2, q3, q4 = (float(v) + 0.0 for v in quaternion)
        return Pose((x, y, z), (q1, q2, q3, q4))


# What `rotations` does with columns, to the bit, for one pose: programs that run compose millions,
# and an operation of numpy on four numbers takes a hundred times as long as they do.


def _turned(quaternion: Quaternion, vector: Vector) -> Vector:
    w, x, y, z = quaternion
    a, b, c = vector
    t, u, s = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return a + w * t + (y * s - z * u), b + w * u + (z * t - x * s), c + w * s + (x * u - y * t)


def _canonical(quaternion: Quaternion) -> Quaternion:
    q = np.array(quaternion, dtype=np.float64)
    length = math.sqrt(np.einsum("...i,...i->...", q, q))
    if not length > 0.0:
        return Pose.of(np.zeros(3), rotations.canonical(quaternion)).quaternion
    w, x, y, z = (float(part) / length for part in quaternion)
    sides = (part for part in (w, x, y, z) if abs(part) > rotations.NOTHING)
    sign = -1.0 if next(sides, w) < 0.0 else 1.0
    return _part(w, sign), _part(x, sign), _part(y, sign), _part(z, sign)


def _part(part: float, sign: float) -> float:
    return 0.0 if abs(part) < rotations.DUST else part * sign


IDENTITY: Final = Pose()


@dataclass(frozen=True, slots=True)
class Load:
    """What a tool weighs: mass in kg, centre of gravity in mm, inertia in kg·m²."""

    mass: float
    centre: Vector = (0.0, 0.0, 0.0)
    axes: Quaternion = (1.0, 0.0, 0.0, 0.0)
    inertia: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Tool:
    """A tool: pose of its tip in the flange frame, and its load if that is known.

    held: the robot carries it; False for a tool that stands in the room. free_turn: how it is
    turned about its own z axis means nothing to the work, as of a round nozzle or a milling cutter.
    """

    tip: Pose = IDENTITY
    load: Load | None = None
    held: bool = True
    free_turn: bool = False


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame that targets are relative to (RAPID work object, MELFA base).

    user: the user frame in the robot's base frame. object: the object frame in the user
    frame. held: the robot carries the work piece. mechanism: the unit that moves it, if any.
    seen: the object that it is found with, empty for none: then the poses only say where that
    usually is, and nothing is written before it is known where it was seen.
    """

    user: Pose = IDENTITY
    object: Pose = IDENTITY
    held: bool = False
    mechanism: str = ""
    seen: str = ""

    @property
    def pose(self) -> Pose:
        """The object frame in the robot's base frame."""
        return self.user @ self.object


FLANGE: Final = "tool0"
"""Name of the tool that is the bare flange."""
BASE: Final = "base"
"""Name of the frame that is the robot's own base (`wobj0` in RAPID)."""


@dataclass(frozen=True, slots=True)
class Configuration:
    """The arm branch of a target, in the words of no vendor.

    back: wrist centre behind axis 1. down: elbow below the line from shoulder to wrist.
    flip: axis 5 negative. quadrants: of axes 1, 4 and 6, quadrant q being the angles from
    90·q to 90·q + 90 degrees; a source that knows only whole turns gives 4 · turns.
    """

    back: bool = False
    down: bool = False
    flip: bool = False
    quadrants: tuple[int, int, int] = (0, 0, 0)

    @property
    def turns(self) -> tuple[int, int, int]:
        """Whole turns of axes 1, 4 and 6; turn t being -180 + 360·t to 180 + 360·t degrees."""
        one, four, six = ((q + 2) // 4 for q in self.quadrants)
        return one, four, six


NO_EXTERNAL: Final = (UNUSED_AXIS,) * 6


def _same(left: tuple[float, ...], right: tuple[float, ...]) -> bool:
    return np.array_equal(left, right, equal_nan=True)


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """A Cartesian target: pose, arm branch (None: not stated), six external axes (NaN: unused)."""

    pose: Pose
    configuration: Configuration | None = None
    external: tuple[float, ...] = NO_EXTERNAL

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Target):
            return NotImplemented
        return (
            self.pose == other.pose
            and self.configuration == other.configuration
            and _same(self.external, other.external)
        )

    def __hash__(self) -> int:
        return hash((self.pose, self.configuration))


@dataclass(frozen=True, slots=True, eq=False)
class JointTarget:
    """Joint angles in degrees (mm for linear axes) and six external axes.

    joints: one value a joint of the robot; NaN for a joint that the arm does not have.
    """

    joints: tuple[float, ...]
    external: tuple[float, ...] = NO_EXTERNAL

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, JointTarget):
            return NotImplemented
        return _same(self.joints, other.joints) and _same(self.external, other.external)

    def __hash__(self) -> int:
        return hash(tuple(j for j in self.joints if j == j))
