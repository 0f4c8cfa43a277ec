"""How a language prints its nodes, as the comparison of an old text with a new tree needs it."""

from __future__ import annotations

import abc
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import Any, Final, NamedTuple

from assistant.languages.texts.alignment import same
from assistant.languages.texts.words import Word

MOST_WORDS: Final = 1 << 14
"""Words of one node that are compared; a longer one that changed is printed as a whole."""


@dataclass(frozen=True, slots=True)
class Block:
    """Children that stand on lines of their own, `depth` steps deeper than what holds them."""

    children: tuple[Any, ...]
    depth: int = 1


Sketch = Sequence["str | Block"]
"""How a language prints a node: lines that end with a line feed, with its blocks between them."""


class Extent(NamedTuple):
    """Offsets in the source."""

    start: int
    end: int


class Layout(abc.ABC):
    """What the text of one vendor language looks like.

    spelled: kinds of words that may be written in several ways. indent: one step of the printer's.
    """

    spelled: frozenset[str]
    indent: str

    @abc.abstractmethod
    def words(self, text: str, start: int, end: int) -> Iterator[Word]:
        """The words between two offsets that have to be those of the tree."""

    @abc.abstractmethod
    def noted(self, gap: str) -> bool:
        """Whether a comment stands between two words."""

    @abc.abstractmethod
    def sketch(self, node: Any) -> Sketch:
        """The canonical text of a node, without outer indentation."""

    @abc.abstractmethod
    def extent(self, text: str, node: Any) -> Extent | None:
        """Where a node of a block stands, without outer blanks; None if it has no place."""

    @abc.abstractmethod
    def line_ends(self, before: Any, after: Any) -> int | None:
        """How many line ends two neighbours of a block want; None for the ends of the block.

        0 if they must share a line, 1 if they must not, 2 if a blank line looks well between
        new ones, None if anything goes.
        """

    def spread(self, text: str, old: Sequence[Any], new: Sequence[Any]) -> Spread | None:  # noqa: ARG002
        """Nodes that stand for many lines as nodes of one line each; None if there are none."""
        return None


@dataclass(frozen=True, slots=True)
class Spread:
    """Two lists for the comparison. extents: of the nodes of `old`."""

    old: Sequence[Any]
    extents: Sequence[Extent]
    new: Sequence[Any]


@dataclass(slots=True)
class Piece:
    """A word or a block. gap: what is printed in front of it. start, end: in the source.

    A block's extent goes from the word before it to the word behind it.
    """

    what: str | Block
    kind: str
    gap: str = ""
    start: int = -1
    end: int = -1
    key: object = None


def pieces_of(layout: Layout, sketch: Sketch) -> list[Piece]:
    pieces = []
    for part in sketch:
        if isinstance(part, Block):
            pieces.append(Piece(part, "block"))
            continue
        at = 0
        for word in layout.words(part, 0, len(part)):
            pieces.append(Piece(word.text, word.kind, part[at : word.start]))
            at = word.end
    return pieces


def same_word(layout: Layout, piece: Piece, word: Word) -> bool:
    """Whether a word of the source may be what the printer writes in another way."""
    if str(piece.what).casefold() == word.text.casefold():
        return True
    return word.kind == piece.kind and piece.kind in layout.spelled


def spelling(piece: Piece) -> str | None:
    return piece.what if isinstance(piece.what, str) else None


def equal_sketches(a: Sketch, b: Sketch) -> bool:
    if len(a) != len(b):
        return False
    return all(
        x is y or (x == y if isinstance(x, str) else isinstance(y, Block) and _same_block(x, y))
        for x, y in zip(a, b, strict=True)
    )


def _same_block(a: Block, b: Block) -> bool:
    return len(a.children) == len(b.children) and all(map(same, a.children, b.children))


def name_blocks(before: list[Piece], after: list[Piece]) -> None:
    """Gives blocks that belong together the same key, words their own text."""
    for piece in [*before, *after]:
        piece.key = piece.what if isinstance(piece.what, str) else id(piece)
    had, has = ([p for p in pieces if isinstance(p.what, Block)] for pieces in (before, after))
    if len(had) == len(has):
        pairs = list(zip(had, has, strict=True))
    else:
        pairs = []
        for new in has:
            mine = {id(child) for child in new.what.children}  # type: ignore[union-attr]
            for old in had:
                theirs = (id(child) for child in old.what.children)  # type: ignore[union-attr]
                if not mine.isdisjoint(theirs) or new.what == old.what:
                    pairs.append((old, new))
                    had.remove(old)
                    break
    for old, new in pairs:
        new.key = old.key


def differences(
    before: list[Piece], after: list[Piece]
) -> Iterator[tuple[str, int, int, int, int]]:
    """Like difflib's opcodes, equal ends first, which also settles which of alike words stay."""
    most = min(len(before), len(after))
    head = tail = 0
    while head < most and before[head].key == after[head].key:
        head += 1
    while tail < most - head and before[-1 - tail].key == after[-1 - tail].key:
        tail += 1
    a = [p.key for p in before[head : len(before) - tail]]
    b = [p.key for p in after[head : len(after) - tail]]
    yield "equal", 0, head, 0, head
    if len(a) * len(b) > MOST_WORDS * 64:
        yield "replace", head, head + len(a), head, head + len(b)
    else:
        for kind, i1, i2, j1, j2 in SequenceMatcher(None, a, b, autojunk=False).get_opcodes():
            yield kind, head + i1, head + i2, head + j1, head + j2
    yield "equal", head + len(a), len(before), head + len(b), len(after)
