"""Timers: M_Timer, the clocks of RAPID, and the timers of the pseudo-program between them."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.compiler.translation import translate
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program, Signal, Variable
from assistant.program.undeclared_names import timers

from .lifting import body, lifted, opaque
from .test_translation import DIALECTS, there_and_back

START = p.StartTimer("timer_2")
SECONDS = e.Elapsed("timer_2")
RAPID = """MODULE work
VAR clock cycle;
VAR num seconds;
PROC main()
ClkReset cycle;
ClkStart cycle;
WHILE ClkRead(cycle)<2.5 DO
WaitTime 0.1;
ENDWHILE
seconds:=ClkRead(cycle);
ENDPROC
ENDMODULE
"""


def test_milliseconds_are_seconds_times_a_thousand() -> None:
    start, kept, seconds = body("M_Timer(2)=0\nMAT=M_Timer(2)\nMAT=M_Timer(2)/1000\n")
    assert start == START
    assert kept == p.Assign(e.Name("MAT"), e.Binary("*", SECONDS, e.Number(1000)))
    assert seconds == p.Assign(e.Name("MAT"), SECONDS)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("M_Timer(2)>=5000", e.Binary(">=", SECONDS, e.Number(5))),
        ("12.5<M_Timer(2)", e.Binary("<", e.Number(0.0125), SECONDS)),
        ("M_Timer(2)<MLIM", e.Binary("<", e.Binary("*", SECONDS, e.Number(1000)), e.Name("MLIM"))),
    ],
)
def test_limits_are_read_in_seconds(written: str, meant: e.Expression) -> None:
    _, test = body(f"M_Timer(2)=0\nIf {written} Then Hlt\n")
    assert isinstance(test, p.If)
    assert test.branches[0].condition == meant


@pytest.mark.parametrize(
    "line",
    ["M_Timer(2)=100", "M_Timer(MANY)=0", "Print #1,M_Timer(2)", "Mov P1 WthIf M_Timer(2)>9,Skip"],
)
def test_another_use_keeps_every_line_of_a_timer(line: str) -> None:
    program = lifted(f"M_Timer(2)=0\nMAT=M_Timer(2)\n{line}\nHlt\n")
    assert "M_Timer(2)=0" in opaque(program)
    assert timers(program) == ()


def test_a_timer_that_nothing_starts_is_kept() -> None:
    (kept,) = body("MAT=M_Timer(2)\n")
    assert isinstance(kept, p.Assign)
    assert kept.value == e.Verbatim("melfa-basic-6", "M_Timer(2)")


@pytest.mark.parametrize("level", [4, 5, 6])
def test_to_rapid_and_back(level: int) -> None:
    rapid, melfa = languages.get("rapid"), languages.get(f"melfa-basic-{level}")
    program = lifted(
        "M_Timer(2)=0\n*AGAIN\nIf M_Timer(2)<1500 Then GoTo *AGAIN\nMAT=M_Timer(2)\n", level
    )
    tree = rapid.build(rapid.adapt(program).program)
    text = rapid.render(tree)
    assert "VAR clock timer_2;" in text
    assert "IF ClkRead(timer_2)<1.5 THEN" in text
    assert "MAT:=ClkRead(timer_2)*1000;" in text
    again = melfa.render(melfa.build(melfa.adapt(rapid.lift(rapid.parse(text))).program))
    written = melfa.lift(melfa.parse(again))
    assert written.procedures[0].body == melfa.adapt(program).program.procedures[0].body


@pytest.mark.parametrize("name", DIALECTS)
def test_a_clock_of_rapid(name: str) -> None:
    rapid = languages.get("rapid")
    tree = rapid.parse(RAPID)
    program = rapid.lift(tree)
    assert rapid.lower(program) == tree
    assert program.procedures[0].body[0] == p.StartTimer("cycle")
    assert not program.declarations
    _, back, (text,) = there_and_back(program, name)
    assert "timer: 2 = cycle" in text
    assert "M_TIMER(2)<2500" in text.upper()
    assert timers(back) == ("cycle",)


@pytest.mark.parametrize(
    "line",
    ["ClkStop cycle;", "ClkStart cycle;", "other cycle;", "seconds:=ClkRead(cycle\\HighRes);"],
)
def test_a_clock_that_is_used_otherwise_stays_one(line: str) -> None:
    rapid = languages.get("rapid")
    program = rapid.lift(rapid.parse(RAPID.replace("ENDPROC", line + "\nENDPROC", 1)))
    assert [d.text for d in program.declarations] == ["VAR clock cycle;"]
    assert timers(program) == ()


def test_a_time_limit_takes_a_timer_that_is_free() -> None:
    program = Program(
        "job",
        (
            Procedure(
                "main",
                (
                    p.StartTimer("timer_1"),
                    p.StartTimer("lap"),
                    p.WaitSignal("ok", e.Number(1), e.Number(2)),
                    p.Assign(e.Name("at"), e.Elapsed("Timer_1")),
                    p.Assign(e.Name("at"), e.Elapsed("lap")),
                ),
            ),
        ),
        signals={"ok": Signal("digital", "input", 3)},
        variables={"at": Variable("number")},
    )
    adapted, back, (text,) = there_and_back(program, "melfa-basic-5")
    assert back.procedures == adapted.procedures
    assert "timer: 1 = timer_1, 2 = lap" in text
    assert "If M_Timer(3)<2000 Then *W1" in text


def test_more_timers_than_there_are() -> None:
    starts = tuple(p.StartTimer(f"lap{k}") for k in range(9))
    language = languages.get("melfa-basic-6")
    findings = language.adapt(Program("job", (Procedure("main", starts),))).findings
    assert [f.code for f in findings] == ["MB209"]


def test_a_translated_file_is_proven(tmp_path) -> None:  # type: ignore[no-untyped-def]
    source = tmp_path / "JOB.prg"
    source.write_text("1 M_Timer(1)=0\n2 MAT=M_Timer(1)\n3 End\n")
    made = translate(source, to="rapid", robot="irb1200-7-0.7", language="melfa-basic-5")
    assert made.ok
    assert [row.level for row in made.rows] == ["supported"] * len(made.rows)
