"""Robots: the catalogue, kinematics, configurations, and what a program asks of an arm."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from assistant.robots.catalogue import get, load, names
    from assistant.robots.configuring import configure, journey
    from assistant.robots.robot import Robot
    from assistant.robots.solved_program import Journey

_LAZY: Final = {
    "Journey": "assistant.robots.solved_program",
    "Robot": "assistant.robots.robot",
    "configure": "assistant.robots.configuring",
    "get": "assistant.robots.catalogue",
    "journey": "assistant.robots.configuring",
    "load": "assistant.robots.catalogue",
    "names": "assistant.robots.catalogue",
}
"""Public names and where they stand; many a command speaks of configurations, but of no arm."""

__all__ = ["Journey", "Robot", "configure", "get", "journey", "load", "names"]


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(importlib.import_module(_LAZY[name]), name)
    return value
