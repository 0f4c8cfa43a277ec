"""The ways through the lines of a program: which can follow which, and what calls what."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Generic, TypeVar

from assistant.languages.line_blocks import Block, Blocks
from assistant.program.analysis.dataflow import reachable

EXIT: Final = -1
"""The place that a return leads to, and the last line: behind all of the lines."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Exits(Generic[T]):
    """Where a statement leads, whatever block it is a word of.

    jumps, calls: what it names to go to, and to call. handlers: what interrupts lead to, and
    whether they call it. on: it may run on to the next line. breaks, returns: it may leave the
    innermost block around it, or the procedure.
    """

    jumps: tuple[T, ...] = ()
    calls: tuple[T, ...] = ()
    handlers: tuple[tuple[T, bool], ...] = ()
    on: bool = True
    breaks: bool = False
    returns: bool = False

    @property
    def targets(self) -> tuple[T, ...]:
        """All that it names."""
        return (*self.jumps, *self.calls, *(target for target, _ in self.handlers))

    def __or__(self, other: Exits[T]) -> Exits[T]:
        """Of a statement that does either."""
        return Exits(
            self.jumps + other.jumps, self.calls + other.calls, self.handlers + other.handlers,
            self.on or other.on, self.breaks or other.breaks, self.returns or other.returns,
        )  # fmt: skip


ON: Final[Exits[Any]] = Exits()
"""Of most statements: to the next line."""


@dataclass(slots=True)
class Graph:
    """The ways through some lines, all by their places.

    after: places that may follow a line. calls: those of the procedures that it calls. handlers:
    of a line that interrupts lead to the line that says so, and whether it is called. jumps: what
    a line jumps to, not by running on.
    """

    after: dict[int, list[int]] = field(default_factory=dict)
    calls: dict[int, list[int]] = field(default_factory=dict)
    handlers: dict[int, tuple[int, bool]] = field(default_factory=dict)
    jumps: dict[int, list[int]] = field(default_factory=dict)

    @property
    def called(self) -> set[int]:
        """Places of lines that are called as procedures."""
        return {place for places in self.calls.values() for place in places}

    def reached(self, starts: Iterable[int], *, through_calls: bool = False) -> set[int]:
        """Places that can be come to from some, themselves included."""
        calls = self.calls if through_calls else {}
        return reachable(starts, lambda at: (*self.after[at], *calls.get(at, ()))) - {EXIT}

    def entered(self, start: int, doors: set[int]) -> tuple[dict[int, int], set[int]]:
        """Doors that control runs into from a start, each with the place that leads there, and all
        places that it comes to without going through one.
        """
        into: dict[int, int] = {}
        found: set[int] = set()
        left = [(start, start)]
        while left:
            at, before = left.pop()
            if at in doors and at != start:
                into.setdefault(at, before)
            elif at not in found:
                found.add(at)
                left += [(place, at) for place in self.after[at] if place != EXIT]
        return into, found


def graph_of(
    places: Sequence[int],
    blocks: Blocks,
    exits: Callable[[int], Exits[T]],
    find: Callable[[T], int | None],
) -> Graph:
    """The ways through the lines at some places, which follow each other in that order.

    exits: of the line at a place. find: the place of what a line names, None if it is not there.
    """
    graph = Graph()
    following = dict(itertools.pairwise(places))

    def on(at: int) -> int:
        """Where control runs on behind a line: at the end of a part, to the end of its block."""
        place = following.get(at, EXIT)
        block = blocks.words.get(place)
        return place if block is None or place not in block.parts else block.words[-1]

    def found(targets: Iterable[T]) -> list[int]:
        return [place for place in map(find, targets) if place is not None]

    def after(at: int) -> Iterator[int]:
        """The places that may follow a line."""
        if (block := blocks.words.get(at)) is not None:
            yield from _behind_word(at, block, blocks, on)
            return
        leads = exits(at)
        if leads is ON:
            yield on(at)
            return
        if jumps := found(leads.jumps):
            graph.jumps[at] = jumps
        if calls := found(leads.calls):
            graph.calls[at] = calls
        for target, called in leads.handlers:
            for place in found([target]):
                graph.handlers.setdefault(place, (at, called))
        yield from jumps
        inner = blocks.around.get(at)
        if leads.breaks and inner is not None and inner.last is not None:
            yield on(inner.last)
        if leads.returns:
            yield EXIT
        if leads.on:
            yield on(at)

    for at in places:
        graph.after[at] = list(dict.fromkeys(after(at)))
    graph.after[EXIT] = []
    return graph


def _behind_word(at: int, block: Block, blocks: Blocks, on: Callable[[int], int]) -> Iterator[int]:
    """What follows an opening, middle or closing word."""
    end = block.words[-1]
    sure = at in block.certain
    if at == end and block.form == "loop":  # a word that closes several goes back to any of them
        yield from (closed.first for closed in blocks.closing[at])
    elif at == block.first and block.form == "choice":
        yield from block.parts
        if block.certain.isdisjoint(block.parts):
            yield end
    else:
        yield on(at)
        if block.form == "loop" and not sure:
            yield on(end)
        elif block.form == "branches" and at != end:  # also behind Else, which is a finding
            yield from [part for part in block.parts if part > at][:1] or ([] if sure else [end])
