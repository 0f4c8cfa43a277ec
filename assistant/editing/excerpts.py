"""Structure of a text, and excerpts: only those pieces that a change may matter to.

The structure (routines, and pieces that can be left out without harm) is put together from what a
language says of each line alone, so it is available while a line is damaged. Lines of an excerpt
keep their numbers: a finding in an excerpt is at the same line and column in the text.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.source_text import SomeLines, SourceText
from assistant.program.editor_support import Declaration, LineFacts

Fold = Callable[[str], str]
_MOST_PIECE_LINES: Final = 40
"""Largest number of lines of a piece, unless a block continues."""


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
        if declares or line - self._first + 1 >= _MOST_PIECE_LINES:
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


_MOST_EXCERPT_LINES: Final = 200
"""That are kept for names on them; more are left to the look at the whole program."""


@dataclass(frozen=True, slots=True)
class Excerpt:
    """Some lines of a text, or all.

    whole: the text that it is of. numbers: see `SomeLines`; None for all lines. looked_at: lines of
    the whole whose findings count, from 0. names: in it.
    """

    text: str
    whole: str
    numbers: Sequence[int] | None
    looked_at: frozenset[int]
    names: frozenset[str]

    def source(self, path: str) -> SourceText:
        """It as languages read it."""
        newline = newline_of(self.text)
        if self.numbers is None:
            return SourceText(self.text, path, "utf-8", newline)
        return SomeLines(self.text, path, "utf-8", newline, self.numbers)

    def line_in_whole(self, line: int) -> int:
        """Both from 0."""
        return line if self.numbers is None else self.numbers[line] - 1


def newline_of(text: str) -> str:
    """The line end that new lines of a text get."""
    return "\r\n" if "\r\n" in text or "\n" not in text else "\n"


def excerpt(
    text: str,
    starts: Sequence[int],
    facts: Sequence[LineFacts],
    made_of: Structure,
    changed: Iterable[int],
    names: frozenset[str] = frozenset(),
    needed: frozenset[str] = frozenset(),
) -> Excerpt:
    """Return the pieces that contain some lines, and the declarations that these pieces need.

    starts: offset of each line. names: names whose uses are included as well. needed: names whose
    declarations are always included.
    """
    wanted = set(changed)
    kept = _holding(made_of, wanted)
    if names:
        kept |= _using(facts, made_of, names, kept)
    looked_at = frozenset(
        line
        for index in kept
        for line in range(made_of.pieces[index].first, made_of.pieces[index].last + 1)
    )
    routines = {made_of.pieces[index].routine for index in kept} - {-1}
    routines |= {
        number
        for number, one in enumerate(made_of.routines)
        if any(one.first <= line <= one.head or line == one.last for line in wanted)
    }
    looked_at |= {line for number in routines for line in _frame(made_of, number) if line in wanted}
    kept |= _beside(made_of, kept)
    kept |= _witnesses(facts, made_of, {n for line in wanted for n in facts[line].names}, kept)
    lines = _with_needed(facts, made_of, kept, routines, needed)
    there = frozenset().union(*(facts[line].names for line in lines))
    return Excerpt(*_only(text, starts, sorted(lines)), looked_at | wanted, there)


def _only(text: str, starts: Sequence[int], lines: Sequence[int]) -> tuple[str, str, Sequence[int]]:
    """Some lines, the text that they are of, and their numbers."""
    ends, numbers = [*starts[1:], len(text)], [line + 1 for line in lines]
    if numbers[-1:] != [len(starts)]:
        numbers.append(len(starts))
    return "".join(text[starts[line] : ends[line]] for line in lines), text, numbers


def _holding(made_of: Structure, wanted: set[int]) -> set[int]:
    """The pieces that lines are in."""
    lines, found = sorted(wanted), set()
    for index, piece in enumerate(made_of.pieces):
        at = bisect_left(lines, piece.first)
        if at < len(lines) and lines[at] <= piece.last:
            found.add(index)
    return found


def _using(
    facts: Sequence[LineFacts], made_of: Structure, names: frozenset[str], kept: set[int]
) -> set[int]:
    """Pieces that name something, as long as there are not too many lines of them."""
    found: set[int] = set()
    room = _MOST_EXCERPT_LINES
    for index, piece in enumerate(made_of.pieces):
        if index in kept:
            continue
        if any(not names.isdisjoint(facts[line].names) for line in _lines(piece)):
            room -= piece.last - piece.first + 1
            if room < 0:
                break
            found.add(index)
    return found


def _beside(made_of: Structure, kept: set[int]) -> set[int]:
    """The pieces before and behind, of the same routine: what leads there, and on."""
    near = {index + step for index in kept for step in (-1, 1)}
    pieces = made_of.pieces
    return {
        index
        for index in near - kept
        if 0 <= index < len(pieces)
        and any(
            other in kept and pieces[other].routine == pieces[index].routine
            for other in (index - 1, index + 1)
        )
    }


def _witnesses(
    facts: Sequence[LineFacts], made_of: Structure, names: set[str], kept: set[int]
) -> set[int]:
    """For each name the first other piece that names it: it is used, or has a value, there."""
    found: set[int] = set()
    naming = (line for line, one in enumerate(facts) if not names.isdisjoint(one.names))
    for line in naming if names else ():
        index = made_of.piece_at(line)
        if index is not None and index not in kept and not names.isdisjoint(facts[line].names):
            found.add(index)
            names = names - facts[line].names
            if not names:
                break
    return found


def _lines(piece: Piece) -> range:
    return range(piece.first, piece.last + 1)


def _frame(made_of: Structure, number: int) -> list[int]:
    one = made_of.routines[number]
    return [*range(one.first, one.head + 1), one.last]


def _with_needed(
    facts: Sequence[LineFacts],
    made_of: Structure,
    kept: set[int],
    routines: set[int],
    needed: frozenset[str],
) -> set[int]:
    """Lines of the kept pieces, and of what declares the names on them, and on those again."""
    declaring = _declaring(facts, made_of, kept, routines)
    called = {one.name: number for number, one in enumerate(made_of.routines)}
    framed, outside = _between(made_of, len(facts))
    lines = {line for index in kept for line in _lines(made_of.pieces[index])} | outside
    lines.update(line for number in routines for line in framed[number])
    asked = [needed, *(facts[line].names for line in lines)]
    seen: set[str] = set()
    while asked:
        for name in asked.pop() - seen:
            seen.add(name)
            frame = framed[called[name]] if name in called else ()
            found = [*declaring.get(name, ()), *frame]
            new = [line for line in found if line not in lines]
            lines.update(new)
            asked += [facts[line].names for line in new]
    return lines


def _between(made_of: Structure, count: int) -> tuple[list[list[int]], set[int]]:
    """Lines that are in no piece: of each routine, and outside of all."""
    behind, framed, outside = 0, [list[int]() for _ in made_of.routines], set[int]()
    number = 0
    for first, last in (*((one.first, one.last) for one in made_of.pieces), (count, count)):
        for line in range(behind, first):
            while number < len(framed) and made_of.routines[number].last < line:
                number += 1
            if number < len(framed) and made_of.routines[number].first <= line:
                framed[number].append(line)
            else:
                outside.add(line)
        behind = last + 1
    return framed, outside


def _declaring(
    facts: Sequence[LineFacts], made_of: Structure, kept: set[int], routines: set[int]
) -> dict[str, list[int]]:
    """Return the lines that declare each name: the line alone for a statement of one line, else its
    complete piece.
    """
    found: dict[str, list[int]] = {}
    for index, piece in enumerate(made_of.pieces):
        if index in kept or not piece.declares:
            continue
        if piece.routine >= 0 and piece.routine not in routines:
            continue
        for line in _lines(piece):
            one, before = facts[line], line == piece.first or facts[line - 1].complete
            alone = before and one.complete and not one.opens
            for declared in one.declares:
                if not declared.implied:
                    part = [line] if alone else list(_lines(piece))
                    found.setdefault(made_of.folded(declared.name), []).extend(part)
    return found
