"""The course of a straight piece of program: the path through its moves, with corners cut.

`Moves` are columns: where each move leads, its speed, blend, tool and frame.

Knots are tool positions with their joints, close enough to each other to take the joints as linear
in between. A short move is one step, from its start to its end; a long one gets knots on its line
or arc, solved in the branch of its end (for an arm without named branches, followed from its
start).

The course is the control polygon of a quadratic spline: at each knot the path is a parabola from
`room` before it to `room` after it, which touches the polygon at both borders. A small corner is a
knot whose room is its zone.

A wide corner, in which one move begins while the one before it slows down, gets several knots. With
u from 0 to 1 through the corner, the rest of the move before, z (1 - u)² of its zone z, and the
begun part of the move after, z u², are added. Between lines that is the parabola that touches both
at the borders of the zone; arcs, orientations and the joints of joint moves overlap likewise. The
corner becomes spans of equal length, each with one knot of the control polygon, the blossom of the
overlap: u0 + u1 - u0 u1 of the one zone and u0 u1 of the other, for the span from u0 to u1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, any_of, max_abs, norms
from assistant.base.data_classes import dataclass
from assistant.program.expressions import Name
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.motion import FINE, Blend, Kind, Speed
from assistant.robots.arms.arm import CLOSING
from assistant.robots.motion.interpolation import (
    Arcs,
    TimeSampling,
    ToolPaths,
    arcs_of,
    joints_along,
    vias_of,
)
from assistant.robots.motion.run import SpeedsAndBlends, from_flange, to_flange
from assistant.robots.robot import CHUNK, IN_LINE, Robot

_UNKNOWN_SPEED: Final = Speed(np.nan)


@dataclass(frozen=True, slots=True)
class Mount:
    """A tool in a frame."""

    tool: Tool
    frame: Frame

    def to_flange(self, positions: Floats, quaternions: Floats) -> tuple[Floats, Floats]:
        """Poses (n, 3), (n, 4) of the tool as `tip` gives them → of the flange."""
        return to_flange(positions, quaternions, self.tool, Frame(held=self.frame.held))

    def tip(self, robot: Robot, joints: Floats) -> tuple[Floats, Floats]:
        """Joints (n, a) → the tool's tip in the base, or in a work piece's holder if the arm
        carries the work piece: (n, 3), (n, 4).
        """
        return from_flange(*robot.flange_poses(joints), self.tool, Frame(held=self.frame.held))


@dataclass(frozen=True, slots=True, eq=False)
class Moves:
    """n moves, each from where the one before ends.

    kinds: (n,) `Kind`. joints: (n, a) at their ends. positions, quaternions: (n, 3), (n, 4) of
    the tool at their ends, as `Mount.tip` gives them. mount: (n,) rows of the table mounts.
    tcp: (n,) mm/s. rotation: (n,) deg/s. percent: (n,) of the joints' speed, NaN if not stated.
    override: (n,) factor of the speeds. acceleration, deceleration: (n,) factors.
    entry, leaving: (n,) mm before and after the end where the path may be left; 0 to stop there.
    """

    kinds: NDArray[np.uint8]
    joints: Floats
    positions: Floats
    quaternions: Floats
    mount: NDArray[np.int32]
    mounts: tuple[Mount, ...]
    tcp: Floats
    rotation: Floats
    percent: Floats
    override: Floats
    acceleration: Floats
    deceleration: Floats
    entry: Floats
    leaving: Floats

    def __len__(self) -> int:
        return len(self.kinds)

    def rest(self, first: int) -> Moves:
        """Those from a row on."""
        return Moves(
            **{
                f.name: value if f.name == "mounts" else value[first:]
                for f in fields(self)
                for value in (getattr(self, f.name),)
            }
        )


def join_moves(parts: Sequence[Moves]) -> Moves:
    """Parts, one after the other, with one table of mounts."""
    if len(parts) == 1:
        return parts[0]
    mounts: list[Mount] = []
    columns = []
    for part in parts:
        mounts += [mount for mount in part.mounts if mount not in mounts]
        columns.append(np.array([mounts.index(m) for m in part.mounts], np.int32)[part.mount])
    whole = {
        f.name: np.concatenate([getattr(part, f.name) for part in parts])
        for f in fields(Moves)
        if f.name not in ("mount", "mounts")
    }
    return Moves(mount=np.concatenate(columns), mounts=tuple(mounts), **whole)


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of a move from earlier statements: factors of its speed and accelerations."""

    override: float = 1.0
    acceleration: float = 1.0
    deceleration: float = 1.0


