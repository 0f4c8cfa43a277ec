"""Trajectories, resampled to the cycle of a controller within limits of speed and acceleration.

Rows are joints in degrees or mm (pulses of some controllers), or poses: x, y, z in mm and
w, x, y, z. The curve through the rows never leaves the range between two neighbours, column by
column.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final, Literal, Protocol, get_args

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, norms, number_of, reals
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Rule
from assistant.controllers.cyclic.rules import (
    BAD_LIMITS,
    BAD_SETTING,
    BAD_TRAJECTORY,
    NO_ROBOT_OF_ROWS,
    NO_ROW_UNIT,
)
from assistant.program.expressions import Name
from assistant.program.geometry import BASE
from assistant.program.motion import Kind as Move
from assistant.program.motion import Path
from assistant.program.se3 import METRE, AnyPoses, Unit, columns_of

Kind = Literal["joints", "poses"]
"""Rows of joints, degrees or mm each (or pulses); or of x, y, z in mm with w, x, y, z."""

RowUnit = Literal["deg", "rad", "pulse"]
"""Degrees, and mm of an axis that slides; radians, and m; or pulses of motors."""


class Axes(Protocol):
    """What a `Robot` tells of its axes: names (a,), which (a,) slide, and limits.

    speeds, accelerations: (a,) a second. limits: (a, 2).
    """

    @property
    def axes(self) -> tuple[str, ...]: ...

    @property
    def sliding(self) -> Truths | Sequence[bool]: ...

    @property
    def speeds(self) -> Floats: ...

    @property
    def accelerations(self) -> Floats | None: ...

    @property
    def limits(self) -> Floats: ...


def numbered(axes: Sequence[str], values: Floats, missing: float) -> Floats:
    """Values of axes (…, a) with a column for each number; missing: of axes that the arm lacks.

    At least six columns: protocols count six axes even where the arm has fewer.
    """
    places = [int(axis[1:]) - 1 for axis in axes]
    found = np.full((*values.shape[:-1], max(6, max(places) + 1)), missing)
    found[..., places] = values
    return found


POSE_COLUMNS: Final = 7
_TO_FULL_SPEED: Final = 0.3
"""Seconds in which an axis may come to its full speed where no acceleration is given: cautious,
makers quote less for light loads."""


def sizes(kind: Kind, changes: Floats) -> Floats:
    """Return the sizes of changes of rows (n, c) in the quantities that have a limit.

    (n, c) a joint each; for poses (n, 2), mm and degrees.
    """
    if kind == "joints":
        return np.asarray(np.abs(changes))
    # w, x, y, z of a small turn: twice the length of the change is its angle in radians.
    turn = 2.0 * np.degrees(norms(changes[:, 3:]))
    return np.column_stack([norms(changes[:, :3]), turn])


@dataclass(frozen=True, slots=True)
class ArmLimits:
    """Limits of the joints of an arm while its tool follows poses.

    joints: (n, 7) poses → (n, a) joints without jumps from row to row, of the caller's robot; it
    may raise Refused. speeds: (a,) a second.
    """

    joints: Callable[[Floats], Floats]
    speeds: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits that no cycle may exceed.

    speeds: of joints, each a second; of poses two, mm/s and deg/s. accelerations: likewise a second
    squared, None for a cautious `_TO_FULL_SPEED`. lowest, highest: of joints, None for none. arm:
    for poses, the limits of their joints; without it only the tool's speed is limited.
    """

    speeds: tuple[float, ...]
    accelerations: tuple[float, ...] | None = None
    lowest: tuple[float, ...] | None = None
    highest: tuple[float, ...] | None = None
    arm: ArmLimits | None = None

    @staticmethod
    def of_robot(robot: Axes, percent: float = 100.0) -> Limits:
        """Return the limits of the joints of an arm, a column for each number from J1 to J6.

        percent: of its speeds; accelerations get slower by its square, so that the path stays.
        """
        _require_axes(robot, BAD_LIMITS)
        percent = number_of(percent, "percent")
        if not 0.0 < percent <= 100.0:
            raise Refused(BAD_LIMITS(reason=f"{percent:g} percent of its speeds"), exit_status=2)
        part, rises = percent / 100.0, robot.accelerations
        low, high = robot.limits.T
        return Limits(
            tuple(numbered(robot.axes, part * robot.speeds, 1.0).tolist()),
            None if rises is None else tuple(numbered(robot.axes, part**2 * rises, 1.0).tolist()),
            tuple(numbered(robot.axes, low, -1.0).tolist()),
            tuple(numbered(robot.axes, high, 1.0).tolist()),
        )

    def columns(self, kind: Kind, width: int) -> tuple[Floats, Floats]:
        """Speeds and accelerations (k,) for rows of that kind; Refused if they do not fit."""
        count = width if kind == "joints" else 2
        try:
            speeds = reals(self.speeds)
            given = self.accelerations
            rises = speeds / _TO_FULL_SPEED if given is None else reals(given)
        except ValueError as error:
            raise Refused(BAD_LIMITS(reason=error), exit_status=2) from None
        for what, values in (("speeds", speeds), ("accelerations", rises)):
            if values.shape != (count,):
                reason = f"{values.size} {what} for {count} {_of(kind)}"
                raise Refused(BAD_LIMITS(reason=reason), exit_status=2)
            if not (np.isfinite(values) & (values > 0.0)).all():
                raise Refused(BAD_LIMITS(reason=f"{what} {values.tolist()}"), exit_status=2)
        return speeds, rises

    def outside(self, kind: Kind, rows: Floats) -> str:
        """Describe the first joint of rows (n, a) outside its range, "" if all are inside."""
        if kind != "joints":
            return ""
        for bound, sign, word in ((self.lowest, -1.0, "below"), (self.highest, 1.0, "above")):
            if bound is None:
                continue
            try:
                ends = np.atleast_1d(reals(bound))
            except ValueError as error:
                raise Refused(BAD_LIMITS(reason=error), exit_status=2) from None
            if len(ends) != rows.shape[1]:
                reason = f"{len(ends)} ends of range for {rows.shape[1]} joints"
                raise Refused(BAD_LIMITS(reason=reason), exit_status=2)
            beyond = ~(sign * (rows - ends) <= 1e-6)  # also where a bound is no number
            if beyond.any():
                row, joint = (int(v) for v in np.argwhere(beyond)[0])
                at = f"{rows[row, joint]:g} is {word} {ends[joint]:g}"
                return f"J{joint + 1} of point {row + 1}: {at}"
        return ""


