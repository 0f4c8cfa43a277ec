"""Limits of an arm during servoing: speeds, accelerations, a region."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.controllers.cyclic.trajectory import braked
from assistant.controllers.setpoint_streams import Arm
from assistant.program.geometry import IDENTITY, Pose, Vector
from assistant.robots import Robot
from assistant.vision import rules
from assistant.vision.servoing.interaction import flange_of, jacobian

_POSTURES: Final = 256
"""Number of random postures of an arm at which the full speed of its tool is computed."""
_SHARES: Final = (0.8, 0.6, 0.4, 0.2, 0.1)
"""Parts of a change that are tried one after the other where all of it leads out of the box."""
_RESERVE: Final = 0.95
"""Requested share of the tool's speed limit: during a step an arm reaches postures in which the
same speeds of its axes give a higher tool speed.
"""
_ROUNDING: Final = 0.02
"""Degrees or mm by which a reported position of an axis at its end may exceed the limit."""
_PLACES: Final = (0.25, 0.5, 0.75, 1.0)
"""On the way to a stop, at which it is looked whether the tip is in the box."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """speed: mm/s, turning: degrees/s of the tool. part: of the full speed of each axis, 0 to 1.
    to_speed: seconds in which an axis comes to that part. margin: degrees or mm that axes keep from
    their ends. box: least and greatest x, y, z of the tip in the base, None for anywhere.
    Raises Refused for what cannot be.
    """

    speed: float = 100.0
    turning: float = 45.0
    part: float = 0.25
    to_speed: float = 0.3
    margin: float = 1.0
    box: tuple[Vector, Vector] | None = None

    def __post_init__(self) -> None:
        ranges = {
            "speed": (0.1, 2000.0),
            "turning": (0.1, 720.0),
            "part": (0.001, 1.0),
            "to_speed": (0.05, 10.0),
            "margin": (0.0, 90.0),
        }
        for name, (least, most) in ranges.items():
            value = getattr(self, name)
            if not least <= value <= most:
                reason = f"it is a number from {least:g} to {most:g}"
                finding = rules.BAD_SETTING(name=name, value=value, reason=reason)
                raise Refused(finding, exit_status=2)
        if self.box is not None and not (np.array(self.box[0]) < np.array(self.box[1])).all():
            reason = "its least corner is not below its greatest in x, y and z"
            raise Refused(
                rules.BAD_SETTING(name="box", value=self.box, reason=reason), exit_status=2
            )


class Guard:
    """The bounds for an arm with a tip on its flange. speeds, rises: (a,) a second (squared)."""

    def __init__(self, robot: Robot, bounds: Bounds, tip: Pose = IDENTITY) -> None:
        self.robot, self.bounds, self.tip = robot, bounds, tip
        self.speeds = bounds.part * robot.speeds
        self.rises = self.speeds / bounds.to_speed
        if robot.accelerations is not None:
            self.rises = np.minimum(self.rises, robot.accelerations)
        self._low, self._high = (robot.limits + bounds.margin * np.array([1.0, -1.0])).T
        self.barred = ""
        """Limit that held the last motion back, "" for none."""

    def slowed(self, speeds: Floats) -> Guard:
        """The same for axes that must not go faster than speeds (a,)."""
        slower = Guard(self.robot, self.bounds, self.tip)
        slower.speeds = np.minimum(self.speeds, speeds)
        return slower

    def arm(self) -> Arm:
        """Return the data that a carrier requires."""
        return Arm(
            controller=self.robot.controller,
            axes=self.robot.axes,
            sliding=tuple(bool(slides) for slides in self.robot.sliding),
            limits=self.robot.limits,
            full=self.robot.speeds,
            speeds=self.speeds,
            rises=self.rises,
            share=self._share(),
            pose_of=lambda joints: flange_of(self.robot, joints) @ self.tip,
            joints_of=self._joints_of,
        )

    def outside(self, joints: Floats) -> str:
        """Return the limit that joints (a,) exceed, in words; "" if all are kept."""
        low, high = self.robot.limits.T
        for i, axis in enumerate(self.robot.axes):
            if not low[i] - _ROUNDING <= joints[i] <= high[i] + _ROUNDING:
                return f"{axis} is at {joints[i]:.2f}"
        if not self._in_box(joints):
            x, y, z = self._tip(joints)
            return f"the tip is at ({x:.1f}, {y:.1f}, {z:.1f}) mm, outside of the box"
        return ""

    def at_end(self, joints: Floats, velocity: Floats) -> Truths:
        """(a,) which axes would be driven on where they have come to their ends."""
        low, high = joints <= self._low + 1e-3, joints >= self._high - 1e-3
        return np.asarray((low & (velocity < 0.0)) | (high & (velocity > 0.0)))

    def limited(self, wanted: Floats, before: Floats, joints: Floats, seconds: float) -> Floats:
        """(a,) the velocity that is allowed for so many seconds from joints (a,) on.

        wanted: the velocity that would be best. before: that of the step before.
        """
        self.barred = ""
        velocity = wanted * min(1.0, _RESERVE * self._scale(wanted, joints))
        velocity = self._risen(velocity, before, seconds)
        room = np.where(velocity > 0.0, self._high - joints, joints - self._low).tolist()
        each = zip(room, self.rises.tolist(), strict=True)
        brake = np.array([braked(way, rise, seconds) for way, rise in each])
        held = np.abs(velocity) > brake + 1e-12
        if held.any():
            self.barred = f"the end of {self.robot.axes[int(np.argmax(held))]}"
            velocity = np.clip(velocity, -brake, brake)
        velocity = self._boxed(velocity, before, joints, seconds)
        middle = joints + velocity * seconds / 2.0
        return np.asarray(velocity * min(1.0, self._scale(velocity, middle)))

    def _scale(self, velocity: Floats, joints: Floats) -> float:
        """Return the factor by which a velocity may be multiplied within the limits of axes and
        tool.
        """
        most = [float((self.speeds / np.maximum(np.abs(velocity), 1e-12)).min())]
        twist = jacobian(self.robot, joints) @ velocity
        arm = self._tip(joints) - np.array(flange_of(self.robot, joints).position)
        tip = float(np.linalg.norm(twist[:3] + np.cross(twist[3:], arm)))
        turn = float(np.degrees(np.linalg.norm(twist[3:])))
        most.append(self.bounds.speed / max(tip, 1e-12))
        most.append(self.bounds.turning / max(turn, 1e-12))
        return min(most)

    def _risen(self, velocity: Floats, before: Floats, seconds: float) -> Floats:
        """Return the velocity nearest to the wanted one that the accelerations allow."""
        change = velocity - before
        part = float((self.rises * seconds / np.maximum(np.abs(change), 1e-12)).min())
        return np.asarray(before + min(1.0, part) * change)

    def _boxed(self, velocity: Floats, before: Floats, joints: Floats, seconds: float) -> Floats:
        """Return the largest part of the velocity that leaves enough room to brake within the box,
        else the velocity of braking: the step before ensured that braking stays within it.
        """
        if self.bounds.box is None or self._stops_within(velocity, joints, seconds):
            return velocity
        self.barred = "the box of the tool"
        part = float((self.rises * seconds / np.maximum(np.abs(before), 1e-12)).min())
        braking = before * max(0.0, 1.0 - part)
        for share in _SHARES:
            mixed = braking + share * (velocity - braking)
            if self._stops_within(mixed, joints, seconds):
                return np.asarray(mixed)
        return braking

    def _stops_within(self, velocity: Floats, joints: Floats, seconds: float) -> bool:
        """True if the tip stays in the box for a step, and while it brakes after that."""
        part = float((self.rises * seconds / np.maximum(np.abs(velocity), 1e-12)).min())
        n = np.floor(1.0 / part)
        whole = (n + 1.0 - part * n * (n + 1.0) / 2.0) * seconds * velocity
        return all(self._in_box(joints + place * whole) for place in _PLACES)

    def _in_box(self, joints: Floats) -> bool:
        if self.bounds.box is None:
            return True
        low, high = map(np.array, self.bounds.box)
        tip = self._tip(joints)
        return bool((tip >= low - 1e-6).all() and (tip <= high + 1e-6).all())

    def _tip(self, joints: Floats) -> Floats:
        return np.array((flange_of(self.robot, joints) @ self.tip).position)

    def _share(self) -> float:
        """Return the share of the full speed at which no motion of all axes exceeds the limits of
        speed and turning.

        It uses the sum over the axes at the worst of many postures.
        """
        chance = np.random.default_rng(0)
        low, high = self.robot.limits.T
        fastest = turning = 0.0
        for joints in chance.uniform(low, high, (_POSTURES, len(low))):
            slopes = jacobian(self.robot, joints) * self.robot.speeds
            arm = self._tip(joints) - np.array(flange_of(self.robot, joints).position)
            ways = slopes[:3] + np.cross(slopes[3:].T, arm).T
            fastest = max(fastest, float(np.linalg.norm(ways, axis=0).sum()))
            turning = max(turning, float(np.degrees(np.linalg.norm(slopes[3:], axis=0)).sum()))
        return min(1.0, self.bounds.speed / fastest, self.bounds.turning / max(turning, 1e-9))

    def _joints_of(self, pose: Pose, near: Floats) -> Floats | None:
        flange = pose @ self.tip.inverse()
        quaternion = rotations.canonical(np.array([flange.quaternion]))
        found, valid = self.robot.ik(np.array([flange.position]), quaternion)
        if not valid.any():
            return None
        solutions = found[0][valid[0]]
        turns = np.where(self.robot.sliding, 0.0, 360.0 * np.round((near - solutions) / 360.0))
        near_by = solutions + turns
        near_by = np.where(self.robot.inside(near_by)[:, None], near_by, solutions)
        return np.asarray(near_by[int(np.argmin(np.abs(near_by - near).max(axis=1)))])
