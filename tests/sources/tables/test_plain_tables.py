"""Tables of plain numbers: polars reads what the other reader reads, and leaves the rest to it."""

from __future__ import annotations

import itertools
import multiprocessing
import struct
import sys

import numpy as np
import polars
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.base.diagnostics import Refused, Unreadable
from assistant.program.pseudo import print_program
from assistant.sources.tables import delimited_text
from tests.examples import drawn
from tests.sources.tables.test_bad_tables import BAD
from tests.sources.tables.test_csv_tables import POSE, read
from tests.tables import every_row

NEVER = sys.maxsize
GOOD = {
    "plain": POSE + "\n1,2,3,1,0,0,0\n4,5,6,0,1,0,0\n",
    "metres": POSE.replace("x_mm", "x_m") + "\n0.1,2,3,1,0,0,0\n4,5,6,0,1,0,0\n",
    "semicolons": (POSE + "\n1.5,2,3,1,0,0,0\n4,5,6,0,1,0,0\n").replace(",", ";"),
    "tabs": (POSE + "\n1.5,2,3,1,0,0,0\n4,5,6,0,1,0,0\n").replace(",", "\t"),
    "returns": (POSE + "\n1,2,3,1,0,0,0\n4,5,6,0,1,0,0\n").replace("\n", "\r\n"),
    "no last line end": POSE + "\n1,2,3,1,0,0,0\n4,5,6,0,1,0,0",
    "comments": "# of a scan\n\n" + POSE + "\n1,2,3,1,0,0,0\n4,5,6,0,1,0,0\n",
    "quoted header": '"' + POSE.replace(",", '","') + '"\n1,2,3,1,0,0,0\n4,5,6,0,1,0,0\n',
    "blank lines": POSE + "\n1,2,3,1,0,0,0\n\n4,5,6,0,1,0,0\n\n",
    "blanks": POSE + "\n1, 2,3,1,0,0,0\n4,5 ,6,0,1,0,0\n",
    "empty rows": POSE + "\n1,2,3,1,0,0,0\n,,,,,,\n4,5,6,0,1,0,0\n",
    "signs": POSE + "\n+1,-2,3.,1,-0,-0.0,0e5\n.4,5E2,-6e-1,0,1,0,0\n",
    "rows in one place": POSE + "\n" + "1,2,3,1,0,0,0\n" * 3 + "4,5,6,0,1,0,0\n",
    "not quite unit": POSE + "\n1,2,3,1.0001,0,0,0\n4,5,6,0,1,0,0\n",
    "speeds": POSE + ",speed_mm_s,blend_mm\n1,2,3,1,0,0,0,100,5\n4,5,6,0,1,0,0,50,0\n",
    "names that are numbers": "name," + POSE + "\n7,1,2,3,1,0,0,0\n8,4,5,6,0,1,0,0\n",
    "joints": "j1_deg,j2_deg\n1,2\n3,4\n",
    "left out": "_number," + POSE + "\n1,1,2,3,1,0,0,0\n2,4,5,6,0,1,0,0\n",
}


def outcome(text: str | bytes) -> tuple[object, ...]:
    """What reading a table gives: the program, or why there is none, and the findings."""
    try:
        found = read(text)
    except (Refused, Unreadable) as error:
        return type(error), [str(one) for one in error.findings]
    return print_program(found.program), [str(one) for one in found.findings]


def equal_outcomes(text: str | bytes, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(delimited_text, "LEAST_PLAIN_BYTES", NEVER)
    expected = outcome(text)
    patch.setattr(delimited_text, "LEAST_PLAIN_BYTES", 0)
    assert outcome(text) == expected


@every_row("case", list(GOOD))
def test_good_tables_are_read_alike(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    equal_outcomes(GOOD[case], monkeypatch)


@every_row("case", list(BAD))
def test_bad_tables_are_refused_alike(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    equal_outcomes(BAD[case][0], monkeypatch)


def test_delimited_text_are_read_by_polars(monkeypatch: pytest.MonkeyPatch) -> None:
    """And others are not: the two tests above compare two readers."""
    monkeypatch.setattr(delimited_text, "LEAST_PLAIN_BYTES", 0)
    rows = b"1;2.5\n-3;4e2\n"
    found = delimited_text.plain_numbers(rows, ord(";"), 2)
    assert found is not None and found.tolist() == [[1.0, 2.5], [-3.0, 400.0]]
    for other in (b"1;\n", b"1;2;3\n", b"1\n2;3;4\n", b"1;2\n\n", b"1; 2\n", b"1;x\n", b'1;"2"\n'):
        assert delimited_text.plain_numbers(other, ord(";"), 2) is None
    monkeypatch.setattr(delimited_text, "LEAST_PLAIN_BYTES", len(rows) + 1)
    assert delimited_text.plain_numbers(rows, ord(";"), 2) is None


def test_a_cell_is_a_number_if_python_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """All cells of up to four characters, at once; those that polars takes for none are null."""
    letters = "09+-.eE"
    cells = ["".join(c) for k in range(1, 5) for c in itertools.product(letters, repeat=k)]
    text = "\n".join(cells) + "\n"
    table = polars.read_csv(
        text.encode(), has_header=False, schema={"0": polars.Float64}, ignore_errors=True
    )
    monkeypatch.setattr(delimited_text, "LEAST_PLAIN_BYTES", 0)
    for cell, value in zip(cells, table["0"].to_list(), strict=True):
        assert value is None or value == float(cell)


@settings(max_examples=drawn(60), deadline=None)
@given(st.lists(st.binary(min_size=8, max_size=8), min_size=1, max_size=20), st.integers(1, 25))
def test_each_number_is_the_nearest_double(bits: list[bytes], digits: int) -> None:
    values = [struct.unpack("d", one)[0] for one in bits]
    cells = [f"{one:.{digits}g}" for one in values if np.isfinite(one)]
    cells = [cell for cell in cells if np.isfinite(float(cell))]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(delimited_text, "LEAST_PLAIN_BYTES", 0)
        found = delimited_text.plain_numbers("".join(f"{c}\n" for c in cells).encode(), ord(","), 1)
    if cells:
        assert found is not None
        assert found[:, 0].tobytes() == np.array([float(cell) for cell in cells]).tobytes()


def _read_in_a_fork(rows: bytes) -> bool:
    return delimited_text.plain_numbers(rows, ord(","), 2) is None


@pytest.mark.skipif(sys.platform == "win32", reason="no forks")
def test_a_fork_of_a_process_that_used_polars_does_not_wait_for_its_threads(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(delimited_text, "LEAST_PLAIN_BYTES", 0)
    rows = b"1,2\n" * 1000
    assert delimited_text.plain_numbers(rows, ord(","), 2) is not None
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.apply_async(_read_in_a_fork, (rows,)).get(60)