def braked(room: float, rise: float, cycle: float) -> float:
    """Return the greatest speed for a cycle from which an axis still comes to rest within its room.

    With n more cycles of braking by `rise` after it: v (n + 1) T - a T² n (n + 1) / 2 = room.
    """
    if not room > 0.0:
        return 0.0
    step = rise * cycle * cycle
    # The largest n whose braking fits into the room: the root of n (n + 1) = 2 room / step.
    n = math.floor((math.sqrt(1.0 + 8.0 * room / step) - 1.0) / 2.0)
    return (room + step * n * (n + 1) / 2.0) / ((n + 1) * cycle)


def _of(kind: Kind) -> str:
    return "joints" if kind == "joints" else "limits of poses (mm/s, deg/s)"


def column_names(kind: Kind, width: int) -> tuple[str, ...]:
    """Return the names of the columns of rows in files and messages."""
    if kind == "joints":
        return tuple(f"J{i}" for i in range(1, width + 1))
    return ("x", "y", "z", "qw", "qx", "qy", "qz")


def _checked_rows(rows: Sequence[Sequence[float]] | Floats) -> Floats:
    """Rows as (n, c) finite floats; raises ValueError with what is wrong."""
    values = reals(rows)
    if values.ndim != 2 or not len(values) or not values.shape[1]:
        raise ValueError(f"its shape is {values.shape}, not (points, columns)")
    if not np.isfinite(values).all():
        row = int(np.argwhere(~np.isfinite(values))[0, 0])
        raise ValueError(f"point {row + 1} holds a number that is not finite")
    return values


