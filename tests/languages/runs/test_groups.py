"""Groups of numbers, printed and read again for all rows at once."""

from __future__ import annotations

import numpy as np
import pytest

from assistant.base.arrays import Floats
from assistant.base.columns import Piece, Slots, rows_text
from assistant.languages.runs.columns import Names
from assistant.languages.runs.row_text import (
    FewestDecimals,
    Groups,
    Marks,
    NameWords,
    decimals_needed,
    numbered_names,
)
from tests.tables import every_row

SQUARE = Groups((3, 1, 2), b"[[", b"],[", b"]]", known=((b"9E9", 9e9),))
ROUND = Groups((3, 1, 2), b"(", b")(", b")")
FEWEST = FewestDecimals((0, 4, 9), {9e9: b"9E9"})


def values(count: int) -> Floats:
    random = np.random.default_rng(count)
    made = np.round(random.uniform(-500, 500, (count, 6)), 4)
    made[:, 1] = 0.0
    made[random.random(count) < 0.5, 3] = 9e9
    return made


def written(groups: Groups, numbers: Floats) -> bytes:
    row: list[Piece] = [*Names.numbered(b"p", np.arange(len(numbers))).pieces(), b"="]
    pieces = groups.pieces([FEWEST.pieces(column) for column in numbers.T])
    return rows_text([*row, *pieces, b";"], len(numbers))


def read(groups: Groups, data: bytes, between: bytes) -> tuple[Names | None, Floats]:
    text = Slots(data)
    marks = Marks(text, b"=," + between, b";")
    found = np.empty((len(marks.rows), 6))
    equals = marks.offsets[marks.first]
    ends = groups.read(text, marks, 1, equals + 1, b";", found)
    assert np.array_equal(ends, marks.stops)
    return numbered_names(text, marks.rows, equals), found


@pytest.mark.parametrize(("groups", "between"), [(SQUARE, b""), (ROUND, b")")])
@pytest.mark.parametrize("count", [1, 2, 50])
def test_what_is_printed_is_read_again(groups: Groups, between: bytes, count: int) -> None:
    names, found = read(groups, written(groups, values(count)), between)
    assert names == Names.numbered(b"p", np.arange(count))
    assert np.array_equal(found, values(count))


@every_row(
    ("old", "new"),
    [
        (b"],[", b",[["),
        (b"],[", b"],"),
        (b"]]", b"]"),
        (b"[[", b"["),
        (b",", b",,"),
        (b"=[[", b"=[[x"),
        (b"=[[", b"=[[1.2.3"),
        (b"]];", b"]]5;"),
    ],
)
def test_a_row_in_another_form_is_refused(old: bytes, new: bytes) -> None:
    data = written(SQUARE, values(9))
    at = data.index(b"p4=")
    damaged = data[:at] + data[at:].replace(old, new, 1)
    with pytest.raises(ValueError, match=r"out of place|two points|convert"):
        read(SQUARE, damaged, b"")


def test_a_column_takes_the_decimals_that_it_needs() -> None:
    assert (
        decimals_needed(np.array([1.5, np.nan]), 2, 9),
        decimals_needed(np.array([1 / 3]), 2, 9),
    ) == (2, 9)
    for column, expected in (
        ([1.0, 2.0], b"1 2 "),
        ([0.5, 9e9], b"0.5 9E9 "),
        ([1 / 3, 0.25], b"0.3333333333333333 0.25 "),
        ([7.5, 7.5], b"7.5 7.5 "),
    ):
        pieces = FEWEST.pieces(np.array(column))
        assert rows_text([*pieces, b" "], 2) == expected


@pytest.mark.parametrize("name", ["a_name_that_is_too_long", "if"])
def test_what_is_no_name_is_refused(name: str) -> None:
    text = Slots(f"p1,{name},".encode("ascii"))
    marks = Marks(text, b"", b",")
    with pytest.raises(ValueError, match="name"):
        NameWords(10, frozenset({"if"})).names(text, marks.rows, marks.stops)