def moves_of(
    kinds: NDArray[np.uint8],
    joints: Floats,
    poses: tuple[Floats, Floats],
    mount: tuple[NDArray[np.int32], tuple[Mount, ...]],
    pace: SpeedsAndBlends,
    rows: slice,
    tables: tuple[Mapping[str, Speed], Mapping[str, Blend]],
    settings: Settings,
) -> Moves:
    """Return columns of moves with the speeds and blends of some rows of a pace.

    tables: named speeds and blends by their names in lower case. A name that is in neither gives a
    speed that is not a number, or a stop.
    """
    speeds = [_speed(speed, tables[0]) for speed in pace.speeds]
    blends = [_blend(blend, tables[1]) for blend in pace.blends]
    speed, blend = pace.speed[rows], pace.blend[rows]

    def column(values: list[float], index: NDArray[np.int32]) -> Floats:
        return np.array(values, dtype=np.float64)[index]

    n = len(kinds)
    return Moves(
        kinds=kinds,
        joints=joints,
        positions=poses[0],
        quaternions=poses[1],
        mount=mount[0],
        mounts=mount[1],
        tcp=column([s.tcp for s in speeds], speed),
        rotation=column([s.rotation for s in speeds], speed),
        percent=column([np.nan if s.joint is None else s.joint for s in speeds], speed),
        override=np.full(n, settings.override),
        acceleration=np.full(n, settings.acceleration),
        deceleration=np.full(n, settings.deceleration),
        entry=column([b.radius or 0.0 for b in blends], blend),
        leaving=column([_leaving(b) for b in blends], blend),
    )


def targets_out_of_frames(
    frames: Sequence[Pose], frame: NDArray[np.int32], p: Floats, q: Floats
) -> tuple[Floats, Floats]:
    """Targets (n, 3), (n, 4) in frames → in what the frames are in.

    frame: (n,) rows of the table frames.
    """
    q = q / norms(q)[:, None]
    if all(pose == Pose() for pose in frames):
        return p, q
    turn = np.array([pose.quaternion for pose in frames])
    shift = np.array([pose.position for pose in frames])
    if len(frames) == 1:
        return rotations.rotate(turn[0], p) + shift[0], rotations.multiply(turn[0], q)
    return rotations.rotate(turn[frame], p) + shift[frame], rotations.multiply(turn[frame], q)


def _speed(speed: Speed | Name, table: Mapping[str, Speed]) -> Speed:
    return table.get(speed.name.lower(), _UNKNOWN_SPEED) if isinstance(speed, Name) else speed


def _blend(blend: Blend | Name, table: Mapping[str, Blend]) -> Blend:
    return table.get(blend.name.lower(), FINE) if isinstance(blend, Name) else blend


def _leaving(blend: Blend) -> float:
    return blend.radius or 0.0 if blend.exit is None else blend.exit


_SAME_TIP: Final = 1e-6
"""mm and degrees up to which tips of two tools are at one place."""
_MOST_TURN_BETWEEN_KNOTS: Final = 60.0
"""degrees that no axis turns between two knots: the arm would change its branch there."""


@dataclass(frozen=True, slots=True, eq=False)
class Knots:
    """k + 1 knots, k steps between them.

    row: (k,) the move that a step belongs to. part: (k,) of its move that it is; 0 where only
    the tool or the frame changes. joints: (k + 1, a). positions, quaternions: (k + 1, 3),
    (k + 1, 4) as `Mount.tip` gives them. length: (k,) mm. turn: (k,) deg.
    guessed: rows on whose way the joints are only taken as linear: no one branch reaches all of it.
    """

    row: Rows
    part: Floats
    joints: Floats
    positions: Floats
    quaternions: Floats
    length: Floats
    turn: Floats
    guessed: Rows


