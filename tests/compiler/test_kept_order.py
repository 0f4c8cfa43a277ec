"""What keeps its text is written where its language has room for it, and read back as that."""

from __future__ import annotations

from dataclasses import replace

import pytest

from assistant import compile, languages
from assistant.base.diagnostics import Severity, has_errors
from assistant.base.source_text import SourceText
from assistant.compiler.loader import parse_pseudo

RAPID = languages.get("rapid")


def test_kept_routines_stand_behind_kept_data() -> None:
    kept = "PROC f(\\VAR bool a|switch s)\nENDPROC\n"
    text = f"MODULE m\nPROC main()\nConfL\\Off;\nENDPROC\n{kept}VAR rawbytes r;\nENDMODULE\n"
    program = replace(RAPID.lift(RAPID.parse(text)), origin=None)
    made = compile(program, language="rapid")
    assert made.proof.holds
    again = compile(made.program, language="rapid")
    assert again.files == made.files


BITS = {"bitand(n, d)": True, "bitor(d, 6)": True, "bitxor(d, bitor(n, d))": True}
BITS |= dict.fromkeys(("bitand(d, d)", "bitand(d, 1)"), False)


@pytest.mark.parametrize("level", [4, 5, 6])
@pytest.mark.parametrize(("value", "said"), BITS.items(), ids=BITS)
def test_bits_of_a_signal_and_of_a_number_are_read_back_as_bits(
    level: int, value: str, said: bool
) -> None:
    head = "program a\nsignal d digital input 7\nvariable n integer = 2\n"
    text = f"{head}procedure main\n  n = {value}\n  if {value} > 0\n    stop\n  end\nend\n"
    program = parse_pseudo(SourceText(text, "a.pseudo"))
    made = compile(program, language=f"melfa-basic-{level}")
    assert made.proof.holds is said
    assert {f.code for f in made.findings if f.code in ("CO102", "MB209")} == (
        set() if said else {"MB209"}
    )


def test_a_kept_move_is_named_whose_settings_would_be_written_for_others() -> None:
    language = languages.get("melfa-basic-4")
    kept = "MVS SETFL2(P_CURR,M1,M2)"
    text = f"10 MVS ,-50\n20 WHILE M_IN(3)=1\n30 {kept}\n40 WEND\n50 END\n"
    program = replace(language.lift(language.parse(text)), origin=None)
    made = compile(program, language="melfa-basic-4")
    (told,) = [f for f in made.findings if f.severity is Severity.ERROR]
    assert (told.code, made.files) == ("CO107", {})
    assert kept in told.message


@pytest.mark.parametrize(
    ("level", "text", "kept"),
    [
        (4, "10 MVR P2,P10,P11\n20 JRC +1,2\n", "JRC +1,2"),
        (5, "1 Mvs P1\n2 M_FsCod0(1,2)=Zone2(P_NTool*P_Curr,P1,P1,3)\n", "M_FsCod0(1,2)=Zone2"),
    ],
)
def test_a_kept_statement_that_moves_nothing_is_named_as_well(
    level: int, text: str, kept: str
) -> None:
    language = languages.get(f"melfa-basic-{level}")
    program = replace(language.lift(language.parse(text)), origin=None)
    made = compile(program, language=language.name)
    (told,) = [f for f in made.findings if f.severity is Severity.ERROR]
    assert (told.code, made.files) == ("CO107", {})
    assert kept in told.message


def test_a_kept_value_is_named_beside_which_settings_would_be_written() -> None:
    language = languages.get("melfa-basic-6")
    kept = "PosMid(PA,SplECord(P_Curr,PB(2)),&HF,M_XDevW(1))"
    program = language.lift(language.parse(f"1 Mvs P10\n2 PA={kept}\n{P10}"))
    made = compile(replace(program, origin=None), language="melfa-basic-6")
    told = [f for f in made.findings if f.severity is Severity.ERROR]
    assert ([f.code for f in told], made.files) == (["CO107", "CO104"], {})
    assert all(kept in f.message for f in told)


P10 = "P10=(298,-17,300.5,0,0,180)(7,0)\n"


def errors_of(text: str, language: str) -> list[tuple[str, str]]:
    made = compile(parse_pseudo(SourceText(text, "a.pseudo")), language=language)
    assert made.ok is not has_errors(made.findings)
    return [(f.code, f.message) for f in made.findings if f.severity is Severity.ERROR]


def test_a_timer_that_nothing_restarts_is_refused_in_rapid() -> None:
    text = "program a\nprocedure main\n{}  if elapsed(cycle) > 2\n    stop\n  end\nend\n"
    ((code, message),) = errors_of(text.format(""), "rapid")
    assert (code, "`cycle`" in message) == ("RA305", True)
    assert not errors_of(text.format("  restart timer cycle\n"), "rapid")


@pytest.mark.parametrize("level", [4, 5, 6])
@pytest.mark.parametrize("wait", ["for heat = 3.5", "until heat = 3.5", "until heat = -3.5"])
def test_a_wait_for_a_value_of_an_analog_input_is_read_back(level: int, wait: str) -> None:
    text = f"program a\nsignal heat analog input 6020\nprocedure main\n  wait {wait}\nend\n"
    assert not errors_of(text, f"melfa-basic-{level}")


@pytest.mark.parametrize("level", [4, 5, 6])
def test_products_of_poses_are_read_back(level: int) -> None:
    head = (
        "program a\nvariable v pose = pose [1, 2, 3] [1, 0, 0, 0]\nprocedure main\n  v = {}\nend\n"
    )
    numbers = ("v @ pose [1, 2, 3]", "pose [0, 0, 1] @ v")
    for said in ("v @ v", "inverse(v) @ v", "(v @ v) @ v", *numbers):
        assert not errors_of(head.format(said), f"melfa-basic-{level}")


def test_a_kept_text_does_not_come_to_name_another_variable() -> None:
    kept = "opaque melfa-basic-4 | ON M1 GOSUB ,*S0,*S0"
    head = "program a\nvariable M1 number\nprocedure main\n  call part(2)\nend\n"
    text = f"{head}procedure part({{}} number)\n  {kept}\nend\nprocedure S0\nend\n"
    ((code, message),) = errors_of(text.format("M1"), "melfa-basic-4")
    assert (code, "names the parameter `M1`" in message) == ("MB209", True)
    assert not errors_of(text.format("M2"), "melfa-basic-4")


def test_a_kept_text_that_comes_to_be_understood_is_named() -> None:
    language = languages.get("melfa-basic-5")
    lines = ("While M_In(7)=1", "M_Out(MCOUNT)=1", "WEnd", "If Not (MA=MCOUNT) Then M1=2", "End")
    text = "".join(f"{at} {line}\n" for at, line in enumerate(lines, 1))
    program = replace(language.lift(language.parse(text)), origin=None)
    made = compile(program, language="melfa-basic-5")
    errors = {f.code: f.message for f in made.findings if f.severity is Severity.ERROR}
    assert list(errors) == ["CO104"]
    assert "M_Out(MCOUNT)=1" in errors["CO104"]
