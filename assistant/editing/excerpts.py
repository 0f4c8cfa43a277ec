"""Excerpts: a text with only those pieces that a change may matter to, all else left blank.

Every character that stays, stays where it is: what is found in an excerpt is found there in the
text as well.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from assistant.editing.structure import Piece, Structure
from assistant.program.editing import Facts

MOST_LINES: Final = 400
"""That are kept for names on them; more are left to the look at the whole program."""


@dataclass(frozen=True, slots=True)
class Excerpt:
    """text: as long as the whole. looked_at: lines whose findings count, from 0. names: in it."""

    text: str
    looked_at: frozenset[int]
    names: frozenset[str]


def excerpt(
    text: str,
    starts: Sequence[int],
    facts: Sequence[Facts],
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
    kept = {
        index
        for index, piece in enumerate(made_of.pieces)
        if any(piece.first <= line <= piece.last for line in wanted)
    }
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
    kept |= _witnesses(facts, made_of, {n for line in wanted for n in facts[line].names}, kept)
    lines = _with_needed(facts, made_of, kept, routines, needed)
    there = frozenset().union(*(facts[line].names for line in lines))
    return Excerpt(_blanked(text, starts, lines), looked_at | wanted, there)


def _using(
    facts: Sequence[Facts], made_of: Structure, names: frozenset[str], kept: set[int]
) -> set[int]:
    """Pieces that name something, as long as there are not too many lines of them."""
    found: set[int] = set()
    room = MOST_LINES
    for index, piece in enumerate(made_of.pieces):
        if index in kept:
            continue
        if any(not names.isdisjoint(facts[line].names) for line in _lines(piece)):
            room -= piece.last - piece.first + 1
            if room < 0:
                break
            found.add(index)
    return found


def _witnesses(
    facts: Sequence[Facts], made_of: Structure, names: set[str], kept: set[int]
) -> set[int]:
    """For each name the first other piece that names it: it is used, or has a value, there."""
    found: set[int] = set()
    for index, piece in enumerate(made_of.pieces):
        if not names:
            break
        if index in kept:
            continue
        for line in _lines(piece):
            if not names.isdisjoint(facts[line].names):
                found.add(index)
                names = names - facts[line].names
    return found


def _lines(piece: Piece) -> range:
    return range(piece.first, piece.last + 1)


def _frame(made_of: Structure, number: int) -> list[int]:
    one = made_of.routines[number]
    return [*range(one.first, one.head + 1), one.last]


def _with_needed(
    facts: Sequence[Facts],
    made_of: Structure,
    kept: set[int],
    routines: set[int],
    needed: frozenset[str],
) -> set[int]:
    """Lines of the kept pieces, and of what declares the names on them, and on those again."""
    declaring: dict[str, list[int]] = {}
    for index, piece in enumerate(made_of.pieces):
        for name in piece.declares:
            declaring.setdefault(name, []).append(index)
    called = {one.name: number for number, one in enumerate(made_of.routines)}
    inside = {line for piece in made_of.pieces for line in _lines(piece)}
    framed = {line for one in made_of.routines for line in range(one.first, one.last + 1)}
    stays = [line for line in range(len(facts)) if line not in inside and line not in framed]
    lines = set(stays)
    of_routine: dict[int, list[int]] = {}
    for line in framed - inside:
        number = _number_at(made_of, line)
        of_routine.setdefault(number, []).append(line)
    pending = [line for index in kept for line in _lines(made_of.pieces[index])]
    pending += [line for number in routines for line in of_routine.get(number, ())]
    pending += stays
    lines.update(pending)
    kept = set(kept)
    asked = [needed, *(facts[line].names for line in pending)]
    seen: set[str] = set()
    while asked:
        for name in asked.pop() - seen:
            seen.add(name)
            for index in declaring.get(name, ()):
                piece = made_of.pieces[index]
                if index in kept or (piece.routine >= 0 and piece.routine not in routines):
                    continue
                kept.add(index)
                new = [line for line in _lines(piece) if line not in lines]
                lines.update(new)
                asked += [facts[line].names for line in new]
            called_there = called.get(name)
            if called_there is not None:
                new = [line for line in of_routine.get(called_there, ()) if line not in lines]
                lines.update(new)
                asked += [facts[line].names for line in new]
    return lines


def _number_at(made_of: Structure, line: int) -> int:
    return next(n for n, one in enumerate(made_of.routines) if one.first <= line <= one.last)


def _blanked(text: str, starts: Sequence[int], lines: set[int]) -> str:
    parts, ends = [], [*starts[1:], len(text)]
    for line, (start, end) in enumerate(zip(starts, ends, strict=True)):
        whole = text[start:end]
        if line in lines:
            parts.append(whole)
        else:
            said = whole.rstrip("\r\n")
            parts.append(" " * len(said) + whole[len(said) :])
    return "".join(parts)
