"""Timers that a language counts in parts of seconds."""

from __future__ import annotations

import re

import pytest

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program
from assistant.program.undeclared_names import numbered_timers, timer_in_seconds
from tests.tables import every_row

TIMER = e.Elapsed("t")
COUNTED = e.Binary("*", TIMER, e.Number(1000))


@every_row(
    ("operator", "left", "right", "said"),
    [
        (">", COUNTED, e.Number(2500), e.Binary(">", TIMER, e.Number(2.5))),
        ("<", e.Number(3000), COUNTED, e.Binary("<", e.Number(3), TIMER)),
        ("/", COUNTED, e.Number(1000), TIMER),
        ("/", COUNTED, e.Number(10), e.Binary("/", COUNTED, e.Number(10))),
        ("/", e.Number(1000), COUNTED, e.Binary("/", e.Number(1000), COUNTED)),
        ("+", COUNTED, e.Number(5), e.Binary("+", COUNTED, e.Number(5))),
        (">", COUNTED, e.Name("n"), e.Binary(">", COUNTED, e.Name("n"))),
    ],
)
def test_milliseconds_beside_numbers_become_seconds(
    operator: str, left: e.Expression, right: e.Expression, said: e.Expression
) -> None:
    assert timer_in_seconds(operator, left, right, 1000) == said


@pytest.mark.parametrize(
    ("names", "count", "numbers", "free"),
    [
        (["timer_2", "a", "b"], 4, {"timer_2": 2, "a": 3, "b": 4}, 1),
        (["timer_12", "a"], 12, {"timer_12": 12, "a": 2}, 1),
        (["timer_12", "a"], 2, {"timer_12": 2, "a": 1}, 0),
        (["timer_02", "timer_2"], 4, {"timer_02": 3, "timer_2": 2}, 1),
        (["a", "b"], 1, {"a": 1}, 0),
    ],
)
def test_timers_have_numbers(
    names: list[str], count: int, numbers: dict[str, int], free: int
) -> None:
    body = tuple(p.StartTimer(name) for name in names)
    program = Program("job", (Procedure("main", body),))
    kept = re.compile("clock ([0-9]+)")
    assert numbered_timers(program, range(1, count + 1), kept) == (numbers, free)
