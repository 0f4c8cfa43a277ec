"""What text of a language does that a program keeps as it is, by what each of its nodes does."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from assistant.base.source_text import words_of
from assistant.program.expressions import Effect, EffectBuilder

Fields = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class NodeEffect:
    """What a node does, without those in it.

    reads, writes, calls, declares: fields of texts, or of nodes of data, that are named there.
    words: of texts whose words may be names. untold: it may do anything.
    """

    reads: Fields = ()
    writes: Fields = ()
    calls: Fields = ()
    declares: Fields = ()
    words: Fields = ()
    moves: bool = False
    jumps: bool = False
    waits: bool = False
    untold: bool = False


class UnknownEffect(Exception):
    """What a node calls is worked out as the program runs: it may do anything."""


Take = Callable[[EffectBuilder, Any], None]
"""Puts into an effect what a node does; raises Untold."""


class Effects:
    """What the nodes of one language do.

    nodes: those in a node or in several. named: the data that a node is, or is a part of, None if
    it is none. rows: of each kind of nodes what they do; others do nothing.
    """

    def __init__(
        self,
        nodes: Callable[[Any], Iterable[Any]],
        named: Callable[[Any], str | None],
        rows: Mapping[type, NodeEffect | Take],
    ) -> None:
        self._nodes, self._named = nodes, named
        self._takes = {
            k: self._take(r) if isinstance(r, NodeEffect) else r for k, r in rows.items()
        }

    def of(self, tree: Any) -> Effect | None:
        """What a node or several do, None if nobody can tell."""
        done = EffectBuilder()
        try:
            for node in self._nodes(tree):
                take = self._takes.get(type(node))
                if take is not None:
                    take(done, node)
        except UnknownEffect:
            return None
        return done.effect()

    def names(self, *values: Any) -> Iterator[str]:
        """What texts, and nodes of data, are called."""
        for value in values:
            if isinstance(value, str):
                yield value
            elif isinstance(value, tuple):
                yield from self.names(*value)
            elif name := self._named(value):
                yield name

    def _take(self, row: NodeEffect) -> Take:
        def take(done: EffectBuilder, node: Any) -> None:
            if row.untold:
                raise UnknownEffect
            done.reads.update(*(self.names(getattr(node, field)) for field in row.reads))
            done.writes.update(*(self.names(getattr(node, field)) for field in row.writes))
            done.calls.update(*(self.names(getattr(node, field)) for field in row.calls))
            for field in row.declares:
                done.declare(*self.names(getattr(node, field)))
            for field in row.words:
                done.reads.update(words_of(getattr(node, field)))
            done.moves |= row.moves
            done.jumps |= row.jumps
            done.waits |= row.waits

        return take
