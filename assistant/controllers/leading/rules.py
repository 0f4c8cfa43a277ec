"""Findings of what takes steps to an arm."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, warning

NO_JOINTS: Final = error(
    "CN651",
    "the controller says that its tool is at {point}, where the arm has no joints for it",
    "state the tool that the program on the controller has, and the robot that it moves",
)
NO_SLOWER: Final = warning(
    "CN652",
    "the controller goes at {percent:g} % at least, at which tool and axes may be {times} times as "
    "fast as they should",
    "keep out of its reach, state higher speeds, or lead it cycle by cycle (--by mxt, --by egm)",
)
OWN_SPEED: Final = warning(
    "CN653",
    "the program on the controller decides how fast the arm moves, and not this command",
    "write the speed into that program: `exchange module --speed`",
)
