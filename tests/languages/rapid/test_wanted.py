"""What modules use and none of them declares, with what their uses tell of it."""

from __future__ import annotations

import pytest

from assistant.languages import get
from assistant.program.program import Signal
from assistant.program.undeclared_names import Wanted
from tests.tables import every_row


def wanted(*bodies: str) -> dict[str, Wanted]:
    rapid = get("rapid")
    texts = [f"MODULE m{at}\n{body}\nENDMODULE\n" for at, body in enumerate(bodies)]
    return {one.name: one for one in rapid.wanted([rapid.parse(text) for text in texts])}


@every_row(
    ("statement", "kind", "type"),
    [
        ("MoveJ p, v100, fine, x;", "tool", "tooldata"),
        ("MoveAbsJ x, v100, fine, tool0;", "joints", "jointtarget"),
        ("MoveJ Offs(x,0,0,1), v100, fine, tool0;", "position", "robtarget"),
        ("n:=x.pos.z; n:=x.tframe.trans.x;", "tool", "tooldata"),
        ("n:=x.trans.z;", "position", "robtarget"),
        ("n:=x.q1;", "data", "orient"),
        ("p:=x;", "position", "robtarget"),
        ("n:=x+1;", "data", "num"),
        ("x:=x+1;", "data", "num"),
        ("WHILE x DO ENDWHILE", "data", "bool"),
        ('TPWrite x+"a";', "data", "string"),
        ("IF x=1 n:=1;", "signal", "signaldi"),
        ("IF x=high n:=1;", "signal", "signaldi"),
        ("TEST x CASE 0: n:=1; CASE 1: n:=2; ENDTEST", "signal", "signaldi"),
        ("TEST x CASE 1: n:=1; CASE 2: n:=2; ENDTEST", "data", "num"),
        ("IF x>5 n:=1;", "data", "num"),
        ("WaitTime x;", "data", "num"),
        ("IF doX=1 n:=1;", "signal", ""),
        ("SetGO x, 3;", "signal", "signalgo"),
        ("IF x=n+1 x:=1;", "data", "num"),
        ("x:=dIn;", "data", "num"),
        ("IF x=TRUE n:=1;", "data", "bool"),
        ("p:=CRobT(\\Tool:=x);", "tool", "tooldata"),
        ("x:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];", "data", "robtarget"),
        ("x:=[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]];", "data", "jointtarget"),
        ("x:=[[1,2,3],[1,0,0,0]];", "data", "pose"),
        ("ClkStart x;", "data", "clock"),
        ("own x;", "data", "string"),
        ('TEST x CASE "a": n:=1; ENDTEST', "data", "string"),
    ],
)
def test_the_type_is_that_which_the_uses_want(statement: str, kind: str, type: str) -> None:
    body = (
        f"VAR num n;\nVAR robtarget p;\nVAR signaldi dIn;\nPROC main()\n{statement}\nENDPROC\n"
        "PROC own(string text)\nENDPROC"
    )
    (found,) = (one for name, one in wanted(body).items() if name in ("x", "doX"))
    assert found.kind == kind
    assert not type or found.type == type


@pytest.mark.parametrize(
    "statement",
    [
        "MoveJ p10, v100, z50, tool0\\WObj:=wobj0;",
        "answer:=resYes;",
        "own n;",
        "FOR i FROM 1 TO 3 DO n:=i; ENDFOR",
        "SetDO hand, high;",
    ],
)
def test_what_is_declared_or_predefined_is_not_wanted(statement: str) -> None:
    declared = (
        "CONST robtarget p10:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
        "VAR num n;VAR num answer;VAR signaldo hand;"
    )
    assert not wanted(f"PROC main()\n{statement}\nENDPROC", f"{declared}PROC own(num a)\nENDPROC")


@every_row(
    ("statement", "kind", "perhaps"),
    [
        ("WaitDI x,1;", "signal", None),
        ("x:=x+1;", "data", None),
        ("WHILE x DO ENDWHILE", "data", None),
        ("IF x=1 n:=1;", "signal", "data"),
        ("n:=x;", "data", "signal"),
        ("IF x=n n:=1;", "data", "signal"),
        ("IF diX=1 n:=1;", "signal", None),
        ("IF diX=2 n:=1;", "signal", "data"),
        ("IF giX=2 n:=1;", "signal", None),
        ("n:=giX;", "signal", "data"),
        ("giX:=n;", "data", None),
    ],
)
def test_a_kind_that_the_uses_leave_open_is_doubtful(
    statement: str, kind: str, perhaps: str | None
) -> None:
    found = wanted(f"VAR num n;\nPROC main()\n{statement}\nENDPROC")
    (one,) = (one for name, one in found.items() if name in ("x", "diX", "giX"))
    assert (one.kind, one.perhaps) == (kind, perhaps)


