"""Position lines and moves in columns: thousands of lines as one node of a few arrays.

The rows that stand here are the plain ones, in the form that controllers and their tools
write; `rows_at` finds them in a text. Any other form goes through the grammar line by
line and means the same.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.program.arrays import Floats, Ints
from assistant.program.columns import Chosen, Decimal, Integer, Piece, numbers, rows_text
from assistant.program.diagnostics import Span

KEYWORDS: Final = ("Mov", "Mvs", "Mvr")
MOV, MVS, MVR = range(3)

FEWEST: Final = 2
"""Rows that make a table; a single line goes through the grammar."""

MOST_PLACES: Final = 9
"""Decimal places that a value is printed with at most."""


@dataclass(frozen=True, slots=True, eq=False)
class PositionRows:
    """n position lines `P1=(x,y,z,a,b,c)(fl1,fl2)` whose names differ in the number only.

    stem: the name before the number. numbers: (n,) ≥ 0.
    values: (n, 6 … 8) mm and degrees. flags: (n, 2).
    """

    stem: str
    numbers: Ints
    values: Floats
    flags: Ints
    span: Span | None = field(default=None, compare=False, repr=False)

    def __len__(self) -> int:
        return len(self.numbers)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, PositionRows):
            return NotImplemented
        return (
            self.stem.upper() == other.stem.upper()
            and np.array_equal(self.numbers, other.numbers)
            and np.array_equal(self.values, other.values)
            and np.array_equal(self.flags, other.flags)
        )

    def __hash__(self) -> int:
        return hash((self.stem.upper(), len(self)))


@dataclass(frozen=True, slots=True, eq=False)
class MoveRows:
    """n code lines `10 MVS P1`, `20 MVR P1,P2,P3` through positions of one stem.

    steps: (n,) step numbers. kinds: (n,) rows of KEYWORDS.
    start, via: (n,) numbers of an arc's first two positions, -1 for other moves.
    end: (n,) number of the position that is reached.
    """

    stem: str
    steps: Ints
    kinds: Ints
    start: Ints
    via: Ints
    end: Ints
    span: Span | None = field(default=None, compare=False, repr=False)

    def __len__(self) -> int:
        return len(self.steps)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, MoveRows):
            return NotImplemented
        return self.stem.upper() == other.stem.upper() and all(
            np.array_equal(getattr(self, f), getattr(other, f))
            for f in ("steps", "kinds", "start", "via", "end")
        )

    def __hash__(self) -> int:
        return hash((self.stem.upper(), len(self)))


# ---------------------------------------------------------------------------- to text


def places_of(values: Floats, least: int = 2) -> int:
    """Decimal places, at least two, that print every value without loss, at most nine."""
    known = values[~np.isnan(values)]
    for places in range(least, MOST_PLACES):
        if np.array_equal(np.round(known, places), known):
            return places
    return MOST_PLACES


def position_text(rows: PositionRows, newline: bytes, places: int | None = None) -> str:
    """The lines of a position table, each with its line end; raises ValueError for NaN.

    places: decimals, None for as many as the table needs.
    """
    places = places_of(rows.values) if places is None else places
    columns: list[Piece] = [
        rows.stem.encode("ascii"),
        Integer(rows.numbers),
        b"=(",
    ]
    for i in range(rows.values.shape[1]):
        if i:
            columns.append(b",")
        columns.append(Decimal(rows.values[:, i], places, plus=True))
    columns += [b")(", Integer(rows.flags[:, 0]), b",", Integer(rows.flags[:, 1]), b")" + newline]
    return rows_text(columns, len(rows)).decode("ascii")


def move_text(rows: MoveRows, newline: bytes, upper: bool, indent: int = 0) -> str:
    """The lines of a run of moves, each with its line end. indent: blanks more behind steps."""
    stem = rows.stem.encode("ascii")
    blanks = b" " * (1 + indent)
    words = [(w.upper() if upper else w).encode() + b" " for w in KEYWORDS]
    columns: list[Piece]
    if not np.any(rows.kinds == MVR):
        plain = Chosen(rows.kinds, [word + stem for word in words])
        columns = [Integer(rows.steps), blanks, plain, Integer(rows.end), newline]
        return rows_text(columns, len(rows)).decode("ascii")
    # an arc names two positions more: their digits are chosen, which an empty text leaves out
    arc = rows.kinds == MVR
    start, via = (
        Decimal(np.where(arc, column, np.nan).astype(np.float64), 0, missing=b"")
        for column in (rows.start, rows.via)
    )
    isarc = arc.astype(np.int64)
    columns = [
        Integer(rows.steps), blanks, Chosen(rows.kinds, words),
        Chosen(isarc, (b"", stem)), start, Chosen(isarc, (b"", b"," + stem)), via,
        Chosen(isarc, (b"", b",")), stem, Integer(rows.end), newline,
    ]  # fmt: skip
    return rows_text(columns, len(rows)).decode("ascii")


# -------------------------------------------------------------------------- from text

_NATURAL: Final = r"(?:0|[1-9][0-9]{0,8})"
_REAL: Final = r"[+-]?[0-9]{1,9}(?:\.[0-9]{0,9})?"
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
_LETTERS: Final = bytes.maketrans(
    b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_=", b" " * 54
)


def rows_at(text: str, at: int) -> PositionRows | MoveRows | None:
    """The longest table of plain rows that begins at an offset, None for fewer than FEWEST."""
    character = text[at : at + 1]
    if character.isdigit():
        found = _MOVES.match(text, at)
        return _moves(found) if found else None
    if not character.isalpha():
        return None
    for elements, pattern in zip((6, 7, 8), _POSITIONS, strict=True):
        found = pattern.match(text, at)
        if found:
            return _positions(found, elements)
    return None


def _positions(found: re.Match[str], elements: int) -> PositionRows:
    data = found.group().encode("ascii").translate(_LETTERS)
    table = numbers(data).reshape(-1, 1 + elements + 2)
    return PositionRows(
        found.group(1),
        table[:, 0].astype(np.int64),
        np.ascontiguousarray(table[:, 1:-2]) + 0.0,
        table[:, -2:].astype(np.int64),
        Span(found.start(), found.end()),
    )


def _moves(found: re.Match[str]) -> MoveRows:
    stem = found.group(1) or found.group(2)
    data = found.group().encode("ascii")
    text = np.frombuffer(data, dtype=np.uint8)
    # the third letter of the keyword tells the three apart; it follows the blank after the step
    ends = np.flatnonzero(text == ord("\n"))
    begins = np.concatenate([[0], ends[:-1] + 1])
    letter = (text >= ord("A")) & (text <= ord("z"))
    letters = np.flatnonzero(letter & ~np.concatenate([[False], letter[:-1]]))
    third = text[letters[np.searchsorted(letters, begins)] + 2] & 0xDF
    kinds = np.select([third == ord("V"), third == ord("S")], [MOV, MVS], MVR)
    values = numbers(data.translate(_LETTERS)).astype(np.int64)
    count = np.where(kinds == MVR, 4, 2)
    last = np.cumsum(count)
    arc = kinds == MVR
    start, via = np.full((2, len(kinds)), -1, dtype=np.int64)
    start[arc], via[arc] = values[last[arc] - 3], values[last[arc] - 2]
    return MoveRows(
        stem,
        values[last - count],
        kinds.astype(np.int64),
        start,
        via,
        values[last - 1],
        Span(found.start(), found.end()),
    )
