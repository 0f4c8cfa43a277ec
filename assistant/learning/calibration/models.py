"""What of an arm may be a little off, and where its flange is with it.

`LengthsModel` has what a robot file says of an arm in closed form: its lengths and the zeros of its
axes; `chain_model` has axes that lie anywhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, Protocol

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths
from assistant.robots import Robot
from assistant.robots.arms import Arm, FiveAxis, Scara, SixAxis
from assistant.robots.arms.arm import Chain, ChainPoses
from assistant.robots.robot_file import LENGTH_NAMES

Unit = Literal["mm", "deg"]
EstimatedErrors = Literal["zeros", "lengths", "chain"]


@dataclass(frozen=True, slots=True)
class Parameter:
    """name: as it is told. unit: of its corrections. nominal: what the robot file says, 0 of what
    it does not say.
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
    """An arm with k parameters, all of them 0 for the arm as its file says it."""

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


def slopes_of_zeros(found: ChainPoses, sliding: Truths) -> tuple[Floats, Floats]:
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
        """Of the lengths that are parameters."""
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
        moved[:, :, :count], turned[:, :, :count] = slopes_of_zeros(found, self.robot.sliding)
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
