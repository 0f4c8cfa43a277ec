"""What the arm does between the targets of linear and circular moves.

The angles at both ends of a move do not tell how often an axis turned on the way, nor
whether the way leaves the reach of the arm; poses on it do.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.program import rotations
from assistant.program.diagnostics import Diagnostic
from assistant.program.geometry import Pose
from assistant.program.path import Kind
from assistant.robots import findings as rules
from assistant.robots.arcs import Arcs, arcs_of, vias_of
from assistant.robots.arms.arm import CLOSING
from assistant.robots.choosing import continued
from assistant.robots.robot import CHUNK, LIMIT_TOLERANCE, Robot
from assistant.robots.run import Run
from assistant.robots.wrist import bends_to, swept

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

WIDE: Final = 20.0
"""degrees or mm that an axis moves in one move from which on the way is looked at."""
BULGE: Final = 1.0
"""mm that an arc is off the straight line from which on it is looked at all the same."""
JUMP: Final = 1.0
"""degrees or mm between joints that are not the same solution."""
SAMPLES: Final = np.array([3, 12, 40])
"""Poses on a way: the second for a line, and for an arc as few as leave bulges of about `BULGE`
between them."""


@dataclass(frozen=True, slots=True)
class Ways:
    """winding: (n, a) whole turns that an axis makes on the way to a row beyond the shorter
    way from the row before. findings: what cannot be done on the way to which rows.
    """

    winding: NDArray[np.int64]
    findings: tuple[Diagnostic, ...]
    rows: Rows


def ways(run: Run, robot: Robot, joints: Floats, branch: Rows) -> Ways:
    """Looks at the linear and circular moves of a run whose joints (n, a) deg are up to whole
    turns.

    branch: (n,) of each row, -1 where there is none.
    """
    winding = np.zeros(joints.shape, dtype=np.int64)
    look = _Look(run, robot, joints)
    bad: list[tuple[int, str]] = []
    for here, samples in look.rows(branch):
        one, before = int(branch[here[0]]), look.before(here)
        found, excess = look.on_the_way(here, samples, one)
        between = np.concatenate([before[:, None], found, joints[here][:, None]], axis=1)
        steps = robot.wound(np.diff(between, axis=1))
        if robot.arm.spherical:
            steps = swept(steps, bends_to(between[..., 3], between[..., 4]))
        whole = steps.sum(axis=1) - robot.wound(joints[here] - before)
        winding[here] = np.round(whole / 360.0)
        bad += _bad(robot, here, found, excess)
        if not robot.arm.named:
            bad += _jumps(run, robot, here, found[:, -1], joints[here])
    winding[:1] = 0  # the whole run starts with the turns that suit it best
    bad.sort()
    findings = []
    for way, round_ in (("straight line", False), ("arc", True)):
        over = [(row, reason) for row, reason in bad if look.is_round(row) is round_]
        if over:
            findings.append(
                rules.ON_THE_WAY(
                    place=run.what(np.array([row for row, _ in over], dtype=np.intp)),
                    way=way,
                    robot=robot.title,
                    reason=over[0][1],
                    where=run.label(over[0][0]),
                )
            )
    return Ways(winding, tuple(findings), np.array([row for row, _ in bad], dtype=np.intp))


class _Look:
    """The moves of a run, each from where the one before ends.

    start: where the tool is before the run, in the frame of the first row; None if the run does
    not go on from there. arcs: the circular moves whose tool and frame stay the same.
    """

    def __init__(self, run: Run, robot: Robot, joints: Floats) -> None:
        self.run, self.robot, self.joints = run, robot, joints
        self.start: Pose | None = None
        if continued(run):
            p, q = robot.fk(run.before)
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
            wide[1:] = (step > WIDE).any(axis=1) & np.isfinite(step).all(axis=1)
            first = self.robot.wound(self.joints[0] - self.run.before)
            wide[0] = (np.abs(first) > WIDE).any()
        linear = wide & (self.run.kinds == Kind.LINEAR)
        samples = np.where(linear, SAMPLES[1], 0)
        if self.arcs is not None:
            parts = np.sqrt(self.arcs.bulges / BULGE)
            least = SAMPLES[np.minimum(np.searchsorted(SAMPLES + 1, parts), len(SAMPLES) - 1)]
            least[parts < 1.0] = 0
            samples[self.arcs.rows] = np.where(
                wide[self.arcs.rows], np.maximum(least, SAMPLES[1]), least
            )
        known = self.same & (branch >= 0)
        known[1:] &= branch[1:] == branch[:-1]
        chosen = np.flatnonzero(known & (samples > 0))
        for count in SAMPLES.tolist():
            some = chosen[samples[chosen] == count]
            many = max(CHUNK // count, 1)
            for one in np.unique(branch[some]):
                own = some[branch[some] == one]
                for at in range(0, len(own), many):
                    yield own[at : at + many], count

    def is_round(self, row: int) -> bool:
        return bool(self.run.kinds[row] != Kind.LINEAR)

    def before(self, rows: Rows) -> Floats:
        """(m, a) deg where the moves to some rows begin."""
        joints = self.joints[rows - 1]
        joints[rows == 0] = self.run.before
        return joints

    def on_the_way(self, rows: Rows, samples: int, branch: int) -> tuple[Floats, Floats]:
        """Joints (m, s, a) deg and excess of the reach (m, s) mm on the ways to some rows.

        The tool turns evenly up to each row, that of a via point included.
        """
        run, robot = self.run, self.robot
        (p0, q0), (p1, q1) = self._starts(rows), run.targets(rows)
        part = np.arange(1, samples + 1) / (samples + 1)
        p = p0[:, None] + part[:, None] * (p1 - p0)[:, None]
        if self.arcs is not None:
            at = np.minimum(np.searchsorted(self.arcs.rows, rows), len(self.arcs.rows) - 1)
            on = np.flatnonzero(self.arcs.rows[at] == rows)
            p[on] = self.arcs.points(at[on], np.broadcast_to(part, (len(on), samples)))
        q0, q1 = (q / np.linalg.norm(q, axis=1, keepdims=True) for q in (q0, q1))
        q = rotations.between(q0[:, None], q1[:, None], part)
        each = np.repeat(rows, samples)
        p, q = run.mounting.to_flange(p.reshape(-1, 3), q.reshape(-1, 4), each)
        shape = (len(rows), samples)
        if not robot.arm.named:
            return robot.follow(self.before(rows), p.reshape(*shape, 3), q.reshape(*shape, 4))
        found, excess = robot.solve(p, q, (branch,))
        return found[:, 0].T.reshape(*shape, len(robot.axes)), excess[0].reshape(shape)

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
    for i in np.flatnonzero(off.max(axis=1) > JUMP):
        axis = int(off[i].argmax())
        name, unit = robot.axes[axis], robot.units[axis]
        out.append((int(rows[i]), f"would have {name} jump by {off[i, axis]:.1f} {unit}"))
    return out


def _bad(robot: Robot, rows: Rows, found: Floats, excess: Floats) -> list[tuple[int, str]]:
    low, high = robot.limits.T
    beyond = np.maximum(low - found, found - high)
    short = excess.max(axis=1)
    over = beyond.max(axis=(1, 2))
    out = []
    for i in np.flatnonzero((short >= CLOSING) | (over > LIMIT_TOLERANCE)):
        if short[i] >= CLOSING:
            out.append((int(rows[i]), f"is up to {short[i]:.1f} mm out of reach"))
            continue
        sample, axis = np.unravel_index(beyond[i].argmax(), beyond[i].shape)
        angle = found[i, sample, axis]
        limit = low[axis] if angle < low[axis] else high[axis]
        reason = (
            f"would have {robot.axes[axis]} at {angle:.2f} {robot.units[axis]}, limit {limit:g}"
        )
        out.append((int(rows[i]), reason))
    return out
