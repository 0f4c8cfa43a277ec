"""The rules of RAPID that know no signatures: small modules, and where each finding stands."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from assistant import languages
from assistant.base.diagnostics import Rule, Severity
from assistant.base.source_text import SourceText
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks import CHECKS
from tests.tables import every_row

RAPID = languages.get("rapid")
OF_CALLS = ("RA40", "RA41", "RA42", "RA43", "RA44")
"""Families that have tests of their own."""
TARGET = "[[{x},{y},0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


def found(*texts: str, paths: tuple[str, ...] = ()) -> list[tuple[str, int | None]]:
    """Code and line of each finding over modules of one program."""
    given = paths or tuple(f"m{i}.mod" for i in range(len(texts)))
    trees = [RAPID.parse(SourceText(t, p)) for t, p in zip(texts, given, strict=True)]
    assert not [f for tree in trees for f in tree.findings]
    findings = RAPID.check(trees)
    assert all(f.cure for f in findings)
    return sorted((f.code, f.line) for f in findings if f.code[:4] not in OF_CALLS)


def module(text: str, name: str = "m") -> str:
    return f"MODULE {name}\n{text}\nENDMODULE\n"


def routine(text: str, kind: str = "PROC", head: str = "main()") -> str:
    return module(f"{kind} {head}\n{text}\nEND{kind}")


def target(name: str, x: float, y: float, storage: str = "CONST") -> str:
    return f"{storage} robtarget {name}:={TARGET.format(x=x, y=y)};\n"


DECLARATIONS = {
    "two data of one name": ("VAR num a;\nPERS num A;", [("RA201", 3)]),
    "a routine named like data": ("VAR num a;\nPROC a()\nENDPROC", [("RA201", 3)]),
    "a local one beside a global one": (
        "VAR num a;\nLOCAL VAR num a;",
        [("RA201", 3), *[("RA452", 3)]],
    ),
    "two parameters of one name": ("PROC p(num a,VAR num A)\nENDPROC", [("RA201", 2)]),
    "data named like a parameter": (
        "PROC p(num a)\nVAR num a;\na:=1;\nENDPROC",
        [("RA201", 3)],
    ),
    "data of a routine hide others": ("VAR num a;\nPROC p()\nVAR num a;\na:=1;\nENDPROC", []),
    "two components of one name": ("RECORD r\nnum a;\nbool A;\nENDRECORD", [("RA201", 2)]),
    "two labels of one name": (
        "PROC p()\nx:\nWaitTime 1;\nX:\nGOTO x;\nENDPROC",
        [("RA201", 5)],
    ),
    "names of 33": (
        f"RECORD r\nnum {'a' * 33};\nENDRECORD\nVAR num {'b' * 33};",
        [("RA202", 2), ("RA202", 5)],
    ),
    "names of 32": (f"VAR num {'a' * 32};\nPROC {'p' * 32}()\n{'l' * 32}:\nENDPROC", []),
    "a string of 81": (f'CONST string s:="{"x" * 81}";', [("RA203", 2)]),
    "a string of 80 and escapes": (f'CONST string s:="{"x" * 78}""\\0D";', []),
    "a module named like its routine": ("PROC m()\nENDPROC", [("RA214", 1)]),
    "a constant without value": ("CONST num a;", [("RA218", 2)]),
    "a clock with a value": ("VAR clock c:=0;", [("RA219", 2)]),
    "a main with a parameter": ("PROC main(num a)\na:=1;\nENDPROC", [("RA235", 2), ("RA453", 2)]),
    "a world zone with its number": (
        "VAR wzstationary z:=[0];\nVAR wztemporary t{2}:=[[0],[1]];",
        [],
    ),
    "a world zone with a plain number": ("VAR wzstationary z:=0;", [("RA219", 2)]),
    "a world zone with a text": ('VAR wztemporary z:=["a"];', [("RA219", 2)]),
    "bytes with a value": ("VAR rawbytes r:=0;", [("RA219", 2)]),
    "an event that is a record": ('VAR triggios t:=[TRUE,10,FALSE,0,"do1",1,0];', []),
    "a persistent with a name as value": ("PERS num a:=pi;", [("RA207", 2)]),
    "a variable with that of another": ("VAR num a:=1;\nVAR num b:=a+1;", [("RA217", 3)]),
    "a constant of constants": ("CONST num a:=1;\nCONST num b{2}:=[a,2*a+pi];", []),
    "a variable with that of the system": ("VAR num a:=reg1;", [("RA217", 2)]),
    "a variable with the number of an error": ("VAR errnum a:=ERR_WAIT_MAXTIME;", []),
    "a constant by a function": ("CONST num a:=Sqrt(2);", [("RA217", 2)]),
    "a variable with a parameter": (
        "PROC p(num a)\nVAR num b:=a;\nb:=2;\nENDPROC",
        [("RA217", 3)],
    ),
    "a persistent of a routine": ("PROC p()\nPERS num a:=1;\na:=2;\nENDPROC", [("RA220", 3)]),
    "local data of a routine": ("PROC p()\nLOCAL VAR num a;\na:=2;\nENDPROC", [("RA220", 3)]),
    "a constant of the task": ("TASK CONST num a:=1;", [("RA220", 2)]),
    "a required switch": ("PROC p(switch s)\nENDPROC", [("RA220", 2)]),
    "an optional switch": ("PROC p(\\switch s)\nENDPROC", []),
    "four dimensions": ("VAR num a{2,2,2,2};", [("RA221", 2)]),
    "a dimension of zero": ("VAR num a{0};", [("RA221", 2)]),
    "three dimensions": ("VAR num a{2,3,4};", []),
    "an interrupt without trap": (
        "VAR intnum i;\nPROC p()\nCONNECT i WITH p;\nENDPROC",
        [("RA222", 4)],
    ),
    "an interrupt with its trap": (
        "VAR intnum i;\nPROC p()\nCONNECT i WITH t;\nENDPROC\nTRAP t\nENDTRAP",
        [],
    ),
    "an alias of an alias": ("ALIAS num a;\nALIAS a b;", [("RA223", 3)]),
    "a record behind data": ("VAR num a;\nRECORD r\nnum x;\nENDRECORD", [("RA209", 3)]),
    "data behind a routine": ("PROC p()\nENDPROC\nVAR num a;", [("RA209", 4)]),
    "a predefined speed": ("CONST speeddata v100:=[1,2,3,4];", [("RA210", 2)]),
    "the fastest speed": ("CONST speeddata vmax:=[1,2,3,4];", [("RA210", 2)]),
}


@every_row(("text", "expected"), DECLARATIONS)
def test_declarations(text: str, expected: list[tuple[str, int]]) -> None:
    assert found(module(text)) == expected


STATEMENTS = {
    "a constant is assigned to": ("CONST num a:=1;\na:=2;", [("RA215", 4)]),
    "a constant of the system": ("v100.v_tcp:=90;\nreg1:=pi;", [("RA215", 3)]),
    "an element of a constant": ("CONST num a{2}:=[1,2];\na{1}:=2;", [("RA215", 4)]),
    "a loop variable": ("FOR i FROM 1 TO 3 DO\ni:=2;\nENDFOR", [("RA216", 4)]),
    "another loop's variable": (
        "VAR num i;\nFOR j FROM 1 TO 3 DO\nENDFOR\ni:=1;",
        [],
    ),
    "no label": ("GOTO x;", [("RA224", 3)]),
    "a label around a block": ("x:\nIF di1=1 THEN\nGOTO X;\nENDIF", []),
    "a label in a block": ("IF di1=1 THEN\nx:\nENDIF\nGOTO x;", [("RA225", 6)]),
    "a label in another branch": (
        "IF di1=1 THEN\nx:\nELSE\nGOTO x;\nENDIF",
        [("RA225", 6)],
    ),
    "a compact IF": ("x:\nIF di1=1 GOTO x;", []),
    "RETRY in the body": ("RETRY;", [("RA226", 3)]),
    "RAISE in the body": ("RAISE;", [("RA226", 3)]),
    "RAISE with a number": ("RAISE 1;", []),
    "handlers at work": ("WaitTime 1;\nERROR\nIF ERRNO=1 RETRY;\nRAISE;", []),
    "TRYNEXT in UNDO": ("WaitTime 1;\nUNDO\nTRYNEXT;", [("RA226", 5)]),
    "two handlers": ("WaitTime 1;\nERROR\nRAISE;\nERROR\nRAISE;", [("RA228", 6)]),
    "ERROR behind UNDO": ("WaitTime 1;\nUNDO\nTPErase;\nERROR\nRAISE;", [("RA228", 6)]),
    "a value from a procedure": ("RETURN 1;", [("RA229", 3)]),
    "behind RETURN": ("RETURN;\nWaitTime 1;\nWaitTime 2;", [("RA450", 4)]),
    "a label behind GOTO": ("GOTO x;\nx:\nWaitTime 1;", []),
    "a comment behind EXIT": ("EXIT;\n! done", []),
    "behind an endless loop": ("WHILE TRUE DO\nWaitTime 1;\nENDWHILE\nTPErase;", [("RA450", 6)]),
    "behind a loop in parentheses": (
        "WHILE (TRUE) DO\nWaitTime 1;\nENDWHILE\nTPErase;",
        [("RA450", 6)],
    ),
    "behind branches that leave": (
        "IF di1=1 THEN\nRETURN;\nELSE\nEXIT;\nENDIF\nTPErase;",
        [("RA450", 8)],
    ),
    "behind one that stays": ("IF di1=1 THEN\nRETURN;\nELSE\nENDIF\nTPErase;", []),
    "in a block": ("WHILE di1=1 DO\nEXIT;\nTPErase;\nENDWHILE", [("RA450", 5)]),
    "waits": ("WaitDI di1,1;\nWaitUntil di1=1;", [("RA454", 3), ("RA454", 4)]),
    "a wait that only waits for the robot": ("WaitUntil\\InPos,TRUE;", []),
    "waits with an end": ("WaitDI di1,1\\MaxTime:=2;\nWaitTime 3;", []),
    "an output on the fly": ("MoveL p,v100,z10,tool0;\nSetDO do1,1;", [("RA455", 4)]),
    "an output in a branch": (
        "MoveL p,v100,z10,tool0;\nIF di1=1 Set do1;",
        [("RA455", 4)],
    ),
    "an output at the place": ("MoveL p,v100,fine,tool0;\nSetDO do1,1;", []),
    "an output beside a move": ("MoveL\\Conc,p,v100,fine,tool0;\nReset do1;", [("RA455", 4)]),
    "an output after a wait": ("MoveL p,v100,z10,tool0;\nWaitTime\\InPos,1;\nSetDO do1,1;", []),
    "an output after a call": ("MoveL p,v100,z10,tool0;\nmain;\nSetDO do1,1;", []),
    "a zone that is handed over": ("MoveL p,v100,given,tool0;\nSetDO do1,1;", []),
    "a zone of its own": (
        "CONST zonedata soft:=[FALSE,2,2,2,.2,2,.2];\nMoveJ p,v100,soft,tool0;\nSet do1;",
        [("RA455", 5)],
    ),
    "the position on the fly": (
        "VAR robtarget r;\nMoveJ p,v100,z5,tool0;\nr:=CRobT();",
        [("RA456", 5)],
    ),
    "the position in a move": (
        "MoveJ p,v100,z5,tool0;\nMoveL Offs(CRobT(),0,0,9),v100,fine,tool0;",
        [("RA456", 4)],
    ),
    "the position after a wait": (
        "VAR robtarget r;\nMoveJ p,v100,z5,tool0;\nWaitRob\\InPos;\nr:=CRobT();",
        [],
    ),
    "the position at the place": ("VAR robtarget r;\nMoveJ p,v100,fine,tool0;\nr:=CRobT();", []),
    "one CASE twice": ("TEST 1\nCASE 1,2:\nCASE 3,1:\nENDTEST", [("RA457", 5)]),
    "one CASE twice, as other words": (
        "TEST 1\nCASE -1:\nCASE -1:\nCASE 1:\nCASE 1.0:\nCASE pi:\nCASE PI:\nENDTEST",
        [("RA457", 5), ("RA457", 7), ("RA457", 9)],
    ),
    "cases of strings": ('TEST "x"\nCASE "a":\nCASE "A":\nENDTEST', []),
    "a step of zero": ("FOR i FROM 1 TO 3 STEP 0 DO\nENDFOR", [("RA458", 3)]),
    "a step that leads away": ("FOR i FROM 1 TO 3 STEP -1 DO\nENDFOR", [("RA458", 3)]),
    "a step down": ("FOR i FROM 3 TO 1 STEP -1 DO\nENDFOR", []),
    "no zone nor speed": ("MoveL p,v25,z3,tool0;", [("RA204", 3), ("RA205", 3)]),
    "no zone nor speed of other moves": (
        "TriggL p,v25,t,z3,tool0;\nMoveExtJ p,v100,z10;",
        [("RA204", 3), ("RA205", 3)],
    ),
    "idle data": ("VAR num a;\nVAR num b;\nb:=1;", [("RA452", 3)]),
    "data that a string names": ('VAR num speed;\nGetDataVal "speed",other;', []),
}


@every_row(("text", "expected"), STATEMENTS)
def test_statements(text: str, expected: list[tuple[str, int]]) -> None:
    assert found(routine(text)) == expected


FUNCTIONS = {
    "without RETURN": ("TPErase;", [("RA451", 2)]),
    "without a value": ("RETURN;", [("RA229", 3)]),
    "one way without": ("IF a>1 THEN\nRETURN 1;\nENDIF", [("RA451", 2)]),
    "every way with": ("IF a>1 THEN\nRETURN 1;\nELSE\nRETURN 2;\nENDIF", []),
    "cases without DEFAULT": ("TEST a\nCASE 1:\nRETURN 1;\nENDTEST", [("RA451", 2)]),
    "cases with DEFAULT": ("TEST a\nCASE 1:\nRETURN 1;\nDEFAULT:\nRAISE 1;\nENDTEST", []),
    "an endless loop": ("WHILE TRUE DO\nIF a>1 RETURN 1;\nENDWHILE", []),
    "BACKWARD": ("RETURN 1;\nBACKWARD\nTPErase;", [("RA228", 4)]),
    "a parameter is assigned to": ("a:=2;\nRETURN a;", []),
}


@every_row(("text", "expected"), FUNCTIONS)
def test_functions(text: str, expected: list[tuple[str, int]]) -> None:
    assert found(routine(text, "FUNC", "num f(num a)")) == expected


ROTATIONS = {
    "unit length": ("CONST robtarget", "[1,0,0,0]", []),
    "four decimals": ("CONST robtarget", "[0.7071,0.7072,0,0]", [("RA206", Severity.WARNING)]),
    "no rotation": ("CONST robtarget", "[1,0.1,0,0]", [("RA206", Severity.ERROR)]),
    "a place holder": ("CONST robtarget", "[0,0,0,0]", [("RA462", Severity.WARNING)]),
    "a variable to fill in": ("VAR robtarget", "[0,0,0,0]", []),
}


@pytest.mark.parametrize(("head", "rotation", "expected"), ROTATIONS.values(), ids=ROTATIONS)
def test_quaternions(head: str, rotation: str, expected: list[tuple[str, Severity]]) -> None:
    rest = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]"
    tree = RAPID.parse(module(f"{head} a:=[[1,2,3],{rotation},{rest}];"))
    assert [(f.code, f.severity) for f in RAPID.check([tree])] == expected


@pytest.mark.parametrize(
    "data",
    [
        "CONST orient a:=[1,0.1,0,0];",
        "CONST pose a{2}:=[[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0.1,0,0]]];",
        "PERS tooldata a:=[TRUE,[[0,0,0],[1,0.1,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];",
        "PERS tooldata a:=[TRUE,[[0,0,0],[1,0,0,0]],[1,[0,0,1],[1,0.1,0,0],0,0,0]];",
        'PERS wobjdata a:=[FALSE,TRUE,"",[[0,0,0],[1,0.1,0,0]],[[0,0,0],[1,0,0,0]]];',
    ],
)
def test_quaternions_of_other_data(data: str) -> None:
    assert found(module(data)) == [("RA206", 2)]


def test_quaternions_of_own_records() -> None:
    text = "RECORD r\nnum x;\norient o;\nENDRECORD\nPERS r a:=[1,[1,0.1,0,0]];"
    assert found(module(text)) == [("RA206", 6)]


def test_quaternions_of_types_with_two_names() -> None:
    text = "ALIAS orient turn;\nRECORD r\nturn o;\nENDRECORD\nPERS r a:=[[1,0.1,0,0]];"
    assert found(module(text)) == [("RA206", 6)]


def test_quaternions_of_targets_in_moves() -> None:
    move = f"MoveJ {TARGET.format(x=1, y=2)},v100,fine,tool0;\n"
    odd = move.replace("[1,0,0,0]", "[1,0.1,0,0]")
    assert found(routine(move + odd)) == [("RA206", 4)]
    assert found(routine(9 * move + odd + move)) == [("RA206", 12)]


# Long runs


def run(count: int, **odd: str) -> str:
    """Declarations of p1, p2 …; odd: other rotations by name."""
    rest = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]"
    return "".join(
        f"CONST robtarget p{i}:=[[{i},{i * i},0],{odd.get(f'p{i}', '[1,0,0,0]')},{rest}];\n"
        for i in range(1, count + 1)
    )


def test_a_row_of_a_run_is_found_on_its_line() -> None:
    text = module(run(40, p17="[1,0.1,0,0]", p30="[0,0,0,0]"))
    assert found(text) == [("RA206", 18), ("RA462", 31)]


CONFIGURATIONS = {
    "as the robot shows it": ("[-1,3,-4,7]", []),
    "an arm of seven axes": ("[0,0,0,1011]", []),
    "half a quadrant": ("[0,0.5,0,0]", ["RA463"]),
    "unused external axes at the wrong place": ("[9E9,9E9,9E9,9E9]", ["RA463"]),
    "a shape there is not": ("[0,0,0,8]", ["RA464"]),
    "a negative shape": ("[0,0,0,-1]", ["RA464"]),
}


@pytest.mark.parametrize(("stated", "codes"), CONFIGURATIONS.values(), ids=CONFIGURATIONS)
def test_configurations_are_those_of_an_arm(stated: str, codes: list[str]) -> None:
    value = f"[[1,2,3],[1,0,0,0],{stated},[9E9,9E9,9E9,9E9,9E9,9E9]]"
    assert found(module(f"CONST robtarget a:={value};")) == [(code, 2) for code in codes]
    several = "".join(f"CONST robtarget p{k}:={value};\n" for k in range(9))
    assert found(module(several)) == [(code, line) for code in codes for line in range(2, 11)]
    written = found(routine(f"TPErase;\nMoveJ {value},v20,fine,tool0;"))
    assert written == [(code, 4) for code in codes]
    listed = module(f"CONST robtarget a{{2}}:=[{value},\n{value}];")
    assert found(listed) == [(code, line) for line in (2, 3) for code in codes]


def test_names_of_runs_are_declared_once() -> None:
    one, other = module(run(20), "one"), module(target("P7", 1, 2), "other")
    assert found(one, other) == [("RA201", 2)]
    assert found(other, one) == [("RA201", 8)]
    again = [("RA201", line) for line in range(2, 11)]
    assert found(one, module(run(9), "other")) == again
    twice = run(20).replace("p19:", "p3:")
    assert found(module(twice)) == [("RA201", 20)]


def test_targets_that_nothing_uses() -> None:
    moves = "".join(f"MoveL p{i},v100,z10,tool0;\n" for i in range(1, 19))
    text = module(f"{run(20)}PROC main()\n{moves}ENDPROC")
    tree = RAPID.parse(text)
    (finding,) = RAPID.check([tree])
    assert (finding.code, finding.line) == ("RA452", 20)
    assert "`p19`, `p20`" in finding.message
    assert found(text.replace("main", "weld")) == []
    assert found(text.replace("MoveL p18", "MoveL p19")) == [("RA452", 19)]
    late = text.replace("PROC main()\n", 'PROC main()\nGetDataVal "p19",reg2;\n')
    assert found(late) == [("RA452", 21)]


def arc(start: str, via: str, end: str, count: int = 0) -> str:
    moves = f"MoveL {start},v100,fine,tool0;\nMoveC {via},{end},v100,fine,tool0;\n"
    return f"{'MoveJ p1,v100,fine,tool0;' + chr(10)}" * count + moves


ARCS = {
    "half a circle": ((0, 0), (10, 10), (20, 0), []),
    "the end at the via point": ((0, 0), (10, 10), (10, 10), ["RA459"]),
    "a full circle": ((0, 0), (10, 10), (0, 0), ["RA459"]),
    "a line": ((0, 0), (10, 0), (20, 0), ["RA460"]),
    "a line that turns back": ((0, 0), (30, 0), (20, 0), ["RA460"]),
    "almost round": ((0, 0), (10, 30), (20, 0), ["RA461"]),
}


@every_row("count", [0, 9])
@every_row(("a", "b", "c", "expected"), ARCS)
def test_arcs(
    a: tuple[int, int], b: tuple[int, int], c: tuple[int, int], expected: list[str], count: int
) -> None:
    data = target("p1", *a) + target("p2", *b) + target("p3", *c)
    text = module(f"{data}PROC main()\n{arc('p1', 'p2', 'p3', count)}ENDPROC")
    assert found(text) == [(code, 7 + count) for code in expected]


def test_arcs_between_targets_that_may_change() -> None:
    data = "".join(target(f"p{i}", 0, 0, "VAR") for i in (1, 2, 3))
    assert found(module(f"{data}PROC main()\n{arc('p1', 'p2', 'p3')}ENDPROC")) == []


def test_arcs_that_begin_in_another_frame() -> None:
    data = target("p1", 0, 0) + target("p2", 0, 0) + target("p3", 9, 0)
    moves = arc("p1", "p2", "p3").replace("fine,tool0;", "fine,tool0\\WObj:=table;", 1)
    assert found(module(f"{data}PROC main()\n{moves}ENDPROC")) == []


def test_a_program_of_many_rows_has_no_finding() -> None:
    moves = "".join(f"MoveL p{i},v100,z10,tool0;\n" for i in range(1, 9001))
    assert found(module(f"{run(9000)}PROC main()\n{moves}ENDPROC")) == []


# Several modules


def test_two_programs_are_not_one() -> None:
    one, other = routine("TPErase;"), routine("TPErase;").replace("MODULE m", "MODULE n")
    assert found(one, other) == [("RA212", 2)]
    assert found(one, other, paths=("T_ROB1/m.mod", "T_ROB2/n.mod")) == []
    assert found(one, other, paths=("arm_L.mod", "arm_R.mod")) == []
    assert found(one, one) == [("RA213", 1)]


def test_what_every_task_has_is_seen_by_each() -> None:
    program = routine("MoveL p,vSlow,fine,tool0;")
    shared = module("LOCAL VAR num a;\nCONST speeddata vSlow:=[5,5,5,5];", "shared")
    double = module("CONST speeddata vSlow:=[5,5,5,5];", "other")
    paths = ("TASK1/m.mod", "TASK2/n.mod", "TASK0/shared.sys")
    assert found(program, routine("TPErase;"), shared, paths=paths) == [("RA452", 2)]
    assert found(program, double, shared, paths=paths) == [("RA201", 3), ("RA452", 2)]


def test_duplicates_of_modules() -> None:
    assert found(module("VAR num a;"), module("VAR num A;", "n")) == [("RA201", 2)]
    assert (
        found(module("VAR num a;"), module("LOCAL VAR num a;\nPROC p()\na:=1;\nENDPROC", "n")) == []
    )


def test_programs_that_lie_together_are_not_one_set_of_names() -> None:
    one = module("PROC main()\nTPErase;\nENDPROC", "one")
    two = module("PROC main()\nTPErase;\nENDPROC", "two")
    data = [
        module("PERS tooldata t:=[TRUE,[[0,0,9],[1,0,0,0]],[1,[0,0,9],[1,0,0,0],0,0,0]];", n)
        for n in ("data1", "data2")
    ]
    assert [code for code, _ in found(one, two, *data)] == ["RA212"]
    assert [code for code, _ in found(one, *data)] == ["RA201"]


def test_persistents_of_two_tasks_are_shared() -> None:
    text = "PERS num a:=1;\nVAR num b;"
    trees = [RAPID.parse(module(text, name)) for name in ("one", "two")]
    findings = RAPID.check(trees)
    assert [(f.code, f.severity) for f in findings] == [("RA201", Severity.WARNING)] * 2


def test_routines_that_nothing_calls() -> None:
    library = "LOCAL PROC a()\nENDPROC\nFUNC num b()\nRETURN 1;\nENDFUNC\nPROC c()\nENDPROC"
    assert found(module(library, "n")) == [("RA453", 2)]
    assert found(routine("TPErase;"), module(library, "n")) == [("RA453", 2)]
    used = routine('%"n:a"%;\nreg1:=b();')
    assert found(used, module(library, "n")) == []
    built = routine('%"rou"+ValToStr(reg1)%;')
    assert found(built, module("LOCAL PROC route5()\nENDPROC", "n")) == []
    system = module(library, "n").replace("MODULE n", "MODULE n(SYSMODULE)")
    assert found(routine('a;\n%"n:a"%;'), system) == []


def test_speeds_that_another_module_may_declare() -> None:
    def severity(text: str) -> Severity:
        (finding,) = [f for f in RAPID.check([RAPID.parse(text)]) if f.code == "RA204"]
        return finding.severity

    text = routine("MoveL p,v25,fine,tool0;")
    assert severity(text) is Severity.WARNING
    assert severity(text.replace("MODULE m\n", "MODULE m\n! program: m\n")) is Severity.ERROR


BOOKING = {
    "never booked": ("VAR errnum ERR_JAM:=-1;", "RAISE ERR_JAM;", "warning"),
    "without a value": ("VAR errnum ERR_JAM;", "RAISE ERR_JAM;", "warning"),
    "of this module alone": ("LOCAL VAR errnum ERR_JAM:=-1;", "RAISE ERR_JAM;", "error"),
    "a constant": ("CONST errnum ERR_JAM:=95;", "RAISE ERR_JAM;", "error"),
    "a number": ("", "RAISE 91;", "warning"),
    "by its name": (
        "LOCAL VAR errnum ERR_JAM:=-1;",
        'ErrRaise "ERR_JAM",4800,"a","b","c","d","e";',
        "error",
    ),
    "booked": ("VAR errnum ERR_JAM:=-1;", "BookErrNo ERR_JAM;\nRAISE ERR_JAM;", ""),
    "assigned": ("VAR errnum ERR_JAM:=-1;", "ERR_JAM:=ERR_WAIT_MAXTIME;\nRAISE ERR_JAM;", ""),
    "of those that anybody may raise": ("CONST errnum ERR_JAM:=90;", "RAISE ERR_JAM;", ""),
    "of the controller": ("", "RAISE ERR_WAIT_MAXTIME;", ""),
}


@every_row("case", list(BOOKING))
def test_errors_that_nothing_books(case: str) -> None:
    data, body, severity = BOOKING[case]
    tree = RAPID.parse(module(f"{data}\nPROC main()\n{body}\nENDPROC"))
    findings = [f for f in RAPID.check([tree]) if f.code == "RA467"]
    assert [f.severity.value for f in findings] == [severity] * bool(severity)


TOOL = "[{held},[[0,0,100],{rot}],[{mass},[0,0,50],{axes},0,0,0]]"
FRAME = '[{held},{fixed},"{unit}",[[500,0,0],{user}],[[0,0,0],{object}]]'


def tool(
    held: str = "TRUE", rot: str = "[1,0,0,0]", mass: str = "2", axes: str = "[1,0,0,0]"
) -> str:
    return "PERS tooldata tG:=" + TOOL.format(held=held, rot=rot, mass=mass, axes=axes) + ";\n"


def frame(
    held: str = "FALSE",
    fixed: str = "TRUE",
    unit: str = "",
    user: str = "[1,0,0,0]",
    object: str = "[1,0,0,0]",
) -> str:
    values = FRAME.format(held=held, fixed=fixed, unit=unit, user=user, object=object)
    return f"PERS wobjdata wT:={values};\n"


ZERO = "[0,0,0,0]"
MOUNTED = {
    "right": (tool(), frame(), ""),
    "tip without orientation": (tool(rot=ZERO), frame(), "RA462 error"),
    "load without axes": (tool(axes=ZERO), frame(), "RA462 error"),
    "user frame without orientation": (tool(), frame(user=ZERO), "RA462 error"),
    "object frame without orientation": (tool(), frame(object=ZERO), "RA462 error"),
    "no unit": (tool(), frame(fixed="FALSE"), "RA468 error"),
    "a unit": (tool(), frame(fixed="FALSE", unit="STN1"), ""),
    "a unit that moves nothing": (tool(), frame(unit="STN1"), ""),
    "no mass": (tool(mass="0"), frame(), "RA469 warning"),
    "mass that nobody has stated": (tool(mass="-1"), frame(), "RA469 warning"),
    "both held": (tool(), frame(held="TRUE"), "RA470 error"),
    "neither held": (tool(held="FALSE"), frame(), "RA471 error"),
    "work carried to the tool": (tool(held="FALSE"), frame(held="TRUE"), ""),
}


@every_row("many", [1, 9])
@every_row("case", list(MOUNTED))
def test_tools_and_work_objects_that_no_controller_takes(case: str, many: int) -> None:
    data, more, expected = MOUNTED[case]
    moves = "MoveL p,v100,z10,tG\\WObj:=wT;\n" * many
    text = module(f"{data}{more}{target('p', 1, 2)}PROC main()\n{moves}ENDPROC")
    findings = [f"{f.code} {f.severity.value}" for f in RAPID.check([RAPID.parse(text)])]
    assert findings == [expected] * bool(expected)
    assigned = text.replace("PROC main()", "PROC main()\ntG:=tool0;\nwT:=wobj0;")
    assert not list(RAPID.check([RAPID.parse(assigned)]))


def test_the_first_move_with_a_wrong_pair_is_named() -> None:
    moves = ["MoveL p,v100,z10,tG;"] * 12
    moves[5] = moves[7] = "MoveL p,v100,z10,tG\\WObj:=wT;"
    body = "\n".join(moves)
    text = module(tool() + frame(held="TRUE") + target("p", 1, 2) + f"PROC main()\n{body}\nENDPROC")
    assert found(text) == [("RA470", 11)]


def test_tools_that_no_move_uses_may_be_placeholders() -> None:
    (finding,) = RAPID.check([RAPID.parse(module(tool(rot=ZERO)))])
    assert (finding.code, finding.severity) == ("RA462", Severity.WARNING)
    stationary = module(tool(held="FALSE") + routine("MoveL p,v100,fine,tG;")[9:-10])
    assert ("RA471", 4) in found(stationary)
    calibrated = routine("MToolTCPCalib j1,j2,j3,j4,tG,reg1,reg2;\nMoveL p,v100,fine,tG;")
    assert found(module(tool(rot=ZERO), "data"), calibrated) == []


UNKNOWN_ERRORS = {
    "raised": "RAISE ERR_JAMM;",
    "compared": "IF ERRNO=ERR_JAMM TPErase;",
    "compared with a number": "IF reg1<>ERR_JAMM TPErase;",
    "a case": "TEST ERRNO\nCASE ERR_JAM,ERR_JAMM:\nTPErase;\nENDTEST",
    "assigned": "seen:=ERR_JAMM;",
    "handled": "TPErase;\nERROR (ERR_JAMM)\nRETRY;",
    "of any name": "IF seen=JAMMED TPErase;",
}


@every_row("case", list(UNKNOWN_ERRORS))
def test_errors_that_nothing_declares(case: str) -> None:
    data = "VAR errnum ERR_JAM:=1;\nVAR errnum seen;"
    body = UNKNOWN_ERRORS[case]
    text = module(f"{data}\nPROC main()\nseen:=ERR_JAM;\n{body}\nENDPROC")
    findings = [f for f in RAPID.check([RAPID.parse(text)]) if f.code == "RA403"]
    assert len(findings) == 1
    assert "JAMM" in findings[0].message
    right = text.replace("ERR_JAMM", "ERR_WAIT_MAXTIME").replace("JAMMED", "ERR_JAM")
    assert not [f for f in RAPID.check([RAPID.parse(right)]) if f.code == "RA403"]


def test_what_was_compiled_gets_no_advice() -> None:
    text = routine("WaitDI di1,1;")
    assert found(text) == [("RA454", 3)]
    assert (
        found(text.replace("MODULE m\n", "MODULE m\n! program: m\n! signal: di1 digital input\n"))
        == []
    )


def test_every_rule_has_a_case() -> None:
    files = (Path(__file__), Path(__file__).with_name("test_triggers.py"))
    source = "".join(file.read_text(encoding="utf-8") for file in files)
    known = [rule.code for rule in vars(rules).values() if isinstance(rule, Rule)]
    tried = re.compile(r"RA(207|21[2-9]|22\d|235|4[56]\d|47[01])")
    codes = [code for code in known if tried.fullmatch(code)]
    assert len(codes) > 25
    assert len({check.find for check in CHECKS}) == len(CHECKS)
    assert [code for code in codes if code not in source] == []


def test_what_follows_from_a_syntax_error_is_not_said() -> None:
    for statement in ("sub1();", "MoveL Offs(p,0,0,10, v100,fine,tool0;", "VAR num a[5];"):
        text = routine(statement)
        errors = [f.code for f in RAPID.check([RAPID.parse(text)]) if f.severity is Severity.ERROR]
        assert len(errors) == 1, errors
