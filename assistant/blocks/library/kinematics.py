"""Kinematics as blocks: where joints bring the flange, and which joints bring it there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.blocks.diagrams.block import Block, Port
from assistant.blocks.library.arrays import joints_port, pose_parts, pose_port, pose_signal
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.robot import Robot

JACOBIAN_STEP: Final = 1e-4
"""Degrees or mm by which a joint is changed to either side for its column of the Jacobian."""
NEAREST_BRANCH: Final = -1.0
"""A branch input that asks for the branch nearest to the joints of the step before."""


class ForwardKinematics(Block):
    """joints → pose of the tool in the base. tool: in the frame of the flange."""

    def __init__(self, name: str, robot: Robot, tool: Pose = IDENTITY) -> None:
        super().__init__(name, [joints_port(robot)], [pose_port()])
        self.robot, self.tool = robot, tool

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del now
        return [tool_pose(self.robot, self.tool, given[0])]


class InverseKinematics(Block):
    """pose, branch → joints of that branch, whether there are any, all branches, which are valid.

    A branch is its number among those of `Robot.ik`, or `NEAREST`. Without a solution the joints of
    the step before stay, and `valid` is 0; before there were any, those of the arm's home. Axes
    that turn further than once go on from the step before as far as their limits allow.
    """

    def __init__(self, name: str, robot: Robot, tool: Pose = IDENTITY) -> None:
        count = robot.branches
        super().__init__(
            name,
            [pose_port(), Port("branch")],
            [
                joints_port(robot),
                Port("valid"),
                Port("all", count * len(robot.axes)),
                Port("which", count),
            ],
        )
        self.robot, self.flange = robot, tool.inverse()
        self._last = robot.home.copy()

    def begin(self) -> None:
        self._last = self.robot.home.copy()

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del now
        position, turn = pose_parts(given[0])
        flange = Pose.of(position[0], turn[0]) @ self.flange
        found, valid = self.robot.ik([flange.position], [flange.quaternion])
        joints, there = self._near(found[0]), valid[0]
        branch = given[1][0]
        if branch == NEAREST_BRANCH:
            away = np.where(there, np.abs(joints - self._last).max(axis=1), np.inf)
            chosen = int(np.argmin(away)) if there.any() else -1
        else:
            chosen = int(branch) if 0 <= branch < len(there) and there[int(branch)] else -1
        if chosen >= 0:
            self._last = joints[chosen]
        return [self._last, [float(chosen >= 0)], joints.ravel(), there.astype(float)]

    def _near(self, joints: Floats) -> Floats:
        """Joints (b, a) whose axes are turned as near as limits allow to the step before."""
        near = joints.copy()
        for axis in self.robot.winding():
            near[:, axis] += 360.0 * np.round((self._last[axis] - joints[:, axis]) / 360.0)
        return np.where(self.robot.inside(near)[:, None], near, joints)


class Jacobian(Block):
    """joints → 6 a numbers, row by row: mm and degrees of the tool by each joint, in the base.

    Rows: x, y, z, and the turn about x, y, z. By differences to either side; the closed forms give
    thirteen digits, so that nine are left.
    """

    def __init__(self, name: str, robot: Robot, tool: Pose = IDENTITY) -> None:
        super().__init__(name, [joints_port(robot)], [Port("jacobian", 6 * len(robot.axes))])
        self.robot, self.tool = robot, tool

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del now
        return [tool_jacobian(self.robot, given[0], self.tool).ravel()]


class Resolved(Block):
    """Resolved motion rate: joints, speed of the tool (6,) → speeds of the joints (a,).

    Least squares, damped near singularities (Nakamura and Hanafusa 1986). damping: least singular
    value of the Jacobian, in mm and degrees a degree, at which it begins.
    """

    direct: ClassVar[bool] = True

    def __init__(
        self, name: str, robot: Robot, tool: Pose = IDENTITY, *, damping: float = 0.05
    ) -> None:
        speeds = Port("speeds", len(robot.axes), "deg/s")
        super().__init__(name, [joints_port(robot), Port("speed", 6)], [speeds])
        self.robot, self.tool, self.damping = robot, tool, damping

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del now
        matrix = tool_jacobian(self.robot, given[0], self.tool)
        u, s, vt = np.linalg.svd(matrix, full_matrices=False)
        part = np.clip(s[-1] / self.damping, 0.0, 1.0)
        damped = (1.0 - part**2) * self.damping**2
        return [vt.T @ ((s / (s**2 + damped)) * (u.T @ given[1]))]


def tool_pose(robot: Robot, tool: Pose, joints: Floats) -> Floats:
    """(7,) pose of a tool in the base for joints (a,)."""
    p, q = robot.fk(joints)
    place = Pose.of(p[0], q[0]) @ tool
    return pose_signal(place.position, place.quaternion)


def tool_jacobian(robot: Robot, joints: Floats, tool: Pose = IDENTITY) -> Floats:
    """(6, a) mm and degrees of the tool, in the base, a degree (or mm) of each of joints (a,)."""
    count = len(robot.axes)
    change = JACOBIAN_STEP * np.eye(count)
    p, q = robot.fk(np.concatenate([joints + change, joints - change]))
    p = p + rotations.rotate(q, np.array(tool.position))
    moved = (p[:count] - p[count:]) / (2.0 * JACOBIAN_STEP)
    turn = rotations.multiply(q[:count], rotations.conjugate(q[count:]))
    turn[turn[:, 0] < 0.0] *= -1.0
    turned = np.degrees(2.0 * turn[:, 1:]) / (2.0 * JACOBIAN_STEP)  # small: the sine is the angle
    return np.concatenate([moved.T, turned.T])
