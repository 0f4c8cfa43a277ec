"""What a call changes among what its statement reads, and data that go by two names."""

from __future__ import annotations

import pytest

from assistant import languages
from tests.tables import every_row

from .test_lower import program, written
from .test_procedures import NUMBERS

COUNTED = " FUNC num counted(num k)\n  n:=n+1;\n  RETURN k;\n ENDFUNC\n"
TAKEN = " FUNC num taken(INOUT num k)\n  k:=k-1;\n  RETURN 1;\n ENDFUNC\n"


@every_row("name", ["melfa-basic-4", "melfa-basic-5"])
@every_row(
    ("line", "said"),
    [
        ("m:=n+counted(1);", False),
        ("m:=counted(n)+n;", True),
        ("m:=counted(n)+n+counted(1);", False),
        ("m:=counted(counted(n));", True),
        ("m:=m+counted(1);", True),
        ("IF n>1 THEN m:=1; ELSEIF counted(1)>0 THEN m:=2; ENDIF", True),
        ("IF m>1 THEN m:=1; ELSEIF n+counted(1)>0 THEN m:=2; ENDIF", False),
        ("m:=taken(n)+n;", True),
        ("m:=n+taken(n);", False),
        ("m:=m+taken(n)+n;", True),
        ("WaitUntil counted(1)>n;", True),
        ("WaitUntil n<counted(1);", False),
        ("WaitUntil taken(m)>1;", True),
        ("WaitUntil taken(m)>1\\MaxTime:=2;", False),
    ],
)
def test_calls_in_front_do_not_change_what_is_read(name: str, line: str, said: bool) -> None:
    source = program(line, COUNTED + TAKEN, NUMBERS)
    codes = {f.code for f in languages.get(name).adapt(source).findings}
    assert ("MB209" not in codes) == said


ALIASES = {
    "a number": ("bump n;", "*BUMP\nMN=MN+30\nMM=MN\nRETURN"),
    "a routine that it calls": ("far n;", "*FAR\nMN=MN+1\nGOSUB *SHOW\nRETURN"),
    "an argument that is handed on": ("hand n;", "*HAND\nGOSUB *BUMP\nMM=MN\nRETURN"),
    "one variable twice": ("both m,m;", "MM=MM+1\nMM=MM*2\nRETURN"),
    "one of its own twice": ("mine;", "MINEOWN=MINEOWN+1\nMINEOWN=MINEOWN*2\nRETURN"),
    "an element": ("el a{2};", "*EL\nMA(2)=MA(2)+1\nMM=MA(2)\nRETURN"),
    "an element by a variable": ("el a{n};", "MELQINDEX1=MN\nGOSUB *EL\n"),
    "an index that it changes": (
        "pace c{n};",
        "MPACEQINDEX1=MN\nMPACEQ=MC(MPACEQINDEX1)\nGOSUB *PACE\nMC(MPACEQINDEX1)=MPACEQ\n",
    ),
    "a function": ("m:=f(n);", "*F\nMN=MN+1\nMFRESULT=MN+MN\nRETURN"),
    "several variables": (
        "both n,m;\nboth m,m;", "GOSUB *BOTH\nMN=MBOTHA\nMM=MB\nGOSUB *BOTH2\n"
    ),
    "another name inside": ("hide n;", "*HIDE\nMHIDEN=7\nMN=MHIDEN\nMM=MN\nGOSUB *SHOW\nRETURN"),
}  # fmt: skip
ROUTINES = """\
 PROC bump(INOUT num q)
  q:=q+30;
  m:=n;
 ENDPROC
 PROC far(INOUT num q)
  q:=q+1;
  show;
 ENDPROC
 PROC show()
  m:=n;
 ENDPROC
 PROC hand(INOUT num q)
  bump q;
  m:=q;
 ENDPROC
 PROC both(INOUT num a,INOUT num b)
  a:=a+1;
  b:=b*2;
 ENDPROC
 PROC mine()
  VAR num own:=3;
  both own,own;
  m:=own;
 ENDPROC
 PROC el(INOUT num q)
  q:=q+1;
  m:=a{2};
 ENDPROC
 PROC pace(INOUT num q)
  n:=2;
  q:=5;
 ENDPROC
 FUNC num f(INOUT num q)
  q:=q+1;
  RETURN n+q;
 ENDFUNC
 PROC hide(INOUT num q)
  VAR num n:=7;
  q:=n;
  m:=q;
  show;
 ENDPROC
"""