@dataclass(frozen=True, slots=True, eq=False)
class _Curve:
    """at: (n,) increasing. rows, slopes: (n, c), slopes by `at`."""

    at: Floats
    rows: Floats
    slopes: Floats

    @staticmethod
    def through(at: Floats, rows: Floats) -> _Curve:
        step = np.diff(at)[:, None]
        chord = np.diff(rows, axis=0) / step
        slopes = np.zeros_like(rows)
        if len(rows) == 2:
            # Two points: a straight line, whose slope is that of its chord.
            slopes[:] = chord
            return _Curve(at, rows, slopes)
        before, after = chord[:-1], chord[1:]
        one, two = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
        # At an extremum the slope is 0, so that the curve does not overshoot the point.
        same = before * after > 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            # Weighted harmonic mean (Fritsch and Butland): keeps each piece within its end points.
            mean = (one + two) / (one / before + two / after)
        slopes[1:-1] = np.where(same, mean, 0.0)
        slopes[0], slopes[-1] = chord[0], chord[-1]
        return _Curve(at, rows, slopes)

    def piece(self, s: Floats) -> Rows:
        """The piece (m,) in which each place lies."""
        return np.clip(np.searchsorted(self.at, s, side="right") - 1, 0, len(self.at) - 2)

    def values(self, s: Floats) -> Floats:
        """The rows (m, c) at places (m,)."""
        i = self.piece(s)
        step = (self.at[i + 1] - self.at[i])[:, None]
        t = ((s - self.at[i])[:, None]) / step
        a, b = self.rows[i], self.rows[i + 1]
        u, v = self.slopes[i] * step, self.slopes[i + 1] * step
        rise = b - a
        # Cubic Hermite polynomial by Horner's rule.
        return np.asarray(a + t * (u + t * (3.0 * rise - 2.0 * u - v + t * (u + v - 2.0 * rise))))

    def changes(self, i: Rows, s: Floats) -> tuple[Floats, Floats]:
        """First and second derivatives (m, c) at places (m,) of the pieces i (m,)."""
        step = (self.at[i + 1] - self.at[i])[:, None]
        t = ((s - self.at[i])[:, None]) / step
        u, v = self.slopes[i] * step, self.slopes[i + 1] * step
        rise = self.rows[i + 1] - self.rows[i]
        two, three = 3.0 * rise - 2.0 * u - v, u + v - 2.0 * rise
        return (u + t * (2.0 * two + 3.0 * t * three)) / step, (
            2.0 * two + 6.0 * t * three
        ) / step**2


