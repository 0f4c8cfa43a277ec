"""A programming-assistant compiler for industrial robots."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.lazy import offered

__version__ = "0.1.0"

if TYPE_CHECKING:
    from assistant import languages, robots
    from assistant.compiler import compile, load, translate

_LAZY: Final = {
    "compile": ("assistant.compiler", "compile"),
    "load": ("assistant.compiler", "load"),
    "translate": ("assistant.compiler", "translate"),
    "languages": ("assistant.languages", None),
    "robots": ("assistant.robots", None),
}
"""Public names, imported when first used so that the command line starts fast."""

__all__ = ["__version__", "compile", "languages", "load", "robots", "translate"]


__getattr__ = offered(__name__, _LAZY)
