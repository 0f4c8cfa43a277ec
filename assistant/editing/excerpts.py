"""Excerpts: of a text only those pieces that a change may matter to.

Lines keep their numbers: what is found in an excerpt is found in the text in the same line and
column.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from assistant.base.source_text import SomeLines, SourceText
from assistant.editing.structure import Piece, Structure
from assistant.program.editor_support import LineFacts

MOST_EXCERPT_LINES: Final = 200
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
    """The pieces that lines are in, and the declarations that these need.

    starts: offset of each line. names: whose uses are looked at as well. needed: whose declarations
    are there in any case.
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
    room = MOST_EXCERPT_LINES
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
    """Lines that declare each name: a statement of one line by itself, else its whole piece."""
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
