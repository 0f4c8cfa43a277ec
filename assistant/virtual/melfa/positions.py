"""Functions of positions, circles and pallets (COSIROP help, CR1D).

Frames, posture flags, areas and points between positions; circles through three points; pallets,
grids and arcs of positions (COSIROP: DEF PLT; CR1D 4-189 and 4-190). Angles are radian, as in
programs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.program.geometry import IDENTITY, Pose
from assistant.virtual.melfa import arm_state
from assistant.virtual.melfa.arm_state import Arm
from assistant.virtual.melfa.values import (
    Bare,
    Failed,
    Joints,
    Position,
    Unknown,
    Value,
    eight,
    joints,
    number,
    open_point,
    out_of_range,
    position,
    text,
    whole,
)
from assistant.virtual.melfa.world import World

if TYPE_CHECKING:
    from assistant.robots import Robot


_FLAT: Final = 1e-9
"""Sine of the angle between two chords below which three places lie on a line."""


@dataclass(frozen=True, slots=True)
class Circle:
    """centre (3,) mm, normal (3,): the way round is positive about it."""

    centre: Floats
    normal: Floats

    def middle(self, start: Floats, end: Floats) -> Floats:
        """The place halfway from one place to another, the positive way round."""
        return self.at(start, self.angle(start, end) / 2.0)

    def at(self, start: Floats, angle: float) -> Floats:
        """The place by an angle in radian from another one, the positive way round."""
        u = start - self.centre
        v = np.cross(self.normal, u)
        return np.asarray(self.centre + np.cos(angle) * u + np.sin(angle) * v)

    def angle(self, start: Floats, end: Floats) -> float:
        """Radian from one place to another the positive way round, from 0 to a whole turn."""
        u, w = start - self.centre, end - self.centre
        return float(np.arctan2(w @ np.cross(self.normal, u), w @ u) % (2.0 * np.pi))


def circle_through(a: Floats, b: Floats, c: Floats) -> Circle | None:
    """The circle from a through b to c; None where they lie on a line or fall together."""
    p, q = b - a, c - a
    normal = np.cross(p, q)
    size = float(np.linalg.norm(normal))
    # Relative to the chords, so that the limit is the same for arcs of any size.
    if size <= _FLAT * float(np.linalg.norm(p)) * float(np.linalg.norm(q)):
        return None
    # Centre of the circle, seen from a.
    to = (p @ p * np.cross(q, normal) + q @ q * np.cross(normal, p)) / (2.0 * size**2)
    return Circle(a + to, normal / size)


def circle_about(a: Floats, b: Floats, centre: Floats) -> Circle | None:
    """The circle from a to b by less than half a turn; None where they lie on a line."""
    p, q = a - centre, b - centre
    normal = np.cross(p, q)
    size = float(np.linalg.norm(normal))
    if size <= _FLAT * float(np.linalg.norm(p)) * float(np.linalg.norm(q)):
        return None
    return Circle(centre, normal / size)


_NO_FLAGS: Final = (None, None)
"""Flags of a position that the manuals give none."""


def _point_of(value: Value) -> Floats:
    """X, Y, Z in mm."""
    x, y, z = position(value).values[:3]
    if x is None or y is None or z is None:
        raise Failed(2800, "a position with elements that are not defined")
    return np.array([x, y, z])


def _distance(_: World, one: Value, other: Value) -> float:
    return float(np.linalg.norm(_point_of(one) - _point_of(other)))


# ------------------------------------------------------------------------------------ frames


def _inverse(world: World, value: Value) -> Position:
    return arm_state.inverse(position(value), world.arm.robot)


def _frame_of(world: World, origin: Value, along: Value, beside: Value) -> Position:
    """Fram: the origin, a place on its X axis, and one where Y is positive."""
    _six_axes(world)
    o, x, y = _point_of(origin), _point_of(along), _point_of(beside)
    first, normal = x - o, np.cross(x - o, y - o)
    length, size = float(np.linalg.norm(first)), float(np.linalg.norm(normal))
    if size <= _FLAT * length * float(np.linalg.norm(y - o)):
        raise Unknown("a frame through places on a line")
    first, normal = first / length, normal / size
    turned = np.stack([first, np.cross(normal, first), normal], axis=-1)
    made = Pose.of(o, rotations.canonical(rotations.from_matrix(turned)))
    return arm_state.position_of(made, Position(eight(()), _NO_FLAGS))


def _aligned(world: World, value: Value) -> Position:
    """Align: A, B and C to the nearest of 0, 90 and 180 with their signs."""
    _six_axes(world)
    given = position(value)
    turned = tuple(None if v is None else _right_angle(v) for v in given.values[3:6])
    return Position((*given.values[:3], *turned, *given.values[6:]), given.flags)


def _right_angle(angle: float) -> float:
    quarters = angle / 90.0
    if abs(quarters - math.floor(quarters) - 0.5) < _HALF_TURN_LIMIT:
        raise Unknown(f"which right angle is nearest to {angle:g} degrees")
    near = 90.0 * round(quarters)
    # Within half a turn; adding 0.0 makes 0.0 of -0.0.
    while abs(near) > 180.0:
        near -= math.copysign(360.0, near)
    return near + 0.0


_HALF_TURN_LIMIT: Final = 1e-9


def _middle_position(
    world: World, one: Value, other: Value, detour: Value, kind: Value
) -> Position:
    """PosMid: halfway on a straight move, by the shorter way round."""
    _six_axes(world)
    first, last = position(one), position(other)
    flags = first.flags[0], last.flags[0]
    if None not in flags and flags[0] != flags[1]:
        raise Failed(2810, "the posture flags of start and end differ")
    if whole(kind) != 0:
        raise Unknown("the middle of a move that is not of equivalent rotation")
    a, b = arm_state.pose_of(first), arm_state.pose_of(last)
    angle = float(rotations.angle_between(a.quaternion, b.quaternion))
    if whole(detour) != 0 and angle > _NO_TURN:
        raise Unknown("the middle of a move by the longer way round")
    if angle > _OPPOSITE:
        raise Unknown("the middle of a turn by half a turn")
    turned = rotations.between(a.quaternion, b.quaternion, 0.5)
    made = Pose.of((_point_of(one) + _point_of(other)) / 2.0, rotations.canonical(turned))
    return arm_state.position_of(made, first)


_NO_TURN: Final = 1e-6
_OPPOSITE: Final = 179.999
"""Degrees between two postures that are the same, and that every way round is as long between."""


def _six_axes(world: World) -> None:
    if world.arm.robot is not None and world.arm.robot.five_axis:
        raise Unknown("such a function with an arm of five axes")


# ------------------------------------------------------------------------------------- areas


def _in_box(_: World, value: Value, one: Value, other: Value) -> int:
    """Zone: each element between those of two places; angles the positive way round."""
    given, first, last = (position(v).values[:6] for v in (value, one, other))
    for at, (v, a, b) in enumerate(zip(given, first, last, strict=True)):
        if v is None or a is None or b is None:
            raise Unknown("an area with elements that are not defined")
        if not (_turned_between(v, a, b) if at >= 3 else min(a, b) <= v <= max(a, b)):
            return 0
    return 1


def _turned_between(v: float, a: float, b: float) -> bool:
    return b - a >= 360.0 or (v - a) % 360.0 <= (b - a) % 360.0


def _in_capsule(_: World, value: Value, one: Value, other: Value, radius: Value) -> int:
    """Zone2: as near as a radius to the line between two places."""
    within = number(radius, "the radius")
    if within < 0:
        raise out_of_range("the radius of an area")
    p, a, b = _point_of(value), _point_of(one), _point_of(other)
    along = b - a
    length = float(along @ along)
    # The nearest point of the line, not beyond its ends.
    share = 0.0 if length == 0.0 else min(1.0, max(0.0, float((p - a) @ along) / length))
    return int(float(np.linalg.norm(p - a - share * along)) <= within)


def _in_turned_box(_: World, value: Value, *rest: Value) -> int:
    """Zone3: -1 where its three places make no plane (CR1D 4-342)."""
    a, b, c = (_point_of(v) for v in rest[:3])
    if any(number(v) < 0 for v in rest[3:5]):
        raise out_of_range("the width or height of an area")
    if circle_through(a, b, c) is None:
        return -1
    _point_of(value)
    raise Unknown("the box of Zone3, which the manual tells by a drawing only")


# ---------------------------------------------------------------------------------- the arm


def _arm_with_robot(world: World) -> Arm:
    """Return a separate arm for a conversion, with the tool and the base that it applies."""
    given = world.arm
    if given.robot is None:
        raise Unknown("the arm")
    made = Arm(given.robot)
    if (given.tip, given.foot) != (IDENTITY, IDENTITY):
        if world.options.conversions is None:
            raise open_point(
                "whether JtoP and PtoJ count with the tool and the base", "conversions"
            )
        if world.options.conversions == "all":
            made.tool, made.base, made.tip, made.foot = (
                given.tool,
                given.base,
                given.tip,
                given.foot,
            )
    return made


def _to_position(world: World, value: Value) -> Position:
    arm = _arm_with_robot(world)
    arm.at_joints(tuple(v for v in joints(value).values if v is not None))
    return arm.shown()


def _to_joints(world: World, value: Value) -> Joints:
    arm, given = _arm_with_robot(world), position(value)
    arm.at_position(arm.placed(given), given.flags)
    return arm.shown_joints()


def _is_reached(world: World, value: Value) -> int:
    """PosCq: whether a position or joints are within the range of motion."""
    robot = _robot_of(world)
    if isinstance(value, Bare):
        raise Unknown("whether a constant is a position or joints")
    if isinstance(value, Joints):
        given = tuple(v for v in value.values if v is not None)
        # Axes that the constant leaves out are 0.
        own = robot.own_joints((*given, *(0.0,) * 6)[: max(6, len(given))])
        return int(bool(robot.inside(np.array([own]))[0]))
    arm, wanted = Arm(robot), position(value)
    arm.tip, arm.foot = world.arm.tip, world.arm.foot
    arm.at_position(arm.placed(wanted), wanted.flags)
    try:
        arm.shown_joints()
    except Failed:
        return 0
    return 1


def _robot_of(world: World) -> Robot:
    if world.arm.robot is None:
        raise Unknown("the arm")
    return world.arm.robot


# -------------------------------------------------------------------------------------- flags

_POSTURE_LETTERS: Final = (("L", "R"), ("B", "A"), ("F", "N"))
"""Letters of FL1 for 0 and 1: bits 2, 1 and 0."""


def _posture_letter(_: World, value: Value, which: Value) -> str:
    one, at = _posture_flag(value, 0), whole(which)
    if at not in range(3):
        raise out_of_range(f"the structure flag {at}")
    return _POSTURE_LETTERS[at][one >> (2 - at) & 1]


def _with_posture(_: World, value: Value, letters: Value) -> Position:
    """SetFl1 takes the letters from the last one on: "LR" is L (COSIROP)."""
    given, one = position(value), _posture_flag(value, 0)
    for letter in reversed(text(letters).upper()):
        place = next((i for i, pair in enumerate(_POSTURE_LETTERS) if letter in pair), None)
        if place is None:
            raise out_of_range(f"the structure flag {letter}")
        bit = 1 << (2 - place)
        one = one | bit if _POSTURE_LETTERS[place].index(letter) else one & ~bit
    return Position(given.values, (one, given.flags[1]))


def _read_turns(_: World, value: Value, axis: Value) -> int:
    """RdFl2: four bits of each axis, with a sign."""
    # Four bits with a sign: 8 to 15 are -8 to -1.
    nibble = _posture_flag(value, 1) >> _turn_shift(axis) & 15
    return nibble - 16 if nibble > 7 else nibble


def _with_turns(_: World, value: Value, axis: Value, turns: Value) -> Position:
    given, count = position(value), whole(turns)
    if not -8 <= count <= 7:
        raise out_of_range(f"{count} turns")
    shift, two = _turn_shift(axis), _posture_flag(value, 1)
    made = two & ~(15 << shift) | (count & 15) << shift
    return Position(given.values, (given.flags[0], made))


def _turn_shift(axis: Value) -> int:
    if whole(axis) not in range(1, 9):
        raise out_of_range(f"the axis {whole(axis)}")
    return 4 * (whole(axis) - 1)


def _posture_flag(value: Value, which: int) -> int:
    flag = position(value).flags[which]
    if flag is None:
        raise Unknown(f"FL{which + 1} of a position without flags")
    return flag


# -------------------------------------------------------------------------------------- arcs


def arc_data(one: Value, via: Value, other: Value) -> tuple[int, float, float, float, Position]:
    """CalArc: whether there is one, its radius, angle in radian, length and centre."""
    a, b, c = _point_of(one), _point_of(via), _point_of(other)
    spread = max(float(np.linalg.norm(a - b)), float(np.linalg.norm(b - c)))
    if spread == 0.0:
        return -2, -1.0, 0.0, 0.0, _centre(np.zeros(3))
    if spread < _NEAR_RADIUS:
        raise Unknown("whether an arc goes through places that are so near")
    circle = circle_through(a, b, c)
    if circle is None:
        return -1, -1.0, 0.0, float(np.linalg.norm(c - a)), _centre(np.zeros(3))
    radius, angle = float(np.linalg.norm(a - circle.centre)), circle.angle(a, c)
    return 1, radius, angle, radius * angle, _centre(circle.centre)


_NEAR_RADIUS: Final = 0.01
"""mm; the manual speaks of approximately the same place."""


def _centre(place: Floats) -> Position:
    return Position(eight((*(float(v) for v in place), 0.0, 0.0, 0.0)), _NO_FLAGS)


# --------------------------------------------------------------------------------- the tables


def _constructor(kind: type[Position] | type[Joints], radian: range) -> Callable[..., Value]:
    """Return the function SetPos or SetJnt: elements of which some are angles in radian."""

    def made(world: World, *given: Value | None) -> Value:
        values: list[float | None] = []
        for at, value in enumerate(given):
            plain = None if value is None else float(number(value))
            turns = at in radian
            if at >= 6 and plain is not None:
                if world.options.slides is None:
                    raise open_point("whether an additional axis turns or slides", "slides")
                turns = not world.options.slides
            if turns and plain is not None and world.options.degrees:
                raise Unknown("the unit of angles in SetPos and SetJnt where PRGMDEG is 1")
            values.append(math.degrees(plain) if plain is not None and turns else plain)
        return kind(eight(tuple(values)))

    return made


POSITION_FUNCTIONS: Final[Mapping[str, Callable[..., Value]]] = {
    "DIST": _distance,
    "INV": _inverse,
    "FRAM": _frame_of,
    "ALIGN": _aligned,
    "POSMID": _middle_position,
    "ZONE": _in_box,
    "ZONE2": _in_capsule,
    "ZONE3": _in_turned_box,
    "POSCQ": _is_reached,
    "JTOP": _to_position,
    "PTOJ": _to_joints,
    "RDFL1": _posture_letter,
    "SETFL1": _with_posture,
    "RDFL2": _read_turns,
    "SETFL2": _with_turns,
}
CONSTRUCTORS: Final[Mapping[str, Callable[..., Value]]] = {
    "SETPOS": _constructor(Position, range(3, 6)),
    "SETJNT": _constructor(Joints, range(6)),
}
"""Functions whose arguments may be left out."""


_ZIGZAG_PALLET: Final = 1
_ARC_PALLET: Final = 3
_FIXED_ORIENTATION: Final = 10
"""Added to a direction whose points keep the posture of the start."""
_PALLET_KINDS: Final = (1, 2, 3, 11, 12, 13)
_MOST_PALLETS: Final = 8
_MOST_POINTS: Final = 32767


@dataclass(frozen=True, slots=True)
class Grid:
    """start, first, second: its corner and the ends of the edges there; of an arc its start, a
    place on its way and its end. opposite: the fourth corner, None for a parallelogram.
    counts: points along the first and the second edge. direction: 1 zigzag, 2 same, 3 arc.
    fixed: whether all points have the posture of the start.
    """

    start: Position
    first: Position
    second: Position
    opposite: Position | None
    counts: tuple[int, int]
    direction: int
    fixed: bool

    @property
    def points(self) -> int:
        return self.counts[0] if self.direction == _ARC_PALLET else self.counts[0] * self.counts[1]


def pallet_grid(
    number: int,
    corners: tuple[Position | None, ...],
    counts: tuple[int, int],
    direction: int,
    fixed: bool = False,
) -> Grid:
    """A pallet as `Def Plt` defines it; raises Failed.

    fixed: whether directions 1 to 3 keep the posture of the start, too.
    """
    start, first, second, opposite = corners
    if not 1 <= number <= _MOST_PALLETS:
        raise out_of_range(f"the pallet {number}")
    if start is None or first is None or second is None:
        raise Failed(3120, "a corner of the pallet is left out")
    if direction not in _PALLET_KINDS:
        raise out_of_range(f"a pallet of direction {direction}")
    kind = direction % _FIXED_ORIENTATION
    along, rows = counts
    if (
        along < 1
        or (rows < 1 and kind != _ARC_PALLET)
        or (kind != _ARC_PALLET and along * rows > _MOST_POINTS)
    ):
        raise out_of_range(f"a pallet of {along} by {rows} points")
    if kind == _ARC_PALLET:
        opposite = None
    given = [c for c in (start, first, second, opposite) if c is not None]
    if any(None in corner.values[:6] for corner in given):
        raise Failed(3750, "a corner of the pallet is not defined")
    return Grid(
        start, first, second, opposite, counts, kind, fixed or direction > _FIXED_ORIENTATION
    )


def pallet_point(of: Grid | None, number: int, at: int) -> Position:
    """A point by its number from 1: along the first edge, then the next row."""
    if of is None:
        raise Failed(3850, f"the pallet {number} is not defined")
    if not 1 <= at <= of.points:
        raise out_of_range(f"the point {at} of a pallet of {of.points}")
    if of.direction == _ARC_PALLET:
        return _arc_position(of, at)
    along, rows = of.counts
    row, column = divmod(at - 1, along)
    # Every other row runs backwards.
    if of.direction == _ZIGZAG_PALLET and row % 2:
        column = along - 1 - column
    # A single row or column has no step.
    i = column / (along - 1) if along > 1 else 0.0
    j = row / (rows - 1) if rows > 1 else 0.0
    place = tuple(_grid_mean(of, axis, i, j) for axis in range(3))
    turned = tuple(_grid_mean(of, axis, i, j) for axis in range(3, 6))
    return _pallet_position(of, place, turned)


def _pallet_position(
    of: Grid, place: tuple[float, ...], turned: tuple[float | None, ...]
) -> Position:
    turned = of.start.values[3:6] if of.fixed else turned
    return Position(eight((*place, *turned)), of.start.flags)


def _arc_position(of: Grid, at: int) -> Position:
    """Points at equal angles from the start to the end of the arc.

    Through places on a line they are at equal distances, as `Mvr` goes straight there.
    """
    a, b, c = (np.array(p.values[:3], dtype=np.float64) for p in (of.start, of.first, of.second))
    circle = circle_through(a, b, c)
    share = (at - 1) / (of.counts[0] - 1) if of.counts[0] > 1 else 0.0
    place = a + share * (c - a) if circle is None else circle.at(a, share * circle.angle(a, c))
    ends = [
        (_known_element(of.start, axis), _known_element(of.second, axis)) for axis in range(3, 6)
    ]
    turned = tuple(one + share * (other - one) for one, other in ends)
    return _pallet_position(of, tuple(float(v) for v in place), turned)


def _grid_mean(of: Grid, axis: int, i: float, j: float) -> float:
    start, first, second = (_known_element(c, axis) for c in (of.start, of.first, of.second))
    made = start + i * (first - start) + j * (second - start)
    if of.opposite is None:
        return made
    return made + i * j * (_known_element(of.opposite, axis) - first - second + start)


def _known_element(corner: Position, axis: int) -> float:
    value = corner.values[axis]
    assert value is not None
    return value
