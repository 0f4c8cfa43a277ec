"""The arm of a controller: where it stands. The settings of a slot that hold for its moves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.configurations import from_flags, to_flags
from assistant.virtual.melfa import poses
from assistant.virtual.melfa.stops import Failed, Unknown
from assistant.virtual.melfa.values import ORIGIN, Joints, Position, eight

if TYPE_CHECKING:
    from assistant.robots import Robot

OPTIMUM: Final = 10000.0
"""mm/s that `M_NSpd` shows: the controller chooses the speed."""
FULL: Final = 100.0


@dataclass(slots=True)
class Settings:
    """What a slot sets for its moves. override, joint_override, acceleration: percent.

    speed: mm/s. corner: mm of `Cnt`, 0 for none, infinite for a size that the controller takes.
    """

    speed: float = OPTIMUM
    override: float = FULL
    joint_override: float = FULL
    corner: float = 0.0
    acceleration: tuple[float, float] = (FULL, FULL)

    def reset(self) -> None:
        """What `End` sets back; tool and base stay (COSIROP: END)."""
        self.speed, self.override, self.joint_override = OPTIMUM, FULL, FULL
        self.corner, self.acceleration = 0.0, (FULL, FULL)


@dataclass(slots=True)
class Arm:
    """flange: in the robot's own base, None where not known. flags: of the last position.

    joints: degrees, None where not known. tool, base: as set; shown are their positions.
    tool_number, base_number: None where they were set by a position. hands: what each was told, 1
    to open. soft: the kind of `Cmp` that holds, empty for none.
    """

    robot: Robot | None = None
    flange: Pose | None = None
    joints: tuple[float, ...] | None = None
    flags: tuple[int | None, int | None] = (None, None)
    tool: Position = ORIGIN
    base: Position = ORIGIN
    tip: Pose = IDENTITY
    foot: Pose = IDENTITY
    tool_number: int | None = None
    base_number: int | None = None
    servo: bool = True
    hands: dict[int, float] = field(default_factory=dict)
    soft: str = ""

    # ------------------------------------------------------------------------------ reading

    def shown(self) -> Position:
        """P_Curr."""
        if self.flange is None:
            raise Unknown("where the arm stands")
        pose = poses.shown_of(self.flange, self.foot, self.tip)
        like = Position(eight(()), self.flags)
        return poses.position_of(pose, like, self.robot)

    def shown_joints(self) -> Joints:
        """J_Curr."""
        if self.joints is None and self.robot is not None and self.flange is not None:
            self.joints = self._solved()
        if self.joints is None:
            raise Unknown("the joints that the arm stands at")
        return Joints(eight(self.joints))

    def placed(self, shown: Position) -> Pose:
        """The flange for a position as it is shown."""
        pose = poses.pose_of(shown, self.robot)
        return poses.flange_of(pose, self.foot, self.tip)

    # ------------------------------------------------------------------------------- moving

    def at_position(self, flange: Pose, flags: tuple[int | None, int | None]) -> None:
        self.flange, self.flags, self.joints = flange, flags, None

    def at_joints(self, joints: tuple[float, ...]) -> None:
        """Stands at joints; where the flange is then is known with a robot only."""
        self.joints, self.flange, self.flags = joints, None, (None, None)
        if self.robot is None:
            return
        if not any(joints[6:]):  # additional axes that the arm need not have
            joints = joints[:6]
        own = self.robot.own_joints((*joints, *(0.0,) * 6)[: max(6, len(joints))])
        if len(own) != len(self.robot.axes):
            raise Failed(2802, f"{len(joints)} joints for {len(self.robot.axes)} axes")
        position, quaternion = self.robot.fk(np.array([own]))
        self.flange = Pose.of(position[0], quaternion[0])
        one, two = to_flags(self.robot.configuration(np.array([own])))[0].tolist()
        self.flags = (one, two)

    def _solved(self) -> tuple[float, ...]:
        assert self.robot is not None and self.flange is not None
        one, two = self.flags
        if one is None:
            raise Unknown("the arm branch that the arm stands in")
        stated = from_flags(np.array([[one, two or 0]]))
        p, q = np.array([self.flange.position]), np.array([self.flange.quaternion])
        found = self.robot.joints_of(p, q, stated)[0]
        if np.isnan(found).any():
            raise Failed(2602, "the position exceeds the limits")
        six = [0.0] * max(6, len(found))
        for place, value in zip(self.robot.places, found, strict=True):
            six[place] = float(value)
        return tuple(six)
