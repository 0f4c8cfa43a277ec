"""Options of a run: their page, and what a script may give them."""

from __future__ import annotations

import math
import re
from dataclasses import fields
from datetime import UTC, datetime
from pathlib import Path

import pytest

from assistant.base.diagnostics import Refused
from assistant.virtual.melfa import Options
from assistant.virtual.melfa.options import choose

PAGE = Path(__file__).parents[2] / "docs" / "running.md"
ROW = re.compile(r"^\| (`[a-z_, `]+`) \| ([^|]+) \|", re.M)


def rows() -> dict[str, str]:
    """The options of the page, each with its values."""
    found = {}
    for names, values in ROW.findall(PAGE.read_text(encoding="utf-8")):
        for name in re.findall(r"`([a-z_]+)`", names):
            found[name] = values
    return found


def test_the_page_has_every_option() -> None:
    wanted = {field.name for field in fields(Options)}
    assert wanted <= set(rows())


def test_the_values_of_the_page_can_be_given() -> None:
    tried = 0
    for field in fields(Options):
        for word in re.findall(r'"([^"]+)"', rows()[field.name]):
            tried += 1
            assert getattr(choose({field.name: word}), field.name) == word
    assert tried >= 20


def test_what_is_not_given_is_as_usual() -> None:
    assert choose({}) == Options() and choose({"truth": 1}) == Options()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("degrees", 1), ("truth", True), ("bits", 8), ("bits", "16"), ("digits", 0),
        ("digits", True), ("tools", {"1": [0, 0, 0, 0, 0]}), ("tools", {"a": [0] * 6}),
        ("tools", {"1": [True] * 6}), ("tools", 5), ("over", None), ("pulses", "at last"),
        ("tools", {"1": [math.nan] * 6}), ("digits", -3), ("printed", 10**12), ("places", -1),
        ("timers", -1), ("longest_text", 0), ("began", 1),
        ("began", datetime(2026, 5, 1, tzinfo=UTC)),
    ],
)  # fmt: skip
def test_what_an_option_cannot_be(name: str, value: object) -> None:
    with pytest.raises(Refused) as refused:
        choose({name: value})
    (finding,) = refused.value.findings
    assert finding.code == "VC209" and name in finding.message


@pytest.mark.parametrize(
    ("name", "value"),
    [("places", 0), ("timers", 0), ("digits", 17), ("began", datetime(2026, 5, 1, 12, 30))],
)
def test_the_ends_of_what_can_be_given(name: str, value: object) -> None:
    assert getattr(choose({name: value}), name) == value


def test_all_mistakes_are_told_at_once() -> None:
    with pytest.raises(Refused) as refused:
        choose({"quotient": "zero", "bits": 8, "ways": 1})
    assert [f.code for f in refused.value.findings] == ["VC208", "VC209", "VC208"]


def test_frames_by_their_numbers() -> None:
    chosen = choose({"tools": {"1": [0, 0, 120.5, 0, 0, 90]}})
    assert chosen.tools == {1: (0.0, 0.0, 120.5, 0.0, 0.0, 90.0)}
