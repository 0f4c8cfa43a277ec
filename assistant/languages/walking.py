"""Every node of a typed tree, quickly: the lines of a file are asked many times."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from assistant.program.rewriting import record_fields


class Walk:
    """Goes through trees of one language.

    is_node: whether a type is one of its nodes. held: the type of those that keep in their `known`
    what is inside them, None for no type.
    """

    def __init__(self, is_node: Callable[[type], bool], held: type | None = None) -> None:
        self._is_node = is_node
        self._held = held
        self._inside: dict[type, tuple[str, ...] | None] = {}

    def inside(self, kind: type) -> tuple[str, ...] | None:
        """Fields of a node that may hold nodes, the last one first; None for what is no node."""
        if kind not in self._inside:
            found = None
            if self._is_node(kind):
                parts = record_fields(kind)
                said = () if parts is None else reversed(parts.names)
                found = tuple(name for name in said if name != "span")
            self._inside[kind] = found
        return self._inside[kind]

    def nodes(self, root: Any) -> Iterator[Any]:
        """Every node in a node or a tuple of them, itself first, as they stand in the text."""
        known, held = self._inside, self._held
        pending = [root]
        while pending:
            item = pending.pop()
            kind = type(item)
            if kind is tuple:
                pending.extend(item[::-1])
                continue
            if kind is held:
                yield item
                if not item.known:
                    parts = reversed(self.inside(kind) or ())
                    item.known.extend(self.nodes(tuple(getattr(item, part) for part in parts)))
                yield from item.known
                continue
            names = known[kind] if kind in known else self.inside(kind)
            if names is not None:
                yield item
                pending.extend([getattr(item, name) for name in names])
