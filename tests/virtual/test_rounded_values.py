"""Whole numbers of MELFA-BASIC: what comes into their variables is rounded, in RAPID as well."""

from __future__ import annotations

from pathlib import Path

import pytest

import assistant
from assistant import Proving
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load, load_text
from assistant.virtual.events import Waited
from tests.virtual.test_translated_melfa import run_rapid

WAYS = {
    "an assignment": ("M4%=2.6\nDly M4%\nEnd\n", [3.0]),
    "an element": ("Dim M4%(2)\nM4%(2)=1.6\nDly M4%(2)\nEnd\n", [2.0]),
    "the first value of a loop": ("For M4%=0.6 To 2.4\nDly M4%\nNext M4%\nEnd\n", [1.0, 2.0]),
    "a loop of other numbers": ("For M4=0.6 To 2.4\nDly M4\nNext M4\nEnd\n", [0.6, 1.6]),
    "a parameter": ("Put(2.6)\nEnd\nFunction V Put(ByVal M7%)\nDly M7%\nFEnd\n", [3.0]),
    "a result": (
        "M3=Half(5.4)\nDly M3\nEnd\nFunction M% Half(ByVal M8)\nHalf=M8/2\nFEnd\n",
        [3.0],
    ),
    "what a function gives back": (
        "Def Inte MX\nMX=1\nFill(MX)\nDly MX\nEnd\nFunction V Fill(ByRef M8)\nM8=2.6\nFEnd\n",
        None,
    ),
}
"""Programs, and the seconds of their delays, worked out by hand; None if nothing tells them."""


@pytest.mark.parametrize("name", WAYS)
def test_each_way_into_a_whole_number_rounds(name: str) -> None:
    text, delays = WAYS[name]
    loaded = load_text(SourceText(text), language="melfa-basic-6")
    done = assistant.translate(loaded, to="rapid", proving=Proving())
    if delays is None and not done.ok:  # where it is said, it is said right
        return
    assert done.ok and done.motion is not None and done.motion.holds, done.findings
    (data,) = done.files.values()
    run = run_rapid(None, data.decode(), {}, 10_000)
    waited = [event.seconds for event in run.events if isinstance(event, Waited)]
    assert delays is None or waited == pytest.approx(delays)


def test_what_a_called_program_is_given_is_rounded(tmp_path: Path) -> None:
    (tmp_path / "MAIN.mb5").write_text('M1=2\nCallP "SUBA",M1*3+0.6\nEnd\n')
    (tmp_path / "SUBA.mb5").write_text("FPrm M9%\nIf M9%=7 Then M_Out(3)=1\nDly M9%\nEnd\n")
    loaded = load(tmp_path / "MAIN.mb5")
    done = assistant.translate(loaded, to="rapid", proving=Proving())
    assert done.motion is not None and done.motion.holds, done.findings
    assert done.motion.found is not None and done.motion.found.changes


def test_whole_numbers_are_not_rounded_once_more() -> None:
    text = "For M4%=1 To 3\nPut(M4%+1)\nNext M4%\nEnd\nFunction V Put(ByVal M7%)\nDly M7%\nFEnd\n"
    loaded = load_text(SourceText(text), language="melfa-basic-6")
    (data,) = assistant.translate(loaded, to="rapid").files.values()
    assert b"Round" not in data


def test_parts_of_a_whole_number_are_not_counted() -> None:
    text = "For M4%=1 To 3 Step 0.5\nDly M4%\nNext M4%\nEnd\n"
    done = assistant.translate(load_text(SourceText(text), language="melfa-basic-5"), to="rapid")
    assert not done.ok and "counts by what is no whole number" in str(done.findings)
