"""Moving the arm by hand: jogging, aligning the hand, the safe position.

Parameters set how fast a controller jogs and how far it inches; no manual at hand gives their
values. Here they are 250 mm/s and a tenth of the joints' speed at an override of 100 %.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.virtual.cr.store import CrRefusal
from assistant.virtual.events import How, Moved
from assistant.virtual.kernel import Ending, Kernel, Task
from assistant.virtual.kernel.timed_arm import CrArm
from assistant.virtual.melfa.arm_state import Arm
from assistant.virtual.melfa.values import Failed

_GRACE: Final = 0.14
"""Seconds of real time after which a jog stops that is not asked for again (BFP-A4288, JOG)."""
JOINT, _WORLD, TOOL = 0, 1, 2
_JOINT_PERCENT: Final = 10.0
_LINEAR: Final = 250.0
"""mm/s."""
_TURNING: Final = 45.0
"""Degrees/s."""
_INCHES: Final = {1: (1.0, 0.5), 2: (0.1, 0.05)}
"""High and low inching: mm, degrees."""
FAR: Final = 400
"""Steps that are looked ahead along a line."""
STEP: Final = (5.0, 1.0)
"""mm, and degrees, of such a step."""
NAME: Final = "jog"


class Jogging:
    """Jogging of the arm. arm: that of the interpreter, which gets the new joints. rate: simulated
    seconds for each real one. All of this runs in the thread of the kernel.
    """

    def __init__(self, kernel: Kernel, robot: Robot, motion: CrArm, arm: Arm, rate: float) -> None:
        self._kernel, self._robot = kernel, robot
        self._motion, self._arm, self._rate = motion, arm, rate
        self._task: Task | None = None
        self._asked: tuple[int, ...] = ()
        self._until = 0.0

    @property
    def running(self) -> bool:
        return self._task is not None

    def jog(self, mode: int, negative: int, positive: int, inch: int) -> None:
        """Start the requested jog, or continue it; raises CrRefusal if it is impossible."""
        asked = (mode, negative, positive, inch)
        # The same request again: the jog goes on, and its
        # time begins anew. An inch is never prolonged.
        if self._task is not None and asked == self._asked and inch == 0:
            self._until = self._kernel.now + _GRACE * self._rate
            return
        if negative & positive or mode not in (JOINT, _WORLD, TOOL) or inch not in (0, *_INCHES):
            raise CrRefusal(5410)
        # A new direction begins from rest.
        self.stop()
        signs = [(positive >> i & 1) - (negative >> i & 1) for i in range(8)]
        if not any(signs):
            return
        joints = self._joint_goal(signs, inch) if mode == JOINT else None
        goal = joints if joints is not None else self._line_goal(signs, inch, mode)
        self._asked = asked
        self._begin(self._moved(goal, linear=mode != JOINT))
        # Without another request the jog stops: the line may be cut, or the key released.
        if inch == 0:
            self._until = self._kernel.now + _GRACE * self._rate
            self._kernel.at(self._until, self._look)

    def go_to(self, joints: Floats) -> None:
        """Moves to joints (a,) in degrees, by joints."""
        self.stop()
        self._asked = ()
        self._begin(self._moved(joints, linear=False))

    def align(self) -> None:
        """Turns the hand so that its axes are along those of the base, as near as they are."""
        pose = self._tip()
        matrix = rotations.to_matrix(np.array(pose.quaternion))
        made = np.zeros((3, 3))
        # Three times the largest element that shares no
        # row or column with those taken: the nearest axes.
        for _ in range(3):
            used = np.abs(made)
            taken = np.maximum(used.max(1)[:, None], used.max(0)[None, :])
            free = np.abs(matrix) * (1.0 - taken)
            row, column = np.unravel_index(int(np.argmax(free)), (3, 3))
            made[row, column] = np.sign(matrix[row, column])
            last = int(row), int(column)
        if np.linalg.det(made) < 0.0:  # the axis that was the furthest off points the other way
            made[last] = -made[last]
        goal = Pose.of(np.array(pose.position), rotations.from_matrix(made))
        solved = self._solved([goal])
        if not len(solved):
            raise CrRefusal(2602)
        self.go_to(solved[-1])

    def stop(self) -> None:
        """Stop the arm where it is."""
        task, self._task = self._task, None
        if task is not None and task.ended is None:
            self._motion.cut(task)
            self._kernel.drop(task)
        if task is not None:
            self._arm.at_joints(self._motion.where()[1])

    # ----------------------------------------------------------------------------- its own

    def _begin(self, moved: Moved) -> None:
        def body(task: Task) -> Ending:
            try:
                self._motion.go(task, moved)
            except Failed as failed:
                return Ending("error", str(failed))
            finally:
                if self._task is task:
                    self._task = None
                    self._arm.at_joints(self._motion.where()[1])
            return Ending()

        self._task = self._kernel.task(NAME, body, essential=False)

    def _look(self) -> None:
        """The time for another request is over, or was set anew."""
        if self._task is None:
            return
        # Set anew by another request meanwhile; 1e-6 absorbs rounding of the clock.
        if self._until > self._kernel.now + 1e-6:
            self._kernel.at(self._until, self._look)
        else:
            self.stop()

    def _moved(self, joints: Floats, *, linear: bool) -> Moved:
        p, q = self._robot.flange_poses(joints[None])
        flange = Pose.of(p[0], q[0])
        if linear:
            configuration = tuple(int(v) for v in self._robot.configuration(joints[None])[0])
            how = How(configuration=configuration, rotation=_TURNING)
            return Moved("linear", flange, self._arm.tip, speed=_LINEAR, how=how)
        six = [0.0] * max(6, len(joints))
        for place, value in zip(self._robot.places, joints.tolist(), strict=True):
            six[place] = value
        return Moved("joint", flange, self._arm.tip, joints=tuple(six), percent=_JOINT_PERCENT)

    def _now(self) -> Floats:
        standing = self._motion.where()[1]
        return np.array([standing[place] for place in self._robot.places])

    def _tip(self) -> Pose:
        p, q = self._robot.flange_poses(self._now()[None])
        return Pose.of(p[0], q[0]) @ self._arm.tip

    def _joint_goal(self, signs: list[int], inch: int) -> Floats:
        """To the limits of the axes, or by an inch."""
        made = self._now()
        axes = {place: i for i, place in enumerate(self._robot.places)}
        for place, sign in enumerate(signs):
            if not sign:
                continue
            if place not in axes:
                raise CrRefusal(5410)
            at = axes[place]
            low, high = (float(v) for v in self._robot.limits[at])
            wanted = made[at] + sign * _INCHES[inch][1] if inch else (low if sign < 0 else high)
            made[at] = min(max(wanted, low), high)
        return made

    def _line_goal(self, signs: list[int], inch: int, mode: int) -> Floats:
        """Return the joints as far as the arm can move along the axes, or one inch on; its present
        joints if it cannot move.
        """
        mm, degrees = _INCHES[inch] if inch else STEP
        away = np.array(signs[:3], dtype=np.float64) * mm
        turn = np.array(signs[3:6], dtype=np.float64) * degrees
        start = self._tip()
        # Looked ahead in steps, to find how far the line can be followed.
        poses = [_moved(start, away * k, turn * k, mode) for k in range(1, 2 if inch else FAR + 1)]
        found = self._solved(poses)
        return np.asarray(found[-1]) if len(found) else self._now()

    def _solved(self, tips: list[Pose]) -> Floats:
        """(n, a) joints of the poses of the tip up to the first that cannot be reached."""
        if self._robot.five_axis:
            tips = [_five_axes(tip) for tip in tips]
        flanges = [tip @ self._arm.tip.inverse() for tip in tips]
        stated = self._robot.configuration(self._now()[None])
        found = self._robot.joints_of(
            np.array([f.position for f in flanges]),
            np.array([f.quaternion for f in flanges]),
            np.repeat(stated, len(flanges), axis=0),
        )
        bad = np.isnan(found).any(axis=1)
        # Only up to the first gap: poses behind it may be in reach again.
        return np.asarray(found[: int(np.argmax(bad)) if bad.any() else len(found)])


def _moved(start: Pose, away: Floats, turn: Floats, mode: int) -> Pose:
    """A pose moved along and about the axes of the base, or of itself."""
    angle = float(np.linalg.norm(turn))
    turned = rotations.about(turn / angle if angle else np.array([0.0, 0.0, 1.0]), angle)
    # The axes of the tool turn with it; those of the base do not.
    if mode == TOOL:
        return start @ Pose.of(away, turned)
    quaternion = rotations.multiply(turned, np.array(start.quaternion))
    return Pose.of(np.array(start.position) + away, rotations.canonical(quaternion))


def _five_axes(tip: Pose) -> Pose:
    """Return the pose that an arm of five axes reaches for a pose: it keeps A and B."""
    from assistant.robots.arms import closed_form

    p, q = np.array([tip.position]), np.array([tip.quaternion])
    return Pose.of(p[0], rotations.canonical(closed_form.from_ab(p, closed_form.to_ab(p, q))[0]))
