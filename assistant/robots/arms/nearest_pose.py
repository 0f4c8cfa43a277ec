"""Find the reachable pose that is nearest to one out of reach, by damped least squares.

Many searches over joints inside their limits run side by side, in columns.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose
from assistant.robots.arms.closed_form import from_ab, to_ab

if TYPE_CHECKING:
    from assistant.robots.robot import Robot


Residuals = Callable[[Floats, Rows], Floats]
"""Joints (m, s, a) of s tries for each of m searches, and which ones (m,) → what is missing
(m, s, 6) to what is wanted."""

_DIFFERENCE_STEP: Final = 1e-4
"""degrees of an axis over which the change of a pose is taken."""


def least_squares_joints(
    missing: Residuals, joints: Floats, low: Floats, high: Floats, rounds: int, enough: float = 0.0
) -> tuple[Floats, Floats]:
    """Joints (k, a), each nearer to what is wanted, step by step, and their costs (k,).

    low, high: (k, a) limits that they stay inside. enough: cost from which on one is done.
    """
    joints = joints.copy()
    k, count = joints.shape
    own = np.arange(count)
    here = _residuals_at(missing, joints, np.arange(k))
    damping, active = np.full(k, 1e-3), np.arange(k)[_cost(here) > enough]
    for _ in range(rounds):
        if not len(active):
            break
        j, r, l, h = joints[active], here[active], low[active], high[active]  # noqa: E741
        slope = (
            missing(j[:, None] + _DIFFERENCE_STEP * np.eye(count), active) - r[:, None]
        ) / _DIFFERENCE_STEP
        pull = -np.einsum("kai,ki->ka", slope, r)
        fixed = ((j <= l) & (pull < 0.0)) | ((j >= h) & (pull > 0.0))
        slope[fixed] = 0.0
        pull[fixed] = 0.0
        normal = slope @ slope.transpose(0, 2, 1)
        diagonal = normal[:, own, own]
        held = damping[active, None] * (diagonal + 1e-12)
        normal[:, own, own] += np.where(fixed, 1.0, held)
        step = np.linalg.solve(normal, pull[..., None])[..., 0]
        tried = np.clip(j + step, l, h)
        there = _residuals_at(missing, tried, active)
        gain = _cost(r) - _cost(there)
        better = gain > 0.0
        done = better & (gain < 1e-6 * _cost(r)) | (damping[active] > 1e9) | fixed.all(axis=1)
        joints[active] = np.where(better[:, None], tried, j)
        here[active] = np.where(better[:, None], there, r)
        less, more = np.maximum(damping[active] / 4.0, 1e-9), damping[active] * 8.0
        damping[active] = np.where(better, less, more)
        active = active[~done & (_cost(here[active]) > enough)]
    return joints, _cost(here)


def _residuals_at(missing: Residuals, joints: Floats, which: Rows) -> Floats:
    return missing(joints[:, None], which)[:, 0]


def _cost(missing: Floats) -> Floats:
    return np.asarray((missing * missing).sum(axis=-1))


_POSITION_FIRST: Final = ((1.0, 60), (0.03, 20))
"""mm that a turn by one radian counts as, and how many steps are made at most: a first search,
then the last steps, where the position comes first, then the orientation."""
_ORIENTATION_FIRST: Final = ((1e3, 30), (1e5, 30))
"""The same for an orientation that is kept, the position going where that can be taken."""
_ORIENTATION_KEPT: Final = 0.01
"""degrees within which an orientation counts as kept."""
STARTS: Final = (4000, 8)
"""Joint angles that are tried as further starts, the same for every pose, and how many are kept."""
_RINGS: Final = (100, 30)
"""Directions, the same for every pose, and distances in which the wanted orientation is tried."""

_ROUNDING_GRIDS: Final = (0.0, 0.01, 0.05, 0.2)
"""mm around the rounded position in which to search for one that is not just out of reach."""


def nearest_pose_text(robot: Robot, wanted: Pose, tip: Pose, *, keep: bool) -> str:
    """Return the pose of `find_nearest_pose` as text for a message, rounded so that the arm reaches
    it.

    The text has the maker's notation: X Y Z A B C for Mitsubishi (X Y Z A B with five axes), else
    position and quaternion. keep: see `find_nearest_pose`.
    """
    pose = find_nearest_pose(robot, wanted, tip, keep=keep)
    if robot.counts == "quadrants":
        quaternion = np.round(pose.quaternion, 6) + 0.0
        place = _reachable_position(robot, pose, tip, quaternion)
        numbers = ", ".join(f"{value:.2f}" for value in place)
        parts = ", ".join(f"{value:.6f}".rstrip("0").rstrip(".") for value in quaternion)
        return f"[{numbers}] [{parts}] (mm in its base)"
    q = np.array([pose.quaternion])
    angles = to_ab([pose.position], q)[0] if robot.five_axis else rotations.to_euler(q[0])[::-1]
    angles = np.round(angles, 2) + 0.0
    angles[angles == -180.0] = 180.0
    values = [*_reachable_position(robot, pose, tip, angles), *angles]
    numbers = ", ".join(
        f"{name} {value:.2f}" for name, value in zip("XYZABC", values, strict=False)
    )
    return f"{numbers} (mm and degrees in its base)"


def _reachable_position(robot: Robot, pose: Pose, tip: Pose, orientation: Floats) -> Floats:
    """The position (3,) of two decimals, nearest to a pose's, that the arm takes with what is
    written of the orientation: a quaternion, A B C or A B.
    """
    rounded = np.round(pose.position, 2) + 0.0
    if not robot.arm.named:  # without a closed form: too slow to try
        return rounded
    steps = np.array(list(itertools.product((0, -1, 1, -2, 2), repeat=3)))
    for grid in _ROUNDING_GRIDS:
        tried = np.round(rounded + grid * steps[: len(steps) if grid else 1], 2)
        if len(orientation) == 4:
            q = np.tile(orientation / np.linalg.norm(orientation), (len(tried), 1))
        elif len(orientation) == 3:
            q = np.tile(rotations.from_euler(orientation[::-1]), (len(tried), 1))
        else:
            q = from_ab(tried, np.tile(orientation, (len(tried), 1)))
        back = tip.inverse()
        flange = tried + rotations.rotate(q, np.array(back.position))
        _, valid = robot.ik(flange, rotations.multiply(q, np.array(back.quaternion)))
        good = tried[valid.any(axis=1)]
        if len(good):
            off = np.linalg.norm(good - np.array(pose.position), axis=1)
            return np.asarray(good[off.argmin()] + 0.0)
    return rounded


def find_nearest_pose(robot: Robot, wanted: Pose, tip: Pose, *, keep: bool = False) -> Pose:
    """The tip's pose in the robot's base, within reach and limits, nearest to the wanted one.

    tip: of the tool on the flange. keep: the orientation stays where some position allows it,
    for an arm that can take any; else the position comes first. Damped least squares over the
    joints, which stay inside their limits, from the arm's branches stretched towards the pose
    and from the best of many others.
    """
    if keep and len(robot.axes) >= 6:
        pose = _find_nearest_pose(robot, wanted, tip, _ORIENTATION_FIRST)
        turned = rotations.angle_between(np.array(pose.quaternion), np.array(wanted.quaternion))
        if float(turned) < _ORIENTATION_KEPT:
            return Pose(pose.position, wanted.quaternion)
    return _find_nearest_pose(robot, wanted, tip, _POSITION_FIRST)


def _find_nearest_pose(
    robot: Robot, wanted: Pose, tip: Pose, stages: tuple[tuple[float, int], tuple[float, int]]
) -> Pose:
    (lever, rounds), (last_lever, last_rounds) = stages
    flange = wanted @ tip.inverse()
    p, q = np.array([flange.position]), np.array([flange.quaternion])
    found, _ = robot.solve(p, rotations.canonical(q))
    low, high = robot.limits.T
    starts = np.clip(found[:, :, 0].T, low, high)
    search = _Search(robot, wanted, tip, lever)
    starts = np.vstack([starts, np.clip(robot.home, low, high), _near(search)])
    if stages is _ORIENTATION_FIRST and robot.arm.named:
        starts = np.vstack([starts, _around(search)])
    last = _Search(robot, wanted, tip, last_lever)
    joints = last.best(_refined(last, _refined(search, starts, rounds), last_rounds))
    p, q = robot.flange_poses(joints)
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
        p, q = self.robot.flange_poses(joints)
        p = p + rotations.rotate(q, np.array(self.tip.position))
        q = rotations.multiply(q, np.array(self.tip.quaternion))
        about = rotations.turns(q, np.array(self.wanted.quaternion))
        return np.hstack([np.array(self.wanted.position) - p, self.lever * about])

    def best(self, joints: Floats) -> Floats:
        """(1, a) which of some joints (k, a) come nearest."""
        return joints[[_cost(self.missing(joints)).argmin()]]


def _near(search: _Search) -> Floats:
    """(STARTS[1], a) deg of many within the limits that come nearest to the wanted pose."""
    low, high = search.robot.limits.T
    joints = np.random.default_rng(0).uniform(low, high, (STARTS[0], len(low)))
    best = (search.missing(joints) ** 2).sum(axis=1).argsort()[: STARTS[1]]
    return np.asarray(joints[best])


def _around(search: _Search) -> Floats:
    """(k, a) deg of a few poses of the wanted orientation, as near as some directions show."""
    robot, tip = search.robot, search.tip.inverse()
    ways = np.random.default_rng(0).normal(size=(_RINGS[0], 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    away = np.geomspace(0.5, 2.0 * robot.reach, _RINGS[1])
    tried = (away[:, None, None] * ways).reshape(-1, 3) + np.array(search.wanted.position)
    q = np.tile(rotations.multiply(search.wanted.quaternion, tip.quaternion), (len(tried), 1))
    flange = tried + rotations.rotate(search.wanted.quaternion, tip.position)
    joints, valid = robot.ik(flange, q)
    some = np.flatnonzero(valid.any(axis=1))[: STARTS[1]]
    return np.asarray(joints[some, valid[some].argmax(axis=1)])


def _refined(search: _Search, joints: Floats, rounds: int) -> Floats:
    """Each of some joints (k, a) nearer to the wanted pose, step by step, side by side."""
    low, high = (np.broadcast_to(limit, joints.shape) for limit in search.robot.limits.T)

    def missing(tried: Floats, _: Rows) -> Floats:
        return search.missing(tried.reshape(-1, joints.shape[1])).reshape(*tried.shape[:2], -1)

    return least_squares_joints(missing, joints, low, high, rounds)[0]
