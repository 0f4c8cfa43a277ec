"""Variables that a program of MELFA-BASIC reads and gives no value: others begin with one."""

from __future__ import annotations

import pytest

import assistant
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text

TARGETS = "P1=(+354.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)\n"


def told(body: str, to: str = "rapid") -> list[tuple[str, str, str]]:
    """Codes of such findings, with the line and the level of the row that they stand at."""
    lines = [f"{n} {line}" for n, line in enumerate(["Spd 100", *body.split("/"), "End"], 1)]
    text = SourceText("\n".join(lines) + "\n" + TARGETS)
    rows = assistant.translate(load_text(text, language="melfa-basic-5"), to=to).rows
    codes = ("MB251", "MB252")
    return [(f.code, r.text, r.level) for r in rows for f in r.reasons if f.code in codes]


@pytest.mark.parametrize(
    ("body", "found"),
    [
        ("If M1=0 Then M2=1", [("MB251", "2 If M1=0 Then M2=1", "partial")]),
        ("GoSub *S/Mvs P1/End/*S/M1=M1+1/Return", [("MB251", "6 M1=M1+1", "partial")]),
        ("Mov J9", [("MB252", "2 Mov J9", "not")]),
        ("M1=0/If M1=0 Then M2=1", []),
        ("For M1=1 To 2/M2=M1/Next M1/M2=M1", []),
        ("GoSub *S/M2=M1/End/*S/M1=1/Return", []),
    ],
)
def test_it_is_told_where_it_is_read(body: str, found: list[tuple[str, str, str]]) -> None:
    assert told(body) == found
    assert told(body, "melfa-basic-6") == []
