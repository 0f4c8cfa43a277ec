"""Blocks of a language of one statement a line, by the words that open, part and close them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final, Literal

Form = Literal["branches", "choice", "loop"]
"""How control goes through a block. The parts of `branches` are tried one after the other; a
`choice` goes to one of its parts, and lines above the first never run; a `loop` is run again.
"""


@dataclass(frozen=True, slots=True)
class BlockWord:
    """What a statement is to blocks.

    opens: kind of the block that it begins, of a form. parts: kind of the block that it begins a
    further part of. closes: kinds of the blocks that it ends, the inner one first, ANY for one of
    whichever kind. certain: what it asks for always holds. bounds: it begins or ends a routine,
    and no block goes on across it.
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
"""What most statements are."""


@dataclass(slots=True, eq=False)
class Block:
    """A block by the places of its lines.

    parts: of its middle words. last: of the closing word, None where it is missing.
    depth: blocks that its lines stand in. crossed: where a block around it ends while it is open.
    certain: places of words that ask for what always holds.
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

    around: place of a line → the innermost block that it stands in; opening and closing words
    stand in what is around their block. words: place of a word → the whole block that it is of.
    closing: place of a closing word → the blocks that it closes, the innermost first.
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
        """The blocks around a line, the inner one first; middle words stand in their own."""
        own = self.words.get(at)
        inner = own if own is not None and at in own.parts else self.around.get(at)
        return [] if inner is None else list(inner.chain)


def blocks_of(lines: Iterable[tuple[int, BlockWord]]) -> Blocks:
    """The blocks of some lines, each a place and what stands there."""
    found = Blocks()
    inner: Block | None = None
    for at, word in lines:
        if word is NO_WORD:
            found.around[at] = inner
            continue
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
                _close_outer(inner, kind, at)
        if not word.opens:
            found.around[at] = inner
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
        chain[meant].last, chain[meant - 1].around = at, chain[meant].around
