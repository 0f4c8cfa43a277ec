"""A program that was read, lifted and changed: its text changes where the program does."""

from __future__ import annotations

import difflib
import random
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages, robots
from assistant.base.source_text import SourceText
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.comparison import Tolerance, compare
from assistant.program.geometry import Pose
from assistant.program.program import Program
from tests.examples import drawn

FIVE = languages.get("melfa-basic-5")
FOUR = languages.get("melfa-basic-4")

TEXT = """\
1 ' weld and go home
2 *Start   ' again and again
3  Ovrd  50
4  Spd 100     ' slow
5     Mov   pAbove
6     Mvs   pSeam , -50
7     Mvs   pSeam
8  Dly 0.50    ' settle
9  HClose 1
10 If M_In(8)=1 Then GoTo *Start
11 For M1=1 To 10
12   Mov  P1
13   M_Out(10) = 1
14 Next
15 End
P1=(1.5,2,300,0,180,0)(7,0)
pAbove=(+500.000,+0.000,+500.000,+180.000,+0.000,+180.000)(7,0)
pSeam = (500, 0, 400, 180, 0, 180)(7,0)
"""


def changes(before: str, after: str) -> list[str]:
    lines = (text.splitlines() for text in (before, after))
    found = list(difflib.unified_diff(*lines, n=0, lineterm=""))[2:]
    return [line for line in found if not line.startswith("@@")]


def lowered(language: Any, text: str, change: Any) -> tuple[str, Program]:
    """The text of a program after a change of what it was lifted to, and the changed program."""
    program = change(language.lift(language.parse(SourceText(text, "job.prg"))))
    return language.render(language.lower(program)), program


def with_body(program: Program, change: Any) -> Program:
    first, *others = program.procedures
    body = tuple(change(list(first.body)))
    return replace(program, procedures=(replace(first, body=body), *others))


def at(body: list[p.Statement], kind: Any) -> int:
    return next(k for k, statement in enumerate(body) if isinstance(statement, kind))


def wait(seconds: float) -> Any:
    def change(body: list[p.Statement]) -> list[p.Statement]:
        body[at(body, p.Wait)] = p.Wait(e.Number(seconds))
        return body

    return lambda program: with_body(program, change)


def test_nothing_changes_without_a_change() -> None:
    assert lowered(FIVE, TEXT, lambda program: replace(program))[0] == TEXT


def test_a_statement_changes_within_its_line() -> None:
    after, _ = lowered(FIVE, TEXT, wait(0.75))
    assert changes(TEXT, after) == ["-8  Dly 0.50    ' settle", "+8  Dly 0.75    ' settle"]


def test_a_target_changes_its_line() -> None:
    def change(program: Program) -> Program:
        target = program.targets["P1"]
        moved = replace(target, pose=replace(target.pose, position=(1.5, 7.0, 300.0)))
        return replace(program, targets={**program.targets, "P1": moved})

    after, _ = lowered(FIVE, TEXT, change)
    assert changes(TEXT, after) == [
        "-P1=(1.5,2,300,0,180,0)(7,0)",
        "+P1=(+1.50,+7.00,+300.00,+0.00,+180.00,+0.00)(7,0)",
    ]


def test_a_position_of_five_axes_changes_its_line() -> None:
    arm = robots.get("rv-2aj")
    text = "10 MOV P1 ' there\n20 END\nP1=(250,0,250,20,150)(6,0)\n"
    program = FOUR.lift(FOUR.parse(SourceText(text, "job.prg")), arm)
    (name,), (target,) = program.targets, program.targets.values()
    moved = replace(target, pose=Pose((260.0, 0.0, 250.0), target.pose.quaternion))
    after = FOUR.render(FOUR.lower(replace(program, targets={name: moved}), arm))
    assert changes(text, after) == [
        "-P1=(250,0,250,20,150)(6,0)",
        "+P1=(+260.00,+0.00,+250.00,+20.00,+150.00,+0.00)(6,0)",
    ]


def test_a_speed_changes_its_line_and_holds_no_longer_than_before() -> None:
    def change(body: list[p.Statement]) -> list[p.Statement]:
        where = at(body, p.Move)
        move: Any = body[where]
        slower = replace(move.motion, speed=replace(move.motion.speed, tcp=60.0))
        body[where] = replace(move, motion=slower)
        return body

    text = TEXT.replace("5     Mov   pAbove\n", "")  # which no speed of lines is for
    after, _ = lowered(FIVE, text, lambda program: with_body(program, change))
    lines = changes(text, after)
    assert lines[:2] == ["-4  Spd 100     ' slow", "+4  Spd 60     ' slow"]
    assert any(line.startswith("+") and line.endswith("Spd 100") for line in lines[2:])


