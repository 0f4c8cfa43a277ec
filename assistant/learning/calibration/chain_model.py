"""An arm whose axes may lie anywhere, and where its flange is then.

Between two axes that are not parallel there are the corrections of the four parameters of Denavit
and Hartenberg (1955), between parallel ones those of Hayati (1983), whose turn about y stands in
for the shift along the axis: where axes are parallel to a hair, that shift changes without bound.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.learning.calibration.models import (
    ArmModel,
    EstimatedErrors,
    FlangeSlopes,
    LengthsModel,
    Parameter,
    Unit,
    slopes_of_zeros,
)
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.robots.arms.arm import Chain, ChainPoses, Joint

PARALLEL_SINE: Final = 0.1
"""Sine of the angle between two axes below which they count as parallel."""


def arm_model(robot: Robot, estimate: EstimatedErrors) -> ArmModel:
    """The model of a robot; of an arm without lengths of its own `lengths` are the zeros alone."""
    if estimate == "chain":
        return ChainModel(robot)
    return LengthsModel(robot, lengths=estimate == "lengths")


@dataclass(frozen=True)
class ChainModel:
    """Zeros of all axes, and of the links between them what moves the next axis."""

    robot: Robot

    @cached_property
    def links(self) -> tuple[tuple[Pose, tuple[str, ...]], ...]:
        """Of each link but the last: the frame of its corrections in that of its joint, z along
        the axis and x along the common normal with the next one, and which corrections it has.
        """
        chain = self.robot.arm.whole_chain
        found = chain.along(np.zeros((1, len(chain.joints))))
        origins, axes, frames = found.origins[0], found.axes[0], found.frames[0]
        out = []
        for i in range(len(chain.joints) - 1):
            place, names = _common_normal(origins[i], axes[i], origins[i + 1], axes[i + 1])
            if chain.joints[i].sliding or chain.joints[i + 1].sliding:
                names = ("alpha", "beta") if chain.joints[i + 1].sliding else ("a", "alpha", "beta")
            own = Pose.of(origins[i], rotations.from_matrix(frames[i]))
            out.append((own.inverse() @ place, names))
        return tuple(out)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        robot, found = self.robot, []
        units: dict[str, Unit] = {"a": "mm", "d": "mm", "alpha": "deg", "beta": "deg"}
        for i, axis in enumerate(robot.axes):
            unit: Unit = "mm" if robot.sliding[i] else "deg"
            found.append(Parameter(f"{axis}.zero", unit, float(robot.zero[i])))
        for axis, (_, names) in zip(robot.axes[:-1], self.links, strict=True):
            found += [Parameter(f"{axis}.{name}", units[name]) for name in names]
        return tuple(found)

    def flange(self, joints: Floats, values: Floats) -> tuple[Floats, Floats]:
        found = self._along(joints, values)
        return found.origins[:, -1], found.turns

    def slopes(self, joints: Floats, values: Floats) -> FlangeSlopes:
        found = self._along(joints, values)
        moved: list[Floats] = []
        turned: list[Floats] = []
        degree = np.radians(1.0)

        def slides(along: Floats) -> None:
            moved.append(along)
            turned.append(np.zeros_like(along))

        def turns(about: Floats, through: Floats) -> None:
            moved.append(np.cross(about, found.origins[:, -1] - through) * degree)
            turned.append(about * degree)

        for i, (place, own) in enumerate(self._own(values)):
            frame = found.frames[:, i] @ rotations.to_matrix(np.array(place.quaternion))
            shift = Pose((own.get("a", 0.0), 0.0, own.get("d", 0.0)))
            at = found.frames[:, i] @ np.array((place @ shift).position) + found.origins[:, i]
            tilt = np.radians(own.get("alpha", 0.0))
            y = np.cos(tilt) * frame[:, :, 1] + np.sin(tilt) * frame[:, :, 2]
            for name in own:
                if name in ("a", "d"):
                    slides(frame[:, :, 0 if name == "a" else 2])
                else:
                    turns(frame[:, :, 0] if name == "alpha" else y, at)
        first, second = slopes_of_zeros(found, self.robot.sliding)
        both = np.concatenate([first, np.stack(moved, axis=2)], axis=2)
        spun = np.concatenate([second, np.stack(turned, axis=2)], axis=2)
        return FlangeSlopes(found.origins[:, -1], found.turns, both, spun)

    def chain(self, values: Floats) -> Chain:
        nominal = self.robot.arm.whole_chain
        joints: list[Joint] = [nominal.joints[0]]
        for (place, own), joint in zip(self._own(values), nominal.joints[1:], strict=True):
            bent = place @ _link_correction(**own) @ place.inverse()
            joints.append(replace(joint, pose=bent @ joint.pose))
        return Chain(tuple(joints), nominal.flange)

    def zero(self, values: Floats) -> Floats:
        return np.asarray(self.robot.zero + values[: len(self.robot.axes)])

    def _along(self, joints: Floats, values: Floats) -> ChainPoses:
        robot = replace(self.robot, zero=self.zero(values))
        return self.chain(values).along(robot.chained(joints))

    def _own(self, values: Floats) -> Iterator[tuple[Pose, dict[str, float]]]:
        """Of each link its frame and its corrections."""
        rest = values[len(self.robot.axes) :].tolist()
        for place, names in self.links:
            yield place, dict(zip(names, rest, strict=False))
            rest = rest[len(names) :]


def _link_correction(a: float = 0.0, d: float = 0.0, alpha: float = 0.0, beta: float = 0.0) -> Pose:
    """Tz(d)·Tx(a)·Rx(alpha)·Ry(beta), degrees."""
    turn = rotations.multiply(
        rotations.about((1.0, 0.0, 0.0), alpha), rotations.about((0.0, 1.0, 0.0), beta)
    )
    return Pose.of(np.array([a, 0.0, d]), rotations.canonical(turn))


def _common_normal(
    origin: Floats, axis: Floats, other: Floats, direction: Floats
) -> tuple[Pose, tuple[str, ...]]:
    """The frame at the foot of the common normal of two axes, on the first of them."""
    cross, between = np.cross(axis, direction), other - origin
    sine = float(np.linalg.norm(cross))
    if sine < PARALLEL_SINE:
        along = between - (between @ axis) * axis
        foot, names = origin + (between @ axis) * axis, ("a", "alpha", "beta")
        if np.linalg.norm(along) < 1e-6:
            along = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    else:
        along = cross * (1.0 if between @ cross >= 0.0 else -1.0)
        reach = np.linalg.lstsq(np.column_stack([axis, -direction]), between, rcond=None)[0][0]
        foot, names = origin + reach * axis, ("d", "a", "alpha")
    x = along / np.linalg.norm(along)
    turn = np.column_stack([x, np.cross(axis, x), axis])
    return Pose.of(foot, rotations.from_matrix(turn)), names