def knots_of(moves: Moves, start: Floats, robot: Robot) -> Knots:
    """The way from joints (a,) through n moves."""
    ends = MoveEnds(moves, start, robot)
    steps = ends.steps()
    lead = ends.remounted.astype(np.intp)
    last = np.cumsum(steps + lead)  # knot of each move's end; knot 0 is the start
    row = np.repeat(np.arange(len(moves)), steps + lead)
    part = np.repeat(1.0 / steps, steps + lead)
    again = np.flatnonzero(lead)
    first = last[again] - steps[again]
    part[first - 1] = 0.0
    real = part > 0.0
    k = len(row)
    knots = Knots(
        row,
        part,
        np.empty((k + 1, len(robot.axes))),
        np.empty((k + 1, 3)),
        np.empty((k + 1, 4)),
        np.where(real, (ends.lengths / steps)[row], 0.0),
        np.where(real, (ends.turns / steps)[row], 0.0),
        np.empty(0, np.intp),
    )
    at = last if k > len(moves) else slice(1, None)  # the same, faster
    knots.joints[0], knots.joints[at] = start, moves.joints
    knots.positions[0], knots.positions[at] = ends.p0[0], moves.positions
    knots.quaternions[0], knots.quaternions[at] = ends.q0[0], moves.quaternions
    knots.joints[first], knots.positions[first] = ends.j0[again], ends.p0[again]
    knots.quaternions[first] = ends.q0[again]
    wide = np.flatnonzero(steps > 1)
    guessed = [
        _fill_inner_knots(knots, moves, ends, some, steps, last, robot)
        for some in _batches(wide, steps[wide])
    ]
    free = np.flatnonzero(real & (moves.kinds[row] == Kind.JOINT))
    knots.length[free] = norms(knots.positions[free + 1] - knots.positions[free])
    knots.turn[free] = rotations.angle_between(knots.quaternions[free], knots.quaternions[free + 1])
    return Knots(
        row,
        part,
        knots.joints,
        knots.positions,
        knots.quaternions,
        knots.length,
        knots.turn,
        np.concatenate([np.empty(0, np.intp), *guessed]),
    )


class MoveEnds:
    """Start poses of n moves, with their tool and frame, and the lengths of their paths.

    j0 (n, a), p0 (n, 3), q0 (n, 4). lengths (n,) mm, turns (n,) deg; straight for joint moves.
    remounted: (n,) whether the tool or frame differs from the one before, so that the tip is
    elsewhere.
    """

    def __init__(self, moves: Moves, start: Floats, robot: Robot) -> None:
        self.moves = moves
        self.j0 = np.concatenate([start[None], moves.joints[:-1]])
        p, q = moves.mounts[moves.mount[0]].tip(robot, start[None])
        self.p0 = np.concatenate([p, moves.positions[:-1]])
        self.q0 = np.concatenate([q, moves.quaternions[:-1]])
        self.remounted = np.zeros(len(moves), dtype=bool)
        self.remounted[1:] = np.diff(moves.mount) != 0
        for index in np.unique(moves.mount[self.remounted]):
            rows = np.flatnonzero(self.remounted & (moves.mount == index))
            p, q = moves.mounts[index].tip(robot, self.j0[rows])
            moved = max_abs(p - self.p0[rows]) > _SAME_TIP
            turned = rotations.angle_between(q, self.q0[rows]) > _SAME_TIP
            self.remounted[rows] = moved | turned
            self.p0[rows], self.q0[rows] = p, q
        self.lengths = norms(moves.positions - self.p0)
        self.turns = rotations.angle_between(self.q0, moves.quaternions)
        self.arcs = self._arcs()
        if self.arcs is not None:
            self.lengths[self.arcs.rows] = self.arcs.lengths

    def _arcs(self) -> Arcs | None:
        vias = vias_of(self.moves.kinds)
        ends = self.moves.positions
        return arcs_of(vias, self.p0[vias], ends[vias], ends[vias + 1]) if len(vias) else None

    def steps(self) -> Rows:
        """(n,) how many steps each move is cut into."""
        angles = max_abs(self.moves.joints - self.j0)
        free = self.moves.kinds == Kind.JOINT
        straight = np.where(free, 0.0, self.lengths)
        wanted = np.maximum(
            straight / TimeSampling.APART, np.maximum(self.turns, angles) / TimeSampling.TURNED
        )
        if self.arcs is not None:
            at = self.arcs.rows
            wanted[at] = np.maximum(wanted[at], np.degrees(self.arcs.angles) / TimeSampling.TURNED)
        steps = np.clip(np.ceil(wanted), 1, TimeSampling.MOST)
        more = steps.sum() - len(steps)
        if more > TimeSampling.MOST_KNOTS:
            steps = 1.0 + np.floor((steps - 1.0) * (TimeSampling.MOST_KNOTS / more))
        return np.asarray(steps.astype(np.intp))


