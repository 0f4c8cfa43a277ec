"""Packages that load what they offer when it is first asked for: commands start fast by it."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping
from typing import Any


def offered(package: str, names: Mapping[str, tuple[str, str | None]]) -> Callable[[str], Any]:
    """The `__getattr__` of a package.

    names: public name → module, and its name there, None for the module itself.
    """

    def get(name: str) -> Any:
        if name not in names:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, attribute = names[name]
        found = importlib.import_module(module)
        value = getattr(found, attribute) if attribute else found
        setattr(sys.modules[package], name, value)
        return value

    return get
