"""The branches of a program, and which of them a run takes."""

from __future__ import annotations

from collections import Counter

import pytest

from assistant import languages
from assistant.virtual import melfa
from assistant.virtual.events import Branches, BranchKey
from assistant.virtual.kernel import Board, Kernel, Signals
from assistant.virtual.melfa.code import branches as melfa_branches
from assistant.virtual.rapid.interpreter import start_task
from assistant.virtual.rapid.statements import branches as rapid_branches
from tests.virtual import random_melfa, random_rapid
from tests.virtual.translating import START

RAPID = """MODULE M
VAR num n:=2;
PROC main()
  FOR i FROM 1 TO n STEP 1 DO
    IF i=1 THEN
      WaitTime 1;
    ELSEIF i=5 THEN
      Stop;
    ENDIF
    IF DInput(di1)=1 WaitTime 2;
  ENDFOR
  WHILE TRUE DO
    TEST n
    CASE 1:
      EXIT;
    CASE 2,3:
      n:=1;
    ENDTEST
  ENDWHILE
ENDPROC
ENDMODULE
"""
MELFA = """M1=2
For M2=1 To M1
If M2=1 Then
Dly 1
ElseIf M2=5 Then
Hlt
EndIf
If M_In(1)=1 Then Dly 2
Next M2
*L
Select M1
Case 1
M1=7
Break
Case 2
M1=1
Break
End Select
On M1 GoTo *L,*L
End
"""
WAYS = {
    "rapid": """
        4 FOR entered: 1, 4 FOR passed: 0, 5 IF met: 1, 5 ELSEIF met: 0, 5 IF not met: 1,
        10 IF met: 0, 10 IF not met: 2, 13 CASE 1: 1, 13 CASE 2: 1, 13 no CASE: 0""",
    "melfa": """
        3 If met: 1, 3 ElseIf met: 0, 3 If not met: 1, 8 If met: 0, 8 If not met: 2,
        2 For entered: 1, 2 For passed: 0, 11 Case 1: 1, 11 Case 2: 1, 11 no Case: 0,
        19 GoTo 1: 1, 19 GoTo 2: 0, 19 no GoTo: 1""",
}


def taken(
    language: str, text: str, inputs: dict[str, float]
) -> tuple[Counter[BranchKey], Branches]:
    """How often each way was gone, and those that there are."""
    counted: Counter[BranchKey] = Counter()
    kernel = Kernel(Board(Signals(inputs)), most_steps=20_000)
    kernel.branch = lambda *way: counted.update([way])
    tree = languages.get(language).parse(text)
    if language == "rapid":
        start_task(kernel, (tree,), start=START)
        kernel.run()
        return counted, rapid_branches((tree,))
    melfa.start_slot(kernel, (tree,), start=START)
    kernel.run()
    return counted, melfa_branches((tree,))


@pytest.mark.parametrize(
    ("language", "text"), [("rapid", RAPID), ("melfa", MELFA)], ids=["rapid", "melfa"]
)
def test_the_ways_of_a_program_and_how_often_they_are_gone(language: str, text: str) -> None:
    counted, known = taken(language if language == "rapid" else "melfa-basic-5", text, {})
    told = [f"{one.line} {one.said}: {counted[way]}" for way, one in known.items()]
    assert sorted(told) == sorted(" ".join(WAYS[language].split()).split(", "))


def test_no_run_goes_a_way_that_is_not_there() -> None:
    """A statement whose ways are known goes one of them; others have a constant as condition."""
    ways = 0
    for seed in range(8):
        drawn = random_rapid.program(seed)
        texts = [("rapid", drawn.text, drawn.scenarios[1])]
        texts += [
            (f"melfa-basic-{level}", random_melfa.program(level, seed), {"1": 1.0, "8": 1.0})
            for level in (4, 6)
        ]
        for language, text, inputs in texts:
            counted, known = taken(language, text, inputs)
            decisions = {(file, at) for file, at, _ in known}
            assert [way for way in counted if way[:2] in decisions and way not in known] == []
            ways += len(counted.keys() & known.keys())
    assert ways > 50
