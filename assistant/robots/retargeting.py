"""Retarget joint angles and speeds of joint moves from one arm to another.

Joint angles become those that put the flange of the other arm where the flange was. Speeds are
converted between percent and mm/s, as vendors state them differently. The new move is never the
faster one, at no override: the override is a factor of the speed alone on both arms, so a move
that takes as long at the full override does so at any.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats, rows_of
from assistant.base.data_classes import dataclass
from assistant.program.expressions import Name
from assistant.program.geometry import Frame, Tool
from assistant.program.motion import Kind, Speed
from assistant.program.program import Program
from assistant.program.rewriting import Body, map_bodies
from assistant.program.statements import Follow, Motion, MoveCircular, Moving
from assistant.robots.arms.spherical_wrist import Placed
from assistant.robots.motion.run import from_flange
from assistant.robots.program_values import Names
from assistant.robots.robot import IN_LINE, Robot
from assistant.robots.solved_program import Leg, SolvedProgram
from assistant.robots.timing.plan import drive_of

_MOVE_PARTS: Final = 24
"""Parts of a joint move between which its way is taken as straight."""
_LEAST_DIRECT_SHARE: Final = 0.5
"""Share of its way that a move must lead on for its distance to say how long it takes."""
_LEAST_SPEED: Final = 1.0
"""mm/s and degrees/s below which a speed says too little of how long a move takes."""


@dataclass(frozen=True, slots=True)
class SpeedChange:
    """A speed that was changed, of a statement; seconds that the move takes at least.

    by_arms: the mm/s that the arms give, which are more than `after` if a limit was stated.
    """

    statement: Moving
    before: Speed
    after: Speed
    seconds: float
    by_arms: float

    @property
    def limited(self) -> bool:
        return self.by_arms > self.after.tcp


def convert_joint_speeds(
    program: Program,
    solution: SolvedProgram,
    source: SolvedProgram | None,
    *,
    percent: bool,
    most: float = math.inf,
) -> tuple[Program, tuple[SpeedChange, ...]]:
    """A program whose joint moves state percents (`percent`) or mm/s, where their start is known.

    solution: of the program on the arm that will run it. source: of the same statements on the
    arm that it was written for, None if that is not known: then only mm/s become percents.
    A move whose time is not known keeps its speed. most: mm/s that no percent exceeds as mm/s.
    """
    changes: list[SpeedChange] = []
    speeds = {name.lower(): speed for name, speed in program.speeds.items()}
    names = Names(program)
    arm = source.robot if source else None
    procedures = []
    for procedure in program.procedures:
        legs = solution.legs[procedure.name]
        others = (None,) * len(legs) if source is None else source.legs[procedure.name]
        names.enter(procedure)
        made = [
            _JointMoves(leg, other, solution.robot, arm, names, speeds, most)
            .statement(percent, changes)
            for leg, other in zip(legs, others, strict=True)
        ]  # fmt: skip
        changed = [None if n is leg.statement else n for n, leg in zip(made, legs, strict=True)]
        body = _with_speeds(procedure.body, iter(changed)) if any(changed) else procedure.body
        procedures.append(replace(procedure, body=body))
    return replace(program, procedures=tuple(procedures)), tuple(changes)


def _with_speeds(body: Body, moving: Iterator[Moving | None]) -> Body:
    """A body whose motion statements, in order of text, take the speeds of others, if any."""
    return tuple(
        _at_speeds(one, next(moving))
        if isinstance(one, Moving)
        else map_bodies(one, lambda inner: _with_speeds(inner, moving))
        for one in body
    )


def _at_speeds(statement: Moving, other: Moving | None) -> Moving:
    """The statement, with the configurations that it got, at the speeds of the other."""
    if other is None:
        return statement
    if isinstance(statement, Follow) and isinstance(other, Follow):
        path = replace(statement.path, speed=other.path.speed, speeds=other.path.speeds)
        return replace(statement, path=path)
    if isinstance(statement, Follow) or isinstance(other, Follow):
        raise TypeError(statement)
    return replace(statement, motion=other.motion)


@dataclass(frozen=True, slots=True)
class _JointMoves:
    """The joint moves of a leg on the arm that will run them, and on the one they were made for."""

    leg: Leg
    other: Leg | None
    arm: Robot
    source: Robot | None
    names: Names
    speeds: dict[str, Speed]
    most: float

    def statement(self, percent: bool, changes: list[SpeedChange]) -> Moving:
        """The statement of the leg, with its speeds changed; each is taken down."""
        statement = self.leg.statement
        if isinstance(statement, Follow):
            path = statement.path
            rows = np.flatnonzero(path.kinds == Kind.JOINT)
            speed, table = path.speed.copy(), list(path.speeds)
            for row in rows:
                mount = path.tools[path.tool[row]], path.frames[path.frame[row]]
                new = self._speed(int(row), path.speeds[path.speed[row]], mount, percent, changes)
                if new is not None:
                    table += [new] if new not in table else []
                    speed[row] = table.index(new)
            if len(table) == len(path.speeds):
                return statement
            return replace(statement, path=replace(path, speed=speed, speeds=tuple(table)))
        if isinstance(statement, MoveCircular) or getattr(statement, "kind", "joint") != "joint":
            return statement
        motion: Motion = statement.motion
        new = self._speed(0, motion.fixed[0], (motion.tool, motion.frame), percent, changes)
        return statement if new is None else replace(statement, motion=replace(motion, speed=new))

    def _speed(
        self,
        row: int,
        stated: Speed | Name,
        mount: tuple[str, str],
        percent: bool,
        changes: list[SpeedChange],
    ) -> Speed | None:
        """The speed of a row, None for the one that it has."""
        speed = self.speeds.get(stated.name.lower()) if isinstance(stated, Name) else stated
        if speed is None or (speed.joint is None) != percent:
            return None
        ends = _joint_move_ends(self.leg, row)
        if ends is None or (not percent and math.isfinite(speed.tcp)):
            return None
        tool, frame = (self.names.tool(mount[0]), self.names.frame(mount[1]))
        way = _ToolPath.of(*ends, self.arm, tool or Tool(), frame or Frame())
        theirs = None if self.other is None else _joint_move_ends(self.other, row)
        made = (
            self._percent(speed, way, ends, theirs)
            if percent
            else self._physical(speed, way, theirs)
        )
        if made is None:
            return None
        new, seconds = made
        by_arms = new.tcp
        if not percent and by_arms > self.most:
            new = replace(new, tcp=self.most)
        changes.append(SpeedChange(self.leg.statement, speed, new, seconds, by_arms))
        return new

    def _physical(
        self, speed: Speed, way: _ToolPath, theirs: _JointMoveEnds | None
    ) -> tuple[Speed, float] | None:
        """From percent: as slow as the source is, from one stop to the next."""
        if theirs is None or self.source is None or speed.joint is None:
            return None
        seconds = _joint_move_seconds(*theirs, self.source, min(speed.joint, 100.0) / 100.0)
        if seconds <= 0.0:
            return None
        return way.within(speed, seconds)

    def _percent(
        self, speed: Speed, way: _ToolPath, ends: _JointMoveEnds, theirs: _JointMoveEnds | None
    ) -> tuple[Speed, float] | None:
        """From mm/s: rounded down to whole percents, at least one."""
        seconds = max(way.steepest / speed.tcp, way.quickest / speed.rotation)
        if theirs is not None and self.source is not None:
            seconds = _joint_move_seconds(*theirs, self.source, 1.0, seconds)
        if not seconds > 0.0:
            return None
        least = float((np.abs(ends[1] - ends[0]) / self.arm.speeds).max())
        whole = math.floor(min(100.0, max(1.0, 100.0 * least / seconds)) + 1e-9)
        return replace(speed, joint=float(whole)), seconds


_JointMoveEnds = tuple[Floats, Floats]
"""Joints (a,) at the start and at the end of a move."""


def _joint_move_ends(leg: Leg, row: int) -> _JointMoveEnds | None:
    """Return the start and end joints of a row of a leg, None if they are unknown."""
    if row >= len(leg.joints):
        return None
    start = leg.before if row == 0 else leg.joints[row - 1]
    if start is None or not np.isfinite(start).all() or not np.isfinite(leg.joints[row]).all():
        return None
    return start, leg.joints[row]


def _joint_move_seconds(
    start: Floats, end: Floats, robot: Robot, share: float, least: float = 0.0
) -> float:
    """Seconds of a joint move from rest to rest with a share of the axes' speeds, all of them at
    one pace, which grows and shrinks at a steady rate. least: that it takes without that.
    """
    drive = drive_of(robot)
    far = np.abs(end - start)
    if not far.any():
        return least
    with np.errstate(divide="ignore"):
        most = float((share * drive.speeds / far).min())
        rate = float((drive.accelerations / far).min())
    most = min(most, 1.0 / least) if least > 0.0 else most
    if most**2 >= rate:
        return float(2.0 / np.sqrt(rate))
    return float(1.0 / most + most / rate)


@dataclass(frozen=True, slots=True)
class _ToolPath:
    """The way of the tool in a joint move.

    chord, length: mm between its ends, and along it. turn, turned: degrees of the same.
    steepest, quickest: what mm and degrees came to, were all of it like its fastest part.
    """

    chord: float
    length: float
    turn: float
    turned: float
    steepest: float
    quickest: float

    @staticmethod
    def of(start: Floats, end: Floats, robot: Robot, tool: Tool, frame: Frame) -> _ToolPath:
        part = np.linspace(0.0, 1.0, _MOVE_PARTS + 1)[:, None]
        p, q = robot.flange_poses(start + part * (end - start))
        p, q = from_flange(p, q, tool, Frame(held=frame.held))
        steps = np.linalg.norm(np.diff(p, axis=0), axis=1)
        turns = rotations.angle_between(q[:-1], q[1:])
        return _ToolPath(
            float(np.linalg.norm(p[-1] - p[0])),
            float(steps.sum()),
            float(rotations.angle_between(q[0], q[-1])),
            float(np.sum(turns)),
            float(_MOVE_PARTS * steps.max()),
            float(_MOVE_PARTS * np.max(turns)),
        )

    def within(self, speed: Speed, seconds: float) -> tuple[Speed, float] | None:
        """The largest speed at which the move takes so long, and that time; None if none does.

        By the distance of its ends, which is the shorter one, where the way is not much longer;
        else, as in a turn on the spot, by how far the tool is turned there.
        """
        tcp, rotation = self.chord / seconds, self.turn / seconds
        if self.chord >= _LEAST_DIRECT_SHARE * self.length and tcp >= _LEAST_SPEED:
            return replace(speed, tcp=_rounded_down(tcp), joint=None), seconds
        if self.turn >= _LEAST_DIRECT_SHARE * self.turned and rotation >= _LEAST_SPEED:
            most = _rounded_down(max(self.length / seconds, _LEAST_SPEED))
            return replace(speed, tcp=most, rotation=_rounded_down(rotation), joint=None), seconds
        return None


def _rounded_down(value: float) -> float:
    """Rounded down to three digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return round(math.floor(value / digit + 1e-9) * digit, 6)


