"""Opening a session, and the operation right, which one line at a time holds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.virtual.cr import positions
from assistant.virtual.cr.command import Command, bare
from assistant.virtual.cr.state import TASKMAX, CrSession
from assistant.virtual.cr.store import CrRefusal

if TYPE_CHECKING:
    from assistant.robots import Robot

JOG_SPEEDS: Final = "3,5,A,1E,32,46,64"
"""Percent, hexadecimal."""


def _open_session(session: CrSession, argument: str) -> str:
    state = session.state
    world, joints = axes_there(state.robot)
    return ";".join(
        [
            f"{world:02X}",
            f"{joints:02X}",
            positions.posture_flags(state.robot, state.joints),
            JOG_SPEEDS,
            state.suffix,
            "PRM",
            state.robot.name.upper(),
            state.robot.controller,
            "MELFA",
            f"{state.now():%y-%m-%d}",
            "Ver.VIRTUAL",
            "JPN" if argument.endswith(";JPN") else "ENG",
            "VIRTUAL CONTROLLER",
            "1;1",
            f"{TASKMAX};",
        ]
    )


def axes_there(robot: Robot) -> tuple[int, int]:
    """Bits of X Y Z A B C and of J1 to J6 that the arm has; a SCARA turns about Z only."""
    joints = sum(1 << place for place in robot.places if place < 6)
    world = {"five-axis": 0x1F, "scara": 0x27}.get(robot.arm.kind, 0x3F)
    return world, joints


def _close_session(session: CrSession) -> str:
    session.hang_up()
    return ""


def _take_right(session: CrSession) -> str:
    holder = session.state.right
    if holder not in (None, session) and not holder.silent:
        raise CrRefusal(6020)
    session.state.right = session
    return ""


def _give_right(session: CrSession) -> str:
    if session.state.right is session:
        session.state.right = None
    return ""


SESSION_COMMANDS: Final = {
    "OPEN=": Command(_open_session),
    "CLOSE": Command(bare(_close_session)),
    "CNTLON": Command(bare(_take_right)),
    "CNTLOFF": Command(bare(_give_right)),
}
