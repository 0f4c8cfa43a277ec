"""The arm of a CR controller: where it is, its tool and base, and a motion that is paused.

Positions of MELFA-BASIC become poses and back: R = Rz(C)·Ry(B)·Rx(A); a position is shown as Base ·
flange · Tool. An interrupt, a stop or a skip pauses the arm on its way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field, replace
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.configurations import from_flags, to_flags
from assistant.virtual.melfa.values import (
    ORIGIN,
    Elements,
    Failed,
    Joints,
    Position,
    Unknown,
    eight,
)

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.virtual.events import Moved
    from assistant.virtual.melfa.world import World


Both = TypeVar("Both", Position, Joints)

_SIX: Final = 6
"""Elements of a pose; the additional axes follow them."""


def pose_of(value: Position, robot: Robot | None = None) -> Pose:
    """The pose of a position; raises Failed where an element of it is not defined.

    robot: of five axes, whose A and B are counted otherwise (see robots.arms.closed_form).
    """
    six = value.values[:6]
    if robot is not None and robot.five_axis:
        from assistant.robots.arms import closed_form

        x, y, z, a, b = _all_numbers(six[:5])
        made = closed_form.from_ab(np.array([[x, y, z]]), np.array([[a, b]]))[0]
        return Pose.of(np.array([x, y, z]), rotations.canonical(made))
    x, y, z, a, b, c = _all_numbers(six)
    return Pose.of(np.array([x, y, z]), rotations.from_euler((c, b, a), "ZYX"))


def position_of(pose: Pose, like: Position | None = None, robot: Robot | None = None) -> Position:
    """A pose as a position with the flags and additional axes of another one."""
    if robot is not None and robot.five_axis:
        from assistant.robots.arms import closed_form

        p, q = np.array([pose.position]), np.array([pose.quaternion])
        angles = (*(float(v) for v in closed_form.to_ab(p, q)[0]), 0.0)
    else:
        found = rotations.to_euler(np.array(pose.quaternion), "ZYX")
        angles = (float(found[2]), float(found[1]), float(found[0]))
    more = like.values[6:] if like is not None else (None, None)
    flags = like.flags if like is not None else (None, None)
    return Position((*pose.position, *angles, *more), flags)


def _all_numbers(values: Elements) -> tuple[float, ...]:
    found = tuple(v for v in values if v is not None)
    if len(found) < len(values):
        raise Failed(2800, "a position with elements that are not defined")
    return found


# ------------------------------------------------------------------------------ arithmetic


def composed(left: Position, right: Position, robot: Robot | None) -> Position:
    """`P1*P2`: the second one in the frame of the first, with its flags."""
    return position_of(_plain_numbers(left, robot) @ _plain_numbers(right, robot), left)


def divided(left: Position, right: Position, robot: Robot | None) -> Position:
    """`P1/P2`: the first one times the inverse of the second."""
    return position_of(_plain_numbers(left, robot) @ _plain_numbers(right, robot).inverse(), left)


def divided_from_left(left: Position, right: Position, robot: Robot | None) -> Position:
    """The first one seen from the second."""
    return position_of(_plain_numbers(right, robot).inverse() @ _plain_numbers(left, robot), left)


def inverse(value: Position, robot: Robot | None) -> Position:
    return position_of(_plain_numbers(value, robot).inverse(), value)


def elementwise(left: Both, right: Both, combine: Callable[[float, float], float]) -> Both:
    """`P1+P2`, `J1-J2`: element by element, with the flags of the left one."""
    values = tuple(
        _element_pair(at, a, b, combine)
        for at, (a, b) in enumerate(zip(left.values, right.values, strict=True))
    )
    return replace(left, values=values)


def scaled(value: Both, factor: float) -> Both:
    """`P1*2`, `J1/3`: every element."""
    return replace(value, values=tuple(None if v is None else v * factor for v in value.values))


def _element_pair(
    at: int, a: float | None, b: float | None, combine: Callable[[float, float], float]
) -> float | None:
    if a is not None and b is not None:
        return combine(a, b)
    if at < _SIX:
        if a is None and b is None:
            return None
        raise Unknown("a sum with an element that is not defined")
    # An additional axis that one side does not have counts as 0.
    return a if b is None else combine(0.0, b)


def _plain_numbers(value: Position, robot: Robot | None) -> Pose:
    """A pose that is calculated with, of an arm of six axes."""
    if robot is not None and robot.five_axis:
        raise Unknown("products of positions of an arm of five axes")
    return pose_of(value)


def same_place(left: Pose | None, right: Pose, tolerance: float = 0.01) -> bool:
    """True if two poses are at one position, within mm."""
    if left is None:
        return False
    return bool(np.linalg.norm(np.subtract(left.position, right.position)) <= tolerance)


def _flange_of(shown: Pose, base: Pose, tool: Pose) -> Pose:
    """Return the flange in the robot base: shown = base · flange · tool."""
    return base.inverse() @ shown @ tool.inverse()


def _shown_of(flange: Pose, base: Pose, tool: Pose) -> Pose:
    return base @ flange @ tool


OPTIMUM: Final = 10000.0
"""mm/s that `M_NSpd` shows: the controller chooses the speed."""
FULL: Final = 100.0


@dataclass(slots=True)
class Settings:
    """Settings of a slot for its moves. override, joint_override, acceleration: percent.

    speed: mm/s. corner: mm of `Cnt`, 0 for none, infinite for a size that the controller chooses.
    """

    speed: float = OPTIMUM
    override: float = FULL
    joint_override: float = FULL
    corner: float = 0.0
    acceleration: tuple[float, float] = (FULL, FULL)

    def reset(self) -> None:
        """Reset the settings that `End` resets; tool and base stay (COSIROP: END)."""
        self.speed, self.override, self.joint_override = OPTIMUM, FULL, FULL
        self.corner, self.acceleration = 0.0, (FULL, FULL)


@dataclass(slots=True)
class Arm:
    """State of the arm. flange: in the robot base, None if unknown. flags: those of the last
    position.

    joints: degrees, None if unknown. corner: as of the position that it was sent to. tool, base: as
    set; shown are their positions. tool_number, base_number: None if a position set them. hands:
    latest command of each, 1 to open. soft: the active kind of `Cmp`, empty for none.
    """

    robot: Robot | None = None
    flange: Pose | None = None
    joints: tuple[float, ...] | None = None
    flags: tuple[int | None, int | None] = (None, None)
    corner: Moved | None = None
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
        pose = _shown_of(self.flange, self.foot, self.tip)
        like = Position(eight(()), self.flags)
        return position_of(pose, like, self.robot)

    def shown_joints(self) -> Joints:
        """J_Curr."""
        if self.joints is None and self.robot is not None and self.flange is not None:
            self.joints = self._solved()
        if self.joints is None:
            raise Unknown("the joints that the arm stands at")
        return Joints(eight(self.joints))

    def placed(self, shown: Position) -> Pose:
        """The flange for a position as it is shown."""
        pose = pose_of(shown, self.robot)
        return _flange_of(pose, self.foot, self.tip)

    # ------------------------------------------------------------------------------- moving

    def at_position(self, flange: Pose, flags: tuple[int | None, int | None]) -> None:
        # The joints are solved on demand.
        self.flange, self.flags, self.joints, self.corner = flange, flags, None, None

    def at_joints(self, joints: tuple[float, ...]) -> None:
        """Stands at joints; where the flange is then is known with a robot only."""
        self.joints, self.flange, self.flags, self.corner = joints, None, (None, None), None
        if self.robot is None:
            return
        if not any(joints[6:]):  # additional axes that the arm need not have
            joints = joints[:6]
        own = self.robot.own_joints((*joints, *(0.0,) * 6)[: max(6, len(joints))])
        if len(own) != len(self.robot.axes):
            raise Failed(2802, f"{len(joints)} joints for {len(self.robot.axes)} axes")
        position, quaternion = self.robot.flange_poses(np.array([own]))
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
            # Axes in the places where positions count them; others stay 0.
            six[place] = float(value)
        return tuple(six)


def _arm_moves(world: World) -> bool:
    """True if the arm is moving for this program."""
    mine = world.slot is None or world.slot.controller.owner is world.slot
    return mine and not world.task.kernel.motion.stands()


def pause_arm(world: World, late: bool) -> bool:
    """Has the arm stand; whether it has to go on later. late: at the end of its motion."""
    kernel = world.task.kernel
    if world.paused or not _arm_moves(world):
        return False
    if late:
        kernel.motion.settle(world.task)
        return False
    kernel.motion.hold(kernel)
    world.paused = True
    return True


def resume_arm(world: World) -> bool:
    """Lets the arm go on; False if it was moved elsewhere meanwhile."""
    if not world.paused:
        return False
    world.paused = False
    world.task.kernel.motion.resume(world.task.kernel)
    return True


def cut_motion(world: World) -> None:
    """Ends the motion where the arm is."""
    if world.paused or _arm_moves(world):
        world.paused = False
        standing = world.task.kernel.motion.cut(world.task)
        if standing is not None:
            world.arm.at_joints(standing[1])


def before_motion(world: World) -> None:
    """A motion while another one is paused: that one is not made to its end."""
    if world.paused:
        cut_motion(world)


def arm_now(world: World) -> Arm:
    """The arm as it stands or flies at this moment."""
    motion = world.task.kernel.motion
    standing = None if motion.stands() else motion.where()
    # No motion, or one without time: the arm is at its target.
    if standing is None:
        return world.arm
    found = replace(world.arm)
    found.at_joints(standing[1])
    return found


def read_position(world: World) -> Position:
    """P_Curr, which is not sure where motions take no time and the latest may still be in its
    corner.
    """
    shown = arm_now(world).shown()
    kernel = world.task.kernel
    latest = kernel.latest_motion() if kernel.motion.where() is None else None
    return shown if latest is None or latest.blend <= 0.0 else replace(shown, corner=latest)
