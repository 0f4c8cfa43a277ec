"""Robots: the catalogue, kinematics, configurations, and what a program asks of an arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.lazy import offered

if TYPE_CHECKING:
    from assistant.robots.arms.from_toolbox import from_rtb
    from assistant.robots.catalogue import get, load, names
    from assistant.robots.configuring import configure, solve_program
    from assistant.robots.robot import Robot
    from assistant.robots.solved_program import SolvedProgram

_LAZY: Final = {
    "SolvedProgram": ("assistant.robots.solved_program", "SolvedProgram"),
    "Robot": ("assistant.robots.robot", "Robot"),
    "configure": ("assistant.robots.configuring", "configure"),
    "from_rtb": ("assistant.robots.arms.from_toolbox", "from_rtb"),
    "get": ("assistant.robots.catalogue", "get"),
    "solve_program": ("assistant.robots.configuring", "solve_program"),
    "journey": ("assistant.robots.configuring", "solve_program"),  # as it was called
    "load": ("assistant.robots.catalogue", "load"),
    "names": ("assistant.robots.catalogue", "names"),
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
