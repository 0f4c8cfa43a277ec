"""Two programs are the same, or the place where they differ is named."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.comparison import Tolerance, compare
from assistant.program.expressions import Name, Number
from assistant.program.geometry import IDENTITY, Configuration, Pose, Target, Tool
from assistant.program.motion import FINE, Blend, Kind, Path, Speed
from assistant.program.program import Procedure, Program, Signal, Variable
from assistant.program.pseudo.printer import part_text
from assistant.program.statements import Branch, Comment, Follow, If, Motion, Move, SetSignal, Wait
from tests.tables import every_row

PATH = Path.of(
    "seam",
    [[0, 0, 0], [10, 0, 0], [20, 0, 5]],
    [[1, 0, 0, 0]] * 3,
    kinds=[Kind.LINEAR, Kind.VIA, Kind.END],
    speeds=[Speed(100.0), Speed(50.0)],
    blends=[Blend(5.0), FINE],
    speed=[0, 0, 1],
    blend=[0, 0, 1],
)
MOTION = Motion(Speed(100.0), FINE)
PROGRAM = Program(
    "plate",
    (
        Procedure(
            "main",
            (
                Comment("to the plate"),
                Move("joint", Name("p1"), MOTION),
                If((Branch(Name("go"), (Wait(Number(0.5)),)),), (SetSignal("glue", Number(1)),)),
                Follow(PATH),
            ),
        ),
        Procedure("home", (Wait(Number(1)),)),
    ),
    signals={"glue": Signal("digital", "output", 10)},
    targets={"p1": Target(Pose((100.0, 0.0, 50.0)), Configuration())},
)


def body(program: Program, index: int, statement: object) -> Program:
    main = program.procedures[0]
    changed = (*main.body[:index], statement, *main.body[index + 1 :])
    return replace(program, procedures=(replace(main, body=changed), *program.procedures[1:]))


def test_a_program_is_the_same_as_itself_and_everything_is_counted():
    result = compare(PROGRAM, PROGRAM)
    assert result.same
    assert result.statements == 7 + 3  # seven statements, three rows of the path
    assert result.targets == 1 + 3
    assert (result.position, result.angle) == (0.0, 0.0)


def test_the_order_of_procedures_does_not_count():
    assert compare(PROGRAM, replace(PROGRAM, procedures=PROGRAM.procedures[::-1])).same


CHANGES = {
    "comment": lambda p: body(p, 0, Comment("to the table")),
    "kind of move": lambda p: body(p, 1, Move("linear", Name("p1"), MOTION)),
    "target name": lambda p: body(p, 1, Move("joint", Name("p2"), MOTION)),
    "tool": lambda p: body(p, 1, Move("joint", Name("p1"), replace(MOTION, tool="gun"))),
    "speed": lambda p: body(p, 1, Move("joint", Name("p1"), replace(MOTION, speed=Speed(101.0)))),
    "statement gone": lambda p: replace(
        p, procedures=(replace(p.procedures[0], body=p.procedures[0].body[1:]), p.procedures[1])
    ),
    "procedure gone": lambda p: replace(p, procedures=p.procedures[:1]),
    "signal number": lambda p: replace(p, signals={"glue": Signal("digital", "output", 11)}),
    "configuration": lambda p: replace(
        p, targets={"p1": Target(Pose((100.0, 0.0, 50.0)), Configuration(flip=True))}
    ),
    "target gone": lambda p: replace(p, targets={}),
    "external axis": lambda p: replace(
        p, targets={"p1": replace(p.targets["p1"], external=(0.0,) * 6)}
    ),
    "inner wait": lambda p: body(
        p, 2, If((Branch(Name("go"), (Wait(Number(0.6)),)),), p.procedures[0].body[2].otherwise)
    ),
    "path kinds": lambda p: body(p, 3, Follow(replace(PATH, kinds=np.zeros(3, np.uint8)))),
    "path speed": lambda p: body(p, 3, Follow(replace(PATH, speeds=(Speed(100.0), Speed(51.0))))),
    "path blend": lambda p: body(p, 3, Follow(replace(PATH, blend=np.array([0, 1, 1], np.int32)))),
    "path row gone": lambda p: body(p, 3, Follow(PATH.rows(0, 2))),
    "nan": lambda p: body(p, 3, Follow(replace(PATH, positions=PATH.positions * np.nan))),
}


@every_row("change", list(CHANGES))
def test_every_change_is_found(change):
    result = compare(PROGRAM, CHANGES[change](PROGRAM), Tolerance(1e-3, 1e-3, 1e-6))
    assert not result.same
    assert str(result.mismatches[0].about)


def test_tables_in_another_order_are_the_same_path():
    other = replace(
        PATH,
        speeds=PATH.speeds[::-1],
        speed=(1 - PATH.speed).astype(np.int32),
        tools=("unused", *PATH.tools),
        tool=PATH.tool + 1,
    )
    assert other == PATH
    assert compare(PROGRAM, body(PROGRAM, 3, Follow(other))).same


def test_deviations_are_measured_and_the_worst_is_named():
    moved = PATH.positions.copy()
    moved[1] += [0.003, 0.004, 0.0]
    other = body(PROGRAM, 3, Follow(replace(PATH, positions=moved)))
    result = compare(PROGRAM, other, Tolerance(position=0.005, angle=0.1))
    assert result.same
    assert result.position == pytest.approx(0.005)
    assert result.worst == "path seam row 2"
    assert not compare(PROGRAM, other, Tolerance(position=0.0039)).same


def test_a_quaternion_and_its_negative_are_the_same_rotation():
    negated = body(PROGRAM, 3, Follow(replace(PATH, quaternions=-PATH.quaternions)))
    assert compare(PROGRAM, negated, Tolerance(angle=1e-9)).same


PARTS = (
    e.Number(16),
    e.Verbatim("rapid", "a(1)"),
    e.TargetValue(Target(IDENTITY, Configuration())),
    p.WaitSignal("gi1", e.Number(5)),
    p.WaitUntil(e.Binary("=", e.Name("gi1"), e.Number(5))),
    p.If((p.Branch(e.Truth(True), (p.Stop(),)),)),
    p.For("i", e.Number(1), e.Number(2), ()),
    p.Opaque("rapid", "two\nlines"),
    Signal("group", "input", 3, 4),
    Variable("number", e.Number(3), (2,)),
    Tool(IDENTITY),
    Procedure("job", ()),
    Speed(100.0),
    p.Branch(e.Truth(True), ()),
    p.If(()),
    (e.Number(1), p.Stop()),
    None,
    "a text",
)


@every_row("part", PARTS)
def test_what_differs_is_told_in_words_of_the_text_form(part: Any) -> None:
    text = part_text(part)
    assert text and "\n" not in text
    assert not re.search(r"[A-Za-z]+\([a-z]+=|<.* object|\bNone\b|\bTrue\b", text)


def test_a_wait_that_became_another_is_told_in_words() -> None:
    first = Procedure("main", (p.WaitSignal("gi1", e.Number(5)),))
    second = Procedure("main", (p.WaitUntil(e.Binary("=", e.Name("gi1"), e.Number(5))),))
    found = compare(Program("job", (first,)), Program("job", (second,)))
    assert [m.message for m in found.mismatches] == [
        "`wait for gi1 = 5` became `wait until gi1 = 5`"
    ]
