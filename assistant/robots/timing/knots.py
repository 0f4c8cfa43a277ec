"""The way of moves as knots: close enough to each other to take the joints as linear between.

A knot is a place of the tool with the joints that it takes. A short move is one step, from its
start to its end; a long one gets knots on its line or arc, solved in the branch of its end (of an
arm without named branches followed from its start).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, any_of, max_abs, norms
from assistant.program.motion import Kind
from assistant.robots.arms.arm import CLOSING
from assistant.robots.motion.along import ToolPaths, joints_along
from assistant.robots.motion.arcs import Arcs, arcs_of, vias_of
from assistant.robots.motion.densities import TimeSampling
from assistant.robots.robot import CHUNK, IN_LINE, Robot
from assistant.robots.timing.rows import Moves

SAME_TIP: Final = 1e-6
"""mm and degrees up to which tips of two tools are at one place."""
MOST_TURN_BETWEEN_KNOTS: Final = 60.0
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
    """Where n moves start, with their own tool and frame, and how long their ways are.

    j0 (n, a), p0 (n, 3), q0 (n, 4). lengths (n,) mm, turns (n,) deg; of joint moves straight.
    remounted: (n,) whether the tool or frame is another one than before, whose tip is elsewhere.
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
            moved = max_abs(p - self.p0[rows]) > SAME_TIP
            turned = rotations.angle_between(q, self.q0[rows]) > SAME_TIP
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
            joints[some] = solved_joints(robot, branches[some], *flange)
        else:
            joints[some] = followed_joints(robot, ends.j0[each[some]], each[some], *flange)
    straight = ~free
    guessed = _unwind(joints, between, straight, each, rows, inner, moves, ends, robot)
    knots.positions[at], knots.quaternions[at], knots.joints[at] = p, q, joints
    return guessed


def solved_joints(robot: Robot, branches: Rows, p: Floats, q: Floats) -> Floats:
    """(m, a) joints at flange poses in branches (m,), whole turns left open; NaN where those do
    not reach.
    """
    joints, excess = joints_along(robot, None, branches, (p[:, None], q[:, None]))
    joints[excess >= CLOSING] = np.nan
    return joints[:, 0]


def followed_joints(robot: Robot, before: Floats, each: Rows, p: Floats, q: Floats) -> Floats:
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
    """Makes the joints of inner knots continuous from the start of each move to its end.

    Where that cannot be, they are set to `between`, and the rows are given.
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
    bad = (missed | (widest > MOST_TURN_BETWEEN_KNOTS) | lost) & solved[first]
    good = np.repeat(~bad, inner)
    joints[:] = np.where(good[:, None] & solved[:, None], smooth, between)
    return np.asarray(rows[bad])