def _batches(rows: Rows, steps: Rows) -> list[Rows]:
    """Rows in groups of about `CHUNK` steps each."""
    if not len(rows):
        return []
    return np.split(rows, np.flatnonzero(np.diff(np.cumsum(steps) // CHUNK)) + 1)


def _fill_inner_knots(
    knots: Knots, moves: Moves, ends: MoveEnds, rows: Rows, steps: Rows, last: Rows, robot: Robot
) -> Rows:
    """Sets the inner knots of some moves of several steps; gives those whose joints are guessed."""
    inner = steps[rows] - 1
    each = np.repeat(rows, inner)  # row of every inner knot
    first = np.concatenate([[0], np.cumsum(inner)[:-1]])
    count = np.arange(len(each)) - np.repeat(first, inner) + 1
    part = count / steps[each]
    at = last[each] - steps[each] + count
    starts = ends.p0[each], ends.q0[each]
    lasts = moves.positions[each], moves.quaternions[each]
    p, q = (one[:, 0] for one in ToolPaths(starts, lasts, each, ends.arcs).at(part[:, None]))
    between = ends.j0[each] + part[:, None] * (moves.joints[each] - ends.j0[each])
    free = moves.kinds[each] == Kind.JOINT
    mount = moves.mount[each]
    branches = np.repeat(robot.branch_of(robot.configuration(moves.joints[rows])), inner)
    joints = between.copy()
    for index in np.unique(mount):
        here = mount == index
        tool = moves.mounts[index]
        some = np.flatnonzero(here & free)
        if len(some):
            p[some], q[some] = tool.tip(robot, joints[some])
        some = np.flatnonzero(here & ~free)
        flange = tool.to_flange(p[some], q[some])
        if robot.arm.named:
            joints[some] = _solved_joints(robot, branches[some], *flange)
        else:
            joints[some] = _followed_joints(robot, ends.j0[each[some]], each[some], *flange)
    straight = ~free
    guessed = _unwind(joints, between, straight, each, rows, inner, moves, ends, robot)
    knots.positions[at], knots.quaternions[at], knots.joints[at] = p, q, joints
    return guessed


def _solved_joints(robot: Robot, branches: Rows, p: Floats, q: Floats) -> Floats:
    """(m, a) joints at flange poses in branches (m,), whole turns left open; NaN where those do
    not reach.
    """
    joints, excess = joints_along(robot, None, branches, (p[:, None], q[:, None]))
    joints[excess >= CLOSING] = np.nan
    return joints[:, 0]


def _followed_joints(robot: Robot, before: Floats, each: Rows, p: Floats, q: Floats) -> Floats:
    """(m, a) joints of an arm without named branches, followed along the flange poses of moves.

    before: (m, a) where the move of a pose starts. each: (m,) which move that is. NaN where the
    arm does not reach.
    """
    joints = np.empty((len(p), len(robot.axes)))
    starts = np.flatnonzero(np.diff(each, prepend=-1))
    counts = np.diff(np.append(starts, len(each)))
    for count in np.unique(counts):
        first = starts[counts == count]
        at = first[:, None] + np.arange(count)
        found, excess = robot.follow(before[first], p[at], q[at])
        found[excess >= CLOSING] = np.nan
        joints[at] = found
    return joints


def _unwind(
    joints: Floats,
    between: Floats,
    solved: Truths,
    each: Rows,
    rows: Rows,
    inner: Rows,
    moves: Moves,
    ends: MoveEnds,
    robot: Robot,
) -> Rows:
    """Make the joints of inner knots continuous from the start of each move to its end.

    If that is not possible, they are set to `between`, and the rows are returned.
    """
    if robot.arm.spherical:
        line = solved & (np.abs(joints[:, 4]) < IN_LINE)
        # Only the sum of axes 4 and 6 counts there; axis 4 goes straight on.
        joints[line, 5] += joints[line, 3] - between[line, 3]
        joints[line, 3] = between[line, 3]
    first = np.concatenate([[0], np.cumsum(inner)[:-1]])
    lost = np.logical_or.reduceat(any_of(np.isnan(joints)), first)
    steps = np.empty_like(joints)
    steps[1:] = joints[1:] - joints[:-1]
    steps[first] = joints[first] - ends.j0[rows]
    steps = np.nan_to_num(robot.wound(steps))
    total = np.cumsum(steps, axis=0)
    before = np.concatenate([np.zeros((1, joints.shape[1])), total])[first]
    smooth = ends.j0[each] + total - np.repeat(before, inner, axis=0)
    final = first + inner - 1
    off = np.nan_to_num(robot.wound(moves.joints[rows] - joints[final]))
    missed = max_abs(smooth[final] + off - moves.joints[rows]) > 1.0
    widest = np.maximum(np.maximum.reduceat(max_abs(steps), first), max_abs(off))
    bad = (missed | (widest > _MOST_TURN_BETWEEN_KNOTS) | lost) & solved[first]
    good = np.repeat(~bad, inner)
    joints[:] = np.where(good[:, None] & solved[:, None], smooth, between)
    return np.asarray(rows[bad])


_CornerPoses = tuple[Floats, Floats, Floats]
"""Joints (m, a), positions (m, 3) and quaternions (m, 4) at m places of a way."""


class _Corners:
    """c corners.

    step: (s,) rows of the knots that move. d: (s,) their lengths. at: (c,) the step before each
    corner. zone: (c,) how far it reaches, before and after.
    """

    def __init__(
        self, moves: Moves, knots: Knots, step: Rows, d: Floats, at: Rows, zone: Floats
    ) -> None:
        self.moves, self.knots, self.step, self.d = moves, knots, step, d
        self.at, self.zone = at, zone
        self.gone = np.concatenate([[0.0], np.cumsum(d)])
        row = knots.row[step]
        self.before, self.behind = row[at], row[at + 1]
        self.first = np.searchsorted(row, self.before)
        self.last = np.searchsorted(row, self.behind, side="right") - 1
        rates = max_abs(knots.joints[step + 1] - knots.joints[step]) / d
        self.swept = zone * (rates[at] + rates[at + 1])
        wanted = np.maximum(2.0 * zone / TimeSampling.APART, self.swept / TimeSampling.TURNED)
        spans = np.maximum(np.ceil(wanted), TimeSampling.SPANS)
        spans = np.minimum(spans, TimeSampling.MOST)
        if spans.sum() > TimeSampling.MOST_KNOTS:
            spans *= TimeSampling.MOST_KNOTS / spans.sum()
        self.spans = spans.astype(np.intp) // 2 * 2 + 1

    def inserted(
        self, robot: Robot, distance: Floats, room: Floats, corner: Rows
    ) -> tuple[Knots, Floats, Floats, Rows]:
        """The knots with those of the corners; with them distances (k,) of the steps, and room and
        corner (k + 1,) of the knots, see `Course`.
        """
        knots, spans = self.knots, self.spans
        each = np.repeat(np.arange(len(spans)), spans)
        count = np.arange(len(each)) - np.repeat(np.cumsum(spans) - spans, spans)
        joints, positions, quaternions = self._blossoms(robot, each, count)
        kept, middle = np.flatnonzero(self._kept()), self.step[self.at] + 1
        order = np.argsort(np.concatenate([kept, middle[each]]), kind="stable")

        def whole(old: NDArray[Any], new: NDArray[Any]) -> NDArray[Any]:
            return np.concatenate([old[kept], new])[order]

        half = self.zone / self.spans
        place = np.concatenate([[0.0], np.cumsum(distance)])
        new = (place[middle] - self.zone)[each] + (2 * count + 1) * half[each]
        distance = np.diff(whole(place, new))
        # Of the step that leads to each knot:
        ahead = np.where(count > spans[each] // 2, self.behind[each], self.before[each])
        row = whole(np.concatenate([[0], knots.row]), ahead)[1:]
        joints, positions = whole(knots.joints, joints), whole(knots.positions, positions)
        quaternions = whole(knots.quaternions, quaternions)
        length = norms(np.diff(positions, axis=0))
        turn = rotations.angle_between(quaternions[:-1], quaternions[1:])
        number = whole(np.arange(len(knots.joints)), np.full(len(each), -2))
        same = np.flatnonzero(np.diff(number) == 1)
        length[same], turn[same] = knots.length[number[same]], knots.turn[number[same]]
        part = np.where(distance > 0.0, 1.0, 0.0)
        return (
            Knots(row, part, joints, positions, quaternions, length, turn, knots.guessed),
            distance,
            whole(room, half[each]),
            whole(corner, self.at[each]),
        )

    def _kept(self) -> Truths:
        """(k + 1,) the knots that no corner replaces, nor comes close to."""
        reach = self.gone[self.at + 1]
        low = np.searchsorted(self.gone, reach - self.zone - self.d[self.at] / 4.0, side="right")
        high = np.searchsorted(self.gone, reach + self.zone + self.d[self.at + 1] / 4.0)
        low, high = np.maximum(low, self.first + 1), np.minimum(high, self.last + 1)
        change = np.zeros(len(self.gone) + 1, np.intp)
        np.add.at(change, low, 1)
        np.add.at(change, high, -1)
        kept = np.ones(len(self.knots.joints), dtype=bool)
        kept[self.step[np.flatnonzero(np.cumsum(change)[: len(self.step)] > 0)]] = False
        return kept

    def _blossoms(self, robot: Robot, each: Rows, count: Rows) -> _CornerPoses:
        """The knots of the spans; each: (m,) their corners, count: (m,) which span it is."""
        u0, u1 = count / self.spans[each], (count + 1) / self.spans[each]
        reach, zone = self.gone[self.at + 1][each], self.zone[each]
        before = self._at(reach - zone * (1.0 - u0) * (1.0 - u1), self.first[each], self.at[each])
        behind = self._at(reach + zone * u0 * u1, self.at[each] + 1, self.last[each])
        middle = self.step[self.at[each]] + 1
        knots = self.knots
        joints = before[0] + behind[0] - knots.joints[middle]
        p = before[1] + behind[1] - knots.positions[middle]
        back = rotations.multiply(behind[2], rotations.conjugate(knots.quaternions[middle]))
        q = rotations.multiply(back, before[2])
        kinds, mount = self.moves.kinds, self.moves.mount[self.before[each]]
        free = (kinds[self.before] == Kind.JOINT) | (kinds[self.behind] == Kind.JOINT)
        branch = robot.branch_of(robot.configuration(knots.joints[middle]))
        for index in np.unique(mount):
            tool, here = self.moves.mounts[index], mount == index
            some = np.flatnonzero(here & ~free[each])
            flange = tool.to_flange(p[some], q[some])
            if robot.arm.named:
                found = _solved_joints(robot, branch[some], *flange)
            else:
                found = _followed_joints(robot, joints[some], np.arange(len(some)), *flange)
            off = robot.wound(found - joints[some])
            good = max_abs(off) <= self.swept[each[some]] / 2.0
            joints[some[good]] += off[good]
            some = np.concatenate([np.flatnonzero(here & free[each]), some[~good]])
            p[some], q[some] = tool.tip(robot, joints[some])
        return joints, p, q

    def _at(self, place: Floats, first: Rows, last: Rows) -> _CornerPoses:
        """Between knots, at places (m,) along the way in steps from first (m,) to last (m,)."""
        ordinal = np.clip(np.searchsorted(self.gone, place, side="right") - 1, first, last)
        part = np.clip((place - self.gone[ordinal]) / self.d[ordinal], 0.0, 1.0)
        step, knots = self.step[ordinal], self.knots
        joints, positions = (
            values[step] + part[:, None] * (values[step + 1] - values[step])
            for values in (knots.joints, knots.positions)
        )
        q = rotations.between(knots.quaternions[step], knots.quaternions[step + 1], part)
        return joints, positions, q


NO_STEP: Final = 1e-9
"""mm or degrees below which a step counts as no movement."""
ON_THE_SPOT: Final = 1e-3
"""mm of way for a degree of turn below which a move is a turn on the spot."""
TURN_OF_ZONE: Final = 0.15
"""Degrees of turn for a mm of a zone, as RAPID's predefined zones have it (z10: 1.5)."""
_MOST_PARABOLA_CUT: Final = 0.05
"""mm or degrees that a corner is cut by at most to be one parabola of the joints and the tool."""


@dataclass(frozen=True, slots=True, eq=False)
class Zones:
    """c corners that are cut, in order: the moves before and after each (c,), its place along the
    course and how far it reaches to both sides, mm (c,).
    """

    before: Rows
    after: Rows
    place: Floats
    size: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """s steps of knots that move, and s + 1 knots between them.

    step: (s,) rows of the knots. distance: (s,) along the path, mm (degrees where the tool turns on
    the spot, or the arm moves around it), as if no corner were cut. room: (s + 1,) the same before
    and after each knot at which the path is bent; 0 for a stop. corner: (s + 1,) whether the knot
    belongs to a corner that is cut. inside: (s,) whether a step lies between knots of one corner.
    loose: (s,) whether it is of a joint move, or lies in the corner of one. axes: (a, s) and tool:
    (3, s) movement in a step for each mm of it. straight: (s,) whether it is of joint moves alone,
    so that its joints are nowhere else than on the lines between the knots and the parabolas of the
    corners. moves, robot: inputs of the course. scale: (n,) length of each of the moves. zones: its
    corners.
    """

    knots: Knots
    step: Rows
    distance: Floats
    room: Floats
    corner: Truths
    inside: Truths
    loose: Truths
    axes: Floats
    tool: Floats
    straight: Truths
    moves: Moves
    robot: Robot
    scale: Floats
    zones: Zones

    @property
    def row(self) -> Rows:
        """(s,) the move that a step belongs to."""
        return np.asarray(self.knots.row[self.step])


def course_of(moves: Moves, knots: Knots, robot: Robot) -> Course:
    """Return the course of moves that pass through knots."""
    lengths, turns = (sums_by_move(knots.row, x, len(moves)) for x in (knots.length, knots.turn))
    scale, kind = _scales(knots, lengths, turns)
    distance = knots.part * scale[knots.row]
    going = (distance > NO_STEP) | (knots.part <= 0.0)
    if not going.all():  # Moves to where the tool is have no knots: the way goes on through them.
        knots, distance = _only(knots, going), distance[going]
    step = np.flatnonzero(distance > NO_STEP)
    d, row = distance[step], knots.row[step]
    axes, tool = _rates(knots.joints, step, d), _rates(knots.positions, step, d)
    free = moves.kinds == Kind.JOINT
    beside = free[row]
    beside[:-1] |= free[row[1:]]
    both = free[row]
    both[:-1] &= free[row[1:]]
    room = np.full(len(knots.joints), np.nan)  # of each knot of a corner or a stop
    corner = np.full(len(room), -1)
    at, zone = _zones(moves, row, scale, kind)
    cut = zone > 0.0
    zones = Zones(row[at[cut]], row[at[cut] + 1], np.cumsum(d)[at[cut]], zone[cut])
    scale = sums_by_move(row, d, len(moves))
    if len(step) > 1:
        small = np.minimum(zone, np.minimum(d[at], d[at + 1]) / 2.0)
        for knot in (step[at] + 1, step[at + 1]):
            room[knot], corner[knot] = small, np.where(small > 0.0, at, -1)
        wide = (_corner_cuts(axes, at, zone) > _MOST_PARABOLA_CUT) | (
            _corner_cuts(tool, at, zone) > _MOST_PARABOLA_CUT
        )
        wide &= step[at + 1] == step[at] + 1  # the tool is the same
        if wide.any():
            corners = _Corners(moves, knots, step, d, at[wide], zone[wide])
            knots, distance, room, corner = corners.inserted(robot, distance, room, corner)
            step = np.flatnonzero(distance > NO_STEP)
            d = distance[step]
            axes, tool = _rates(knots.joints, step, d), _rates(knots.positions, step, d)
    knots = replace(knots, quaternions=rotations.unflipped(knots.quaternions))
    first, last = corner[step], corner[step + 1]
    ends = np.append(step, len(room) - 1)
    inside = (first >= 0) & (first == last)
    room = _rooms(room[ends], d)
    loose = free[knots.row[step]]
    loose[inside] |= beside[first[inside]]
    straight = free[knots.row[step]]
    straight[inside] = both[first[inside]]
    cuts = corner[ends] >= 0
    whole = moves, robot, scale, zones
    return Course(knots, step, d, room, cuts, inside, loose, axes, tool, straight, *whole)


def _only(knots: Knots, going: Truths) -> Knots:
    """Those at the ends of some steps (k,)."""
    kept = np.append(True, going)
    poses = knots.joints[kept], knots.positions[kept], knots.quaternions[kept]
    steps = knots.length[going], knots.turn[going]
    return Knots(knots.row[going], knots.part[going], *poses, *steps, knots.guessed)


def _scales(knots: Knots, lengths: Floats, turns: Floats) -> tuple[Floats, NDArray[np.uint8]]:
    """(n,) how long each move's way is, and in what: 0 mm, 1 degrees of the tool, 2 of an axis."""
    angles = np.zeros(len(lengths))
    swept = max_abs(np.diff(knots.joints, axis=0))
    np.maximum.at(angles, knots.row, swept / np.maximum(knots.part, 1e-300) * (knots.part > 0))
    moved = (lengths > NO_STEP) & (lengths > ON_THE_SPOT * turns)
    turned = ~moved & (turns > NO_STEP) & (turns > ON_THE_SPOT * angles)
    kind = np.where(moved, 0, np.where(turned, 1, 2)).astype(np.uint8)
    return np.where(moved, lengths, np.where(turned, turns, angles)), kind


def _zones(moves: Moves, row: Rows, scale: Floats, kind: NDArray[np.uint8]) -> tuple[Rows, Floats]:
    """(c,) steps behind which a corner or a stop is, and how far it reaches: 0 for a stop.

    row: (s,) the moves of the steps. A corner takes half of either move at most.
    """
    at = np.flatnonzero(row[:-1] != row[1:])
    i, j = row[at], row[at + 1]
    stops = np.concatenate([[0], np.cumsum(moves.entry <= 0.0)])
    entry = np.where(kind[i] == 0, moves.entry[i], TURN_OF_ZONE * moves.entry[i])
    leaving = np.where(kind[j] == 0, moves.leaving[i], TURN_OF_ZONE * moves.leaving[i])
    zone = np.minimum(np.minimum(entry, scale[i] / 2.0), np.minimum(leaving, scale[j] / 2.0))
    zone[(stops[j] > stops[i]) | (kind[i] != kind[j])] = 0.0
    through = (moves.kinds[i] == Kind.VIA) & (moves.kinds[j] == Kind.END)
    return at[~through], zone[~through]


def _corner_cuts(rates: Floats, at: Rows, zone: Floats) -> Floats:
    """(c,) how far from corners behind steps one parabola goes past; 0 where it cannot be far."""
    cut = np.zeros(len(at))
    far = np.flatnonzero(zone * np.abs(rates).max() > 2.0 * _MOST_PARABOLA_CUT)
    bend = np.abs(rates[:, at[far] + 1] - rates[:, at[far]]).max(axis=0)
    cut[far] = bend * zone[far] / 4.0
    return cut


def _rooms(room: Floats, d: Floats) -> Floats:
    """(s + 1,) of all knots, from those of corners and stops, NaN for others; the ends are stops.

    Between other steps it is half of the shorter, or what the corner beside them leaves.
    """
    room[0] = room[-1] = 0.0
    smooth = np.isnan(room)
    left = np.where(smooth[:-1], d / 2.0, d - np.nan_to_num(room[:-1]))
    right = np.where(smooth[1:], d / 2.0, d - np.nan_to_num(room[1:]))
    inner = np.minimum(left[:-1], right[1:])
    room[1:-1] = np.where(smooth[1:-1], inner, room[1:-1])
    return room


def _rates(values: Floats, step: Rows, d: Floats) -> Floats:
    """(c, s) change of values (k + 1, c) of knots in each step, for each mm of it."""
    change = np.diff(values, axis=0)
    if len(step) < len(change):
        change = change[step]
    return np.divide(change.T, d, order="C")


def sums_by_move(row: Rows, values: Floats, n: int) -> Floats:
    """(n,) of values (s,) of the moves that they belong to."""
    return np.asarray(np.bincount(row, values, n), dtype=np.float64)
