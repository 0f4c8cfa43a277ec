"""Texts and names in the letters of ASCII."""

from __future__ import annotations

import pytest

from assistant.base.source_text import in_ascii, plain_letters
from assistant.program.program import identifier


@pytest.mark.parametrize(
    ("text", "comment"),
    [
        ("Außenkontur", "Aussenkontur"),
        ("Слой: внешний контур", "Sloy: vneshniy kontur"),
        ("Ø 12 mm", "dia. 12 mm"),
        ("4xØ6, ⌀8, φ10", "4xdia. 6, dia. 8, dia. 10"),
        ("HØJDE", "HOEJDE"),
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


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ("Ø6.6", "D6_6"),
        ("⌀ 6,6", "D6_6"),
        ("Bohrung ø12", "Bohrung_D12"),
        ("Bohrung %%C12", "Bohrung_D12"),
        ("∅9 φ8", "D9_D8"),
        ("M4xØ6", "M4xD6"),
        ("50%%cut", "n_50_cut"),
        ("Sølv 3", "Soelv_3"),
    ],
)
def test_a_sign_of_a_diameter_in_a_name_is_a_letter_before_the_number(
    given: str, name: str
) -> None:
    assert identifier(given) == name
