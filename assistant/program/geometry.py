"""Poses, frames, tools and targets, in mm and unit quaternions; points on arcs and grids."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats, finite_rows, number_within, reals, rows_of
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, error

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

UNUSED_AXIS: Final = float("nan")
"""An external axis that a target does not name (9E9 in RAPID, absent in MELFA-BASIC)."""
_ROUNDING: Final = 1e-5
"""Deviation from a rotation that a matrix of rounded numbers may have."""
_NO_POSE: Final = error(
    "TB447",
    "a pose {reason}",
    "give a position (x, y, z) in mm and a unit quaternion (w, x, y, z), or a matrix (4, 4) or "
    "(3, 3) of a rotation to Pose.of_matrix; assistant.pose.of takes SE3 and all other forms",
)


@dataclass(frozen=True, slots=True)
class Pose:
    """Position in mm and orientation as a unit quaternion (w, x, y, z).

    `first @ second` composes two poses: `second`, given in the frame of `first`, in the frame
    that `first` is given in. Numbers that are not finite are kept as they were read; what moves or
    writes a pose refuses them. Raises Refused for another number of numbers.
    """

    position: Vector = (0.0, 0.0, 0.0)
    quaternion: Quaternion = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        # Running programs make millions of poses: tuples of the right lengths are not converted.
        position, quaternion = self.position, self.quaternion
        if type(position) is tuple is type(quaternion) and len(position) + len(quaternion) == 7:
            if len(position) == 3 and type(position[0]) is float is type(quaternion[0]):
                return
        object.__setattr__(self, "position", _tuple_of(position, 3, "position"))
        object.__setattr__(self, "quaternion", _tuple_of(quaternion, 4, "quaternion"))

    def __matmul__(self, other: Pose) -> Pose:
        """The pose `other`, given in this one's frame, in this one's own frame."""
        if not isinstance(other, Pose):
            return NotImplemented
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
        """Return the pose that composes with this one to the identity."""
        w, x, y, z = self.quaternion
        back = w, -x, -y, -z
        a, b, c = _turned(back, self.position)
        return Pose((0.0 - float(a), 0.0 - float(b), 0.0 - float(c)), _canonical(back))

    def moved(self, points: Floats) -> Floats:
        """Points (n, 3) of this frame, in its own frame."""
        rows = rows_of(points, 3, "points")
        turned = rotations.rotate(np.array(self.quaternion), rows)
        out = np.asarray(turned + np.array(self.position))
        return out if np.ndim(points) != 1 or not len(out) else out[0]

    def offset(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Pose:
        """Moved along its own axes (mm); negative z backs off along the tool."""
        try:
            by = float(x), float(y), float(z)
        except (TypeError, ValueError):
            by = _vector_of([x, y, z], "offset")
        return self @ Pose(by)

    @property
    def rotation(self) -> Floats:
        """Rotation matrix (3, 3) of the orientation; its columns are the axes of this frame.

        Raises Refused if the quaternion is zero or not finite.
        """
        return rotations.to_matrix(_unit(self.quaternion))

    @property
    def matrix(self) -> Floats:
        """Homogeneous matrix (4, 4): the rotation, and the position in mm in the last column.

        Raises Refused as `rotation` does.
        """
        made = np.eye(4)
        made[:3, :3] = self.rotation
        made[:3, 3] = self.position
        return made

    @staticmethod
    def of_matrix(matrix: ArrayLike, position: ArrayLike | None = None) -> Pose:
        """Return the pose of a homogeneous matrix (4, 4), or of a rotation matrix (3, 3).

        position: (3,) in mm, of a rotation matrix; without it the pose is at the origin. The
        quaternion is of unit length, its first part that is not zero positive. The matrix may be
        a rotation up to 1e-5, as numbers of six decimals are.

        Raises Refused for another shape, numbers that are not finite, a matrix that scales,
        shears or mirrors, a last row other than 0 0 0 1, and a position beside a (4, 4).
        """
        try:
            given = reals(matrix)
        except ValueError as fault:
            raise Refused(_NO_POSE(reason=f"is no matrix: {fault}")) from None
        if given.shape not in ((3, 3), (4, 4)) or not np.isfinite(given).all():
            reason = f"is a matrix (4, 4) or (3, 3) of finite numbers, not {given.shape}"
            shaped = given.shape in ((3, 3), (4, 4))
            reason = "has a matrix with numbers that are not finite" if shaped else reason
            raise Refused(_NO_POSE(reason=reason))
        if given.shape == (4, 4):
            if position is not None:
                raise Refused(_NO_POSE(reason="of a matrix (4, 4) already holds a position"))
            if not np.allclose(given[3], (0.0, 0.0, 0.0, 1.0), rtol=0.0, atol=_ROUNDING):
                raise Refused(_NO_POSE(reason="has a matrix whose last row is not 0 0 0 1"))
        turn = given[:3, :3]
        if (
            not np.allclose(turn @ turn.T, np.eye(3), rtol=0.0, atol=_ROUNDING)
            or np.linalg.det(turn) < 0.0
        ):
            reason = "has a matrix that is not a rotation: it scales, shears or mirrors"
            raise Refused(_NO_POSE(reason=reason))
        place = given[:3, 3] if len(given) == 4 else np.zeros(3)
        if position is not None:
            (place,) = finite_rows(np.array(_tuple_of(position, 3, "position")), 3, "position")
        return Pose.of(place, rotations.from_matrix(turn))

    def interpolate(self, end: Pose, part: float) -> Pose:
        """Return the pose at a part, 0 to 1, of the straight motion from this pose to `end`.

        The position moves along the line, the orientation by the shorter turn at an even rate
        (slerp); 0 gives this pose and 1 gives `end`. Half a turn has two shorter turns: which of
        them is taken is then not stated.

        Raises Refused for a part that is not from 0 to 1, and as `rotation` does.
        """
        if not isinstance(end, Pose):
            raise Refused(_NO_POSE(reason=f"is wanted, not {type(end).__name__}"))
        part = number_within(part, "the part of a motion", least=0.0, most=1.0)
        first, last = np.array(self.position), np.array(end.position)
        turned = rotations.between(_unit(self.quaternion), _unit(end.quaternion), part)
        return Pose.of((1.0 - part) * first + part * last, rotations.canonical(turned))

    @staticmethod
    def of(position: Floats, quaternion: Floats) -> Pose:
        """Return the pose of a position (3,) in mm and a unit quaternion (4,), as they are."""
        try:
            x, y, z = (float(v) + 0.0 for v in position)
            q1, q2, q3, q4 = (float(v) + 0.0 for v in quaternion)
        except (TypeError, ValueError):
            wrong = _tuple_of(position, 3, "position"), _tuple_of(quaternion, 4, "quaternion")
            raise Refused(_NO_POSE(reason=f"is {wrong}")) from None
        return Pose((x, y, z), (q1, q2, q3, q4))


def _vector_of(values: ArrayLike, what: str) -> Vector:
    x, y, z = _tuple_of(values, 3, what)
    return x, y, z


def _tuple_of(values: ArrayLike, width: int, what: str) -> tuple[float, ...]:
    """Return the numbers of a position or quaternion; raise Refused for another shape."""
    try:
        given = reals(values)
    except ValueError as reason:
        raise Refused(_NO_POSE(reason=f"has a {what} that is not numbers: {reason}")) from None
    if given.shape != (width,):
        shape = f"shape {given.shape}, not ({width},)"
        raise Refused(_NO_POSE(reason=f"has a {what} of {shape}"))
    return tuple(given.tolist())


def _unit(quaternion: Quaternion) -> Floats:
    """Unit length (4,); raises Refused for what is not a rotation."""
    length = math.hypot(*quaternion)
    if not (math.isfinite(length) and length > 0.0):
        raise Refused(_NO_POSE(reason=f"has {quaternion}, which is no quaternion of a rotation"))
    _, exponent = math.frexp(length)  # a power of 2 changes no digit, and the squares are numbers
    return rotations.canonical([math.ldexp(part, -exponent) for part in quaternion])


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
    # Zero and NaN go to the columns, which raise and warn as they do for others.
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
    """Load of a tool: mass in kg, centre of gravity in mm, inertia in kg·m²."""

    mass: float
    centre: Vector = (0.0, 0.0, 0.0)
    axes: Quaternion = (1.0, 0.0, 0.0, 0.0)
    inertia: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Tool:
    """A tool: pose of its tip in the flange frame, and its load if that is known.

    held: True if the robot carries it, False for a stationary tool. free_turn: True if the rotation
    about the tool's z axis has no effect on the work, as for a round nozzle or a milling cutter.
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


