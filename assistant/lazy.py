"""Packages that load what they offer when it is first asked for: commands start fast by it."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping
from typing import Any, Final


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


def listed(package: str, names: Mapping[str, tuple[str, str | None]]) -> Callable[[], list[str]]:
    """The `__dir__` of a package: what it offers, loaded or not, and nothing that it only uses."""

    def names_of() -> list[str]:
        own = (name for name in vars(sys.modules[package]) if name.startswith("__"))
        return sorted({*own, *names})

    return names_of


_DRAWING: Final[dict[str, tuple[str, str]]] = {}


def draw_by(names: Mapping[str, tuple[str, str]]) -> None:
    """Who draws what: name of a class or of a method → module and function, loaded when asked."""
    _DRAWING.update(names)


def drawing_of(name: str) -> Callable[..., Any]:
    """The function that draws what has this name in `draw_by`."""
    module, function = _DRAWING[name]
    found: Callable[..., Any] = getattr(importlib.import_module(module), function)
    return found


def pictured(one: object) -> str:
    """Return the HTML that a notebook shows of an object: the `_repr_html_` of its class."""
    html: str = drawing_of(type(one).__name__)(one)
    return html
