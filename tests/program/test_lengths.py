"""Measured lengths are shown as far as they mean something, and notes after what matters."""

from __future__ import annotations

import pytest

from assistant.base.diagnostics import error, info, notes_last, warning
from assistant.base.length_units import length_text


@pytest.mark.parametrize(
    ("mm", "text"),
    [(1.71e-13, "less than 0.01"), (0.0, "0"), (0.126, "0.13"), (5.8642, "5.9"), (120.04, "120")],
)
def test_a_length_has_the_digits_that_mean_something(mm, text):
    assert length_text(mm) == text


def test_notes_come_last():
    rules = [info("XX101", "a"), error("XX102", "b"), info("XX103", "c"), warning("XX104", "d")]
    found = notes_last(rule() for rule in rules)
    assert [one.code for one in found] == ["XX102", "XX104", "XX101", "XX103"]