_MOST_ROWS: Final = 2_000_000
"""Cycles of one trajectory: 3.9 hours at 7.11 ms."""
_SAMPLES_IN_CYCLE: Final = 4
"""Positions in a cycle at which the limits are checked, for trajectories with times."""
_FEWEST_SAMPLES: Final = 8
_MOST_SAMPLES: Final = 4096
"""Positions in a piece between two points at which the limits are checked."""
_LEAST_TIME: Final = 1e-9
"""Seconds between two points."""
_MARGIN: Final = 0.995
"""Part of the limits that is used: rounding to single precision in packets stays within."""
_ROUNDS: Final = 40
_FASTEST: Final = 1e6
"""Greatest factor by which a trajectory without times may be faster than `_nominal`; limits apply
before.
"""


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Points to be gone through. rows: (n, c). times: (n,) seconds, None for as fast as allowed."""

    kind: Kind
    rows: Floats
    times: Floats | None = None

    @staticmethod
    def of_joints(
        rows: Sequence[Sequence[float]] | Floats,
        times: Sequence[float] | Floats | None = None,
        *,
        unit: RowUnit | None = None,
        robot: Axes | None = None,
    ) -> Trajectory:
        """Return a trajectory of joints, which leads an arm.

        rows: (n, a), or an object with such an array as `q`, like what `jtraj` of roboticstoolbox
        gives. times: (n,) seconds, None for as fast as the limits allow. unit: it has to be stated:
        "deg" for degrees, and mm of an axis that slides; "rad" for radians, and m; "pulse" for
        pulses of the motors. robot: whose axes the columns are, needed for "rad", as it knows which
        of them slide; the trajectory then has a column for each number from J1 to J6, as the
        protocols have, 0 for an axis that the arm lacks. Raises Refused.
        """
        if robot is not None:
            _require_axes(robot, BAD_TRAJECTORY)
        if not isinstance(unit, str) or unit not in get_args(RowUnit):
            known = "no unit of its joints" if unit is None else None
            reason = known or f"the unit of its joints is {unit!r:.40}"
            raise Refused(NO_ROW_UNIT(reason=reason), exit_status=2)
        made = _made("joints", getattr(rows, "q", rows), times)
        width = made.rows.shape[1]
        if robot is not None and width != len(robot.axes):
            reason = f"its shape is {made.rows.shape}, not (n, {len(robot.axes)})"
            raise Refused(BAD_TRAJECTORY(reason=reason), exit_status=2)
        if robot is None:
            if unit == "rad":
                raise Refused(NO_ROBOT_OF_ROWS(), exit_status=2)
            return made
        if unit == "rad":
            turned = np.where(robot.sliding, made.rows * METRE["m"], np.degrees(made.rows))
            made = replace(made, rows=turned)
        return replace(made, rows=numbered(robot.axes, made.rows, 0.0))

    @staticmethod
    def of_poses(
        positions: AnyPoses,
        quaternions: Sequence[Sequence[float]] | Floats | None = None,
        times: Sequence[float] | Floats | None = None,
        *,
        unit: Unit | None = None,
    ) -> Trajectory:
        """Return a trajectory of poses of the tool.

        positions: (n, 3) mm, with quaternions (n, 4), scalar first; or poses of any form of
        `assistant.pose.columns`, without. unit: of the positions, needed for SE3, matrices and rows
        of seven. times: as of `of_joints`. Raises Refused.
        """
        if quaternions is None or unit is not None:
            poses = positions if quaternions is None else (positions, quaternions)
            positions, quaternions = columns_of(poses, unit=unit)
        try:
            place, turn = _checked_rows(positions), _checked_rows(quaternions)
            if place.shape[1] != 3 or turn.shape != (len(place), 4):
                raise ValueError(f"positions {place.shape} and quaternions {turn.shape}")
            if not (np.abs(turn).max(axis=1) > 0.0).all():
                raise ValueError("a quaternion is 0")
        except ValueError as error:
            raise Refused(BAD_TRAJECTORY(reason=error), exit_status=2) from None
        # Signs may differ from row to row for the same turn; neighbours must be close in numbers.
        turn = rotations.unflipped(rotations.canonical(turn))
        return _made("poses", np.column_stack([place, turn]), times)

    @staticmethod
    def of_path(path: Path) -> Trajectory:
        """The poses of a path of straight lines, at the speeds of its tool.

        Its frame and tool are those that the controller works in. Raises Refused for arcs, moves
        of the joints, frames, external axes, and speeds that are variables: simulate those
        programs, and give their joints.
        """
        if not isinstance(path, Path):
            reason = f"`{str(path)[:40]}` is no Path, as a statement of a program holds it"
            raise Refused(BAD_TRAJECTORY(reason=reason), exit_status=2)
        refusal = _refusal(path)
        if refusal:
            raise Refused(BAD_TRAJECTORY(reason=refusal), exit_status=1)
        mm_s = np.array([s.tcp for s in path.speeds if not isinstance(s, Name)])
        turning = np.array([s.rotation for s in path.speeds if not isinstance(s, Name)])
        one = Trajectory.of_poses(path.positions, path.quaternions)
        change = sizes("poses", np.diff(one.rows, axis=0))
        row = path.speed[1:]
        seconds = np.maximum(change[:, 0] / mm_s[row], change[:, 1] / turning[row])
        # Rows in the same place take no time, which `_Curve` would divide by.
        moving = np.concatenate([[True], seconds > 1e-9])
        times = np.concatenate([[0.0], np.cumsum(seconds)])[moving]
        return replace(one, rows=one.rows[moving], times=times if len(times) > 1 else None)

    def __len__(self) -> int:
        return len(self.rows)


def _require_axes(robot: object, rule: Rule) -> None:
    """Raises Refused for what is no robot, such as its name."""
    if not hasattr(robot, "axes"):
        name = f'"{robot[:40]}"' if isinstance(robot, str) else "NAME"
        reason = f"`{str(robot)[:40]}` is no Robot, as assistant.robots.get({name}) returns"
        raise Refused(rule(reason=reason), exit_status=2)


def _made(
    kind: Kind,
    rows: Sequence[Sequence[float]] | Floats,
    times: Sequence[float] | Floats | None,
) -> Trajectory:
    try:
        values = _checked_rows(rows)
        if times is None:
            return Trajectory(kind, values)
        at = reals(times)
        if at.shape != (len(values),):
            raise ValueError(f"{len(values)} points but times of shape {at.shape}")
        if not np.isfinite(at).all() or not (np.diff(at) >= _LEAST_TIME).all():
            raise ValueError("its times do not rise from point to point")
    except ValueError as error:
        raise Refused(BAD_TRAJECTORY(reason=error), exit_status=2) from None
    return Trajectory(kind, values, at - at[0])


def _refusal(path: Path) -> str:
    """Why a path cannot be followed as poses in time, "" if it can."""
    if not len(path):
        return "it has no points"
    if not (path.kinds[1:] == Move.LINEAR).all():
        return "it has moves that are no straight lines"
    if any(frame != BASE for frame in path.frames) or len(set(path.tool.tolist())) > 1:
        return "it has frames of its own, or several tools"
    if np.isfinite(path.external).any():
        return "it has external axes"
    for speed in path.speeds:
        if isinstance(speed, Name) or not 0.0 < speed.tcp < np.inf:
            return "a speed of it is a variable or no number of mm/s"
    return ""


def resampled(trajectory: Trajectory, limits: Limits, cycle: float) -> Floats:
    """The rows (m, c) to command, one a cycle, from the first point to the last, at rest at both.

    No step from row to row exceeds a speed times the cycle, no change between two steps an
    acceleration times its square. Raises Refused if points are out of range, if the limits do not
    fit, or if no time stretched that far keeps them.
    """
    if not 0.0 < cycle <= 1.0:
        what = BAD_SETTING(name="cycle", value=cycle, reason="it is seconds, above 0, at most 1")
        raise Refused(what, exit_status=2)
    # A dataclass made without `of_joints` or `of_poses` was never checked.
    trajectory = _made(trajectory.kind, trajectory.rows, trajectory.times)  # whoever made it
    speeds, rises = limits.columns(trajectory.kind, trajectory.rows.shape[1])
    _width(trajectory)
    outside = limits.outside(trajectory.kind, trajectory.rows)
    if outside:
        raise Refused(BAD_TRAJECTORY(reason=f"{outside} of its range"))
    points, times, fastest = _with_times(trajectory, speeds)
    if len(points) == 1:
        return points
    curve = _Curve.through(times, points)
    places = _places(times, cycle, trajectory.times is not None)
    v, a = speeds * _MARGIN, rises * _MARGIN
    for _ in range(_ROUNDS):
        rows = _in_time(curve, places, trajectory.kind, v, a, fastest, cycle)
        too_fast = _excess(trajectory.kind, rows, limits, speeds, rises, cycle)
        if too_fast <= 1.0:
            return rows
        # Slightly more than the excess asks for; and at
        # least 2 %, so that the rounds come to an end.
        slower = min(0.98, 0.99 / too_fast)
        # Time stretched by a factor lowers speeds by it and accelerations by its square.
        v, a, fastest = v * slower, a * slower**2, fastest * slower
    raise Refused(BAD_TRAJECTORY(reason="no time that it may take keeps the limits"))


def _width(trajectory: Trajectory) -> None:
    width = trajectory.rows.shape[1]
    if trajectory.kind == "poses" and width != POSE_COLUMNS:
        raise Refused(BAD_TRAJECTORY(reason=f"poses have {POSE_COLUMNS} columns, not {width}"))


def _with_times(trajectory: Trajectory, speeds: Floats) -> tuple[Floats, Floats, float]:
    """Points that differ, their times, and how many times faster than these it may go."""
    rows, times = trajectory.rows, trajectory.times
    if times is not None:
        return rows, times, 1.0
    seconds = (sizes(trajectory.kind, np.diff(rows, axis=0)) / speeds).max(axis=1, initial=0.0)
    moving = np.concatenate([[True], seconds > 1e-9])
    at = np.concatenate([[0.0], np.cumsum(seconds)])[moving]
    return rows[moving], at, _FASTEST


def _places(times: Floats, cycle: float, given: bool) -> Floats:
    """Places (p,) on the curve, all points among them, so close that limits hold in between."""
    step = np.diff(times)
    # Points without times may be far apart in one step: the bends between them need samples.
    least = 2 if given else _FEWEST_SAMPLES
    parts = np.clip(np.ceil(step * (_SAMPLES_IN_CYCLE / cycle)), least, _MOST_SAMPLES).astype(
        np.intp
    )
    if parts.sum() > _SAMPLES_IN_CYCLE * _MOST_ROWS:
        raise Refused(BAD_TRAJECTORY(reason=f"it has more than {_MOST_ROWS:,} cycles"))
    piece = np.repeat(np.arange(len(step)), parts)
    inside = np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.append(times[piece] + step[piece] * inside / parts[piece], times[-1])


def _in_time(
    curve: _Curve, places: Floats, kind: Kind, v: Floats, a: Floats, fastest: float, cycle: float
) -> Floats:
    """Rows at the cycle, along the curve as fast as v and a let it, at rest at both ends.

    Half of each acceleration is for the bends of the curve, half for speeding up along it.
    """
    piece = curve.piece(places[:-1])
    ends = [curve.changes(piece, s) for s in (places[:-1], places[1:])]
    first = np.maximum(*(sizes(kind, one) for one, _ in ends))
    second = np.maximum(*(sizes(kind, two) for _, two in ends))
    with np.errstate(divide="ignore"):
        # v² bounds the squared rate; half of the acceleration
        # is left for the bend (second derivative).
        most = np.minimum((v / first) ** 2, a / (2.0 * second)).min(axis=1)
        rise = (a / (2.0 * first)).min(axis=1)
    most = np.minimum(most, fastest**2)
    step = np.diff(places)
    squares = _along(most, 2.0 * np.minimum(rise, 1e12) * step)
    rate = np.sqrt(squares)
    # The squared rate is linear in the place: constant
    # acceleration, whose mean is that of the ends.
    seconds = 2.0 * step / (rate[:-1] + rate[1:])
    clock = np.concatenate([[0.0], np.cumsum(seconds)])
    # 1e-9 absorbs rounding: without it a whole number of cycles may become one more.
    count = int(np.ceil(clock[-1] / cycle - 1e-9))
    if count >= _MOST_ROWS:
        raise Refused(BAD_TRAJECTORY(reason=f"it takes more than {_MOST_ROWS:,} cycles"))
    at = np.minimum(np.arange(count + 1) * cycle, clock[-1])
    i = np.clip(np.searchsorted(clock, at, side="right") - 1, 0, len(step) - 1)
    since = at - clock[i]
    change = (squares[i + 1] - squares[i]) / (2.0 * step[i])
    s = np.clip(places[i] + since * (rate[i] + 0.5 * change * since), places[i], places[i + 1])
    rows = curve.values(s)
    if kind == "poses":
        # The curve goes through the numbers of quaternions,
        # which leaves the unit sphere between rows.
        rows[:, 3:] /= np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)
    return rows


def _along(most: Floats, gain: Floats) -> Floats:
    """Squared rates (p,) along places: from rest to rest, below `most` of the steps beside."""
    # At rest at both ends; below the limits of both pieces at each place.
    cap = np.concatenate([[0.0], np.minimum(most[1:], most[:-1]), [0.0]]).tolist()
    gains = gain.tolist()
    # Forwards no faster than it can speed up, then backwards no faster than it can brake.
    for i, more in enumerate(gains):
        cap[i + 1] = min(cap[i + 1], cap[i] + more)
    for i in range(len(gains) - 1, -1, -1):
        cap[i] = min(cap[i], cap[i + 1] + gains[i])
    return np.array(cap)


def _excess(
    kind: Kind, rows: Floats, limits: Limits, speeds: Floats, rises: Floats, cycle: float
) -> float:
    """By how much time has to be stretched for rows to keep their limits; at most 1 if they do."""
    steps = np.diff(rows, axis=0)
    found = [(sizes(kind, steps) / (speeds * cycle)).max(initial=0.0)]
    rest = np.zeros((1, rows.shape[1]))
    # Rest before and after: the first and the last step are changes of speed too.
    turns = sizes(kind, np.diff(np.concatenate([rest, steps, rest]), axis=0))
    found.append(np.sqrt((turns / (rises * cycle**2)).max(initial=0.0)))
    if kind == "poses" and limits.arm is not None:
        joints = np.abs(np.diff(limits.arm.joints(rows), axis=0))
        found.append((joints / (np.array(limits.arm.speeds) * cycle)).max(initial=0.0))
    return float(max(found))
