"""Routines that were translated from RAPID do what they did there: both are run, and compared."""

from __future__ import annotations

from pathlib import Path

import pytest

import assistant
from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler import Translation
from assistant.compiler.loader import load_text
from assistant.program.passes.variables import repeats_cycle
from assistant.virtual import melfa, rapid
from assistant.virtual.events import Moved
from assistant.virtual.proving.comparison import difference

MELFA = ["melfa-basic-4", "melfa-basic-5", "melfa-basic-6"]
MODULE = """\
MODULE Cell
    PERS tooldata tG:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
    CONST robtarget p10:=[[350,20,250],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR num n:=4;
    VAR num m:=2;
    PERS num z:=4;
    VAR bool b;
    VAR num k{3}:=[1,2,3];
    VAR robtarget pt:=[[340,20,250],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    DATA
    PROC main()
        MAIN
    ENDPROC
    PROC at(num x,num y)
        MoveL Offs(p10,x,y,0),v100,fine,tG;
    ENDPROC
    PROC shown()
        at n,m;
    ENDPROC
    MORE
ENDMODULE
"""

ALIASES: dict[str, tuple[str, str]] = {
    "a number": ("s n;", "PROC s(INOUT num q) q:=q+30; at n,q; n:=n+1; at n,q; ENDPROC"),
    "a position": (
        "s pt; MoveL pt,v100,fine,tG;",
        "PROC s(VAR robtarget q) q.trans.z:=q.trans.z+40; MoveL pt,v100,fine,tG; ENDPROC",
    ),
    "an element": ("s k{2}; at k{2},0;", "PROC s(INOUT num q) q:=q+10; at k{2},q; ENDPROC"),
    "an element whose index changes": (
        "s k{m}; at k{2},k{3};", "PROC s(INOUT num q) m:=3; q:=q+10; at k{2},k{m}; ENDPROC"
    ),
    "a copied element whose index changes": (
        "s k{m}; at k{2},k{3};", "PROC s(INOUT num q) m:=3; q:=q+10; ENDPROC"
    ),
    "a truth": (
        "s b;", "PROC s(INOUT bool q) q:=TRUE; IF b THEN at 1,0; ELSE at 2,0; ENDIF ENDPROC"
    ),
    "a persistent": ("s z;", "PROC s(PERS num q) q:=q+10; at z,q; ENDPROC"),
    "a routine inside": ("s n;", "PROC s(INOUT num q) q:=q+10; shown; ENDPROC"),
    "handed on": (
        "s n; shown;",
        "PROC s(INOUT num q) t q; at n,q; ENDPROC PROC t(INOUT num q) q:=q+9; ENDPROC",
    ),
    "handed on to one that reads": (
        "s n; shown;",
        "PROC s(INOUT num q) t q; ENDPROC PROC t(INOUT num q) q:=q+9; at n,q; ENDPROC",
    ),
    "a function": (
        "m:=f(n); at m,n;", "FUNC num f(INOUT num q) q:=q+10; RETURN n+q; ENDFUNC"
    ),
    "a function in a condition": (
        "WHILE f(n)<9 DO shown; ENDWHILE", "FUNC num f(INOUT num q) q:=q+2; RETURN n; ENDFUNC"
    ),
    "one variable twice": (
        "s n,n; s n,m; shown;", "PROC s(INOUT num x,INOUT num y) x:=x+1; y:=y*2; at x,y; ENDPROC"
    ),
    "one of its own twice": (
        "own;",
        "PROC own() VAR num w:=3; s w,w; at w,0; ENDPROC "
        "PROC s(INOUT num x,INOUT num y) x:=x+1; y:=y*2; at x,y; ENDPROC",
    ),
    "two elements that may be one": (
        "FOR i FROM 1 TO 3 DO s k{i},k{2}; ENDFOR at k{1}+k{3},k{2};",
        "PROC s(INOUT num x,INOUT num y) x:=x+1; y:=y*2; at x,y; ENDPROC",
    ),
    "a component and the whole": (
        "s pt,pt.trans.x;",
        "PROC s(INOUT robtarget q,INOUT num x) x:=x+5; MoveL q,v100,fine,tG; ENDPROC",
    ),
    "a name that is hidden": (
        "s n; shown;", "PROC s(INOUT num q) VAR num n:=7; q:=q+n; n:=1; at n,q; shown; ENDPROC"
    ),
    "a result inside another": (
        "at f(1)+g(2),0;",
        "FUNC num f(num x) RETURN x*2; ENDFUNC FUNC num g(num x) RETURN f(x)+1; ENDFUNC",
    ),
}  # fmt: skip
ARRAYS: dict[str, tuple[str, str]] = {
    "of a routine": ("s; s;", "PROC s() VAR num q{2}; q{1}:=q{1}+10; at q{1},0; ENDPROC"),
    "of a routine, long": (
        "s; s;", "PROC s() VAR num q{30}; q{29}:=q{29}+10; at q{29},q{30}; ENDPROC"
    ),
    "of a routine, two dimensions": (
        "s; s;", "PROC s() VAR num q{3,4}; q{3,4}:=q{3,4}+10; at q{3,4},q{1,2}; ENDPROC"
    ),
    "of a routine with parameters": (
        "s 1; s 2;", "PROC s(num x) VAR num q{6}; q{1}:=q{1}+x; at q{1},0; ENDPROC"
    ),
    "of truths": (
        "s; s;", "PROC s() VAR bool q{5}; IF q{5} at 1,0; q{5}:=TRUE; at 2,0; ENDPROC"
    ),
    "of targets": (
        "s; s;",
        "PROC s() VAR robtarget q{2}; q{1}.trans.x:=q{1}.trans.x+5; at q{1}.trans.x,0; ENDPROC",
    ),
    "of the module": (
        "w{2}:=w{2}+1; at w{2},w{7}; IF v{1} at 1,1;", "VAR num w{7}; VAR bool v{2};"
    ),
    "constants of routines": (
        "CONST num c:=2; s c;",
        "PROC s(num x) CONST num c:=9; at c,x; t; ENDPROC PROC t() CONST num c:=7; at c,n; ENDPROC",
    ),
    "a scalar that a jump leaves out": (
        "s 1; s 2;",
        "PROC s(num x) VAR num w; IF x>1 GOTO over; w:=5; over: w:=w+1; at w,0; ENDPROC",
    ),
}  # fmt: skip

