"""Motion between the targets of linear and circular moves: joints, turns, limits, singularities."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Ints, Rows, Singles, Truths, all_of, any_of, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.program.geometry import Pose
from assistant.program.motion import Kind
from assistant.robots import findings as rules
from assistant.robots.arms.arm import CLOSING
from assistant.robots.motion.branch_sequence import AxisBetweenTargets
from assistant.robots.motion.interpolation import (
    Arcs,
    ToolPaths,
    TurnSampling,
    arcs_of,
    flange_along,
    joints_along,
    vias_of,
)
from assistant.robots.motion.row_reach import distance_text
from assistant.robots.motion.run import Run, continued
from assistant.robots.motion.singularities import (
    EVEN,
    WRIST_PAIRS,
    bends_to,
    may_pass_through,
    passes_through,
    steps_without_singularity,
)
from assistant.robots.robot import CHUNK, Robot

_BETWEEN_TOLERANCE: Final = 1e-3
"""degrees or mm by which an axis may pass its limit between rows: what is printed of them is no
better."""


@dataclass(frozen=True, slots=True)
class MotionBetweenTargets:
    """Motion of the arm on the paths to m rows that are examined.

    rows: (m,). winding: (m, a) whole turns that an axis makes beyond the shorter direction from the
    row before. below, above: (m, a) degrees or mm by which an axis goes below and above its value
    at the row, at most 0 and at least 0. short: (m,) mm that the path is out of reach. jumps: moves
    that an arm without named branches cannot do.
    """

    rows: Rows
    winding: Ints
    below: Floats
    above: Floats
    short: Floats
    jumps: tuple[tuple[int, str], ...]

    def of(self, axis: int, count: int) -> AxisBetweenTargets:
        """Return the motion of one axis on the path to each of `count` rows."""
        winding = np.zeros(count, dtype=np.int64)
        below, above = np.zeros(count), np.zeros(count)
        winding[self.rows], below[self.rows] = self.winding[:, axis], self.below[:, axis]
        above[self.rows] = self.above[:, axis]
        return AxisBetweenTargets(winding, below, above)

    def faults(self, run: Run, robot: Robot, joints: Floats) -> tuple[Rows, list[Diagnostic]]:
        """Rows to which there is no way with joints (n, a), whole turns included, and why."""
        low, high = robot.limits.T
        here = joints[self.rows]
        # Where a row is beyond a limit itself, that is told of by itself.
        under = np.where(self.below < 0.0, low - (here + self.below), -np.inf)
        over = np.where(self.above > 0.0, here + self.above - high, -np.inf)
        beyond = np.maximum(under, over)
        bad = list(self.jumps)
        for i in np.flatnonzero(
            (self.short >= CLOSING) | (beyond > _BETWEEN_TOLERANCE).any(axis=1)
        ):
            row = int(self.rows[i])
            if self.short[i] >= CLOSING:
                bad.append((row, f"is up to {distance_text(self.short[i])} mm out of reach"))
                continue
            axis = int(beyond[i].argmax())
            least = under[i, axis] > over[i, axis]
            angle = here[i, axis] + (self.below if least else self.above)[i, axis]
            limit = (low if least else high)[axis]
            value = f"{angle:.2f} {robot.units[axis]}"
            bad.append((row, f"would have {robot.axes[axis]} at {value}, limit {limit:g}"))
        bad.sort()
        findings = []
        for way, round_ in (("straight line", False), ("arc", True)):
            told = [one for one in bad if bool(run.kinds[one[0]] != Kind.LINEAR) is round_]
            if told:
                findings.append(
                    rules.ON_THE_WAY(
                        about=run.what(np.array([row for row, _ in told], dtype=np.intp)),
                        way=way,
                        robot=robot.title,
                        reason=told[0][1],
                        where=run.label(told[0][0]),
                    )
                )
        return np.array([row for row, _ in bad], dtype=np.intp), findings


_JUMP: Final = 1.0
"""degrees or mm between joints that are not the same solution."""


@dataclass(frozen=True, slots=True)
class SampledJoints:
    """Joints on the ways to k rows, both ends included.

    joints: (k, p, a) deg. turned: (k, p, a) by how much they have turned since the start,
    without a break. excess: (k, p - 2) mm out of reach, of the poses between the ends.
    spherical: whether axes 4 to 6 meet.
    """

    joints: Floats
    turned: Floats
    excess: Floats
    spherical: bool

    def of(self, some: Truths) -> SampledJoints:
        return SampledJoints(
            self.joints[some], self.turned[some], self.excess[some], self.spherical
        )

    def leaps(self) -> Truths:
        """(k, p - 1) between which poses an axis goes so far that it may have gone round, or the
        wrist so far that it may not have gone through its singularity, but past it.
        """
        out = np.asarray((np.abs(np.diff(self.turned, axis=1)) > TurnSampling.LEAP).any(axis=2))
        if self.spherical:
            out |= may_pass_through(bends_to(self.joints[..., 3], self.joints[..., 4]))
        return out

    def doubtful(self, robot: Robot) -> Truths:
        """(k,) whether poses so far apart may hide a turn, a peak or the end of reach."""
        steps = np.abs(np.diff(self.turned, axis=1))
        out = np.asarray(self.leaps().any(axis=1))
        margin = steps.max(axis=1)[:, None] + TurnSampling.NEAR
        for limit in robot.limits.T:
            out |= (np.abs(robot.wound(self.joints - limit)) < margin).any(axis=(1, 2))
        k, places, axes = self.joints.shape
        elbow = robot.arm.elbow(robot.chained(self.joints.reshape(-1, axes)))
        if elbow is not None:
            out |= (np.abs(np.sin(elbow)) < TurnSampling.STRETCHED).reshape(k, places).any(axis=1)
        return out


class MoveSampler:
    """The moves of a run, each from where the one before ends.

    start: where the tool is before the run, in the frame of the first row; None if the run does
    not go on from there. arcs: the circular moves whose tool and frame stay the same.
    """

    def __init__(self, run: Run, robot: Robot, joints: Floats) -> None:
        self.run, self.robot, self.joints = run, robot, joints
        self.start: Pose | None = None
        if continued(run):
            p, q = robot.flange_poses(run.before)
            self.start = run.mounting.from_flange(Pose.of(p[0], q[0]), 0)
        self.same = run.mounting.unchanged()
        self.same[0] = self.start is not None
        self.arcs = self._arcs()

    def _arcs(self) -> Arcs | None:
        vias = vias_of(self.run.kinds)
        vias = vias[self.same[vias] & self.same[vias + 1]]
        if not len(vias):
            return None
        starts, _ = self._starts(vias)
        return arcs_of(vias, starts, self.run.targets(vias)[0], self.run.targets(vias + 1)[0])

    def rows(self, branch: Rows) -> Iterator[tuple[Rows, int]]:
        """Rows (m,) of one branch to which the way has to be looked at, and at how many poses."""
        wide = np.zeros(len(self.joints), dtype=bool)
        with np.errstate(invalid="ignore"):
            step = np.abs(self.robot.wound(np.diff(self.joints, axis=0)))
            wide[1:] = any_of(step > TurnSampling.WIDE) & all_of(np.isfinite(step))
            first = self.robot.wound(self.joints[0] - self.run.before)
            wide[0] = (np.abs(first) > TurnSampling.WIDE).any()
            wide |= self.long()
        linear = wide & (self.run.kinds == Kind.LINEAR)
        samples = np.where(linear, TurnSampling.SAMPLES[1], 0)
        if self.arcs is not None:
            parts = np.sqrt(self.arcs.bulges / TurnSampling.BULGE)
            enough = np.searchsorted(TurnSampling.SAMPLES + 1, parts)
            least = TurnSampling.SAMPLES[np.minimum(enough, len(TurnSampling.SAMPLES) - 1)]
            least[parts < 1.0] = 0
            samples[self.arcs.rows] = np.where(
                wide[self.arcs.rows], np.maximum(least, TurnSampling.SAMPLES[1]), least
            )
        known = self.same & (branch >= 0)
        known[1:] &= branch[1:] == branch[:-1]
        chosen = np.flatnonzero(known & (samples > 0))
        for count in TurnSampling.SAMPLES.tolist():
            some = chosen[samples[chosen] == count]
            many = max(CHUNK // count, 1)
            for one in np.unique(branch[some]):
                own = some[branch[some] == one]
                for at in range(0, len(own), many):
                    yield own[at : at + many], count

    def long(self) -> Truths:
        """(n,) which rows are far from the row before."""
        out = np.zeros(len(self.joints), dtype=bool)
        for start in range(1, len(out), CHUNK):
            rows = slice(start - 1, min(start + CHUNK, len(out)))
            p, _ = self.run.targets(rows)
            out[start : rows.stop] = norms(np.diff(p, axis=0)) > TurnSampling.LONG
        if self.start is not None:
            p, _ = self.run.targets(slice(0, 1))
            out[0] = np.linalg.norm(p[0] - self.start.position) > TurnSampling.LONG
        return out

    def far(self, rows: Rows) -> Truths:
        """(m,) which of some rows the tool goes or turns far to."""
        (p0, q0), (p1, q1) = self._starts(rows), self.run.targets(rows)
        turn = rotations.angle_between(q0, q1)
        return np.asarray((norms(p1 - p0) > TurnSampling.LONG) | (turn > TurnSampling.WIDE))

    def seen(self, rows: Rows, way: SampledJoints) -> MotionBetweenTargets:
        """Summarise the sampled paths to some rows (k,)."""
        end = way.turned[:, -1]
        whole = end - self.robot.wound(self.joints[rows] - self.before(rows))
        away = way.turned - end[:, None]
        jumps: list[tuple[int, str]] = []
        if not self.robot.arm.named and len(rows):
            jumps = _jumps(self.run, self.robot, rows, way.joints[:, -2], self.joints[rows])
        winding = np.round(whole / 360.0).astype(np.int64)
        short = way.excess.max(axis=1)
        return MotionBetweenTargets(
            rows, winding, away.min(axis=1), away.max(axis=1), short, tuple(jumps)
        )

    def way(self, rows: Rows, part: Floats, branch: int) -> SampledJoints:
        """The ways to some rows (k,) at parts (p,) of each, both ends added."""
        found, excess = self.on_the_way(rows, np.broadcast_to(part, (len(rows), len(part))), branch)
        before = self.before(rows)
        joints = np.concatenate([before[:, None], found, self.joints[rows][:, None]], axis=1)
        return SampledJoints(joints, self._turned(joints), excess, self.robot.arm.spherical)

    def closer(self, row: Rows, part: Floats, branch: int) -> tuple[Rows, Floats, SampledJoints]:
        """The way to one row (1,), at more parts where an axis leaps: beside a singularity it turns
        by a half in a thousandth of the way.
        """
        way = self.way(row, part, branch)
        for _ in range(TurnSampling.SPLITS):
            leaping = np.flatnonzero(way.leaps()[0])
            if not len(leaping):
                break
            part = _divided(part, leaping)
            way = self.way(row, part, branch)
        return row, part, way

    def crosses(self, row: Rows, part: Floats, pair: int, ends: Floats) -> bool:
        """True if the path to one row (1,) passes through the singularity of the wrist.

        ends: (2, 2) directions of the wrist's bend at its ends, of the first branch of a pair.
        """
        for _ in range(TurnSampling.SPLITS):
            found, _ = self.on_the_way(row, part[None], 2 * pair)
            between = bends_to(found[0, :, 3], found[0, :, 4])
            bends = np.concatenate([ends[:, :1], between, ends[:, 1:]], axis=1)
            goes = bool(passes_through(bends).any())
            unsure = np.flatnonzero(may_pass_through(bends))
            if not len(unsure):
                break
            part = _divided(part, unsure)
        return goes

    def _turned(self, joints: Floats) -> Floats:
        steps = self.robot.wound(np.diff(joints, axis=1))
        if self.robot.arm.spherical:
            steps = steps_without_singularity(steps, bends_to(joints[..., 3], joints[..., 4]))
        return np.concatenate([np.zeros_like(steps[:, :1]), np.cumsum(steps, axis=1)], axis=1)

    def peaks(
        self, part: Floats, way: SampledJoints, branch: int, seen: MotionBetweenTargets
    ) -> None:
        """Adds to what ways were seen to come to the peaks between their poses, where an axis
        turns back near to a limit.
        """
        part = np.concatenate([[0.0], part, [1.0]])
        margin = np.abs(np.diff(way.turned, axis=1)).max(axis=1) + TurnSampling.NEAR
        for least, column in ((True, seen.below), (False, seen.above)):
            at = (way.turned.argmin if least else way.turned.argmax)(axis=1)  # (k, a)
            there = np.take_along_axis(way.joints, at[:, None], axis=1)[:, 0]
            limit = self.robot.limits[:, 0 if least else 1]
            near = np.abs(self.robot.wound(there - limit)) < margin
            i, axis = np.nonzero(near & (at > 0) & (at < len(part) - 1))
            if not len(i):
                continue
            first = at[i, axis] - 1
            span = part[first + 2] - part[first]
            fine = (
                part[first][:, None]
                + span[:, None] * np.arange(1, TurnSampling.PEAK) / TurnSampling.PEAK
            )
            found, _ = self.on_the_way(seen.rows[i], fine, branch)
            joints = np.concatenate([way.joints[i, first][:, None], found], axis=1)
            turned = way.turned[i, first][:, None] + self._turned(joints)
            away = turned[np.arange(len(i)), :, axis] - way.turned[i, -1, axis][:, None]
            more = np.minimum if least else np.maximum
            more.at(column, (i, axis), more.reduce(away, axis=1))

    def before(self, rows: Rows) -> Floats:
        """(m, a) deg where the moves to some rows begin."""
        joints = self.joints[rows - 1]
        joints[rows == 0] = self.run.before
        return joints

    def on_the_way(self, rows: Rows, part: Floats, branch: int) -> tuple[Floats, Floats]:
        """Joints (m, s, a) deg and excess of the reach (m, s) mm on the ways to some rows, at
        parts (m, s) of each.

        The tool turns evenly up to each row, that of a via point included.
        """
        (p0, q0), (p1, q1) = self._starts(rows), self.run.targets(rows)
        q0, q1 = (q / norms(q)[:, None] for q in (q0, q1))
        tool = ToolPaths((p0, q0), (p1, q1), rows, self.arcs).at(part)
        flange = flange_along(self.run.mounting, rows, tool)
        before = None if self.robot.arm.named else self.before(rows)
        return joints_along(self.robot, before, np.full(len(rows), branch), flange)

    def _starts(self, rows: Rows) -> tuple[Floats, Floats]:
        """Targets (m, 3), (m, 4) that the moves to some rows begin at."""
        p, q = self.run.targets(np.maximum(rows - 1, 0))
        if self.start is not None:
            p[rows == 0], q[rows == 0] = self.start.position, self.start.quaternion
        return p, q


def _jumps(
    run: Run, robot: Robot, rows: Rows, last: Floats, joints: Floats
) -> list[tuple[int, str]]:
    """Rows whose joints (m, a) deg are not those that the last ones on the way (m, a) lead to: an
    arm whose branches have no names may have several solutions in one.
    """
    p, q = run.flange(rows)
    led, _ = robot.follow(last, p[:, None], q[:, None])
    off = np.abs(robot.wound(joints - led[:, 0]))
    out = []
    for i in np.flatnonzero(off.max(axis=1) > _JUMP):
        axis = int(off[i].argmax())
        name, unit = robot.axes[axis], robot.units[axis]
        out.append((int(rows[i]), f"would have {name} jump by {off[i, axis]:.1f} {unit}"))
    return out


def _divided(part: Floats, solved_runs: Rows) -> Floats:
    """Parts (p,) of a way, and more in some of the stretches 0 to p between them and its ends."""
    whole = np.concatenate([[0.0], part, [1.0]])
    first, last = whole[solved_runs, None], whole[solved_runs + 1, None]
    more = first + (last - first) * np.arange(1, TurnSampling.SPLIT) / TurnSampling.SPLIT
    return np.unique(np.concatenate([part, more.ravel()]))


def motion_between_targets(
    run: Run, robot: Robot, joints: Floats, branch: Rows
) -> MotionBetweenTargets:
    """Examine the linear and circular moves of a run whose joints (n, a) deg are up to whole turns.

    branch: (n,) of each row, -1 if missing.
    """
    look = MoveSampler(run, robot, joints)
    axes = len(robot.axes)
    parts = [MotionBetweenTargets(np.empty(0, np.intp), *_empty_columns(axes), np.empty(0), ())]
    for rows, samples in look.rows(branch):
        one = int(branch[rows[0]])
        part = np.arange(1, samples + 1) / (samples + 1)
        way = look.way(rows, part, one)
        fine = way.doubtful(robot) & robot.arm.named
        parts.append(look.seen(rows[~fine], way.of(~fine)))
        dense = np.arange(1, TurnSampling.FINE) / TurnSampling.FINE
        many = max(CHUNK // TurnSampling.FINE, 1)
        for start in range(0, int(fine.sum()), many):
            at = rows[fine][start : start + many]
            way = look.way(at, dense, one)
            leaping = np.asarray(way.leaps().any(axis=1))
            looked = [(at[~leaping], dense, way.of(~leaping))]
            looked += [look.closer(at[i : i + 1], dense, one) for i in np.flatnonzero(leaping)]
            for some, part, way in looked:
                seen = look.seen(some, way)
                look.peaks(part, way, one, seen)
                parts.append(seen)
    out = MotionBetweenTargets(
        np.concatenate([each.rows for each in parts]),
        np.concatenate([each.winding for each in parts]),
        np.concatenate([each.below for each in parts]),
        np.concatenate([each.above for each in parts]),
        np.concatenate([each.short for each in parts]),
        tuple(jump for each in parts for jump in each.jumps),
    )
    out.winding[out.rows == 0] = 0  # the whole run starts with the turns that suit it best
    return out


def _empty_columns(axes: int) -> tuple[Ints, Floats, Floats]:
    return np.empty((0, axes), np.int64), np.empty((0, axes)), np.empty((0, axes))


def confirmed_crossings(run: Run, robot: Robot, bends: Singles, crossed: Truths) -> Truths:
    """Which moves go through the singularity of the wrist (4, n), of those that do by their ends.

    bends: see `singularities.directions`. Where the ends are far apart, poses between them tell.
    """
    out = crossed.copy()
    apart = np.hypot(*np.diff(bends, axis=2, prepend=bends[:, :, :1]).swapaxes(0, 1)) > EVEN
    look = MoveSampler(run, robot, np.empty((0, len(robot.axes))))
    rows = np.flatnonzero(crossed.any(axis=0) & look.same)
    rows = rows[rows > 0]
    apart[:, rows] |= look.far(rows)
    rows = rows[(crossed & apart)[:, rows].any(axis=0)]
    part = np.arange(1, TurnSampling.FINE) / TurnSampling.FINE
    for start in range(0, len(rows), max(CHUNK // TurnSampling.FINE, 1)):
        here = rows[start : start + max(CHUNK // TurnSampling.FINE, 1)]
        for pair in range(WRIST_PAIRS):
            every = np.broadcast_to(part, (len(here), len(part)))
            found, _ = look.on_the_way(here, every, 2 * pair)
            between = bends_to(found[..., 3], found[..., 4])  # (2, k, p)
            ends = np.stack([bends[pair][:, here - 1], bends[pair][:, here]], axis=2)
            way = np.concatenate([ends[..., :1], between, ends[..., 1:]], axis=2)
            goes = np.asarray(passes_through(way).any(axis=1))
            unsure = may_pass_through(way).any(axis=1)
            for i in np.flatnonzero(unsure & crossed[pair, here] & apart[pair, here]):
                goes[i] = look.crosses(here[i : i + 1], part, pair, ends[:, i])
            out[pair, here] &= goes | ~apart[pair, here]
    return out
