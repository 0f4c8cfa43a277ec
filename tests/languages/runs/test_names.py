"""Names in columns: taken apart, put together, found and printed."""

from __future__ import annotations

import numpy as np

from assistant.base.columns import rows_text
from assistant.languages.runs.columns import NameIndex, Names, rows_of, split_name
from tests.tables import every_row

WRITTEN = ("p1", "p10", "P1", "q", "p1_2", "p007", "a0", "x1234567890123456", "p1", "home")


@every_row(
    ("name", "stem", "number"),
    [
        ("p12", b"p", 12),
        ("p0", b"p", 0),
        ("p_1_20", b"p_1_", 20),
        ("home", b"home", -1),
        ("p007", b"p007", -1),
        ("p1234567890123456", b"p1234567890123456", -1),
        ("p123456789012345", b"p", 123456789012345),
    ],
)
def test_a_name_is_a_stem_and_a_number(name: str, stem: bytes, number: int) -> None:
    assert split_name(name) == (stem, number)
    assert Names.of([name]).name(0) == name


def test_names_are_printed_as_they_were_written() -> None:
    names = Names.of(WRITTEN)
    text = rows_text([*names.pieces(), b"\n"], len(names)).decode("ascii")
    assert tuple(text.split()) == WRITTEN


def test_columns_are_equal_whatever_their_tables() -> None:
    names = Names.of(WRITTEN)
    again = Names.joined([names.rows(slice(4)), Names.of(WRITTEN[4:])])
    assert again == names
    assert again.equal(Names.of((*WRITTEN[:9], "away"))).tolist() == [True] * 9 + [False]
    assert names != names.rows(slice(9))


def test_a_name_is_found_in_any_case_and_one_of_neither_part_never() -> None:
    index = NameIndex(Names.of(("a1", "B2", "a10", "home")))
    assert index.rows(Names.of(("A10", "b2", "HOME", "a2"))).tolist() == [2, 1, 3, -1]
    assert index.rows(Names.none(2)).tolist() == [-1, -1]


def test_names_stand_at_their_rows_and_nothing_elsewhere() -> None:
    spread = Names.of(("p1", "home")).spread(np.array([1, 3]), 4)
    assert [spread.name(row) for row in range(4)] == ["", "p1", "", "home"]


def test_numbers_are_found_among_others() -> None:
    known = np.array([7, 3, 5])
    assert rows_of(known, np.array([5, 4, 7, 9])).tolist() == [2, -1, 0, -1]
    assert rows_of(np.empty(0, dtype=np.int64), np.array([5])).tolist() == [-1]