def test_new_statements_get_numbers_in_between() -> None:
    text = TEXT
    for number in range(15, 0, -1):
        text = text.replace(f"\n{number} ", f"\n{number}0 ")
    text = "10" + text[1:]

    def change(body: list[p.Statement]) -> list[p.Statement]:
        where = at(body, p.Wait) + 1
        return [*body[:where], p.Gripper("open", 2), p.Wait(e.Number(1)), *body[where:]]

    after, _ = lowered(FIVE, text, lambda program: with_body(program, change))
    assert changes(text, after) == ["+83 HOpen 2", "+86 Dly 1"] or changes(text, after) == [
        "+83  HOpen 2", "+86  Dly 1",
    ]  # fmt: skip


def test_where_there_is_no_room_lines_move_on_with_their_jumps() -> None:
    text = (
        "1 Mov P1\n2 Dly 1\n3 Dly 2\n4 M1=M1+1\n5 If M1<3 Then 3\n9 GoTo 1\nP1=(1,2,3,0,0,0)(7,0)\n"
    )
    program = FIVE.lift(FIVE.parse(SourceText(text, "job.prg")))
    waits = [s for s in program.procedures[0].body if isinstance(s, p.Wait)]
    assert len(waits) == 2

    def change(body: list[p.Statement]) -> list[p.Statement]:
        where = body.index(waits[0]) + 1
        return [*body[:where], p.Wait(e.Number(7)), *body[where:]]

    after, _ = lowered(FIVE, text, lambda program: with_body(program, change))
    assert after == (
        "1 Mov P1\n2 Dly 1\n3 Dly 7\n4 Dly 2\n5 M1=M1+1\n6 If M1<3 Then 4\n9 GoTo 1\n"
        "P1=(1,2,3,0,0,0)(7,0)\n"
    )


def test_what_was_written_by_the_compiler_is_changed_in_place() -> None:
    for language in (FOUR, FIVE):
        program = replace(FIVE.lift(FIVE.parse(TEXT)), origin=None)
        text = language.render(language.lower(program))
        text = text.replace("\r\n", " \r\n")
        after, _ = lowered(language, text, wait(0.25))
        word = "DLY" if language is FOUR else "Dly"
        old, new = changes(text, after)
        assert old.split(" ", 1)[1] == f"{word} 0.5 ' settle "
        assert new.split(" ", 1)[1] == f"{word} 0.25 ' settle "


simple = st.one_of(
    st.builds(p.Wait, st.sampled_from([0.25, 1.0, 3.5]).map(e.Number)),
    st.builds(p.Gripper, st.sampled_from(["open", "close"]), st.integers(1, 3)),
    st.builds(p.SetOverride, st.integers(1, 100).map(e.Number)),
    st.builds(p.Comment, st.sampled_from(["a note", "another"])),
)


@pytest.mark.parametrize("level", [4, 5, 6])
@given(data=st.data(), seed=st.integers(0, 9))
@settings(max_examples=drawn(15), deadline=None)
def test_any_edit_is_in_the_text_and_nothing_else(
    level: int, data: st.DataObject, seed: int
) -> None:
    language = languages.get(f"melfa-basic-{level}")
    chance = random.Random(seed)
    lines = TEXT.splitlines()
    if level == 4:
        lines = [line.upper() for line in lines]
        lines[9] = lines[9].replace("GOTO ", "")
    text = "\r\n".join(line + " " * chance.randrange(3) for line in lines) + "\r\n"

    def change(body: list[p.Statement]) -> list[p.Statement]:
        where = data.draw(st.integers(0, len(body)))
        kind = data.draw(st.sampled_from(["insert", "replace", "remove"]))
        if kind == "insert" or where == len(body) or isinstance(body[where], p.Label):
            return [*body[:where], data.draw(simple), *body[where:]]
        put = [data.draw(simple)] if kind == "replace" else []
        return [*body[:where], *put, *body[where + 1 :]]

    after, program = lowered(language, text, lambda program: with_body(program, change))
    again = language.lift(language.parse(SourceText(after, "job.prg")))
    precision = language.precision
    tolerance = Tolerance(precision.position, precision.angle, precision.number)
    adapted = language.adapt(program).program
    assert compare(adapted, again, tolerance).same or compare(program, again, tolerance).same
    if "robot-assistant" not in after:
        bare = [line.lstrip("0123456789") for line in text.splitlines()]
        kept = [line.lstrip("0123456789") for line in after.splitlines()]
        assert len(set(bare) - set(kept)) <= 3