ENOUGH = 500
"""Statements of three cycles and more of each module."""

LABELS = "PROC s(num x) L1: n:=n+x; at n,0; IF n<9 GOTO L1; t x; ENDPROC "
LABELS += "PROC t(num x) again: m:=m+x; L1: at m,0; m:=m+3; IF m<9 GOTO L1; ENDPROC"


def as_its_source(main: str, more: str) -> None:
    """The module does in every dialect what it does in RAPID, in three cycles where it repeats."""
    data = more if more.startswith("VAR") else ""
    text = MODULE.replace("MORE", "" if data else more).replace("MAIN", main).replace("DATA", data)
    source = languages.get("rapid").parse(text)
    loaded = load_text(SourceText(text), language="rapid")
    once, thrice = rapid.run(source), rapid.run(source, most_cycles=3)
    assert any(isinstance(event, Moved) for event in once.events) and once.ended == "end"
    for to in MELFA:
        translation = assistant.translate(loaded, to=to)
        assert translation.ok, (to, translation.findings)
        (written,) = translation.files.values()
        target = languages.get(to)
        first = thrice if repeats_cycle(translation.compiled.program) else once
        second = melfa.run(target.parse(target.decode(written)), most_steps=ENOUGH)
        assert difference(first, second) is None, to
        assert second.ended == "unknown" or len(second.events) >= len(first.events), to


@pytest.mark.parametrize("what", ALIASES)
def test_a_variable_by_two_names_is_one(what: str) -> None:
    as_its_source(*ALIASES[what])


@pytest.mark.parametrize("what", ARRAYS)
def test_an_array_begins_with_nothing(what: str) -> None:
    as_its_source(*ARRAYS[what])


def test_routines_with_parameters_have_labels_of_their_own() -> None:
    as_its_source("s 2; at m,n;", LABELS)


def test_an_array_that_keeps_its_values_over_cycles_keeps_them_in_a_loop() -> None:
    data, body = "VAR num q{2};\nVAR num w{2};\n", "q{1}:=q{1}+1;\nw{1}:=1;\n"
    text = f"MODULE m\n{data}PROC main()\n{body}ENDPROC\nENDMODULE\n"
    program = languages.get("rapid").lift(languages.get("rapid").parse(text))
    found = languages.get("melfa-basic-5").adapt(program).findings
    assert [f.code for f in found] == ["MB263"]
    assert "`q`" in found[0].message
    assert "`w`" not in found[0].message


CELL = """\
[signals.go1]
kind = "group"
number = 32
bits = 4
[signals.do1]
number = 4
[signals.gi1]
direction = "input"
kind = "group"
number = 16
bits = 4
"""


def in_cell(folder: Path, main: str, to: str) -> Translation:
    """A program with a cell's signals, translated."""
    process = folder / "cell.toml"
    process.write_text(CELL, encoding="utf-8")
    text = f"MODULE m\nPROC main()\n{main}\nENDPROC\nENDMODULE\n"
    loaded = load_text(SourceText(text), process=process, language="rapid")
    return assistant.translate(loaded, to=to)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("to", MELFA)
@pytest.mark.parametrize("line", ["WaitGI gi1,5;", "WaitUntil gi1=5;"])
def test_a_wait_for_some_bits_is_one(tmp_path: Path, line: str, to: str) -> None:
    found = in_cell(tmp_path, line + "\nSetGO go1,15;\n", to)
    assert found.ok, found.findings
    (written,) = found.files.values()
    language = languages.get(to)
    tree = language.parse(language.decode(written))
    for value, ended in ((5, "end"), (4, "stopped"), (21, "end")):
        bits = {16 + bit: value >> bit & 1 for bit in range(5)}
        run = melfa.run(tree, inputs=bits, most_steps=1_000)
        assert run.ended in (ended, "steps" if ended != "end" else "")


@pytest.mark.parametrize("to", MELFA)
@pytest.mark.parametrize(
    "line",
    ["SetGO go1,16;", "SetGO go1,-1;", "SetGO go1,2.5;", "SetDO do1,3;", "WaitGI gi1,16;"],
)
def test_what_does_not_fit_a_signal_is_an_error_there(tmp_path: Path, line: str, to: str) -> None:
    found = in_cell(tmp_path, "SetGO go1,15;\n" + line, to)
    assert {(f.code, f.line) for f in found.findings} >= {("MB240", 4)} and not found.ok
    assert not [f for f in found.findings if f.code.startswith("CO1")]
