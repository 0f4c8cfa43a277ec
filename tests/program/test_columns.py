"""Numbers in columns are written and read as Python would, one by one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.base.columns import CHUNK, Chosen, Decimal, Integer, read_numbers, rows_text
from tests.tables import every_row

VALUES = st.lists(
    st.one_of(
        st.floats(-1e5, 1e5),
        st.floats(-1, 1),
        st.sampled_from([0.0, -0.0, 0.5, -0.0004, 9.9999999999, 99999.0, 1e5]),
    ),
    min_size=1,
    max_size=40,
)


def written(value: float, places: int, *, plus: bool, strip: bool) -> str:
    """What a row should say, worked out in whole numbers."""
    whole = int(np.rint(abs(value) * 10.0**places))
    text = str(whole // 10**places)
    if places:
        text += f".{whole % 10**places:0{places}d}"
    if strip and places:
        text = text.rstrip("0").rstrip(".")
    return ("-" if value < 0 and whole else "+" if plus else "") + text


@given(VALUES, st.integers(0, 9), st.booleans(), st.booleans())
def test_decimals_are_those_of_whole_number_arithmetic(values, places, plus, strip):
    piece = Decimal(np.array(values), places, plus=plus, strip=strip)
    rows = rows_text([piece, b"\n"], len(values)).decode().splitlines()
    assert rows == [written(v, places, plus=plus, strip=strip) for v in values]


@given(st.lists(st.integers(-(10**17), 10**17), min_size=1))
def test_integers(values):
    rows = rows_text([Integer(np.array(values)), b";"], len(values)).decode()
    assert rows == "".join(f"{v};" for v in values)


def test_pieces_stand_in_their_order_over_more_than_one_chunk():
    n = 2 * CHUNK + 3
    index = np.arange(n)
    pieces = [b"<", Integer(index), b":", Chosen(index % 3, (b"", b"one", b"xy")), b"", b">\r\n"]
    expected = "".join(f"<{i}:{('', 'one', 'xy')[i % 3]}>\r\n" for i in range(n))
    assert rows_text(pieces, n).decode() == expected


def test_no_rows_are_no_text():
    assert rows_text([b"x", Integer(np.empty(0, np.int64))], 0) == b""


def test_what_is_missing_has_a_text_of_its_own():
    values = np.array([1.5, math.nan, -2.0, math.nan])
    text = rows_text([Decimal(values, 2, missing=b"9E9"), b" "], 4)
    assert text == b"1.50 9E9 -2.00 9E9 "


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e16])
def test_what_has_no_digits_is_refused(value):
    with pytest.raises(ValueError):
        rows_text([Decimal(np.array([0.0, value]), 3)], 2)


NUMBER = st.one_of(
    st.from_regex(r"[+-]?([0-9]{1,16}(\.[0-9]{0,9})?|\.[0-9]{1,9})", fullmatch=True),
    st.from_regex(r"-?[0-9]{1,3}(\.[0-9]{1,3})?[eE][+-]?[0-9]{1,2}", fullmatch=True),
    st.sampled_from(["9E9", "9E+09", "0", "-0", "5.", ".5"]),
)


@given(st.lists(NUMBER, max_size=40), st.sampled_from([",", " ", ";\r\n", "],["]))
def test_every_number_is_the_one_that_python_reads(texts, separator):
    read = read_numbers(f"[{separator.join(texts)}]".encode())
    assert read.tolist() == [float(t) for t in texts]


def test_long_texts_are_read_in_parts():
    values = np.arange(200_000) / 7
    text = ",".join(f"{v:.4f}" for v in values).encode()
    np.testing.assert_array_equal(read_numbers(text), np.round(values, 4))


@every_row("text", [b"1.2.3", b"1-2", b"abc", b"-", b".", b"1e", b"--1", b"1 +", b"1,x", b"0x1F"])
def test_what_is_no_number_is_refused(text):
    with pytest.raises(ValueError):
        read_numbers(text)
