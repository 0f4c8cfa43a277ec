"""Error models of an arm: its correctable parameters, and the pose of its flange with corrections.

`LengthsModel` corrects what a robot file states of an arm in closed form: lengths and zeros of the
axes. `_ChainModel` lets axes lie anywhere: between two axes that are not parallel there are the
corrections of the four parameters of Denavit and Hartenberg (1955), between parallel ones those of
Hayati (1983), whose rotation about y replaces the shift along the axis: where axes are nearly
parallel, that shift is unbounded.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Final, Literal, Protocol

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.robots.arms import Arm, FiveAxis, Scara, SixAxis
from assistant.robots.arms.arm import Chain, ChainPoses, Joint
from assistant.robots.robot_file import LENGTH_NAMES

Unit = Literal["mm", "deg"]
EstimatedErrors = Literal["zeros", "lengths", "chain"]


@dataclass(frozen=True, slots=True)
class Parameter:
    """Parameter of an arm. name: its name in reports. unit: of its corrections. nominal: its value
    in the robot file, 0 if the file does not state it.
    """

    name: str
    unit: Unit
    nominal: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class FlangeSlopes:
    """Positions (n, 3) and rotations (n, 3, 3) of the flange, and their change by each parameter, a
    mm or degree: moved (n, 3, k) mm, turned (n, 3, k) radians about the axes of the base.
    """

    positions: Floats
    rotations: Floats
    moved: Floats
    turned: Floats


class ArmModel(Protocol):
    """Model of an arm with k parameters, all of them 0 for the arm of the robot file."""

    @property
    def robot(self) -> Robot: ...

    @property
    def parameters(self) -> tuple[Parameter, ...]: ...

    def flange(self, joints: Floats, values: Floats) -> tuple[Floats, Floats]:
        """Joints (n, a) and corrections (k,) → positions (n, 3), rotations (n, 3, 3)."""
        ...

    def slopes(self, joints: Floats, values: Floats) -> FlangeSlopes:
        """The same with the change by each correction."""
        ...

    def chain(self, values: Floats) -> Chain:
        """The corrected arm as joints, zeros aside."""
        ...

    def zero(self, values: Floats) -> Floats:
        """(a,) corrected zeros of the axes."""
        ...


def rotation_vectors(turns: Floats) -> Floats:
    """(n, 3, 3) small rotations → (n, 3) radians about the axes."""
    return np.asarray(rotations.turns((1.0, 0.0, 0.0, 0.0), rotations.from_matrix(turns)))


def _slopes_of_zeros(found: ChainPoses, sliding: Truths) -> tuple[Floats, Floats]:
    """Change of the flange by the zero of each axis: (n, 3, a) mm and (n, 3, a) radians."""
    axes, lever = found.axes, found.origins[:, -1:] - found.origins[:, :-1]
    degree = np.where(sliding, 0.0, np.radians(1.0))[:, None]
    moved = np.where(sliding[:, None], axes, np.cross(axes, lever) * degree)
    return moved.transpose(0, 2, 1), (axes * degree).transpose(0, 2, 1)


@dataclass(frozen=True)
class LengthsModel:
    """Zeros of all axes, and with `lengths` those of an arm in closed form."""

    robot: Robot
    lengths: bool = True

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the lengths that are parameters."""
        arm = self.robot.arm
        if not self.lengths or not isinstance(arm, SixAxis | FiveAxis | Scara):
            return ()
        fixed = ("a1", "a3") if isinstance(arm, FiveAxis) else ()
        return tuple(name for name in LENGTH_NAMES[arm.kind] if name not in fixed)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        robot = self.robot
        has = robot.arm if isinstance(robot.arm, Scara) else getattr(robot.arm, "lengths", None)
        zeros = (
            Parameter(f"{axis}.zero", "mm" if slides else "deg", float(zero))
            for axis, slides, zero in zip(robot.axes, robot.sliding, robot.zero, strict=True)
        )
        lengths = (Parameter(name, "mm", float(getattr(has, name))) for name in self.names)
        return (*zeros, *lengths)

    def flange(self, joints: Floats, values: Floats) -> tuple[Floats, Floats]:
        p, q = replace(self.robot, arm=self.arm(values), zero=self.zero(values)).fk(joints)
        return p, rotations.to_matrix(q)

    def slopes(self, joints: Floats, values: Floats) -> FlangeSlopes:
        n, k, count = len(joints), len(self.parameters), len(self.robot.axes)
        moved, turned = np.zeros((n, 3, k)), np.zeros((n, 3, k))
        robot = replace(self.robot, zero=self.zero(values))
        found = self.chain(values).along(robot.chained(joints))
        moved[:, :, :count], turned[:, :, :count] = _slopes_of_zeros(found, self.robot.sliding)
        p = found.origins[:, -1]
        for i in range(count, k):  # the flange shifts as much as a length grows, and does not turn
            longer = values.copy()
            longer[i] += 1.0
            moved[:, :, i] = self.flange(joints, longer)[0] - p
        return FlangeSlopes(p, found.turns, moved, turned)

    def chain(self, values: Floats) -> Chain:
        return self.arm(values).whole_chain

    def zero(self, values: Floats) -> Floats:
        return np.asarray(self.robot.zero + values[: len(self.robot.axes)])

    def arm(self, values: Floats) -> Arm:
        """With its corrected lengths."""
        arm, count = self.robot.arm, len(self.robot.axes)
        more = dict(zip(self.names, values[count:].tolist(), strict=True))
        if not more:
            return arm
        if isinstance(arm, Scara):
            return replace(arm, **{name: getattr(arm, name) + by for name, by in more.items()})
        assert isinstance(arm, SixAxis | FiveAxis)
        changed = {name: getattr(arm.lengths, name) + by for name, by in more.items()}
        return replace(arm, lengths=replace(arm.lengths, **changed))


_PARALLEL_SINE: Final = 0.1
"""Sine of the angle between two axes below which they count as parallel."""


def arm_model(robot: Robot, estimate: EstimatedErrors) -> ArmModel:
    """Return the model of a robot; `lengths` has only the zeros for an arm without separate
    lengths.
    """
    if estimate == "chain":
        return _ChainModel(robot)
    return LengthsModel(robot, lengths=estimate == "lengths")


@dataclass(frozen=True)
class _ChainModel:
    """Zeros of all axes, and of the links between them what moves the next axis."""

    robot: Robot

    @cached_property
    def links(self) -> tuple[tuple[Pose, tuple[str, ...]], ...]:
        """Return for each link but the last the frame of its corrections in that of its joint, z
        along the axis and x along the common normal with the next one, and the names of its
        corrections.
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
        first, second = _slopes_of_zeros(found, self.robot.sliding)
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
        """Yield the frame and the corrections of each link."""
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
    if sine < _PARALLEL_SINE:
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
