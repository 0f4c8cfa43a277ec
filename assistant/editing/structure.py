"""What a text is made of: routines, and pieces that can be left out of it without harm.

Put together of what a language says of each line by itself, so that it is also there while a line
is damaged.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import dataclass
from typing import Final

from assistant.program.editor_support import Declaration, LineFacts

Fold = Callable[[str], str]
MOST_PIECE_LINES: Final = 40
"""Of a piece, unless a block goes on."""


@dataclass(slots=True)
class Routine:
    """Lines of a routine, from 0; `head` the last one of its head, `last` the one that ends it."""

    first: int
    head: int
    last: int
    name: str = ""


@dataclass(frozen=True, slots=True)
class Piece:
    """Lines that may be left out together. routine: its index, -1 outside of all."""

    first: int
    last: int
    routine: int
    declares: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Structure:
    routines: tuple[Routine, ...]
    pieces: tuple[Piece, ...]
    folded: Fold

    def routine_at(self, line: int) -> Routine | None:
        return next((one for one in self.routines if one.first <= line <= one.last), None)

    def piece_at(self, line: int) -> int | None:
        """The index of the piece that a line is in."""
        at = bisect_right(self.pieces, line, key=lambda piece: piece.first) - 1
        return at if at >= 0 and line <= self.pieces[at].last else None


def structure(
    facts: Sequence[LineFacts], folded: Fold, borders: Set[int] = frozenset()
) -> Structure:
    """Routines and pieces, in their order.

    folded: how names are compared. borders: last lines of pieces as they were known before; a block
    that nothing closes any more ends its piece there, and not with the text.
    """
    return _Building(facts, folded, borders).done()


class _Building:
    def __init__(self, facts: Sequence[LineFacts], folded: Fold, borders: Set[int]) -> None:
        self._facts, self._folded, self._borders = facts, folded, borders
        self._routines: list[Routine] = []
        self._pieces: list[Piece] = []
        self._open: Routine | None = None
        self._first = -1
        self._depth = 0

    def done(self) -> Structure:
        in_head = False
        for line, facts in enumerate(self._facts):
            if in_head and self._open is not None:
                self._open.head = line
                in_head = not facts.complete
            elif facts.begins:
                self._close(line)
                self._end(line - 1)
                named = next((one.name for one in facts.declares), "")
                self._open = Routine(line, line, line, self._folded(named))
                self._routines.append(self._open)
                in_head = not facts.complete
            elif facts.ends and (self._depth <= 0 or facts.opens >= 0):
                self._close(line)
                self._end(line)
            elif facts.stays:
                self._close(line)
            else:
                self._piece(line, facts)
        self._close(len(self._facts))
        self._end(len(self._facts) - 1)
        return Structure(tuple(self._routines), tuple(self._pieces), self._folded)

    def _piece(self, line: int, facts: LineFacts) -> None:
        if self._first < 0:
            self._first = line
        self._depth += facts.opens
        if self._depth > 0 or not facts.complete:
            return
        self._depth = 0
        declares = any(not one.implied for one in facts.declares)
        if declares or line - self._first + 1 >= MOST_PIECE_LINES:
            self._close(line + 1)

    def _close(self, behind: int) -> None:
        """Ends the piece at hand in front of a line."""
        if self._first >= 0:
            inside = range(self._first, behind - 1) if self._depth > 0 else ()
            for last in (*(line for line in inside if line in self._borders), behind - 1):
                self._pieces.append(self._made(self._first, last))
                self._first = last + 1
        self._first, self._depth = -1, 0

    def _made(self, first: int, last: int) -> Piece:
        declared = frozenset(
            self._folded(one.name)
            for facts in self._facts[first : last + 1]
            for one in facts.declares
            if not one.implied
        )
        routine = len(self._routines) - 1 if self._open is not None else -1
        return Piece(first, last, routine, declared)

    def _end(self, last: int) -> None:
        if self._open is not None:
            self._open.last = max(last, self._open.head)
        self._open = None


def declarations(facts: Sequence[LineFacts]) -> Iterator[tuple[int, Declaration]]:
    """Every declaration with its line."""
    for line, one in enumerate(facts):
        for declared in one.declares:
            yield line, declared
