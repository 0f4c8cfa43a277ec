"""Robots: the catalogue, kinematics, configurations, and what a program asks of an arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.lazy import offered

if TYPE_CHECKING:
    from assistant.robots.catalogue import get, load, names
    from assistant.robots.configuring import configure, journey
    from assistant.robots.robot import Robot
    from assistant.robots.solved_program import Journey

_LAZY: Final = {
    "Journey": ("assistant.robots.solved_program", "Journey"),
    "Robot": ("assistant.robots.robot", "Robot"),
    "configure": ("assistant.robots.configuring", "configure"),
    "get": ("assistant.robots.catalogue", "get"),
    "journey": ("assistant.robots.configuring", "journey"),
    "load": ("assistant.robots.catalogue", "load"),
    "names": ("assistant.robots.catalogue", "names"),
}
"""Public names and where they stand; many a command speaks of configurations, but of no arm."""

__all__ = ["Journey", "Robot", "configure", "get", "journey", "load", "names"]


__getattr__ = offered(__name__, _LAZY)
