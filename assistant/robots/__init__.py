"""Robots: the catalogue, kinematics, configurations, and what a program asks of an arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.lazy import offered

if TYPE_CHECKING:
    from assistant.robots.arms.toolbox import from_rtb
    from assistant.robots.program_solution import configure, solve_program
    from assistant.robots.robot import Robot
    from assistant.robots.robot_file import get, load, names
    from assistant.robots.solved_program import SolvedProgram

_LAZY: Final = {
    "SolvedProgram": ("assistant.robots.solved_program", "SolvedProgram"),
    "Robot": ("assistant.robots.robot", "Robot"),
    "configure": ("assistant.robots.program_solution", "configure"),
    "from_rtb": ("assistant.robots.arms.toolbox", "from_rtb"),
    "get": ("assistant.robots.robot_file", "get"),
    "solve_program": ("assistant.robots.program_solution", "solve_program"),
    "journey": ("assistant.robots.program_solution", "solve_program"),  # as it was called
    "load": ("assistant.robots.robot_file", "load"),
    "names": ("assistant.robots.robot_file", "names"),
}
"""Public names and where they stand; many a command speaks of configurations, but of no arm."""

__all__ = [
    "Robot",
    "SolvedProgram",
    "configure",
    "from_rtb",
    "get",
    "load",
    "names",
    "solve_program",
]


__getattr__ = offered(__name__, _LAZY)
