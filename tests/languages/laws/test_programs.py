"""Laws of programs: what is written is read back, says the same, and under legal names."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from assistant import compile, languages
from assistant.base.diagnostics import Refused, Span
from assistant.compiler.read_back_proof import prove_read_back
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.comparison import Tolerance, compare
from assistant.program.geometry import Configuration, Frame, Pose, Target, Tool
from assistant.program.motion import FINE, FULL_BLEND, Path, Speed
from assistant.program.program import Procedure, Program, Signal
from tests.examples import drawn
from tests.languages.laws.subjects import (
    PARTS,
    TURNED,
    WAITS,
    errors,
    every_language,
    few,
    many,
    programs,
    written,
)
from tests.tables import every_row


@dataclass(frozen=True, slots=True)
class Polish:
    """A statement that no language has heard of."""

    seconds: e.Expression
    span: Span | None = None


@every_language
def test_a_statement_without_a_row_is_refused(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(p, "TRAITS", {**p.TRAITS, Polish: "sets"})
    program = Program("m", (Procedure("main", (Polish(e.Number(1.0)),)),), "main")
    with pytest.raises(Refused) as refused:
        languages.get(name).lower(program)
    assert errors(refused.value.findings)


def proven(name: str, program: Program) -> Program:
    """What a language says of a program once it is adapted, written and read back."""
    language = languages.get(name)
    adapted = language.adapt(program)
    assert not errors(adapted.findings), adapted.findings
    again = language.adapt(adapted.program)
    assert compare(adapted.program, again.program).same
    assert not errors(again.findings)
    tree = language.lower(program)
    text = language.render(tree)
    read = language.parse(text)
    assert language.same(read, tree)
    assert language.render(read) == text
    assert not errors((*read.findings, *language.check([read])))
    assert language.same(language.parse(language.format(read)), read)
    tolerance = Tolerance(
        language.precision.position, language.precision.angle, language.precision.number
    )
    assert compare(adapted.program, language.lift(tree), tolerance).same
    proof = prove_read_back(language, adapted.program, written(language, adapted.program))
    assert proof.holds, proof.findings
    assert proof.lifted is not None
    return proof.lifted


@every_language
@given(program=programs)
@few
def test_what_all_can_say_is_proven(name: str, program: Program) -> None:
    proven(name, program)


@pytest.mark.slow
@every_language
@given(program=programs)
@many
def test_much_that_all_can_say_is_proven(name: str, program: Program) -> None:
    proven(name, program)


# ------------------------------------------------------------------------------------ names

WORDS = (
    *("end", "End", "MOVEL", "fine", "if", "dly", "P1", "j1", "m_out", "main", "program", "v100"),
    *("set", "on", "proc", "Function", "a_", "_x", "_", "ü", "Ü", "ue", "日本", "İ", "ß", "ſ", "Ω"),
    *("x" * 70, "x" * 71, "x" * 16, "x" * 17),
)
"""Names that are words somewhere, that are written alike, and that are long."""
NAMES = st.lists(
    st.sampled_from(WORDS) | st.from_regex(r"[^\W\d]\w{0,8}", fullmatch=True),
    min_size=5,
    max_size=15,
    unique_by=str.lower,
)


def naming(names: list[str]) -> Program:
    """A program whose points, frames, tools, signals and procedures have these names.

    A frame has the name of a point as well, in capitals.
    """
    points, tools, signals, called = (names[start::4] for start in range(4))
    frames = [upper for name in points if (upper := name.upper()).lower() == name.lower()]
    moves = [
        p.Move("linear", e.Name(point), p.Motion(Speed(100.0), FINE, tool, frame))
        for point in points
        for tool in tools
        for frame in frames or ["base"]
    ]
    sets = [p.SetSignal(signal, e.Number(1)) for signal in signals]
    body = (*moves, *sets, *map(p.Call, called))
    part = (p.Wait(e.Number(1)),)
    return Program(
        "job",
        (Procedure("start_here", body), *(Procedure(name, part) for name in called)),
        "start_here",
        targets={name: Target(place(row), Configuration()) for row, name in enumerate(points)},
        frames={name: Frame(place(row)) for row, name in enumerate(frames)},
        tools={name: Tool(place(row)) for row, name in enumerate(tools)},
        signals={name: Signal("digital", "output", row) for row, name in enumerate(signals, 1)},
    )


def place(row: int) -> Pose:
    return Pose((10.0 * row, 0.0, 500.0), TURNED)


def keeps_names_apart(name: str, names: list[str]) -> None:
    program = naming(names)
    lifted = proven(name, program)
    for table in ("targets", "frames", "tools", "signals", "procedures"):
        assert len(getattr(lifted, table)) == len(getattr(program, table)), table


@pytest.mark.one_in(2)
@every_language
@given(names=NAMES)
@example(["_x", "_", "a_", "end", "ß", "ſ", "ss", "x" * 70, "x" * 71])
@example(["p", "t", "Ü", "q", "r", "s", "ue"])
@few
def test_any_names_become_legal_and_stay_apart(name: str, names: list[str]) -> None:
    keeps_names_apart(name, names)


@pytest.mark.slow
@every_language
@given(names=NAMES)
@example(
    [
        *("if", "𣲰ĊÕºßğÿć", "Ü", "_x", "EFėóś𪙡VŪÚ", "m_out", "ue", "ûÇħ", "𮀎ÜĽĆVġÇ䪤𐩷"),
        *("set", "hěŁŁ𢤺ÿ", "日本", "x" * 16, "main", "Úcĵ雲J0Uē𫦤"),
    ]
)
@many
def test_many_names_become_legal_and_stay_apart(name: str, names: list[str]) -> None:
    keeps_names_apart(name, names)


# --------------------------------------------------------------------------------- comments

LETTERS = st.characters(codec="utf-8", categories=("L", "N", "P", "S"))
COMMENTS = st.one_of(
    st.text(LETTERS, max_size=20),
    st.text("aeÄÖüéñøÃ¼¶Å½", max_size=20),
    st.text("aｱ日本語ソ表", max_size=20),
    st.text(LETTERS, max_size=9).map(lambda t: t.encode("utf-8").decode("latin-1")),
)


@every_language
@given(text=COMMENTS)
@settings(max_examples=drawn(25))
def test_a_comment_in_any_script_is_proven(name: str, text: str) -> None:
    program = Program("job", (Procedure("main", (p.Comment(text),)),), comments=(text,))
    compiled = compile(program, language=name)
    assert compiled.proof.holds, compiled.proof.findings


# ------------------------------------------------------------------- what cannot be said


@every_language
@every_row(
    "statement",
    [
        p.Opaque("another language", "do it"),
        p.Wait(e.Verbatim("another language", "a while")),
        p.Wait(e.Number(math.nan)),
        p.Assign(e.Name("spot"), e.PoseValue(Pose((math.inf, 0.0, 0.0)))),
        p.If((p.Branch(e.Truth(True), (p.Opaque("another language", "do it"),)),)),
    ],
)
def test_what_cannot_be_said_is_an_error_that_keeps_all_from_being_written(
    name: str, statement: p.Statement
) -> None:
    language = languages.get(name)
    program = Program("job", (Procedure("main", (statement,)),), **PARTS)
    assert errors(language.adapt(program).findings)
    assert not compile(program, language=name).files
    with pytest.raises(Refused) as refused:
        language.lower(program)
    assert errors(refused.value.findings)


ODD = {
    "a case of no value": p.Switch(e.Number(1), (p.Case((), WAITS[:1]),), WAITS[1:2]),
    "no case": p.Switch(e.Number(1), (), WAITS[:1]),
    "a speed beyond all": p.Move("linear", e.Name("home"), p.Motion(Speed(1e300), FULL_BLEND)),
    "a block of nothing": p.While(e.Binary("=", e.Name("ready"), e.Number(1)), ()),
    "a path of nothing": p.Follow(Path.of("seam", [], [], speeds=[Speed(100.0)])),
}


@every_language
@every_row("statement", ODD.values())
def test_what_is_odd_is_an_error_or_proven(name: str, statement: p.Statement) -> None:
    program = Program("job", (Procedure("main", (statement,)),), **PARTS)
    if not errors(languages.get(name).adapt(program).findings):
        proven(name, program)
