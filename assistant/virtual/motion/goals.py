"""Where motions lead: the joints at their ends, and the moves that are planned."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, norms
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.motion import UNSTATED, Kind
from assistant.robots.arms.arm import CLOSING
from assistant.robots.motion.arcs import arcs_of
from assistant.robots.motion.run import from_flange
from assistant.robots.robot import Robot
from assistant.robots.timing.rows import Mount, Moves
from assistant.virtual.events import Moved

Reason = Literal["reach", "joints", "configuration", "nowhere"]

ANY_CONFIGURATION: Final = (UNSTATED, 0, 0, 0, 0, 0)
KIND_OF_MOVE: Final = {"joint": Kind.JOINT, "linear": Kind.LINEAR, "circular": Kind.END}


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why the arm cannot go through a motion, which is the `index`-th of some.

    reason: out of `reach`, `joints` past their limits, in another `configuration` only, or what
    leads `nowhere` that is known. axis: the joint that passes its limit, or "".
    """

    index: int
    reason: Reason
    axis: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Goals:
    """Motions in columns: one row each, of an arc two.

    rows: (n,) the last row of each motion. moves: of the motions before the first that is refused.
    """

    moves: Moves | None
    rows: Rows
    refusal: Refusal | None


def goals_of(motions: Sequence[Moved], start: Floats, robot: Robot, strict: bool) -> Goals:
    """The moves of motions from joints (a,).

    strict: whether axes that turn further than a configuration says are refused; else they turn as
    little as they can in its arm branch.
    """
    rows = _GoalRows(motions, robot)
    joints, refusal = rows.joints(start, strict)
    last = rows.last if refusal is None else rows.last[: refusal.index]
    count = int(last[-1]) + 1 if len(last) else 0
    joints = joints[:count]
    if not count:
        return Goals(None, last, refusal)
    positions, quaternions = rows.tips(joints)
    of = rows.of[:count]
    how = [motion.how for motion in motions]

    def column(values: Sequence[float]) -> Floats:
        return np.asarray(np.array(values, dtype=np.float64)[of])

    behind = [m.blend if m.how.behind is None else m.how.behind for m in motions]
    tcp = column([math.inf if m.speed is None else m.speed for m in motions])
    rotation = column([h.rotation for h in how])
    if any(h.seconds is not None for h in how):
        _set_times(motions, of, (positions, quaternions), rows, start, (tcp, rotation))
    kinds = rows.kinds[:count]
    moves = Moves(
        kinds=kinds,
        joints=joints,
        positions=positions,
        quaternions=quaternions,
        mount=rows.mount[:count],
        mounts=rows.mounts,
        tcp=tcp,
        rotation=rotation,
        percent=column([np.nan if m.percent is None else m.percent for m in motions]),
        override=np.ones(count),
        acceleration=column([h.acceleration for h in how]),
        deceleration=column([h.deceleration for h in how]),
        entry=np.where(kinds == Kind.VIA, np.inf, column([m.blend for m in motions])),
        leaving=column(behind),
    )
    return Goals(moves, last, refusal)


def _set_times(
    motions: Sequence[Moved],
    of: Rows,
    tips: tuple[Floats, Floats],
    rows: _GoalRows,
    start: Floats,
    speeds: tuple[Floats, Floats],
) -> None:
    """The speeds of motions that state how long they are to take."""
    p, q = (np.concatenate([one, end]) for one, end in zip(rows.tip_at(start), tips, strict=True))
    lengths, turns = norms(np.diff(p, axis=0)), rotations.angle_between(q[:-1], q[1:])
    vias = np.flatnonzero(rows.kinds[: len(of)] == Kind.VIA)
    arcs = arcs_of(vias, p[vias], p[vias + 1], p[vias + 2]) if len(vias) else None
    if arcs is not None:
        lengths[arcs.rows] = arcs.lengths
    for i in np.unique(of):
        seconds = motions[i].how.seconds
        if seconds is not None and seconds > 0.0:
            own = of == i
            for values, speed in zip((lengths, turns), speeds, strict=True):
                way = float(values[own].sum())
                speed[own] = way / seconds if way > 0.0 else math.inf


