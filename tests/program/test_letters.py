"""Texts and names in the letters of ASCII."""

from __future__ import annotations

import pytest

from assistant.base.source_text import in_ascii, plain_letters


@pytest.mark.parametrize(
    ("text", "comment"),
    [
        ("Außenkontur", "Aussenkontur"),
        ("Слой: внешний контур", "Sloy: vneshniy kontur"),
        ("Ø 12 mm", "dia.  12 mm"),
        ("チェック、OK", "chekku, OK"),
        ("原点 1", r"\u539f\u70b9 1"),
        ("외곽", "OeGwag"),
    ],
)
def test_a_comment_keeps_what_it_says(text: str, comment: str) -> None:
    assert in_ascii(text) == comment


def test_characters_that_are_read_in_several_ways_are_spelled_in_names_alone() -> None:
    assert plain_letters("原点") == "YuanDian"
    assert in_ascii("原点") == r"\u539f\u70b9"
