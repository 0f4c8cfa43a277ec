"""Blocks for moves by controller operation: the arm stops after each move.

A block is busy until then. CircularMov, LinMovJoint, LinMovCart, JointMovJoint and JointMovCart
are those of Kohrt et al., A Robot Manipulator Communications and Control Framework, table IV
("controller operation: stopped, blocking").
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from typing import ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.connections import Connection, Operator
from assistant.blocks.diagrams import Port
from assistant.blocks.library.ports import Connected, controller_pose, controller_pose_port
from assistant.blocks.rules import OUT_OF_LIMITS, TARGET_NOT_FINITE
from assistant.controllers.mitsubishi import arm_moves
from assistant.controllers.mitsubishi.arm_moves import Goal
from assistant.controllers.states import Position
from assistant.robots.robot import Robot

_TARGET_SIZE: Final = 6
"""Joints by number, whichever the arm lacks, or X, Y, Z in mm and A, B, C in degrees."""


class Move(Connected[Operator]):
    """target (and what else leads there), start → busy, moves done, where it stood last.

    While `start` is above 0.5 and no move is under way, it moves to a target that is another one
    than the last that it moved to. Targets that come while it is busy are not waited for: the one
    that is there when it is free again is next. `joints` are those of J1 to J6 when it last stood,
    0 for one that the arm lacks, and NaN before the first move.

    A target is six joints in degrees (`…Joint`), or a pose (`…Cart` and CircularMov): six numbers
    X, Y, Z in mm and A, B, C in degrees, as the controller shows them, where an arm of five axes
    has A and B only; or seven, x, y, z in mm and a unit quaternion w, x, y, z.
    """

    ways: ClassVar[tuple[str, ...]] = ("target",)
    of_joints: ClassVar[bool] = False

    def __init__(
        self,
        name: str,
        connection: Connection[Operator],
        robot: Robot,
        *,
        period: float | None = None,
    ) -> None:
        ports = [
            Port(way, _TARGET_SIZE, "deg") if self.of_joints else controller_pose_port(way)
            for way in self.ways
        ]
        outputs = [Port("busy"), Port("done"), Port("joints", _TARGET_SIZE, "deg")]
        super().__init__(name, connection, [*ports, Port("start")], outputs, period)
        self.robot, self.moves = robot, connection.name

    def begin(self) -> None:
        self._under_way: Future[Position] | None = None
        self._last: Floats | None = None
        self._done, self._stood = 0, np.full(_TARGET_SIZE, np.nan)
        super().begin()

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Raises Refused for a move that the controller refused or did not end."""
        del now, given
        if self._under_way is not None and self.ended(self._under_way):
            joints = self._under_way.result().joints[:_TARGET_SIZE]
            stood = [0.0 if joint is None else joint for joint in joints]
            self._stood = np.array([*stood, *[0.0] * (_TARGET_SIZE - len(stood))])
            self._under_way = None
            self._done += 1
        return [[float(self._under_way is not None)], [float(self._done)], self._stood]

    def take(self, now: float, given: Sequence[Floats]) -> None:
        del now
        wanted = np.concatenate(given[:-1])
        if self._under_way is not None or self.share.busy or not given[-1][0] > 0.5:
            return
        if self._last is not None and np.array_equal(wanted, self._last):
            return
        if not np.isfinite(wanted).all():
            raise Refused(TARGET_NOT_FINITE(block=self.name))
        ways = given[:-1]
        if self.of_joints:
            self._check(wanted)
        else:
            ways = self._six(ways)
        self._last = wanted
        self._under_way = self.share.carry_out(self.statements(ways), self._goal(ways[-1]))

    def statements(self, ways: Sequence[Floats]) -> Sequence[str]:
        """Return the statements to run one after the other. ways: the targets at the inputs."""
        raise NotImplementedError

    def _six(self, ways: Sequence[Floats]) -> Sequence[Floats]:
        """Return poses of six numbers; those of seven need the posture of the arm."""
        if all(len(way) == _TARGET_SIZE for way in ways):
            return ways
        posture = self._posture()
        return [controller_pose(self.name, self.robot, way, posture) for way in ways]

    def _goal(self, target: Floats) -> Goal:
        if self.of_joints:
            return Goal(
                joints={f"J{place + 1}": float(target[place]) for place in self.robot.places}
            )
        return Goal(pose=dict(zip("XYZABC", target.tolist(), strict=True)))

    def _check(self, wanted: Floats) -> None:
        for place, (low, high) in zip(self.robot.places, self.robot.limits, strict=True):
            value = float(wanted[place])
            if not low <= value <= high:
                name = self.robot.name
                told = {"low": low, "high": high, "robot": name, "value": value}
                raise Refused(OUT_OF_LIMITS(block=self.name, axis=place + 1, **told))

    def _posture(self) -> str:
        """Return the present configuration of the arm, as its controller writes it."""
        return self.share.position().text.rpartition("(")[2]


class JointMovJoint(Move):
    """To joints, by the joints."""

    of_joints = True

    def statements(self, ways: Sequence[Floats]) -> Sequence[str]:
        return arm_moves.joints_statement(ways[0])


class JointMovCart(Move):
    """To a pose of six numbers (X, Y, Z, A, B, C) or seven (quaternion), by the joints."""

    def statements(self, ways: Sequence[Floats]) -> Sequence[str]:
        return arm_moves.pose_statement(ways[0], self._posture())


class LinMovJoint(Move):
    """To where joints bring the tool, on a line."""

    of_joints = True

    def statements(self, ways: Sequence[Floats]) -> Sequence[str]:
        return arm_moves.line_to_joints_statement(ways[0])


class LinMovCart(Move):
    """To a pose of six numbers (X, Y, Z, A, B, C) or seven (quaternion), on a line."""

    def statements(self, ways: Sequence[Floats]) -> Sequence[str]:
        return arm_moves.line_to_pose_statement(ways[0], self._posture())


class CircularMov(Move):
    """To a pose, on an arc by way of another one; each as `LinMovCart` takes it."""

    ways = ("via", "target")

    def statements(self, ways: Sequence[Floats]) -> Sequence[str]:
        return arm_moves.arc_statement(ways[0], ways[1], self._posture())
