"""Every node of a statement, quickly: the lines of a file are asked many times."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

_LEAVES: Final = frozenset((str, int, float, type(None), bool))


_FIELDS: Final[dict[type, tuple[str, ...]]] = {}


def _parts(kind: type) -> tuple[str, ...]:
    if kind not in _FIELDS:
        names: tuple[str, ...] = getattr(kind, "__slots__", ())
        _FIELDS[kind] = tuple(name for name in names if name != "span")
    return _FIELDS[kind]


def nodes(value: Any) -> Iterator[Any]:
    """The node and all nodes in it, in no order."""
    pending = [value]
    while pending:
        item = pending.pop()
        kind = type(item)
        if kind in _LEAVES:
            continue
        if kind is tuple:
            pending.extend(item)
            continue
        yield item
        pending.extend([getattr(item, name) for name in _parts(kind)])
