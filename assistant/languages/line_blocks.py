"""Blocks and control flow of languages with one statement a line.

Words that open, divide and close blocks give the `Blocks` of some lines; with the targets of jumps
they give the `Graph`: which line can follow which, and what calls what. Lines are known by their
indices.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import field
from typing import Any, Final, Generic, Literal, TypeVar

from assistant.base.data_classes import dataclass
from assistant.program.analysis.dataflow import reachable

Form = Literal["branches", "choice", "loop"]
"""Control flow of a block.

The parts of `branches` are tried one after the other; a `choice` runs one of its parts, and lines
above the first never run; a `loop` is run again.
"""


@dataclass(frozen=True, slots=True)
class BlockWord:
    """Role of a statement in blocks.

    opens: kind of the block that it begins, of a form. parts: kind of the block of which it begins
    a further part. closes: kinds of the blocks that it ends, the inner one first, ANY for a block
    of any kind. certain: its condition always holds. bounds: it begins or ends a routine, and no
    block continues across it.
    """

    opens: str = ""
    form: Form = "branches"
    parts: str = ""
    closes: tuple[str, ...] = ()
    certain: bool = False
    bounds: Literal["", "begins", "ends"] = ""

    @property
    def is_of_block(self) -> bool:
        return bool(self.opens or self.parts or self.closes)


ANY: Final = "any"
NO_WORD: Final = BlockWord()
"""Block word of most statements: they neither open, divide nor close a block."""


@dataclass(slots=True, eq=False)
class Block:
    """A block by the positions of its lines.

    parts: of its middle words. last: of the closing word, None if it is missing. depth: blocks
    around its lines. crossed: position at which a block around it ends while it is open. certain:
    positions of words whose condition always holds.
    """

    kind: str
    form: Form
    first: int
    around: Block | None
    parts: list[int] = field(default_factory=list)
    last: int | None = None
    depth: int = 1
    crossed: int | None = None
    certain: set[int] = field(default_factory=set)

    @property
    def chain(self) -> Iterator[Block]:
        """The block and those around it, the inner one first."""
        block: Block | None = self
        while block is not None:
            yield block
            block = block.around

    @property
    def words(self) -> list[int]:
        """The places of all its words, as far as they are there."""
        return [self.first, *self.parts, *(() if self.last is None else (self.last,))]


@dataclass(frozen=True, slots=True)
class Misfit:
    """A closing or middle word that does not fit.

    kind: of the block that it belongs to. inside: the inner block that is still open there, None
    if no block of that kind is open at all.
    """

    at: int
    kind: str
    inside: Block | None


@dataclass(slots=True)
class Blocks:
    """The blocks of some lines, in the order in which they are opened.

    around: position of a line → the innermost block that contains it; opening and closing words are
    in the block around their own. words: position of a word → its complete block. closing: position
    of a closing word → the blocks that it closes, the innermost first.
    """

    all: list[Block] = field(default_factory=list)
    around: dict[int, Block | None] = field(default_factory=dict)
    wrong: list[Misfit] = field(default_factory=list)
    words: dict[int, Block] = field(default_factory=dict)
    closing: dict[int, list[Block]] = field(default_factory=dict)

    @property
    def sound(self) -> bool:
        return not self.wrong and all(block.last is not None for block in self.all)

    def within(self, at: int) -> list[Block]:
        """Return the blocks around a line, the inner one first; middle words are in their block."""
        own = self.words.get(at)
        inner = own if own is not None and at in own.parts else self.around.get(at)
        return [] if inner is None else list(inner.chain)


def blocks_of(lines: Iterable[tuple[int, BlockWord]]) -> Blocks:
    """Return the blocks of some lines, each given by its position and its block word."""
    found = Blocks()
    inner: Block | None = None
    for at, word in lines:
        if word is NO_WORD:
            found.around[at] = inner
            continue
        # No block goes on across the begin or end of a routine.
        if word.bounds:
            inner = None
        if word.opens:
            found.around[at] = inner
            depth = 1 if inner is None else inner.depth + 1
            inner = Block(word.opens, word.form, at, inner, depth=depth)
            found.all.append(inner)
        if word.parts and inner is not None and inner.kind == word.parts:
            inner.parts.append(at)
        elif word.parts:
            found.wrong.append(_misfit(at, word.parts, inner))
        if word.certain and inner is not None:
            inner.certain.add(at)
        for kind in word.closes:
            if inner is not None and kind in (ANY, inner.kind):
                inner.last = at
                inner = inner.around
            else:
                found.wrong.append(_misfit(at, kind, inner))
                # A missing inner end must not make every later word wrong.
                _close_outer(inner, kind, at)
        if not word.opens:
            found.around[at] = inner
    # From the inside out, so that the innermost block comes first among those that a word closes.
    for block in reversed(found.all):
        if block.last is not None:
            found.words.update(dict.fromkeys(block.words, block))
            found.closing.setdefault(block.last, []).append(block)
    return found


def _misfit(at: int, kind: str, inner: Block | None) -> Misfit:
    chain = inner.chain if inner is not None else ()
    return Misfit(at, kind, inner if any(block.kind == kind for block in chain) else None)


def _close_outer(inner: Block | None, kind: str, at: int) -> None:
    """Closes the block that a word is meant for, and leaves those inside of it open."""
    chain = list(inner.chain) if inner is not None else []
    meant = next((k for k, block in enumerate(chain) if block.kind == kind), 0)
    for block in chain[:meant]:
        block.crossed = at
    if meant:
        # The blocks that stay open go on in what surrounds the closed one.
        chain[meant].last, chain[meant - 1].around = at, chain[meant].around


EXIT: Final = -1
"""The place that a return leads to, and the last line: behind all of the lines."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Exits(Generic[T]):
    """Exits of a statement, apart from its role in blocks.

    jumps, calls: names that it jumps to, and that it calls. handlers: names that interrupts lead
    to, and true if they call it. on: it may continue with the next line. breaks, returns: it may
    leave the innermost block around it, or the procedure.
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
        """Return the exits of a statement that takes either."""
        return Exits(
            self.jumps + other.jumps, self.calls + other.calls, self.handlers + other.handlers,
            self.on or other.on, self.breaks or other.breaks, self.returns or other.returns,
        )  # fmt: skip


ON: Final[Exits[Any]] = Exits()
"""Exits of most statements: to the next line."""


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
        """Return the position that follows a line: at the end of a part, the end of its block."""
        place = following.get(at, EXIT)
        block = blocks.words.get(place)
        # Running into a middle word means that the part is done: control goes on at the end.
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
    """Yield the positions that may follow an opening, middle or closing word."""
    end = block.words[-1]
    sure = at in block.certain
    if at == end and block.form == "loop":  # a word that closes several goes back to any of them
        yield from (closed.first for closed in blocks.closing[at])
    elif at == block.first and block.form == "choice":
        yield from block.parts
        # Without a part for all other values, the choice may run none.
        if block.certain.isdisjoint(block.parts):
            yield end
    else:
        yield on(at)
        if block.form == "loop" and not sure:
            yield on(end)
        elif block.form == "branches" and at != end:  # also behind Else, which is a finding
            yield from [part for part in block.parts if part > at][:1] or ([] if sure else [end])
