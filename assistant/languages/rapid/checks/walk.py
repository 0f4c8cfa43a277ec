"""The nodes of a tree, one after the other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any, Final

from assistant.languages.rapid import syntax as s


def nodes(root: Any) -> Iterator[Any]:
    """Every node of a tree (or of a tuple of trees), as they stand in the text."""
    pending = [root]
    while pending:
        item = pending.pop()
        if isinstance(item, tuple):
            pending.extend(reversed(item))
        elif isinstance(item, s.Node):
            yield item
            pending.extend([getattr(item, name) for name in _inside(type(item))])


_FIELDS: Final[dict[type, tuple[str, ...]]] = {}


def _inside(kind: type[s.Node]) -> tuple[str, ...]:
    """Fields that may hold nodes, the last one first."""
    if kind not in _FIELDS:
        _FIELDS[kind] = tuple(f.name for f in reversed(fields(kind)) if f.name != "span")
    return _FIELDS[kind]
