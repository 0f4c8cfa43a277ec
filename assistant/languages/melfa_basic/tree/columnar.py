"""Position lines and moves in columns: thousands of lines as one node of a few arrays.

The rows that stand here are the plain ones, in the form that controllers and their tools
write; `rows_at` finds them in a text. Any other form goes through the grammar line by
line and means the same.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import field, replace
from functools import partial
from typing import ClassVar, Final, TypeVar

import numpy as np

from assistant.base.arrays import Floats, Ints, Rows
from assistant.base.columns import Chosen, Decimal, Integer, Offsets, Piece, Slots, rows_text
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.languages.runs.columns import Names, Run
from assistant.languages.runs.row_text import Groups, Marks, after_digits, in_parts, numbered_names
from assistant.languages.runs.row_text import decimals_needed as fewest_places

KEYWORDS: Final = ("Mov", "Mvs", "Mvr")
MOV, MVS, MVR = range(3)

FEWEST: Final = 2
"""Rows that make a table; a single line goes through the grammar."""

MOST_PLACES: Final = 9
"""Decimal places that a value is printed with at most."""


@dataclass(frozen=True, slots=True, eq=False)
class PositionRows(Run):
    """n position lines `P1=(x,y,z,a,b,c)(fl1,fl2)` whose names differ in the number only.

    stem: the name before the number. numbers: (n,) ≥ 0.
    values: (n, 6 … 8) mm and degrees. flags: (n, 2). places: (n, 2) where each line begins and
    ends, its line end included, counted from the begin of the table.
    """

    stem: str
    numbers: Ints
    values: Floats
    flags: Ints
    span: Span | None = field(default=None, compare=False, repr=False)
    places: Rows | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class MoveRows(Run):
    """n code lines `10 MVS P1`, `20 MVR P1,P2,P3` through positions of one stem.

    steps: (n,) step numbers. kinds: (n,) rows of KEYWORDS.
    start, via: (n,) numbers of an arc's first two positions, -1 for other moves.
    end: (n,) number of the position that is reached.
    label, statement, comment: what a single line may have. places: see `PositionRows`.
    """

    label: ClassVar[None] = None
    statement: ClassVar[None] = None
    comment: ClassVar[None] = None
    stem: str
    steps: Ints
    kinds: Ints
    start: Ints
    via: Ints
    end: Ints
    span: Span | None = field(default=None, compare=False, repr=False)
    places: Rows | None = field(default=None, compare=False, repr=False)


R = TypeVar("R", "PositionRows", "MoveRows", "PositionRows | MoveRows")


def row_spans(rows: PositionRows | MoveRows) -> list[Span]:
    """Spans of the lines of a table in the text; empty if the table was built."""
    if rows.span is None or rows.places is None:
        return []
    return [Span(start, end) for start, end in (rows.places + rows.span.start).tolist()]


def row_slice(rows: R, first: int, stop: int) -> R:
    """Some lines of a table, with their place in the text."""
    part = rows.rows(slice(first, stop))
    if rows.span is None or rows.places is None:
        return part
    begin, end = int(rows.places[first, 0]), int(rows.places[stop - 1, 1])
    span = Span(rows.span.start + begin, rows.span.start + end)
    return replace(part, span=span, places=rows.places[first:stop] - begin)


# ---------------------------------------------------------------------------- to text


def places_of(values: Floats) -> int:
    """Decimal places, at least two, that print every value without loss, at most nine."""
    return fewest_places(values, 2, MOST_PLACES)


def _groups_of(elements: int) -> Groups:
    """A position with so many elements and its flags."""
    return Groups((elements, 2), b"(", b")(", b")")


def position_text(rows: PositionRows, newline: bytes, places: int | None = None) -> str:
    """The lines of a position table, each with its line end; raises ValueError for NaN.

    places: decimals, None for as many as the table needs.
    """
    decimals = places_of(rows.values) if places is None else places
    columns: list[Piece] = [Decimal(column, decimals, plus=True) for column in rows.values.T]
    columns += [Integer(column) for column in rows.flags.T]
    name: list[Piece] = [rows.stem.encode("ascii"), Integer(rows.numbers), b"="]
    groups = _groups_of(rows.values.shape[1]).pieces([[column] for column in columns])
    return rows_text([*name, *groups, newline], len(rows)).decode("ascii")


def move_text(rows: MoveRows, newline: bytes, upper: bool, indent: int = 0) -> str:
    """The lines of a run of moves, each with its line end. indent: blanks more behind steps."""
    stem = rows.stem.encode("ascii")
    words = [(w.upper() if upper else w).encode() + b" " for w in KEYWORDS]
    columns: list[Piece] = [Integer(rows.steps), b" " * (1 + indent), Chosen(rows.kinds, words)]
    arc = rows.kinds == MVR
    if arc.any():  # an arc names two positions more
        at = np.flatnonzero(arc)
        comma = Chosen(arc.astype(np.int64), (b"", b","))
        for numbers in (rows.start, rows.via):
            columns += [*Names.numbered(stem, numbers[at]).spread(at, len(rows)).pieces(), comma]
    return rows_text([*columns, stem, Integer(rows.end), newline], len(rows)).decode("ascii")


# -------------------------------------------------------------------------- from text

FLAGS: Final = range(-(2**31), 2**32)
"""Range of a flag, with a sign or without: 32 bits, four for the turns of each axis."""
_NATURAL: Final = r"(?:0|[1-9][0-9]{0,8})"
_REAL: Final = r"[+-]?[0-9]{1,9}(?:\.[0-9]{0,9})?"
# Possessive and atomic parts: a line that does not fit is not tried in other ways again.
_SPACE: Final = r"[ \t]*+"
_STEM: Final = r"([A-Za-z][A-Za-z_]*)"


def _position_pattern(elements: int) -> re.Pattern[str]:
    real, flag = rf"{_SPACE}{_REAL}{_SPACE}", rf"{_SPACE}[+-]?[0-9]{{1,10}}{_SPACE}"
    row = (
        rf"{_NATURAL}{_SPACE}={_SPACE}\({real}(?:,{real}){{{elements - 1}}}\)"
        rf"{_SPACE}\({flag},{flag}\){_SPACE}\r?\n"
    )
    return re.compile(rf"{_STEM}{row}(?>\1{row})++")


_POSITIONS: Final = tuple(_position_pattern(elements) for elements in (6, 7, 8))


def _move_pattern() -> re.Pattern[str]:
    step = r"[1-9][0-9]{0,5}[ \t]+"
    first = rf"{step}(?i:MOV|MVS)[ \t]+{_STEM}{_NATURAL}{_SPACE}\r?\n"
    same = rf"\1{_NATURAL}"
    row = rf"{step}(?:(?i:MOV|MVS)[ \t]+{same}|(?i:MVR)[ \t]+{same},{same},{same}){_SPACE}\r?\n"
    arc = rf"{step}(?i:MVR)[ \t]+{_STEM}{_NATURAL},\2{_NATURAL},\2{_NATURAL}{_SPACE}\r?\n"
    rest = row.replace(r"\1", r"\2")
    return re.compile(rf"{first}(?>{row})++|{arc}(?>{rest})++")


_MOVES: Final = _move_pattern()


def rows_at(text: str, at: int) -> PositionRows | MoveRows | None:
    """The longest table of plain rows that begins at an offset, None for fewer than FEWEST."""
    character = text[at : at + 1]
    if character.isdigit():
        found = _MOVES.match(text, at)
        return _table(found, _moves) if found else None
    if not character.isalpha():
        return None
    for elements, pattern in zip((6, 7, 8), _POSITIONS, strict=True):
        found = pattern.match(text, at)
        if found:
            rows = _table(found, partial(_positions, _groups_of(elements)))
            inside = (rows.flags >= FLAGS.start) & (rows.flags < FLAGS.stop)
            # Flags beyond 32 bits are errors, which the line reader reports.
            return rows if inside.all() else None
    return None


def _table(found: re.Match[str], read: Callable[[bytes], R]) -> R:
    data = found.group().encode("ascii")
    ends = np.flatnonzero(np.frombuffer(data, dtype=np.uint8) == ord("\n")) + 1
    places = np.stack([np.concatenate([[0], ends[:-1]]), ends], axis=1)
    # Without blanks, marks are all that separates the numbers.
    rows = in_parts(data.translate(None, b" \t\r"), read)
    return replace(rows, span=Span(found.start(), found.end()), places=places)


def _positions(groups: Groups, data: bytes) -> PositionRows:
    """Lines without blanks."""
    text = Slots(data)
    marks = Marks(text, b"=,)", b"\n")
    equals = marks.offsets[marks.first]
    values = np.empty((len(equals), sum(groups.sizes)))
    groups.read(text, marks, 1, equals + 1, b"\n", values)
    names = numbered_names(text, marks.rows, equals)
    assert names is not None
    flags = values[:, -2:].astype(np.int64)
    return PositionRows(names.stems[0].decode("ascii"), names.number, values[:, :-2] + 0.0, flags)


def _moves(data: bytes) -> MoveRows:
    """Lines without blanks: the third letter of the keyword tells the three apart."""
    text = Slots(data)
    marks = Marks(text, b",", b"\n")
    words = after_digits(text.bytes, marks.rows)
    # Clearing the bit of lower case: the letter counts in any case.
    letter = text.bytes[words + 2] & 0xDF
    kinds = np.select([letter == ord("V"), letter == ord("S")], [MOV, MVS], MVR)
    # The three words are of one length.
    arc, begins = kinds == MVR, words + len(KEYWORDS[MVR])
    commas = marks.offsets[marks.first[arc, None] + np.arange(2)]
    start, via = np.full((2, len(kinds)), -1, dtype=np.int64)
    if arc.any():
        start[arc] = _numbers(text, begins[arc], commas[:, 0])
        via[arc] = _numbers(text, commas[:, 0] + 1, commas[:, 1])
        begins[arc] = commas[:, 1] + 1
    steps, _ = text.whole(words, words - marks.rows)
    ends = numbered_names(text, begins, marks.stops)
    assert ends is not None
    stem = ends.stems[0].decode("ascii")
    return MoveRows(stem, steps, kinds.astype(np.int64), start, via, ends.number)


def _numbers(text: Slots, starts: Offsets, ends: Offsets) -> Ints:
    names = numbered_names(text, starts, ends)
    assert names is not None
    return names.number