class _GoalRows:
    """n motions as k rows. of: (k,) the motion of each; last: (n,) the last row of each."""

    def __init__(self, motions: Sequence[Moved], robot: Robot) -> None:
        self.motions, self.robot = motions, robot
        flanges: list[Pose | None] = []
        of: list[int] = []
        kinds: list[int] = []
        tools: dict[Pose, int] = {}
        for index, motion in enumerate(motions):
            if motion.via is not None:
                flanges.append(motion.via)
                of.append(index)
                kinds.append(Kind.VIA)
            flanges.append(motion.flange)
            of.append(index)
            kinds.append(KIND_OF_MOVE[motion.kind])
            tools.setdefault(motion.tool, len(tools))
        self.of, self.kinds = np.array(of), np.array(kinds, dtype=np.uint8)
        self.last = np.searchsorted(self.of, np.arange(len(motions)), side="right") - 1
        self.mounts = tuple(Mount(Tool(tip), Frame()) for tip in tools)
        mount = np.array([tools[motion.tool] for motion in motions], dtype=np.int32)
        self.mount = mount[self.of]
        self.known = np.array([flange is not None for flange in flanges])
        poses = [flange or Pose() for flange in flanges]
        self.p = np.array([pose.position for pose in poses])
        self.q = np.array([pose.quaternion for pose in poses])

    def joints(self, start: Floats, strict: bool) -> tuple[Floats, Refusal | None]:
        """(k, a) at the ends, and the first that cannot be."""
        robot, motions = self.robot, self.motions
        joints = np.full((len(self.of), len(robot.axes)), np.nan)
        named = np.array([motion.joints is not None for motion in motions])[self.of]
        stated = np.array([m.how.configuration is not None for m in motions])[self.of]
        stated &= ~named & (self.kinds != Kind.VIA) & robot.arm.named
        for row in np.flatnonzero(named):
            given = motions[self.of[row]].joints
            assert given is not None
            own = robot.own_joints((*given, *(0.0,) * 6)[: max(6, len(given))])
            if len(own) == len(robot.axes):
                joints[row] = own
        open_, branch = ~stated & ~named & self.known, np.full(len(self.of), -1)
        rows = np.flatnonzero(stated)
        if len(rows):
            wanted = np.array(
                [motions[i].how.configuration or ANY_CONFIGURATION for i in self.of[rows]]
            )
            joints[rows] = robot.joints_of(self.p[rows], self.q[rows], wanted)
            if not strict:
                branch[rows] = robot.branch_of(wanted)
                open_[rows] = np.isnan(joints[rows]).any(axis=1)
        rows = np.flatnonzero(open_)
        if len(rows):
            self._nearest(joints, rows, branch[rows], start)
        bad = np.flatnonzero(~robot.inside(joints))
        if not len(bad):
            return joints, None
        return joints, self._refusal(int(bad[0]), joints)

    def _nearest(self, joints: Floats, rows: Rows, branch: Rows, start: Floats) -> None:
        """Sets rows to the joints in a branch, -1 for any, that are nearest to those before."""
        robot = self.robot
        solved, excess = robot.solve(self.p[rows], self.q[rows])
        found = np.ascontiguousarray(np.moveaxis(solved, (2, 1), (0, 1)))
        found[excess.T >= CLOSING] = np.nan
        found[(branch[:, None] >= 0) & (np.arange(robot.branches) != branch[:, None])] = np.nan
        for place, row in enumerate(rows):
            at = joints[row - 1] if row else start
            if not np.isfinite(at).all():
                return
            near = at + robot.wound(found[place] - at)
            both = np.concatenate([near, found[place]])
            far = np.abs(both - at).max(axis=1)
            far[~robot.inside(both)] = np.inf
            best = int(far.argmin())
            if np.isfinite(far[best]):
                joints[row] = both[best]
        joints[rows[~robot.closes(joints[rows], self.p[rows], self.q[rows])]] = np.nan

    def _refusal(self, row: int, joints: Floats) -> Refusal:
        robot, index = self.robot, int(self.of[row])
        if np.isfinite(joints[row]).all():
            low, high = robot.limits.T
            past = np.maximum(low - joints[row], joints[row] - high)
            return Refusal(index, "joints", robot.axes[int(past.argmax())])
        if not self.known[row]:
            return Refusal(index, "nowhere")
        found, valid = robot.ik(self.p[row : row + 1], self.q[row : row + 1])
        if valid.any():
            return Refusal(index, "configuration")
        near = found[0][np.isfinite(found[0]).all(axis=1)]
        if not len(near):
            return Refusal(index, "reach")
        low, high = robot.limits.T
        past = np.maximum(low - near, near - high).max(axis=1)
        best = near[int(past.argmin())]
        return Refusal(
            index, "joints", robot.axes[int(np.maximum(low - best, best - high).argmax())]
        )

    def tips(self, joints: Floats) -> tuple[Floats, Floats]:
        """(m, 3), (m, 4) of the tools at the ends of the first m rows."""
        count = len(joints)
        p, q = np.empty((count, 3)), np.empty((count, 4))
        for index, mount in enumerate(self.mounts):
            rows = np.flatnonzero((self.mount[:count] == index) & self.known[:count])
            p[rows], q[rows] = from_flange(self.p[rows], self.q[rows], mount.tool, mount.frame)
            rows = np.flatnonzero((self.mount[:count] == index) & ~self.known[:count])
            p[rows], q[rows] = mount.tip(self.robot, joints[rows])
        return p, q

    def tip_at(self, start: Floats) -> tuple[Floats, Floats]:
        """(1, 3), (1, 4) of the first tool where the arm begins."""
        mount: Mount = self.mounts[self.mount[0]]
        return mount.tip(self.robot, start[None])
