"""The pose that an arm can take and that is nearest to one that it cannot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from assistant.program import rotations
from assistant.program.geometry import Pose

if TYPE_CHECKING:
    from assistant.robots.robot import Robot

Floats = NDArray[np.float64]

SEARCH: Final = (1.0, 60)
"""mm that a turn by one radian counts as, and how many steps are made at most."""
FINISH: Final = (0.03, 20)
"""The same for the last steps: the position comes first, then the orientation."""
STARTS: Final = (4000, 8)
"""Joint angles that are tried as further starts, the same for every pose, and how many are kept."""
STEP: Final = 1e-4
"""degrees of an axis over which the change of a pose is taken."""


def nearest(robot: Robot, wanted: Pose, tip: Pose) -> Pose:
    """The tip's pose in the robot's base, within reach and limits, nearest to the wanted one.

    tip: of the tool on the flange. Damped least squares over the joints, which stay inside their
    limits, from the arm's branches stretched towards the pose and from the best of many others.
    """
    flange = wanted @ tip.inverse()
    p, q = np.array([flange.position]), np.array([flange.quaternion])
    found, _ = robot.solve(p, rotations.canonical(q))
    low, high = robot.limits.T
    starts = np.clip(found[:, :, 0].T, low, high)
    search = _Search(robot, wanted, tip, SEARCH[0])
    starts = np.vstack([starts, np.clip(robot.home, low, high), _near(search)])
    reached = [_refined(search, j, SEARCH[1]) for j in starts]
    last = _Search(robot, wanted, tip, FINISH[0])
    joints = _refined(last, min(reached, key=last.cost), FINISH[1])
    p, q = robot.fk(joints)
    return Pose.of(p[0], q[0]) @ tip


@dataclass(frozen=True, slots=True)
class _Search:
    """lever: mm that a turn by one radian counts as."""

    robot: Robot
    wanted: Pose
    tip: Pose
    lever: float

    def missing(self, joints: Floats) -> Floats:
        """(n, 6) of (n, a) degrees: mm and lever times radians to the wanted pose."""
        p, q = self.robot.fk(joints)
        p = p + rotations.rotate(q, np.array(self.tip.position))
        q = rotations.multiply(q, np.array(self.tip.quaternion))
        turn = rotations.multiply(np.array(self.wanted.quaternion), rotations.conjugate(q))
        turn = np.where(turn[:, :1] < 0.0, -turn, turn)
        sine = np.linalg.norm(turn[:, 1:], axis=1, keepdims=True)
        angle = 2.0 * np.arctan2(sine, turn[:, :1])
        about = turn[:, 1:] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0)
        return np.hstack([np.array(self.wanted.position) - p, self.lever * about])

    def cost(self, joints: Floats) -> float:
        return _cost(self.missing(joints[None])[0])


def _near(search: _Search) -> Floats:
    """(STARTS[1], a) deg of many within the limits that come nearest to the wanted pose."""
    low, high = search.robot.limits.T
    joints = np.random.default_rng(0).uniform(low, high, (STARTS[0], len(low)))
    best = (search.missing(joints) ** 2).sum(axis=1).argsort()[: STARTS[1]]
    return np.asarray(joints[best])


def _cost(missing: Floats) -> float:
    return float(missing @ missing)


def _refined(search: _Search, joints: Floats, rounds: int) -> Floats:
    low, high = search.robot.limits.T
    count, damping = len(joints), 1e-3
    here = search.missing(joints[None])[0]
    for _ in range(rounds):
        moved = joints + STEP * np.eye(count)
        slope = (search.missing(moved) - here).T / STEP
        pull = -slope.T @ here
        free = ~(((joints <= low) & (pull < 0.0)) | ((joints >= high) & (pull > 0.0)))
        if not free.any():
            break
        inner = slope[:, free]
        normal = inner.T @ inner
        step = np.zeros(count)
        step[free] = np.linalg.solve(
            normal + damping * np.diag(np.diag(normal) + 1e-12), pull[free]
        )
        tried = np.clip(joints + step, low, high)
        there = search.missing(tried[None])[0]
        if _cost(there) < _cost(here):
            done = _cost(here) - _cost(there) < 1e-6 * _cost(here)
            joints, here, damping = tried, there, max(damping / 4.0, 1e-9)
            if done:
                break
        elif damping > 1e9:
            break
        else:
            damping *= 8.0
    return joints