@pytest.mark.parametrize("what", ALIASES)
def test_a_variable_that_goes_by_two_names_is_worked_on_itself(what: str) -> None:
    line, expected = ALIASES[what]
    arrays = " VAR num a{4}:=[1,2,3,4];\n VAR num c{4}:=[1,2,3,4];\n"
    source = program(line, ROUTINES, NUMBERS + arrays)
    assert expected in written(source, "melfa-basic-5").upper()


FUNCTIONS = """\
 FUNC num inner(num k)
  RETURN k*2;
 ENDFUNC
 FUNC num outer(num k)
  RETURN inner(k)+1;
 ENDFUNC
"""


def test_a_result_is_kept_while_a_function_is_called_inside_another() -> None:
    text = written(program("n:=inner(1)+outer(2);", FUNCTIONS, NUMBERS), "melfa-basic-5").upper()
    assert "GOSUB *INNER\nMINNERRESULT1=MINNERRESULT\nMOUTERK=2\nGOSUB *OUTER\n" in text
    assert "MN=MINNERRESULT1+MOUTERRESULT" in text


@pytest.mark.parametrize("cases", ["1", "1,2"])
def test_in_six_a_function_is_called_once_for_all_cases(cases: str) -> None:
    source = program(f"TEST counted(1)\nCASE {cases}:\n m:=1;\nENDTEST", COUNTED, NUMBERS)
    codes = {f.code for f in languages.get("melfa-basic-6").adapt(source).findings}
    assert "MB209" not in codes
    assert written(source, "melfa-basic-6").upper().count("=COUNTED(1)") <= 1


ACTING = """\
 FUNC num acting()
  SetDO glue,1;
  WaitDI ok,1;
  n:=n+1;
  MoveL seat,v100,fine,tool0;
  RETURN n;
 ENDFUNC
"""
ORDERS = {
    "n:=DOutput(glue)+acting();": (True, False),
    "n:=acting()+DOutput(glue);": (False, False),
    "n:=DInput(ok)+acting();": (True, False),
    "n:=ClkRead(c)+acting();": (True, False),
    r"p:=Offs(CRobT(\Tool:=tool0\WObj:=wobj0),acting(),0,0);": (True, False),
    "a{acting()}:=acting();": (False, True),
    "a{n}:=acting();": (True, True),
    "a{acting()}:=n;": (False, True),
    "a{2}:=acting();": (False, False),
    "a{acting()}:=3;": (False, False),
}
"""Whether it cannot be said with calls in front of the statement, and whether as it stands."""


@pytest.mark.parametrize("line", ORDERS)
def test_a_call_keeps_its_place_among_what_is_read(line: str) -> None:
    data = NUMBERS + " VAR clock c;\n VAR num a{4};\n VAR robtarget p;\n"
    source = program(f"ClkReset c;\nClkStart c;\n{line}", ACTING, data)
    for dialect, refused in zip(("melfa-basic-5", "melfa-basic-6"), ORDERS[line], strict=True):
        found = languages.get(dialect).adapt(source).findings
        texts = [f.message for f in found if f.code == "MB209"]
        assert bool(texts) == refused, (dialect, texts)


def test_a_result_that_is_kept_takes_no_name_of_the_program() -> None:
    data = NUMBERS + " VAR num inner_result_1:=100;\n"
    text = written(
        program("n:=inner(1)+inner(2)+inner_result_1;", FUNCTIONS, data), "melfa-basic-5"
    )
    assert "MN=MINNERRESULT12+MINNERRESULT2+MINNERRESULT1" in text.upper()
