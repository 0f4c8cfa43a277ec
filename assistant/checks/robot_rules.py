"""Rules about how a robot runs a solved program.

Joint speeds, rounded corners, targets closer together than the controller's setpoint cycle,
reorientation times, singularities, loads, and external axes that a target leaves out. At a
singularity a joint has to turn far for a small move of the tool, so a controller slows down or
stops; a joint that gets too fast at the programmed speed is reported separately (CK311), and a move
straight through the wrist singularity by the robot (RB115).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Declared, Diagnostic, fold, info, warning
from assistant.checks.program_view import Moves, ProgramView, RunView, figure
from assistant.program.motion import Kind
from assistant.robots import Robot, SolvedProgram
from assistant.robots.robot import has_trait

_SPEED_TOLERANCE: Final = 1.02
"""By how much a joint may be too fast: rounding of speeds and limits in data sheets."""
_SHORTEST_RUN_UP: Final = 0.1
"""seconds between two stops below which no joint gets to its full speed. The maker's own planning
of the FR robots (melfa_ros2_driver) lets an axis take about 0.05 s to get there and as much to
stop."""

_TOO_FAST: Final = warning(
    "CK311",
    "{axis} would have to move at {needed:.0f} {unit}/s, its limit is {limit:g}, to keep the "
    "programmed {programmed}{worst}",
    "the robot runs slower there or stops; {possible} is possible",
)


def _joint_speeds(view: ProgramView) -> Iterator[Diagnostic]:
    robot = view.robot
    for run_view in view.run_views:
        moves, extremes = run_view.moves, run_view.extremes
        if not len(moves):
            continue
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = extremes.seconds / run_view.seconds
            stated = (
                np.isfinite(moves.tcp) & np.isfinite(run_view.seconds) & (run_view.seconds > 0.0)
            )
        stated &= ~extremes.crossed & (_between_stops(run_view) >= _SHORTEST_RUN_UP)
        fast = np.flatnonzero(stated & (ratio > _SPEED_TOLERANCE))
        for group, worst in run_view.groups(moves.rows[fast], ratio[fast]):
            at = int(fast[worst])
            axis = int(extremes.axis[at])
            yield run_view.told(
                _TOO_FAST,
                group,
                int(moves.rows[at]),
                axis=robot.axes[axis],
                unit=robot.units[axis],
                needed=robot.speeds[axis] * ratio[at],
                limit=robot.speeds[axis],
                programmed=_speed_text(moves, at, float(run_view.seconds[at])),
                possible=_speed_text(moves, at, float(extremes.seconds[at])),
            )


def _speed_text(moves: Moves, at: int, seconds: float) -> str:
    """Return the speed of a move that takes this many seconds: of the TCP, or of the rotation if it
    turns on the spot.
    """
    length, turn = float(moves.length[at]), float(moves.turn[at])
    if length / moves.tcp[at] >= turn / moves.rotation[at]:
        return f"{figure(length / seconds)} mm/s"
    return f"{figure(turn / seconds)} degrees/s of reorientation"


def _between_stops(run_view: RunView) -> Floats:
    """(m,) seconds that the joints need from the stop before a move to the one after it."""
    moves = run_view.moves
    # The slower of program and joints; `fmax` leaves NaN out where the program states no speed.
    needed = np.fmax(run_view.seconds, run_view.extremes.seconds)
    begins, ends = moves.through
    joined = np.append(False, ends[:-1] & begins[1:] & (moves.rows[:-1] == moves.starts[1:]))
    chain = np.cumsum(~joined) - 1
    whole = np.bincount(chain, np.nan_to_num(needed, posinf=0.0), minlength=1)
    # A corner into or out of what is no such move is passed at an unknown, maybe full speed.
    open_ = (
        np.bincount(
            chain, (begins | ends) & ~_between_known_moves(joined, begins, ends), minlength=1
        )
        > 0
    )
    return np.asarray(np.where(open_, np.inf, whole)[chain], dtype=np.float64)


def _between_known_moves(joined: Truths, begins: Truths, ends: Truths) -> Truths:
    """(m,) whether the corners at both ends of a move lead to other moves that are known."""
    after = np.append(joined[1:], False)
    return np.asarray((joined | ~begins) & (after | ~ends))


_WRIST_ANGLE: Final = 3.0
"""degrees of axis 5: to turn the tool by 20 deg/s beside it, axis 4 needs 20 / sin 3° = 380 deg/s,
about what the axes of the catalogue can do."""
_ELBOW_ANGLE: Final = 3.0
"""degrees from the stretched arm: at full speed of axis 3 the wrist still comes out at about
50 mm/s (links of 350 mm, 300 deg/s)."""
_SHOULDER_DISTANCE: Final = 20.0
"""mm from axis 1: past it at 100 mm/s, axis 1 needs 100 / 20 = 5 rad/s = 290 deg/s, about what the
axes of the catalogue can do."""

_NEAR_WRIST: Final = info(
    "CK301",
    "a linear or circular move takes axis 5 to {angle:.1f} degrees from the singularity of the "
    "wrist{worst}",
    "tilt the tool or the work piece so that axis 5 stays away from 0, or use a joint move",
)
_THROUGH_WRIST: Final = warning(
    "CK304",
    "between its ends, a linear or circular move goes straight through the singularity of the "
    "wrist, where axes 4 and 6 would have to turn by half a turn at once{worst}",
    "move the work piece, tilt the tool a little, or use a joint move",
)
_NEAR_ELBOW: Final = info(
    "CK302",
    "a linear or circular move takes the elbow to {angle:.1f} degrees from the stretched "
    "arm{worst}",
    "move the work piece nearer to the robot, or use a joint move",
)
_NEAR_SHOULDER: Final = info(
    "CK303",
    "a linear or circular move takes the wrist centre to {distance:.0f} mm from axis 1{worst}",
    "move the work piece away from the axis, tilt the tool, or use a joint move",
)


def _singularities(view: ProgramView) -> Iterator[Diagnostic]:
    for run_view in view.run_views:
        extremes, rows = run_view.extremes, run_view.moves.rows
        # Moves through the singularity are reported by another rule.
        wrist = np.where(extremes.crossed, np.inf, extremes.wrist)
        within = np.flatnonzero(extremes.crossed & ~extremes.by_ends)
        for group, worst in run_view.groups(rows[within], -extremes.wrist[within]):
            yield run_view.told(_THROUGH_WRIST, group, int(rows[within[worst]]))
        for rule, value, least, field in (
            (_NEAR_WRIST, wrist, _WRIST_ANGLE, "angle"),
            (_NEAR_ELBOW, extremes.elbow, _ELBOW_ANGLE, "angle"),
            (_NEAR_SHOULDER, extremes.shoulder, _SHOULDER_DISTANCE, "distance"),
        ):
            near = np.flatnonzero(value < least)
            for group, worst in run_view.groups(rows[near], -value[near]):
                at = near[worst]
                yield run_view.told(rule, group, int(rows[at]), **{field: value[at]})


_TURN_BORDER: Final = 0.05
"""degrees beside half a turn that the digits of a written position cannot tell apart."""
_TURNING: Final = [0, 3, 5]
"""Columns of axes 1, 4 and 6, whose turns a position names."""
_AXES_WITH_TURNS: Final = 6

_AT_TURN_BORDER: Final = warning(
    "CK305",
    "a joint move ends with {axis} at {angle:.2f} degrees, where the controller begins to count "
    "another turn: the last digits of the position decide which way around it goes{worst}",
    "turn the tool about its axis, by `euler_zyx` of the tool or the angles of the target, so that "
    "{axis} keeps away from half a turn",
)


def _turn_borders(view: ProgramView) -> Iterator[Diagnostic]:
    """Only of controllers whose positions name turns, by the multi-rotation flag FL2."""
    axes = view.robot.axes
    if not has_trait(view.robot, "names-turns") or len(axes) != _AXES_WITH_TURNS:
        return
    for run_view in view.run_views:
        run, joints = run_view.moves.run, run_view.moves.joints[1:]
        with np.errstate(invalid="ignore"):
            off = np.abs((joints[:, _TURNING] + 360.0) % 360.0 - 180.0)
            near = (off < _TURN_BORDER) & (run.kinds == Kind.JOINT)[:, None]
        rows = np.flatnonzero(near.any(axis=1))
        for group, worst in run_view.groups(rows, -off[rows].min(axis=1)):
            row = int(rows[worst])
            axis = _TURNING[int(off[row].argmin())]
            said = {"axis": axes[axis], "angle": joints[row, axis]}
            yield run_view.told(_AT_TURN_BORDER, group, row, **said)


_LEAST_LENGTH: Final = 1.0
"""mm below which a move turns on the spot, and no speed of the TCP is expected of it."""
_LEAST_SLOWDOWN: Final = 1.1
"""Factor by which a move must take longer to be reported; `_LEAST_DELAY` applies as well."""
_LEAST_DELAY: Final = 0.1
"""and seconds: less is lost in accelerating."""

_TURN_BINDS: Final = info(
    "CK312",
    "the tool turns by {turn:.0f} degrees on {length:.0f} mm: at {rotation:g} degrees/s of "
    "reorientation the TCP moves at {real} mm/s instead of {tcp:g}{worst}",
    "state a higher speed of reorientation, or spread the turn over a longer way",
)


def _reorientations(view: ProgramView) -> Iterator[Diagnostic]:
    """Only of controllers that take such a speed from the program."""
    if not has_trait(view.robot, "turning-speed"):
        return
    for run_view in view.run_views:
        moves = run_view.moves
        with np.errstate(invalid="ignore", divide="ignore"):
            alone = moves.length / moves.tcp
            turning = moves.turn / moves.rotation
        binds = (turning > _LEAST_SLOWDOWN * alone) & (turning > alone + _LEAST_DELAY)
        binds &= (moves.tcp > 0.0) & (moves.rotation > 0.0)  # others cannot be meant: CK201
        rows = np.flatnonzero(binds & (moves.length >= _LEAST_LENGTH) & np.isfinite(moves.tcp))
        for group, worst in run_view.groups(moves.rows[rows], turning[rows] - alone[rows]):
            at = rows[worst]
            yield run_view.told(
                _TURN_BINDS,
                group,
                int(moves.rows[at]),
                turn=moves.turn[at],
                length=moves.length[at],
                rotation=moves.rotation[at],
                real=figure(moves.length[at] / turning[at]),
                tcp=moves.tcp[at],
            )


_TURN_ON_SPOT: Final = 0.1
"""mm of way below which a move is a turn on the spot, which no corner is measured by."""
_LEAST_CUT: Final = 0.1
"""mm by which the path must come nearer to a target than its corner says. A corner of r mm where
the path turns by a passes the target at r / 2 · sin(a / 2), as a parabola does. One that is larger
than the way counts as long as that: on a dense path it just says not to stop."""

_CORNER_TOO_LARGE: Final = info(
    "CK321",
    "the corner of {radius:g} mm is more than half of the {way} mm to the next or the last "
    "target, so a controller rounds it by {half} mm at most{worst}",
    "state a smaller corner, or put the targets further apart",
)
_TARGETS_WITHIN_CORNER: Final = info(
    "CK322",
    "targets lie {way} mm apart, nearer than their corner of {radius:g} mm, which a controller "
    "rounds by {half} mm at most{worst}",
    "state a smaller corner, or leave targets out",
)


def corners(view: ProgramView) -> Iterator[Diagnostic]:
    for run_view in view.run_views:
        found = _rounded_rows(run_view.moves)
        with np.errstate(invalid="ignore"):
            meant = np.minimum(found.radius, found.way)
            lost = (meant - found.way / 2.0) * np.sin(found.angle / 2.0) / 2.0
            closer = found.radius > found.way
        for rule, chosen in ((_CORNER_TOO_LARGE, ~closer), (_TARGETS_WITHIN_CORNER, closer)):
            at = np.flatnonzero(chosen & (lost > _LEAST_CUT))
            for group, worst in run_view.groups(found.rows[at], lost[at]):
                here = at[worst]
                way = float(found.way[here])
                yield run_view.told(
                    rule,
                    group,
                    int(found.rows[here]),
                    radius=found.radius[here],
                    way=figure(way),
                    half=figure(way / 2.0),
                )


@dataclass(frozen=True, slots=True)
class _RoundedRows:
    """k rows of a run that are passed in a corner.

    radius: (k,) mm. way: (k,) mm, the shorter of the ways to and from the row; NaN where one of
    them is not known. angle: (k,) radians by which the path turns there.
    """

    rows: Rows
    radius: Floats
    way: Floats
    angle: Floats


def _rounded_rows(moves: Moves) -> _RoundedRows:
    run = moves.run
    radius = moves.radii[run.pace.blend]
    # Of a move the row that it ends at; the via point of an arc is none.
    rows = np.flatnonzero((run.kinds != Kind.VIA) & np.isfinite(radius) & (radius > 0.0))
    rows = rows[rows + 1 < len(run)]
    if not len(rows):
        nothing = np.empty(0)
        return _RoundedRows(rows, nothing, nothing, nothing)
    after = np.where(run.kinds[rows + 1] == Kind.VIA, rows + 2, rows + 1)
    rows, after = rows[after < len(run)], after[after < len(run)]
    before = np.where(run.kinds[rows] == Kind.END, rows - 2, rows - 1)
    here, there, back = (moves.positions[at + 1] for at in (rows, after, np.maximum(before, -1)))
    arriving, leaving = here - back, there - here
    came, goes = norms(arriving), norms(leaving)
    arcs = np.flatnonzero(moves.arcs)
    for ends, ways, directions, at_end in (
        (rows, came, arriving, True),
        (after, goes, leaving, False),
    ):
        own = arcs[np.isin(moves.rows[arcs], ends)]
        if len(own):
            place = np.searchsorted(ends, moves.rows[own])
            ways[place] = moves.length[own]
            directions[place] = moves.tangents(own, at_end=at_end)
    same = run.mounting.unchanged()
    apart = (
        ~same[after] | ~(same[rows] | (rows == 0)) | (came < _TURN_ON_SPOT) | (goes < _TURN_ON_SPOT)
    )
    came[apart] = np.nan
    cross = norms(np.cross(arriving, leaving))
    angle = np.arctan2(cross, np.einsum("ij,ij->i", arriving, leaving))
    return _RoundedRows(rows, radius[rows], np.minimum(came, goes), angle)


_SETPOINT_CYCLES: Final = {"CR800": 0.0035, "CR1": 0.00711, "CR2B": 0.00711, "CR750": 0.00711}
"""Controller → seconds between two places that it commands: the cycle of its real-time external
control (Mitsubishi manuals A3379 and of the CR800)."""
_IRC5_CYCLE: Final = 0.004
"""The same of an IRC5: the cycle of its externally guided motion (option 689-1)."""
_LEAST_IN_A_ROW: Final = 10
"""So many such moves must follow each other: a few among longer ones are planned ahead."""

_TOO_DENSE: Final = warning(
    "CK323",
    "targets {way} mm apart are passed every {passed} ms, which is less than the "
    "{cycle} ms in which the controller commands a place: the arm may slow down or stop on the way"
    "{worst}",
    "leave targets out, or state a lower speed",
)


def _cycle_of(robot: Robot) -> float:
    """Seconds between two places that the controller of a robot commands."""
    return _SETPOINT_CYCLES.get(robot.controller, _IRC5_CYCLE)


def cycles(view: ProgramView) -> Iterator[Diagnostic]:
    for run_view in view.run_views:
        moves, seconds = run_view.moves, run_view.seconds
        if not len(moves):
            continue
        begins, ends = moves.through
        with np.errstate(invalid="ignore"):
            dense = begins & ends & (seconds < view.cycle) & (moves.length > 0.0)
        dense &= np.isfinite(moves.tcp)
        chain = np.cumsum(~dense)  # counts up where a row of them ends
        rows = np.flatnonzero(dense & (np.bincount(chain, dense)[chain] >= _LEAST_IN_A_ROW))
        for group, worst in run_view.groups(moves.rows[rows], -seconds[rows]):
            at = rows[worst]
            yield run_view.told(
                _TOO_DENSE,
                group,
                int(moves.rows[at]),
                way=figure(moves.length[at]),
                passed=figure(1000.0 * seconds[at]),
                cycle=figure(1000.0 * view.cycle),
            )


_NO_MASS: Final = warning(
    "CK331",
    "the tool `{name}` weighs nothing: an ABB controller stops at the first move with it "
    "(undefined load, 41439)",
    "state its mass in kg and its centre of gravity; 0.001 kg is the least that counts",
)
_TOO_HEAVY: Final = warning(
    "CK332",
    "the tool `{name}` weighs {mass:g} kg, {robot} carries {payload:g} kg",
    "look whether kg were meant, or take a lighter tool or another robot",
)


def _loads(view: ProgramView) -> Iterator[Diagnostic]:
    """Check the loads of the tools that the program moves; skip tools without a known load."""
    robot = view.robot
    for name, tool in view.solution.tools.items():
        if not tool.held or tool.load is None:
            continue
        mass = tool.load.mass
        about = Declared(name, "tools", in_full=True)
        if not mass > 0.0 and has_trait(robot, "stops-without-mass"):
            yield _NO_MASS(name=name, about=about)
        elif robot.payload is not None and mass > robot.payload:
            yield _TOO_HEAVY(
                name=name,
                mass=mass,
                robot=robot.title,
                payload=robot.payload,
                about=about,
            )


_MISSING_AXIS_VALUE: Final = warning(
    "CK341",
    "the value of external axis {axis} is missing, which {others} targets around state",
    "state it there as well: a controller that drives the axis stops without it (40512)",
)


def _external_axes(view: ProgramView) -> Iterator[Diagnostic]:
    for run_view in view.run_views:
        stated = np.isfinite(run_view.moves.run.external)
        count = stated.sum(axis=0)
        for axis in np.flatnonzero((count > 0) & (count < len(stated))):
            rows = np.flatnonzero(~stated[:, axis])
            for group, _ in run_view.groups(rows, np.zeros(len(rows))):
                yield _MISSING_AXIS_VALUE(
                    about=run_view.moves.run.what(group),
                    span=run_view.span(int(group[0])),
                    axis=axis + 1,
                    others=count[axis],
                )


_RULES: Final[tuple[Callable[[ProgramView], Iterator[Diagnostic]], ...]] = (
    _singularities,
    _turn_borders,
    _joint_speeds,
    _reorientations,
    corners,
    cycles,
    _loads,
    _external_axes,
)


def check(solution: SolvedProgram, cycle: float | None = None) -> tuple[Diagnostic, ...]:
    """See `assistant.checks.with_robot`."""
    view = ProgramView(solution, _cycle_of(solution.robot) if cycle is None else cycle)
    return fold(finding for rule in _RULES for finding in rule(view))
