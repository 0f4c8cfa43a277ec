"""Errors of RAPID and their handlers: tests say the same where the errors are said at all."""

from __future__ import annotations

from pathlib import Path as FilePath

import pytest

from tests.virtual.test_told_rapid import SIX, written
from tests.virtual.test_translated_cases import HEAD
from tests.virtual.test_translated_rapid import says_the_same

CASES = {
    "a wait that is tried again, and then given up": r"""VAR num n;
WaitDI di1,1\MaxTime:=2;
SetDO doDone,1;
ERROR
IF ERRNO=ERR_WAIT_MAXTIME THEN
  n:=n+1;
  SetGO goSlot,n;
  IF n<3 RETRY;
  TRYNEXT;
ENDIF""",
    "a handler goes back": r"""SetDO do1,1;
there;
SetDO do1,0;
ENDPROC
PROC there()
WaitUntil di1=1\MaxTime:=2;
SetDO doDone,1;
ERROR
  SetDO doGrip,1;
  RETURN;""",
    "errors of its own go up through a loop": r"""VAR num n;
BookErrNo ERR_HOME;
SetDO do1,1;
work;
SetDO do1,0;
ERROR
TEST ERRNO
CASE ERR_WAIT_MAXTIME:
  SetDO doGrip,1;
  TRYNEXT;
CASE ERR_HOME:
  SetDO doVacuum,1;
  RETURN;
ENDTEST
ENDPROC
PROC work()
FOR i FROM 1 TO 3 DO
  inner i;
ENDFOR
ENDPROC
PROC inner(num i)
IF i=2 AND di1=1 RAISE ERR_HOME;
SetGO goSlot,i;
WaitDI di1,1\MaxTime:=2;
ERROR
IF ERRNO=ERR_HOME SetGO goSlot,9;
RAISE;""",
    "a call is tried again": r"""BookErrNo ERR_HOME;
work;
SetDO doDone,1;
ERROR
IF ERRNO=ERR_HOME THEN
  IF nTry<2 RETRY;
  SetDO doGrip,1;
  TRYNEXT;
ENDIF
ENDPROC
PROC work()
nTry:=nTry+1;
SetGO goSlot,nTry;
IF giOrder<>5 RAISE ERR_HOME;
SetDO do1,1;""",
    "the end of a cycle from within": r"""SetDO do1,1;
sub;
SetDO doDone,1;
ENDPROC
PROC sub()
IF giOrder=5 inner;
SetDO doGrip,1;
ENDPROC
PROC inner()
ExitCycle;
SetDO doVacuum,1;""",
    "what nobody steps back through": r"""SetDO do1,1;
UNDO
SetDO do1,0;""",
}
SCENARIOS: tuple[dict[str, float], ...] = (
    {"di1": 0.0, "giorder": 0.0},
    {"di1": 1.0, "giorder": 0.0},
    {"di1": 1.0, "giorder": 5.0},
)
DATA = "VAR num ERR_HOME:=-1;\nVAR num nTry;\n"


@pytest.mark.parametrize("name", CASES)
def test_it_does_the_same(name: str, tmp_path: FilePath) -> None:
    text = f"{HEAD}{DATA}PROC main()\n{CASES[name]}\nENDPROC\nENDMODULE\n"
    says_the_same((name, text, SCENARIOS), SIX, tmp_path)


@pytest.mark.parametrize(
    ("body", "codes"),
    [
        ("WaitDI di1,1\\MaxTime:=2;\nERROR\nRETRY;", {"RA315"}),
        ('MoveL p10,v100,fine,tGripper;\nERROR\nTPWrite ""\\Num:=ERRNO;\nRETRY;', {"RA315"}),
        ("RAISE ERR_HOME;", {"RA316"}),
        ("SetDO do1,1;\nUNDO\nSetDO do1,0;", {"RA311"}),
    ],
)
def test_what_is_not_handled_is_told(body: str, codes: set[str], tmp_path: FilePath) -> None:
    text, found = written(body, tmp_path)
    assert text
    assert codes <= set(found)


def test_a_statement_is_tried_again_four_times(tmp_path: FilePath) -> None:
    text, _ = written("WaitDI di1,1\\MaxTime:=2;\nERROR\nRETRY;", tmp_path)
    assert "IF MRETRIES>=4 THEN" in text.upper()


def test_an_error_nobody_is_for_stops_the_program_as_before(tmp_path: FilePath) -> None:
    text, _ = written("WaitDI di1,1\\MaxTime:=2;\nERROR (ERR_HOME)\nRETRY;", tmp_path)
    assert "Error 9100" in text
