"""Timers that a language counts in parts of seconds."""

from __future__ import annotations

import pytest

from assistant.program import expressions as e
from assistant.program.timers import in_seconds

TIMER = e.Elapsed("t")
COUNTED = e.Binary("*", TIMER, e.Number(1000))


@pytest.mark.parametrize(
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
    assert in_seconds(operator, left, right, 1000) == said
