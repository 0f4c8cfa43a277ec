"""Places on the way of a move where outputs are to be set."""

from __future__ import annotations

import pytest

from assistant.checks import check
from assistant.program.pseudo import parse

PROGRAM = """program p
signal gun digital output 1
target a [400, 0, 400] [0, 0, 1, 0]
target b [400, 100, 400] [0, 0, 1, 0]
procedure main
move joint a speed 100 mm/s blend fine
{before}
move {kind} b speed 100 mm/s blend fine {motion} set gun = 1 at {place}
end
"""


def found(place: str, kind: str = "linear", before: str = "", motion: str = "") -> list[str]:
    text = PROGRAM.format(place=place, kind=kind, before=before, motion=motion)
    return [finding.code for finding in check(parse(text))]


@pytest.mark.parametrize(
    ("place", "codes"),
    [
        ("100 mm before end", []),
        ("101 mm before end", ["CK111"]),
        ("100 mm from start", []),
        ("101 mm from start", ["CK111"]),
        ("-1 mm before end", ["CK112"]),
        ("101 %", ["CK112"]),
        ("-1 %", ["CK112"]),
        ("100 %", []),
        ("-0.1 s before end", ["CK112"]),
        ("0.4 s before end", []),
    ],
)
def test_a_place_that_the_way_does_not_reach(place: str, codes: list[str]) -> None:
    assert found(place) == codes


@pytest.mark.parametrize(
    ("before", "known"),
    [
        ("wait 1 s", True),
        ("set gun = 0", True),
        ("# a comment", True),
        ("label here", False),
        ("call main", False),
        ("if 1 < 2\nmove joint b speed 100 mm/s blend fine\nend", False),
        ("opaque rapid | SearchL di1,p,q,v10,tool0;", False),
        ("move absolute joints [0, 0, 0, 0, 0, 0] speed 100 mm/s blend fine", False),
    ],
)
def test_only_a_way_of_known_length_is_judged(before: str, known: bool) -> None:
    assert found("150 mm before end", before=before) == (["CK111"] if known else [])
    assert found("150 mm before end", "joint", before) == []
    assert found("150 mm before end", before=before, motion="frame table") == []