@dataclass(frozen=True, slots=True)
class ArcMeasures:
    """Measures of n arcs, NaN where a point is not known.

    sides: (n, 3) mm from start to via, from via to end, from start to end.
    area: (n,) mm² of the parallelogram that via and end span from the start.
    apart: (n,) degrees between via and end, seen from the start.
    around: (n,) degrees that the arc goes round.
    """

    sides: Floats
    area: Floats
    apart: Floats
    around: Floats

    @staticmethod
    def through(points: Floats) -> ArcMeasures:
        """points: (n, 3, 3) start, via and end."""
        start, via, end = (points[:, i] for i in range(3))
        to_via, to_end, rest = via - start, end - start, end - via
        lengths = np.linalg.norm(np.stack([to_via, rest, to_end], axis=1), axis=2)
        area = np.linalg.norm(np.cross(to_via, to_end), axis=1)
        # the angle at the via point stands on the part of the circle that is left out
        return ArcMeasures(
            lengths,
            area,
            _angles_between(to_via, to_end),
            360.0 - 2.0 * _angles_between(-to_via, rest),
        )


def _angles_between(a: Floats, b: Floats) -> Floats:
    """(n,) degrees between vectors (n, 3)."""
    sine = np.linalg.norm(np.cross(a, b), axis=1)
    angles: Floats = np.degrees(np.arctan2(sine, (a * b).sum(axis=1)))
    return angles


