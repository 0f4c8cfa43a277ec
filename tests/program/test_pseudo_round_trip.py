"""The text form says everything that a program can say, and says it one way."""

from __future__ import annotations

import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from assistant.program.expressions import Name
from assistant.program.motion import Blend, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.pseudo import parse, print_program
from assistant.program.statements import Follow, Motion, MoveJoints, Statement, Trigger
from tests import strategies
from tests.examples import drawn

PATIENT = settings(
    deadline=None,
    max_examples=drawn(200),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
BRIEF = settings(PATIENT, max_examples=drawn(100))
THOROUGH = settings(PATIENT, max_examples=drawn(1000))


def holding(*body: Statement) -> Program:
    return Program("p", (Procedure("main", body),))


def comes_back(program: Program, side_tables_above: int | None = None) -> None:
    printed = print_program(program, side_tables_above=side_tables_above)
    text = printed.encode().decode()
    again = parse(text, side_tables=printed.tables)
    assert again == program
    twice = print_program(again, side_tables_above=side_tables_above)
    assert twice == printed
    crlf = parse(text.replace("\n", "\r\n"), side_tables=printed.tables)
    assert crlf == program


@BRIEF
@given(strategies.programs())
def test_programs_come_back(program: Program) -> None:
    comes_back(program)


@pytest.mark.slow
@THOROUGH
@given(strategies.programs())
def test_many_programs_come_back(program: Program) -> None:
    comes_back(program, side_tables_above=4)


@BRIEF
@given(strategies.statements())
def test_statements_come_back(statement: Statement) -> None:
    comes_back(holding(statement))


@BRIEF
@given(st.lists(strategies.triggers_of(strategies.expressions(3)), min_size=1, max_size=2))
def test_outputs_on_the_way_of_a_move_come_back(triggers: list[Trigger]) -> None:
    motion = Motion(Speed(100.0), Blend())
    comes_back(holding(MoveJoints(Name("there"), motion, tuple(triggers))))


@BRIEF
@given(strategies.paths())
def test_paths_come_back(path: Path) -> None:
    comes_back(holding(Follow(path)))


@BRIEF
@given(strategies.paths())
def test_rows_of_unusual_layout_mean_the_same(path: Path) -> None:
    """The short cut for usual rows and the grammar agree."""
    text = print_program(holding(Follow(path))).text
    spaced = re.sub(r"(?m)^( +(?:joint|linear|via|to)) \[", r"\1\t  [ ", text)
    again = parse(spaced)
    assert again == holding(Follow(path))
    assert print_program(again).text == text


@BRIEF
@given(strategies.paths())
def test_paths_come_back_from_side_tables(path: Path) -> None:
    comes_back(holding(Follow(path), Follow(path)), side_tables_above=0)
