"""Waits and branches that are written with jumps, and other jumps that lead into them."""

from __future__ import annotations

import pytest

import assistant
from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from assistant.program import statements as p

from .lifting import lifted

WAIT = "*W2\nIf M_In(1)=1 Or M_In(2)=1 Then *W2Z Else *W2\n*W2Z\nMvs P1\n"
JUMPING = "If M1>0 Then *I1T1 Else *I1N1\n*I1T1\nM2=1\nGoTo *I1Z\n*I1N1\nM2=2\n*I1Z\n"
TIMED = "M_Timer(1)=0\n*W1\nIf M_In(1)=1 Then *W1Z\nIf M_Timer(1)<500 Then *W1\nError 9100\n*W1Z\n"


@pytest.mark.parametrize(
    ("lines", "kind", "jump"),
    [
        (WAIT, p.WaitUntil, "If M1=1 Then *W2\n"),
        (WAIT, p.WaitUntil, "If M1=1 Then *W2Z\n"),
        (WAIT, p.WaitUntil, "On M1 GoTo *W2Z\n"),
        (TIMED, p.WaitSignal, "If M1=1 Then *W1\n"),
        (TIMED, p.WaitSignal, "If M1=1 Then *W1Z\n"),
        (JUMPING, p.If, "GoTo *I1T1\n"),
        (JUMPING, p.If, "GoTo *I1N1\n"),
        (JUMPING, p.If, "GoTo *I1Z\n"),
    ],
)
def test_jumps_that_others_lead_into_keep_their_labels(
    lines: str, kind: type[p.Statement], jump: str
) -> None:
    alone, entered = lifted(f"{lines}End\n"), lifted(f"{lines}{jump}End\n")
    assert not [node for node in alone.statements() if isinstance(node, p.Label)]
    assert [node for node in alone.statements() if isinstance(node, kind)]
    labels = {node.name for node in entered.statements() if isinstance(node, p.Label)}
    gone = {node.label for node in entered.statements() if isinstance(node, p.Goto)} - labels
    assert labels
    assert not gone


def test_a_call_of_the_lines_after_a_wait_copies_them_into_a_subroutine() -> None:
    first = "*W9\nIf M_In(3)=1 Or M_In(4)=1 Then *W9Z Else *W9\n*W9Z\n"
    lines = first + WAIT.replace("W2", "W1") + "GoSub *W1Z\nEnd\n"
    loaded = load_text(SourceText(lines.upper(), "WORK.prg"), language="melfa-basic-4")
    translation = assistant.translate(loaded, to="melfa-basic-4")
    assert "MB138" in {finding.code for finding in translation.findings}  # it calls itself
    (data,) = translation.files.values()
    text = "".join(line.partition(" ")[2] + "\n" for line in data.decode().splitlines())
    before, label, after = text.partition("*LW1Z\n")
    assert label
    assert before.count("MVS P1") == after.count("MVS P1") == 1
    assert after.count("GOSUB *LW1Z") == 1


@pytest.mark.parametrize(
    ("condition", "said"),
    [("M_IN(1)=1", True), ("M1=-2", True), ("M_IN(1)=M2", False), ("M_IN(1)>0", False)],
)
def test_the_first_version_waits_for_constants(condition: str, said: bool) -> None:
    language = languages.get("melfa-basic-4")
    found = language.check([language.parse(f"10 M2=1\n20 WAIT {condition}\n30 END\n")])
    assert ("MB111" not in {finding.code for finding in found}) == said
