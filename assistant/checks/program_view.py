"""View of a solved program for rules: linear and circular moves in columns, with extremes.

`ProgramView` holds the solved runs of a program and where their moves are in the text. `Moves` has
start, length (mm) and tool path of each move. `Extremes` has what the arm does between the ends of
a move: where the joints turn only a short step, the step counts as straight; where an axis turns
further, joints are computed at points on the path, more of them the further it turns.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths, all_of, max_abs, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, Span
from assistant.program.expressions import Name, Number
from assistant.program.geometry import Pose
from assistant.program.motion import Blend, Kind, Speed
from assistant.program.program import Program, walk
from assistant.program.statements import Follow, Moving, SetOverride
from assistant.robots import Robot, SolvedProgram
from assistant.robots.arms.arm import CLOSING
from assistant.robots.motion.interpolation import (
    Arcs,
    Circles,
    PeakSampling,
    ToolPaths,
    circles,
    flange_along,
    joints_along,
)
from assistant.robots.motion.run import Run
from assistant.robots.motion.singularities import THROUGH
from assistant.robots.robot import CHUNK, IN_LINE
from assistant.robots.solved_program import Leg, SolvedRun


@dataclass(frozen=True)
class Moves:
    """m linear and circular moves of a solved run, those whose start is known.

    rows: (m,) row of the run that a move ends at. starts: (m,) the one that it begins at, -1 for
    where the robot stands before the run. vias: (m,) row of the via point of an arc, else -1.
    positions, quaternions, joints: of the run, one place further down, the first being where the
    robot stands before it; NaN where that is not known.
    speeds, blends: of the run, by row of its tables; NaN for a named one that nobody declares.
    """

    solved_run: SolvedRun
    robot: Robot
    rows: Rows
    starts: Rows
    vias: Rows
    positions: Floats
    quaternions: Floats
    joints: Floats
    speeds: tuple[Speed, ...]
    radii: Floats

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def run(self) -> Run:
        return self.solved_run.run

    @cached_property
    def arcs(self) -> Truths:
        """(m,) which moves are circular."""
        return self.vias >= 0

    @cached_property
    def _round(self) -> Arcs | None:
        """The moves that are round, each a whole arc."""
        at = np.flatnonzero(self.arcs)
        if not len(at):
            return None
        on = self.circles(at)
        around = np.flatnonzero(on.ends > 0.0)
        circles = on.of(around)
        return (
            Arcs(at[around], circles, np.zeros(len(around)), circles.ends) if len(around) else None
        )

    @cached_property
    def length(self) -> Floats:
        """(m,) mm of the way of the TCP in its frame."""
        chord = norms(self.positions[self.rows + 1] - self.positions[self.starts + 1])
        at = np.flatnonzero(self.arcs)
        if len(at):
            on = self.circles(at)
            chord[at] = np.where(on.ends > 0.0, on.radii * on.ends, chord[at])
        return np.asarray(chord)

    @cached_property
    def turn(self) -> Floats:
        """(m,) degrees of reorientation."""
        q0, q1 = self.quaternions[self.starts + 1], self.quaternions[self.rows + 1]
        # Both signs of a quaternion are one rotation: the shorter turn counts.
        q1 = np.where(np.einsum("ij,ij->i", q0, q1)[:, None] < 0.0, -q1, q1)
        # Half of the chord between unit quaternions is the sine of a quarter of the turn.
        half = norms(q1 - q0) / 2.0
        return np.asarray(4.0 * np.degrees(np.arcsin(np.minimum(half, 1.0))))

    @cached_property
    def tcp(self) -> Floats:
        """(m,) mm/s that are programmed; infinite for as fast as can be, NaN if not known."""
        return self._of_speed([speed.tcp for speed in self.speeds])

    @cached_property
    def rotation(self) -> Floats:
        """(m,) deg/s of reorientation that are programmed."""
        return self._of_speed([speed.rotation for speed in self.speeds])

    @cached_property
    def seconds(self) -> Floats:
        """(m,) that a move takes at its programmed speeds, without accelerating; NaN if not known.

        A controller lets position and orientation arrive together, so the slower one counts.
        """
        fastest = self.robot.tcp_speed or np.inf
        tcp = np.minimum(self.tcp, fastest)
        return np.asarray(np.maximum(self.length / tcp, self.turn / self.rotation))

    @cached_property
    def through(self) -> tuple[Truths, Truths]:
        """(m,) whether a move begins, and whether it ends, without a stop."""
        # The position before the run counts as a stop.
        passing = np.append(False, self.radii[self.run.pace.blend] > 0.0)
        return passing[self.starts + 1], passing[self.rows + 1]

    def circles(self, at: Rows) -> Circles:
        """Those of some arcs; they go round up to `Circles.ends`, 0 for three points on a line."""
        return circles(
            *(self.positions[rows[at] + 1] for rows in (self.starts, self.vias, self.rows))
        )

    def tangents(self, at: Rows, *, at_end: bool) -> Floats:
        """Directions (k, 3) in which some arcs begin or end."""
        a, c = self.positions[self.starts[at] + 1], self.positions[self.rows[at] + 1]
        on = self.circles(at)
        along = on.directions(on.ends if at_end else np.zeros(len(at)))
        return np.where(on.ends[:, None] > 0.0, along, c - a)

    def poses(self, at: Rows, parts: int) -> tuple[Floats, Floats]:
        """Poses of the flange between the ends of some moves: (k, parts - 1, 3), (k, parts - 1, 4).

        They divide the way into equal parts.
        """
        even = np.arange(1, parts) / parts
        return self.poses_at(at, np.broadcast_to(even, (len(at), parts - 1)))

    def poses_at(self, at: Rows, part: Floats) -> tuple[Floats, Floats]:
        """Poses of the flange at parts (k, s) of some moves (k,): (k, s, 3), (k, s, 4).

        Equal parts take equal times, as a controller divides the way at a steady speed.
        """
        first, last = self.starts[at] + 1, self.rows[at] + 1
        starts = self.positions[first], self.quaternions[first]
        ends = self.positions[last], self.quaternions[last]
        tool = ToolPaths(starts, ends, at, self._round).at(part)
        return flange_along(self.run.mounting, self.rows[at], tool)

    def _of_speed(self, values: Sequence[float]) -> Floats:
        return np.asarray(np.array(values, dtype=np.float64)[self.run.pace.speed[self.rows]])


def moves_of(
    solved_run: SolvedRun,
    robot: Robot,
    speeds: Mapping[str, Speed],
    blends: Mapping[str, Blend],
) -> Moves:
    """The linear and circular moves of a solved run; speeds, blends: named ones, by lower case.

    A move whose tool or frame is not that of the move before begins at no known place.
    """
    run = solved_run.run
    p, q = _with_start(run, robot)
    unit = q / norms(q)[:, None]
    before = run.before if run.joined else np.full(len(robot.axes), np.nan)
    joints = np.concatenate([before[None], solved_run.joints])
    kinds = run.kinds
    rows = np.flatnonzero((kinds == Kind.LINEAR) | (kinds == Kind.END))
    arc = (kinds[rows] == Kind.END) & (rows > 0)
    arc &= kinds[np.maximum(rows - 1, 0)] == Kind.VIA
    starts = np.where(arc, rows - 2, rows - 1)
    same = np.append(run.mounting.unchanged(), True)
    same[0] = True  # the start was put into the tool and frame of the first row
    known = same[rows] & np.where(arc, same[rows - 1], True)
    known &= all_of(np.isfinite(joints[rows + 1])) & all_of(np.isfinite(joints[starts + 1]))
    known &= all_of(np.isfinite(p[starts + 1])) & all_of(np.isfinite(p[rows + 1]))
    nothing = Speed(np.nan, np.nan)
    rows, starts, arc = rows[known], starts[known], arc[known]
    return Moves(
        solved_run=solved_run,
        robot=robot,
        rows=rows,
        starts=starts,
        vias=np.where(arc, rows - 1, -1),
        positions=p,
        quaternions=unit,
        joints=joints,
        speeds=tuple(
            speeds.get(s.name.lower(), nothing) if isinstance(s, Name) else s
            for s in run.pace.speeds
        ),
        radii=np.array([_blend_radius(blend, blends) for blend in run.pace.blends]),
    )


def _with_start(run: Run, robot: Robot) -> tuple[Floats, Floats]:
    """Targets (n + 1, 3), (n + 1, 4), the first being where the robot stands before the run."""
    p, q = run.targets(slice(None))
    here = np.full(7, np.nan)
    if run.joined:
        position, quaternion = robot.flange_poses(run.before)
        pose = run.mounting.from_flange(Pose.of(position[0], quaternion[0]), 0)
        here = np.array([*pose.position, *pose.quaternion])
    return np.concatenate([here[None, :3], p]), np.concatenate([here[None, 3:], q])


def _blend_radius(blend: Blend | Name, named: Mapping[str, Blend]) -> float:
    """Mm before the target at which the path may leave it, 0 for a stop, NaN if not known."""
    known = named.get(blend.name.lower()) if isinstance(blend, Name) else blend
    if known is None:
        return np.nan
    return 0.0 if known.radius is None else known.radius


_BENT: Final = float(np.sin(np.radians(IN_LINE)))
"""Sine of axis 5 below which the individual values of axes 4 and 6 have no meaning."""


@dataclass(frozen=True, slots=True)
class Extremes:
    """Extremes of m moves, each array (m,); infinite where an arm has no such singularity.

    wrist: least angle of axis 5 during the move, degrees. elbow: least angle between the upper arm
    and the line from axis 3 to the wrist centre, degrees. shoulder: least distance of the wrist
    centre from axis 1, mm. crossed: True if the move goes straight through the wrist singularity.
    by_ends: True if its ends alone show that, which finding RB115 reports. seconds: the least time
    that the joint speeds allow. axis: the joint that sets this time.
    """

    wrist: Floats
    elbow: Floats
    shoulder: Floats
    crossed: Truths
    by_ends: Truths
    seconds: Floats
    axis: Rows


def extremes_of(moves: Moves) -> Extremes:
    m = len(moves)
    far = np.full(m, np.inf)
    never = np.zeros(m, dtype=bool)
    nothing = np.zeros(m, dtype=np.intp)
    extremes = Extremes(far, far.copy(), far.copy(), never, never.copy(), np.zeros(m), nothing)
    uneven = [np.empty(0, np.intp)]
    for at, joints in _pieces(moves, extremes):
        uneven.append(at[_update_extremes(moves.robot, extremes, at, joints)])
    again = np.concatenate(uneven)
    parts = min(PeakSampling.MOST_PARTS, _most_places(moves.robot) // max(len(again), 1))
    if parts > PeakSampling.PARTS[-1][1]:
        _clear_ends(extremes, again)
        extremes.crossed[again] = extremes.by_ends[again]
        for at, joints in _sampled(moves, again, parts):
            _update_extremes(moves.robot, extremes, at, joints)
            if moves.robot.arm.named:
                _peak(moves, extremes, at, joints)
    return extremes


def _peak(moves: Moves, extremes: Extremes, at: Rows, joints: Floats) -> None:
    """Looks closer where some moves (k,) need the most time, as their joints (k, p, a) show.

    Between the places beside the fastest step, then again beside the fastest one there.
    """
    robot = moves.robot
    branches = robot.branch_of(robot.configuration(joints[:, -1]))
    begin, width = np.zeros(len(at)), np.ones(len(at))
    for _ in range(PeakSampling.CLOSER):
        if not len(at):
            return
        steps = joints.shape[1] - 1
        place = _steps(robot, joints).max(axis=2).argmax(axis=1)
        first, last = np.maximum(place - 1, 0), np.minimum(place + 2, steps)
        begin, width = begin + width * first / steps, width * (last - first) / steps
        part = begin[:, None] + width[:, None] * np.linspace(
            0.0, 1.0, PeakSampling.CLOSER_PARTS + 1
        )
        p, q = moves.poses_at(at, part)
        joints, excess = joints_along(robot, joints[:, 0], branches, (p, q))
        # Paths that leave the reach of their branch tell nothing.
        reached = (excess < CLOSING / 2.0).all(axis=1)
        needed = _steps(robot, joints).max(axis=1) * PeakSampling.CLOSER_PARTS / width[:, None]
        axis = needed.argmax(axis=1)
        seconds = np.where(reached, needed[np.arange(len(at)), axis], 0.0)
        before = extremes.seconds[at]
        more = seconds > before
        extremes.axis[at[more]], extremes.seconds[at[more]] = axis[more], seconds[more]
        # Only where a closer look has found more is another one worth its time.
        on = seconds > PeakSampling.FASTER * before
        at, branches, joints = at[on], branches[on], joints[on]
        begin, width = begin[on], width[on]


def _steps(robot: Robot, joints: Floats) -> Floats:
    """Return (k, p - 1, a) seconds at full speed between positions on paths, joints (k, p, a).

    Steps of axes 4 and 6 are ignored near a straight wrist: their individual values have no meaning
    there.
    """
    step = np.abs(robot.wound(np.diff(joints, axis=1)))
    if robot.arm.spherical:
        small = np.abs(np.sin(np.radians(joints[..., 4] + robot.zero[4]))) < _BENT
        either = (small[:, :-1] | small[:, 1:])[..., None]
        step[..., [3, 5]] = np.where(either, 0.0, step[..., [3, 5]])
    return np.asarray(step / robot.speeds)


def _pieces(moves: Moves, extremes: Extremes) -> Iterator[tuple[Rows, Floats]]:
    """Moves (k,) with their joints (k, parts + 1, a) deg from the start to the end."""
    wide = np.zeros(len(moves))
    for start in range(0, len(moves), CHUNK):
        at = np.arange(start, min(start + CHUNK, len(moves)))
        ends = np.stack([moves.joints[moves.starts[at] + 1], moves.joints[moves.rows[at] + 1]], 1)
        step = max_abs(np.diff(ends, axis=1)[:, 0])
        bent = moves.vias[at] >= 0
        if bent.any():
            via = moves.joints[moves.vias[at] + 1]
            off = np.abs(via[:, None] - ends).max(axis=(1, 2))
            step = np.where(bent & np.isfinite(off), np.maximum(step, off), step)
        wide[at] = step
        yield at, ends
    _crossed_at_targets(moves, extremes)
    extremes.by_ends[:] = extremes.crossed
    wanted = np.flatnonzero((wide > PeakSampling.STRAIGHT) & ~extremes.crossed)
    _clear_ends(extremes, wanted)  # ends so far apart tell nothing of the way
    if moves.robot.arm.named:
        wanted = wanted[_same_branch(moves, wanted)]
    counts = np.array([parts for _, parts in PeakSampling.PARTS])
    parts = counts[np.searchsorted([most for most, _ in PeakSampling.PARTS], wide[wanted])]
    many = parts.sum()
    most = _most_places(moves.robot)
    # Too many positions: all moves get fewer parts, in proportion.
    if many > most:
        parts = np.maximum(parts * most // many, PeakSampling.LEAST_PARTS)
    for one in np.unique(parts):
        yield from _sampled(moves, wanted[parts == one], int(one))


def _most_places(robot: Robot) -> int:
    return PeakSampling.MOST_PLACES if robot.arm.named else PeakSampling.MOST_FOLLOWED


def _crossed_at_targets(moves: Moves, extremes: Extremes) -> None:
    """Adds the moves to and from a target in line at which the wrist bends to the other side."""
    if not moves.robot.arm.spherical or len(moves) < 2:
        return
    first, last = moves.starts + 1, moves.rows + 1
    five = np.radians(moves.joints[:, 4])
    in_line = np.flatnonzero(
        (np.abs(np.sin(five[last[:-1]])) < _BENT) & (moves.rows[:-1] == moves.starts[1:])
    )
    bends = []
    for place in (first[in_line], last[in_line + 1]):
        four = np.radians(moves.joints[place, 3])
        bends.append(np.sin(five[place]) * np.stack([np.cos(four), np.sin(four)]))
    through = in_line[(bends[0] * bends[1]).sum(axis=0) < 0.0]
    extremes.crossed[through] = extremes.crossed[through + 1] = True


def _clear_ends(extremes: Extremes, moves: Rows) -> None:
    """Remove the extremes that the ends of moves have already shown."""
    for least in (extremes.wrist, extremes.elbow, extremes.shoulder):
        least[moves] = np.inf
    extremes.seconds[moves] = 0.0


def _same_branch(moves: Moves, rows: Rows) -> Truths:
    """True for each move whose two ends are in the same arm branch."""
    first, last = (
        moves.robot.branch_of(moves.robot.configuration(moves.joints[place[rows] + 1]))
        for place in (moves.starts, moves.rows)
    )
    return np.asarray(first == last)


def _sampled(moves: Moves, rows: Rows, parts: int) -> Iterator[tuple[Rows, Floats]]:
    """Moves (k,) of those in some rows with their joints (k, parts + 1, a) deg, but for moves
    that leave the reach of the branch that they end in.
    """
    robot = moves.robot
    branches = robot.branch_of(robot.configuration(moves.joints[moves.rows[rows] + 1]))
    many = max(CHUNK // parts, 1)
    for branch in np.unique(branches):
        own = rows[branches == branch]
        for start in range(0, len(own), many):
            at = own[start : start + many]
            first = moves.joints[moves.starts[at] + 1]
            last = moves.joints[moves.rows[at] + 1]
            p, q = moves.poses(at, parts)
            between, excess = joints_along(robot, first, np.full(len(at), branch), (p, q))
            inside = (excess < CLOSING / 2.0).all(axis=1)
            joints = np.concatenate([first[:, None], between, last[:, None]], axis=1)
            yield at[inside], joints[inside]


def _update_extremes(robot: Robot, extremes: Extremes, at: Rows, joints: Floats) -> Truths:
    """Takes down what some of the moves come to; which of them are uneven (k,).

    joints: (k, parts + 1, a) deg.
    """
    k, places, axes = joints.shape
    step = np.abs(robot.wound(np.diff(joints, axis=1)))
    if places == 2:  # a whole turn within one short move is none
        step = np.abs(np.diff(joints, axis=1))
    chain = robot.chained(joints.reshape(-1, axes))
    if robot.arm.spherical:
        sine = np.sin(chain[:, 4])
        bend = (sine[:, None] * np.stack([np.cos(chain[:, 3]), np.sin(chain[:, 3])], 1)).reshape(
            k, places, 2
        )
        nearest = _past_nothing(bend)
        opposite = np.einsum("kpi,kpi->kp", bend[:, :-1], bend[:, 1:]) < 0.0
        extremes.crossed[at] |= (opposite & (nearest < THROUGH)).any(axis=1)
        least = np.degrees(np.arcsin(np.minimum(nearest, 1.0))).min(axis=1)
        extremes.wrist[at] = np.minimum(extremes.wrist[at], least)
        small = np.abs(sine).reshape(k, places) < _BENT
        step[..., [3, 5]] = np.where(
            (small[:, :-1] | small[:, 1:])[..., None], 0.0, step[..., [3, 5]]
        )
    elbow = robot.arm.elbow(chain)
    if elbow is not None:
        angle = _within_a_turn(elbow).reshape(k, places)
        first, last = angle[:, :-1], angle[:, 1:]
        # A jump by more than half a turn is the wrap of the angle, no passage through 0.
        stretched = (first * last < 0.0) & (np.abs(last - first) < np.pi)
        least = np.where(stretched.any(axis=1), 0.0, np.inf)
        least = np.minimum(least, np.degrees(np.abs(angle)).min(axis=1))
        extremes.elbow[at] = np.minimum(extremes.elbow[at], least)
    ahead = robot.arm.wrist(chain)
    if ahead is not None:
        wrist = ahead[:, None] * np.stack([np.cos(chain[:, 0]), np.sin(chain[:, 0])], axis=1)
        least = _past_nothing(wrist.reshape(k, places, 2)).min(axis=1)
        extremes.shoulder[at] = np.minimum(extremes.shoulder[at], least)
    needed = step.max(axis=1) * (places - 1) / robot.speeds
    axis = needed.argmax(axis=1)
    seconds = needed[np.arange(k), axis]
    more = seconds > extremes.seconds[at]
    extremes.axis[at[more]] = axis[more]
    extremes.seconds[at[more]] = seconds[more]
    mean = (step.sum(axis=1) / robot.speeds)[np.arange(k), axis]
    return np.asarray((seconds > PeakSampling.UNEVEN * mean) & (places > 2))


def _past_nothing(points: Floats) -> Floats:
    """Return the distances (k, p - 1) of the straight lines between points (k, p, 2) from the
    origin.
    """
    first, extremes = points[:, :-1], np.diff(points, axis=1)
    squared = np.einsum("kpi,kpi->kp", extremes, extremes)
    part = -np.einsum("kpi,kpi->kp", first, extremes) / np.where(squared > 0.0, squared, 1.0)
    part = np.clip(part, 0.0, 1.0)[..., None]
    return np.asarray(norms(first + part * extremes))


def _within_a_turn(radians: Floats) -> Floats:
    return np.asarray(radians - 2.0 * np.pi * np.round(radians / (2.0 * np.pi)))


_NEIGHBOURS: Final = 2
"""Largest distance between rows that one finding reports together; the points of an arc are two
apart.
"""
_MOST_GROUPS: Final = 5
"""Number of groups of neighbours in a run from which on one finding reports all of them."""


@dataclass(frozen=True)
class ProgramView:
    """Solved program that the rules check.

    cycle: seconds between two positions that the controller commands.
    """

    solution: SolvedProgram
    cycle: float

    @property
    def program(self) -> Program:
        return self.solution.program

    @property
    def robot(self) -> Robot:
        return self.solution.robot

    @cached_property
    def run_views(self) -> tuple[RunView, ...]:
        """The runs of the program in order of text, each with its legs."""
        legs: dict[int, list[Leg]] = {}
        for several in self.solution.legs.values():
            for leg in several:
                if leg.solved_run is not None:
                    legs.setdefault(id(leg.solved_run), []).append(leg)
        shares = _overrides(self.solution)
        solved_runs = self.solution.solved_runs
        return tuple(
            self._view(solved_run, legs[id(solved_run)], shares) for solved_run in solved_runs
        )

    def _view(
        self, solved_run: SolvedRun, legs: Sequence[Leg], shares: dict[int, float]
    ) -> RunView:
        speeds = {name.lower(): speed for name, speed in self.program.speeds.items()}
        blends = {name.lower(): blend for name, blend in self.program.blends.items()}
        moves = moves_of(solved_run, self.robot, speeds, blends)
        return RunView(moves, tuple(sorted(legs, key=lambda leg: leg.rows.start)), shares)


@dataclass(frozen=True)
class RunView:
    """A solved run: its moves, its legs in order of rows, and the override that counts for each.

    shares: id of a leg → what share of the programmed speed it is run with.
    """

    moves: Moves
    legs: tuple[Leg, ...]
    shares: dict[int, float]

    @cached_property
    def extremes(self) -> Extremes:
        return extremes_of(self.moves)

    @cached_property
    def seconds(self) -> Floats:
        """(m,) that the moves take at their speeds and the override; NaN if not known."""
        shares = np.array([self.shares.get(id(leg), 1.0) for leg in self.legs])
        return np.asarray(self.moves.seconds / shares[self.leg_of(self.moves.rows)])

    @cached_property
    def firsts(self) -> Rows:
        """First row of each leg."""
        return np.array([leg.rows.start for leg in self.legs], dtype=np.intp)

    def leg_of(self, rows: Rows) -> Rows:
        """Which legs some rows are of."""
        return np.asarray(np.searchsorted(self.firsts, rows, side="right") - 1)

    def groups(self, rows: Rows, badness: Floats) -> Iterator[tuple[Rows, int]]:
        """Yield groups of rows of the run (k,), ascending, each group with the index of its worst
        row.

        Neighbouring rows form a group, and so do the rows of a path without separate lines. The
        index is one among the k of badness (k,); higher badness is worse.
        """
        leg = self.leg_of(rows)
        alone = np.array([_has_lines(one.statement) for one in self.legs], dtype=bool)[leg]
        apart = (np.diff(leg) > 0) | alone[1:]
        cuts = np.flatnonzero((np.diff(rows) > _NEIGHBOURS) & apart) + 1
        if len(cuts) >= _MOST_GROUPS:
            cuts = cuts[:0]
        at = np.arange(len(rows))
        for each in np.split(at, cuts) if len(at) else ():
            yield rows[each], int(each[badness[each].argmax()])

    def told(self, rule: Rule, rows: Rows, row: int, **fields: Any) -> Diagnostic:
        """A finding about some rows, the worst of which is one of them."""
        where = f" (worst at {self.moves.run.label(row)})" if len(rows) > 1 else ""
        about = self.moves.run.what(rows)
        return rule(about=about, span=self.span(row), worst=where, **fields)

    def span(self, row: int) -> Span | None:
        """The source location of the move to a row."""
        leg = self.legs[int(self.leg_of(np.array([row]))[0])]
        if isinstance(leg.statement, Follow):
            return leg.statement.row_span(row - leg.rows.start)
        return leg.statement.span


def _has_lines(statement: Moving) -> bool:
    """True if each row of the statement has a separate line in the text."""
    return isinstance(statement, Follow) and statement.path.places is not None


def _overrides(solution: SolvedProgram) -> dict[int, float]:
    """Id of a leg → the override above it, as a share of the programmed speed.

    A procedure begins with the largest one that the program states, the first one with 1. One
    that only running the program tells counts as 1.
    """
    program = solution.program
    stated = [_override_share(s) for s in program.statements() if isinstance(s, SetOverride)]
    shares: dict[int, float] = {}
    for procedure in program.procedures if stated else ():
        first = program.entry is not None and procedure.name.lower() == program.entry.lower()
        share = 1.0 if first else max(stated)
        legs = iter(solution.legs.get(procedure.name, ()))
        for statement in walk(procedure.body):
            if isinstance(statement, SetOverride):
                share = _override_share(statement)
            elif isinstance(statement, Moving):
                leg = next(legs, None)
                shares[id(leg)] = share
    return shares


def _override_share(statement: SetOverride) -> float:
    value = statement.percent
    if isinstance(value, Number) and 0.0 < float(value.value) <= 100.0:
        return float(value.value) / 100.0
    return 1.0


def figure(value: float) -> str:
    """A measured value in three digits, never as a power of ten."""
    return f"{float(f'{value:.3g}'):g}"
