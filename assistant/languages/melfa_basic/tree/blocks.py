"""The blocks of a program: which statements open, part and close them, and where they stand."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from assistant.languages.melfa_basic.tree import syntax as s

Kind = Literal["If", "For", "While", "Select"]

CLOSING: Final[Mapping[str, Kind]] = {
    "Next": "For", "WEnd": "While", "EndIf": "If", "End Select": "Select",
}  # fmt: skip
"""Word → the kind of block that it closes."""
_MIDDLE: Final[Mapping[str, Kind]] = {"Else": "If", "Default": "Select"}
_WORDS: Final = (s.Command, s.If, s.ElseIf, s.For, s.Next, s.Select, s.Case, s.Function)
"""What may be a word of a block, or bound them; most lines are something else."""


def opened(statement: s.Statement | None) -> Kind | None:
    """The kind of block that a statement opens, None for none."""
    match statement:
        case s.If(then=None):
            return "If"
        case s.For():
            return "For"
        case s.Select():
            return "Select"
        case s.Command(keyword="While"):
            return "While"
    return None


def divided(statement: s.Statement | None) -> Kind | None:
    """The kind of block that a statement begins a further part of, None for none."""
    match statement:
        case s.ElseIf():
            return "If"
        case s.Case():
            return "Select"
        case s.Command(keyword=word):
            return _MIDDLE.get(word)
    return None


def closed(statement: s.Statement | None) -> tuple[Kind, ...]:
    """The kinds of the blocks that a statement closes, the inner one first.

    `Next M1,M2` closes two loops.
    """
    match statement:
        case s.Next(variables=variables):
            loops: list[Kind] = ["For"] * max(1, len(variables))
            return tuple(loops)
        case s.Command(keyword=word) if word in CLOSING:
            return (CLOSING[word],)
    return ()


def is_word(statement: s.Statement | None) -> bool:
    """Whether a statement opens, parts or closes a block."""
    return bool(opened(statement) or divided(statement) or closed(statement))


def statement_of(item: object) -> s.Statement | None:
    """The statement of a line, None for what has none."""
    return item.statement if isinstance(item, s.Line) else None


# ------------------------------------------------------------------------------- of a program


@dataclass(slots=True, eq=False)
class Block:
    """A block by the places of its lines.

    parts: of ElseIf, Else, Case and Default. last: of the closing word, None where it is missing.
    depth: blocks that its lines stand in. crossed: where a block around it ends while it is open.
    """

    kind: Kind
    first: int
    around: Block | None
    parts: list[int] = field(default_factory=list)
    last: int | None = None
    depth: int = 1
    crossed: int | None = None

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
    kind: Kind
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


def blocks_of(code: Sequence[object], places: Iterable[int]) -> Blocks:
    """The blocks of the lines at some places."""
    found = Blocks()
    inner: Block | None = None
    for at in places:
        statement = statement_of(code[at])
        if not isinstance(statement, _WORDS):
            found.around[at] = inner
            continue
        if isinstance(statement, s.Function) or statement == s.Command("FEnd"):
            inner = None
        if kind := opened(statement):
            found.around[at] = inner
            inner = Block(kind, at, inner, depth=1 if inner is None else inner.depth + 1)
            found.all.append(inner)
            continue
        if kind := divided(statement):
            if inner is not None and inner.kind == kind:
                inner.parts.append(at)
            else:
                found.wrong.append(_misfit(at, kind, inner))
        for kind in closed(statement):
            if inner is not None and inner.kind == kind:
                inner.last = at
                inner = inner.around
            else:
                found.wrong.append(_misfit(at, kind, inner))
                _close_outer(inner, kind, at)
        found.around[at] = inner
    for block in reversed(found.all):
        if block.last is not None:
            found.words.update(dict.fromkeys(block.words, block))
            found.closing.setdefault(block.last, []).append(block)
    return found


def _misfit(at: int, kind: Kind, inner: Block | None) -> Misfit:
    chain = inner.chain if inner is not None else ()
    return Misfit(at, kind, inner if any(block.kind == kind for block in chain) else None)


def _close_outer(inner: Block | None, kind: Kind, at: int) -> None:
    """Closes the block that a word is meant for, and leaves those inside of it open."""
    chain = list(inner.chain) if inner is not None else []
    meant = next((k for k, block in enumerate(chain) if block.kind == kind), 0)
    for block in chain[:meant]:
        block.crossed = at
    if meant:
        chain[meant].last, chain[meant - 1].around = at, chain[meant].around