_COLLINEAR_SINE: Final = 1e-6
"""Sine of an angle below which three points are on a line."""


def arc_middle_across(start: Floats, end: Floats, other: Floats) -> Floats | None:
    """The middle of the arc on the other side of a point of its circle; None on a line."""
    chord, aside = end - start, other - start
    normal = np.cross(chord, aside)
    if np.linalg.norm(normal) <= _COLLINEAR_SINE * np.linalg.norm(chord) * np.linalg.norm(aside):
        return None
    # The circumcentre from two edge vectors at the start.
    centre = start + (
        (aside @ aside) * np.cross(normal, chord) + (chord @ chord) * np.cross(aside, normal)
    ) / (2 * normal @ normal)
    # Away from the other point, across the chord.
    away = chord * (aside @ chord) / (chord @ chord) - aside
    middle: Floats = centre + away * np.linalg.norm(start - centre) / np.linalg.norm(away)
    return middle


def arc_middle_around(start: Floats, end: Floats, centre: Floats, most: float) -> Floats | None:
    """Return the middle of the arc of less than half a turn about a centre; None if no such arc
    exists.

    most: mm by which start and end may differ in their distance from the centre.
    """
    one, two = start - centre, end - centre
    radii = np.linalg.norm(one), np.linalg.norm(two)
    between = one + two
    length = np.linalg.norm(between)
    turned = np.linalg.norm(np.cross(one, two)) > _COLLINEAR_SINE * radii[0] * radii[1]
    # Start and end are in line with the centre: half a turn or none, without a middle.
    if abs(radii[0] - radii[1]) > most or not turned:
        return None
    middle: Floats = centre + between * (radii[0] + radii[1]) / 2 / length
    return middle


def target_between(first: Target, last: Target, middle: Floats) -> Target:
    """A point on the way between two targets: turned halfway, in the branch of the first."""
    one, two = np.array(first.pose.quaternion), np.array(last.pose.quaternion)
    # The shorter turn: both signs of a quaternion are one orientation.
    turned = one + (two if one @ two >= 0 else -two)
    pose = Pose.of(middle, turned / np.linalg.norm(turned))
    return Target(pose, first.configuration, first.external)


def grid_points(corners: Floats, columns: int, rows: int, zigzag: bool) -> Iterator[Floats]:
    """The points of a grid, row by row.

    corners: (3 or 4, 3) start, end of the first row, end of the first column, and the corner
    across, which makes it bilinear. zigzag: every other row runs backwards.
    """
    start, along, across = corners[:3]
    diagonal = corners[3] if len(corners) > 3 else along + across - start
    for row in range(rows):
        down = row / (rows - 1) if rows > 1 else 0.0
        order = range(columns)
        for column in reversed(order) if zigzag and row % 2 else order:
            right = column / (columns - 1) if columns > 1 else 0.0
            near = (1 - right) * start + right * along
            far = (1 - right) * across + right * diagonal
            yield (1 - down) * near + down * far


def points_on_arc(places: Floats, count: int) -> Iterator[Floats]:
    """Points at equal angles on an arc, its ends among them; at equal distances on a line.

    places: (3, 3) its start, a point on its way, and its end.
    """
    start, via, end = places
    chord, aside = end - start, via - start
    normal = np.cross(aside, chord)
    size = float(np.linalg.norm(normal))
    shares = [k / (count - 1) if count > 1 else 0.0 for k in range(count)]
    if size <= _COLLINEAR_SINE * np.linalg.norm(chord) * np.linalg.norm(aside):
        yield from (start + share * chord for share in shares)
        return
    centre = start + (
        # The circumcentre, from the start.
        (aside @ aside) * np.cross(chord, normal) + (chord @ chord) * np.cross(normal, aside)
    ) / (2 * size**2)
    right, last = start - centre, end - centre
    up = np.cross(normal / size, right)
    # From 0 to a full turn: `up` points ahead at the start.
    whole = float(np.arctan2(last @ up, last @ right)) % (2 * np.pi)
    for share in shares:
        yield centre + np.cos(share * whole) * right + np.sin(share * whole) * up
