"""A programming-assistant compiler for industrial robots."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, Final

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


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'assistant' has no attribute {name!r}")
    module, attribute = _LAZY[name]
    found = importlib.import_module(module)
    value = getattr(found, attribute) if attribute else found
    globals()[name] = value
    return value
