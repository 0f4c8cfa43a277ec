"""Findings of what takes steps to an arm."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import error

NO_JOINTS: Final = error(
    "CN651",
    "the controller says that its tool is at {point}, where the arm has no joints for it",
    "state the tool that the program on the controller has, and the robot that it moves",
)
