"""Commands that switch and set what programs run with: servos, override, stops, tools."""

from __future__ import annotations

from typing import Final

from assistant.virtual.cr.command import Command, bare, whole
from assistant.virtual.cr.state import CrSession

TOOLS: Final = 16


def _servo(*, on: bool) -> Command:
    def handler(session: CrSession) -> str:
        session.state.switch_servo(on)
        return ""

    return Command(bare(handler), right=True)


def _flag(name: str, *, on: bool) -> Command:
    """A switch of the controller."""

    def handler(session: CrSession) -> str:
        setattr(session.state, name, on)
        return ""

    return Command(bare(handler))


def _override(session: CrSession) -> str:
    return str(session.state.override)


def _set_override(session: CrSession, argument: str) -> str:
    session.state.override = whole(argument, 1, 100)
    return argument


def _set_tool(session: CrSession, argument: str) -> str:
    session.state.tool = whole(argument.removeprefix("="), 0, TOOLS)
    return ""


def _tool(session: CrSession) -> str:
    return str(session.state.tool)


def _slow(session: CrSession, argument: str) -> str:
    session.state.slow = bool(whole(argument, 0, 1))
    return ""


def _may_start(session: CrSession) -> str:
    """0 if a program can be started."""
    state = session.state
    can = state.may_start and not state.stop_on and state.alarm is None
    return str(int(not can))


COMMANDS: Final = {
    "SRVON": _servo(on=True),
    "SRVOFF": _servo(on=False),
    "OVRD=": Command(_set_override, right=True),
    "OVRD": Command(bare(_override)),
    "STOPON": _flag("stop_on", on=True),
    "STOPOFF": _flag("stop_on", on=False),
    "MLOCKON": _flag("machine_lock", on=True),
    "MLOCKOFF": _flag("machine_lock", on=False),
    "LSON": Command(bare(lambda _: "")),
    "LSOFF": Command(bare(lambda _: "")),
    "AUEON": _flag("may_start", on=True),
    "AUEOFF": _flag("may_start", on=False),
    "ATENA": Command(bare(_may_start)),
    "TOOLSET": Command(_set_tool),
    "TOOLRD": Command(bare(_tool)),
    "SAFE=": Command(_slow),
}
