"""Every node of a statement, quickly: the lines of a file are asked many times."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any, Final

_INSIDE: Final[dict[type, tuple[str, ...] | None]] = {}


def inside(kind: type) -> tuple[str, ...] | None:
    """Fields of a node that may hold nodes, the last one first; None for what is no node."""
    if kind not in _INSIDE:
        parts = [f.name for f in fields(kind) if f.name != "span"] if is_dataclass(kind) else None
        _INSIDE[kind] = None if parts is None else tuple(reversed(parts))
    return _INSIDE[kind]


def nodes(root: Any) -> Iterator[Any]:
    """Every node in a node or a tuple of them, itself first, as they stand in the text."""
    pending = [root]
    while pending:
        item = pending.pop()
        kind = type(item)
        if kind is tuple:
            pending.extend(item[::-1])
            continue
        names = _INSIDE[kind] if kind in _INSIDE else inside(kind)
        if names is not None:
            yield item
            pending.extend([getattr(item, name) for name in names])
