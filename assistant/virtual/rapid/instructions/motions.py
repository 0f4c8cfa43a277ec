"""Motions, what is set for them, and displacements of targets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from assistant.program.geometry import IDENTITY
from assistant.virtual.rapid import motion
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.poses import pose_of


def _and_set(move: Callable[[Given], None], value: int) -> Callable[[Given], None]:
    """A motion that sets a signal in its corner; value: which argument the signal's value is."""

    def does(given: Given) -> None:
        move(given)
        given.machine.signals.set(given.signal(value - 1), given.number(value))

    return does


def _velocity(given: Given) -> None:
    given.machine.arm.override, given.machine.arm.most = given.number(0), given.number(1)


def _displace(given: Given) -> None:
    given.machine.arm.displacement = pose_of(given.record(0, "pose"))


def _displace_no_more(given: Given) -> None:
    given.machine.arm.displacement = IDENTITY


def _stop(given: Given) -> None:
    """The robot goes on to the very target of the motion before, and stops there."""
    motion.stop(given.machine)


def _nothing(given: Given) -> None:
    """What changes how the arm moves, and not where, or only what a person sees."""


ANY: Final = "on off wrist lockaxis4 finepointramp tunevalue"

TABLE: Final[Mapping[str, Function]] = dict(
    (
        takes("MoveJ", 4, motion.joint, motion.OPTIONS),
        takes("MoveL", 4, motion.linear, motion.OPTIONS),
        takes("MoveC", 5, motion.circular, motion.OPTIONS),
        takes("MoveAbsJ", 4, motion.absolute, motion.OPTIONS),
        takes("MoveJDO", 6, _and_set(motion.joint, 5), motion.OPTIONS),
        takes("MoveLDO", 6, _and_set(motion.linear, 5), motion.OPTIONS),
        takes("MoveCDO", 7, _and_set(motion.circular, 6), motion.OPTIONS),
        takes("VelSet", 2, _velocity),
        takes("PDispSet", 1, _displace),
        takes("PDispOff", 0, _displace_no_more),
        takes("AccSet", 2, _nothing, ANY),
        takes("ConfJ", 0, _nothing, ANY),
        takes("ConfL", 0, _nothing, ANY),
        takes("SingArea", 0, _nothing, ANY),
        takes("MotionSup", 0, _nothing, ANY),
        takes("CornerPathWarning", 1, _nothing),
        takes("GripLoad", 1, _nothing),
        takes("PathAccLim", 2, _nothing, "accmax decelmax"),
        takes("WorldAccLim", 0, _nothing, ANY),
        takes("WaitRob", 0, _stop, "inpos zerospeed"),
        takes("EOffsOff", 0, _nothing),
    )
)
