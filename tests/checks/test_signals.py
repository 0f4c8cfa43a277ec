"""Signals that share a number, and groups that are compared with what they never are."""

from __future__ import annotations

import pytest

import assistant
from assistant import checks, languages
from assistant.program.expressions import Binary, Name, Number
from assistant.program.program import Procedure, Program, Signal
from assistant.program.statements import Assign, SetSignal, Statement, WaitSignal, WaitUntil, While

BYTE = Signal("group", "input", 8, 8)


def found(signals: dict[str, Signal], *body: Statement) -> list[str]:
    program = Program("p", (Procedure("main", body),), signals=signals)
    return [f"{f.code} {f.severity.value}" for f in checks.check(program)]


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        (Signal("digital", "input", 5), Signal("digital", "input", 5), ["CK121 error"]),
        (Signal("group", "input", 8, 4), Signal("group", "input", 8, 8), ["CK121 warning"]),
        (Signal("group", "output", 8, 4), Signal("group", "output", 8, 8), ["CK121 error"]),
        (Signal("digital", "input", 5), Signal("digital", "output", 5), []),
        (Signal("digital", "input", 5), Signal("analog", "input", 5), []),
        (Signal("digital", "input", 9), BYTE, []),
        (Signal("digital", "input"), Signal("digital", "input"), []),
    ],
)
def test_two_signals_on_one_number(one, other, expected):
    waits = (WaitSignal("a", Number(1)), WaitSignal("b", Number(1)))
    assert found({"a": one, "b": other}, *waits) == expected
    unused = [code.replace("error", "warning") for code in expected]
    assert found({"a": one, "b": other}, waits[0]) == unused


def test_two_outputs_on_one_number():
    out = Signal("digital", "output", 3)
    sets = (SetSignal("a", Number(1)), SetSignal("b", Number(0)))
    assert found({"a": out, "b": out}, *sets) == ["CK121 error"]


@pytest.mark.parametrize("language", languages.names())
@pytest.mark.parametrize("declared", [("glue", "valve"), ("valve", "glue"), ("Valve", "GLUE")])
def test_the_name_that_is_used_of_two_on_one_number_is_written(declared, language):
    program = Program(
        "p",
        (Procedure("main", (SetSignal("glue", Number(1)),)),),
        signals=dict.fromkeys(declared, Signal("digital", "output", 19)),
        entry="main",
    )
    made = assistant.compile(program, language=language)
    assert made.ok and [f.code for f in made.findings] == ["CK121"]
    (text,) = made.files.values()
    (back,) = (
        languages.get(language).lift(languages.get(language).parse(text.decode())).statements()
    )
    assert back.signal.lower() == "glue"


@pytest.mark.parametrize(
    ("statement", "wrong"),
    [
        (WaitSignal("g", Number(256)), True),
        (WaitSignal("g", Number(255)), False),
        (WaitUntil(Binary("=", Name("G"), Number(300))), True),
        (WaitUntil(Binary("<", Number(-1), Name("g"))), True),
        (WaitUntil(Binary("=", Name("g"), Number(0))), False),
        (While(Binary(">", Name("n"), Number(300)), (Assign(Name("n"), Name("g")),)), True),
        (While(Binary(">", Name("n"), Number(200)), (Assign(Name("n"), Name("g")),)), False),
        (WaitUntil(Binary("=", Name("n"), Number(300))), False),
    ],
)
def test_groups_that_are_compared_with_what_they_never_are(statement, wrong):
    assert found({"g": BYTE}, statement) == ["CK122 warning"] * wrong


def test_words_with_a_sign_may_be_below_zero():
    word = Signal("group", "input", 0, 16)
    assert found({"g": word}, WaitSignal("g", Number(-5))) == []
    assert found({"g": word}, WaitSignal("g", Number(70000))) == ["CK122 warning"]


@pytest.mark.parametrize(("bits", "codes"), [(4, {"CK122"}), (7, set())])
def test_a_question_whose_largest_answer_nobody_can_enter(bits, codes, tmp_path):
    source, process = tmp_path / "ask.mod", tmp_path / "p.toml"
    source.write_text(
        "MODULE ask\nVAR num n;\nPROC main()\n"
        'n:=UINumEntry(\\Header:="h"\\MinValue:=1\\MaxValue:=100\\AsInteger);\nENDPROC\nENDMODULE\n'
    )
    process.write_text(
        '[signals.operator_number]\nkind = "group"\ndirection = "input"\nnumber = 112\n'
        f'bits = {bits}\n[signals.operator_entered]\ndirection = "input"\nnumber = 5\n'
    )
    said = assistant.translate(source, to="melfa-basic-6", process=process)
    assert {f.code for f in said.findings if f.code == "CK122"} == codes
