"""The arm that an interrupt, a stop or a skip has stand on its way, and its motion then."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from assistant.virtual.melfa.arm import Arm
    from assistant.virtual.melfa.world import World


def arm_moves(world: World) -> bool:
    """Whether the arm is on its way for this program."""
    mine = world.slot is None or world.slot.controller.owner is world.slot
    return mine and not world.task.kernel.motion.stands()


def pause_arm(world: World, late: bool) -> bool:
    """Has the arm stand; whether it has to go on later. late: at the end of its motion."""
    kernel = world.task.kernel
    if world.paused or not arm_moves(world):
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
    if world.paused or arm_moves(world):
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
    if standing is None:
        return world.arm
    found = replace(world.arm)
    found.at_joints(standing[1])
    return found