_OTHER_SIDE: Final = 1e6
"""Cost of another side of shoulder, elbow or wrist: more than any angle."""


def joints_on_other_arm(joints: ArrayLike, source: Robot, arm: Robot) -> Floats:
    """Joints (n, a) of an arm → those (n, b) with which another one's flange is where its was.

    In the nearest branch: where the axis that is the farthest from where the source has it is the
    least away; of arms whose angles cannot be compared, on the same sides of shoulder, elbow and
    wrist, then near home. A row is NaN where the other arm does not reach within its limits.
    """
    given = rows_of(joints, len(source.axes), "joints")
    positions, quaternions = source.flange_poses(given)
    alike = type(source.arm) is type(arm.arm) and arm.arm.named
    alike = alike and not isinstance(arm.arm, Placed)
    home = np.tile(arm.home, (len(given), 1))
    wanted = (_counted_by(arm, source.chained(given)) if alike else home)[:, None]
    found, _ = arm.ik(positions, quaternions)
    found = _with_whole_turns(_in_line(found, wanted, arm), wanted, arm)
    away = np.abs(found - wanted).max(axis=2)
    if source.arm.named and arm.arm.named and not alike:
        n, branches, axes = found.shape
        each = np.nan_to_num(found).reshape(-1, axes)
        shape = arm.arm.shape(arm.chained(each)).reshape(n, branches, -1)
        own = source.arm.shape(source.chained(given))
        away += _OTHER_SIDE * np.count_nonzero(shape != own[:, None], axis=2)
    away = np.where(arm.inside(found), away, np.inf)
    rows, branch = np.arange(len(given)), away.argmin(axis=1)
    out: Floats = found[rows, branch]
    good = np.isfinite(away[rows, branch])
    good[good] = arm.closes(out[good], positions[good], quaternions[good])
    out[~good] = np.nan
    return out


