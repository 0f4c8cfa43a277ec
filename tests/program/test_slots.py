"""Numbers at known offsets of a text."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.base.columns import WORD, Slots
from tests.examples import drawn
from tests.tables import every_row

NUMBER = st.one_of(
    st.integers(-999, 9999).map(str),
    st.decimals(-500, 500, places=3).map(str),
    st.floats(-1e5, 1e5, allow_nan=False).map(repr),
    st.sampled_from(["9E9", "9E+09", "1e-05", ".5", "5.", "-.25", "+3", "0.12345678901234567890"]),
)


@settings(max_examples=drawn(200), deadline=None)
@given(st.lists(NUMBER | st.floats().map(repr), min_size=1, max_size=30))
def test_slots_hold_the_doubles_that_are_written(written: list[str]) -> None:
    finite = [w for w in written if "n" not in w] or ["0"]
    data = ",".join(finite) + ","
    ends = np.flatnonzero(np.frombuffer(data.encode(), dtype=np.uint8) == ord(",")) + WORD
    starts = np.concatenate([[WORD], ends[:-1] + 1])
    points = np.array(
        [a + w.index(".") if "." in w else b for w, a, b in zip(finite, starts, ends, strict=True)]
    )
    read = Slots(data.encode()).decimals(starts, ends, points, [(b"9E9", 9e9)])
    assert read.tolist() == [float(w) for w in finite]


@every_row("text", ["", "-", ".", "1-2", "1e", "x1", "+-5"])
def test_a_slot_without_a_number_is_refused(text: str) -> None:
    slots = Slots(text.encode() + b",")
    start, end = np.array([WORD]), np.array([WORD + len(text)])
    point = start + text.index(".") if "." in text else end
    with pytest.raises(ValueError, match="could not convert"):
        slots.decimals(start, end, point, [])
