"""Elements that positions leave out: an error where the controller takes them as a pose."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler import translate
from assistant.compiler.loader import load_text
from assistant.virtual import melfa
from tests.tables import every_row

DATA = """
P1=(+310.00,+20.00,+400.00)
P2=(+330.00,+0.00,+420.00,+180.00,,+180.00)(7,0)
P3=(+350.00,-10.00,+410.00,+180.00,+0.00,+180.00)(7,0)
P4=(+350.00,-10.00,+410.00,,,+180.00)(4,0)
"""
WRONG = {
    "a target": ("Mvs P1",),
    "a gap": ("Mvs P2,-20",),
    "an arc": ("Mvs P3", "Mvr P3,P1,P2"),
    "a constant": ("Mov (300,10,400)",),
    "a tool": ("Tool (0,0,90)", "Mvs P3"),
    "a base": ("Base (0,0,90,0)",),
    "a product": ("P9=P3*(0,0,40)", "Mvs P9"),
    "an inverse": ("P9=Inv(P1)*P3", "Mvs P9"),
    "a copy": ("P9=P1", "P8=P9", "Mvs P8"),
    "assigned": ("P9=(300,10,400)", "Mvs P9"),
    "in one line": ("If M_In(3)=1 Then Mvs P1",),
    "an array": ("Dim PA(2)", "PA(1)=(300,10,400)", "Mvs PA(1)"),
    "a long run": ("Mvs P3", *(f"Mvs P{1 + k % 3}" for k in range(12))),
}
FINE = {
    "read": ("P9=P3", "P9.X=P1.X", "Mvs P9"),
    "filled in": ("P1.A=P3.A", "P1.B=P3.B", "P1.C=P3.C", "Mvs P1"),
    "of four axes": ("Mvs P4",),
    "whole": ("Mvs P3", "Mvs P3*(0,0,40,0,0,0)"),
}


def text_of(lines: tuple[str, ...]) -> str:
    return "\n".join(f"{at} {line}" for at, line in enumerate((*lines, "End"), 1)) + DATA


def errors(text: str) -> list[str]:
    language = languages.get("melfa-basic-5")
    found = language.check([language.parse(text)])
    return [one.code for one in found if one.code == "MB622"]


@every_row("name", list(WRONG))
def test_it_is_an_error_and_not_translated(name: str) -> None:
    text = text_of(WRONG[name])
    assert errors(text)
    made = translate(load_text(SourceText(text), language="melfa-basic-5"), to="rapid")
    assert not made.ok
    assert "MB622" in {one.code for one in made.findings}


def test_the_interpreter_stops_with_the_same_error() -> None:
    tree = languages.get("melfa-basic-5").parse(text_of(WRONG["a target"]))
    done = melfa.run(tree)
    assert done.ended == "error"
    assert "2800" in done.message


@pytest.mark.parametrize("name", FINE)
def test_what_has_its_values_is_none(name: str) -> None:
    assert errors(text_of(FINE[name])) == []


def test_a_sum_counts_them_as_nothing_and_says_so() -> None:
    text = text_of(("Mvs P3+(0,0,25)",))
    assert errors(text) == []
    made = translate(load_text(SourceText(text), language="melfa-basic-5"), to="rapid")
    assert made.ok
    assert "MB293" in {one.code for one in made.findings}