def _counted_by(arm: Robot, values: Floats) -> Floats:
    """Values (n, a) of a chain that two arms have in common → joints of one, which changes them."""
    values[:, ~arm.sliding] = np.degrees(values[:, ~arm.sliding])
    values -= arm.zero
    if arm.coupling:
        values[:, 2] -= arm.coupling * values[:, 1]
    return values


def _in_line(joints: Floats, wanted: Floats, arm: Robot) -> Floats:
    """Axis 4 as wanted where axes 4 and 6 are in line and only their sum counts."""
    if not arm.arm.spherical:
        return joints
    out = joints.copy()
    line = np.abs(joints[..., 4]) < IN_LINE
    fourth = np.clip(np.broadcast_to(wanted[..., 3], line.shape), *arm.limits[3])
    out[..., 5] += np.where(line, joints[..., 3] - fourth, 0.0)
    out[..., 3] = np.where(line, fourth, joints[..., 3])
    return out


def _with_whole_turns(joints: Floats, wanted: Floats, arm: Robot) -> Floats:
    """Joints (n, b, a), each axis so many whole turns on that it is nearest to wanted in limits."""
    low, high = arm.limits.T
    least, most = np.ceil((low - joints) / 360.0), np.floor((high - joints) / 360.0)
    turns = np.where(most >= least, np.clip(np.round((wanted - joints) / 360.0), least, most), 0.0)
    return np.asarray(joints + 360.0 * np.where(arm.sliding, 0.0, turns))