@every_row(
    ("statements", "type", "perhaps"),
    [
        ('x:=y; y:="s";', "string", None),
        ("y:=x; x:=TRUE;", "bool", None),
        ("y:=z; x:=y; z:=CRobT();", "robtarget", None),
        ("IF x=y n:=1; y:=n>1;", "bool", None),
        ("x:=y+z; z:=StrPart(y,1,1);", "string", None),
        ("x:=y; SetDO y,1;", "num", None),
        ("x:=y; y:=z;", "num", "type"),
        ("x:=[1,2,3];", "num", "type"),
        ("x:=[TRUE,FALSE];", "num", "type"),
    ],
)
def test_names_tell_the_types_of_those_that_they_are_assigned_to(
    statements: str, type: str, perhaps: str | None
) -> None:
    found = wanted(f"VAR num n;\nPROC main()\n{statements}\nENDPROC")["x"]
    assert (found.type, found.perhaps) == (type, perhaps)


def test_data_local_to_another_module_are_wanted() -> None:
    found = wanted("PROC main()\nn:=n+1;\nENDPROC", "LOCAL VAR num n;")
    assert found["n"].type == "num"


def test_calls_tell_the_parameters_of_a_routine() -> None:
    found = wanted('PROC main()\nrX 1,"a"\\fast;\nrX 2,"b"\\how:=TRUE;\nENDPROC')["rX"]
    assert [(a.type, a.option) for a in found.arguments] == [
        ("num", ""), ("string", ""), ("switch", "fast"), ("bool", "how"),
    ]  # fmt: skip


def test_a_parameter_has_the_type_of_undeclared_data_that_it_is_given() -> None:
    found = wanted('PROC main()\nrX x,y{2};\nx:=FALSE;\ny{3}:="a";\nENDPROC')
    assert [(a.type, a.dimensions) for a in found["rX"].arguments] == [("bool", 0), ("string", 0)]


def test_data_have_the_type_that_other_calls_give_for_the_same_parameter() -> None:
    found = wanted('PROC main()\nrX 1,x;\nrX 2,TRUE;\nrX 3\\how:=y;\nrX 4\\how:="a";\nENDPROC')
    assert found["x"].type == "bool"
    assert found["y"].type == "string"
    assert [a.type for a in found["rX"].arguments] == ["num", "bool", "string"]


def test_a_parameter_has_an_undeclared_type() -> None:
    found = wanted("CONST scan how:=[2];\nPROC main()\nrX how;\nENDPROC")
    assert [a.type for a in found["rX"].arguments] == ["scan"]


def test_an_optional_parameter_that_is_handed_on_has_the_type_of_its_own() -> None:
    found = wanted("PROC own(\\num slow,\\switch now)\nrX\\pace?slow\\at?now;\nENDPROC")
    assert [(a.type, a.option) for a in found["rX"].arguments] == [
        ("num", "pace"), ("switch", "at"),
    ]  # fmt: skip


def test_a_signal_may_be_given_for_its_value() -> None:
    found = wanted("PROC main()\nrX diA;\nrX 1;\nWaitDI diA,1;\nENDPROC")
    assert [a.type for a in found["rX"].arguments] == ["num"]


def test_what_guns_do_comes_from_the_cell_but_for_their_welds() -> None:
    found = wanted("PROC main()\nSpotL p1,v100,gun1,spot1,tool0;\nSetForce gun1,spot1;\nENDPROC")
    assert sorted(found) == ["SetForce", "gun1", "p1", "spot1"]
    assert found["spot1"].type == "spotdata"


def test_routines_of_a_make_of_hand_come_from_the_cell() -> None:
    found = wanted("PROC main()\ng_GripIn;\ng_MoveTo 10;\nSoftAct 1,20;\nENDPROC")
    assert sorted(found) == ["g_GripIn", "g_MoveTo"]
    assert [a.type for a in found["g_MoveTo"].arguments] == ["num"]


def test_signals_are_of_the_kind_and_way_of_their_instruction() -> None:
    found = wanted("PROC main()\nSetAO aoX,1;\nWaitDI diX,1;\nENDPROC")
    assert found["aoX"].signal == Signal("analog", "output")
    assert found["diX"].signal == Signal("digital", "input")
