"""Valid programs pass: some here, as many as there is time for by `python -m tests.fuzz.valid`."""

from __future__ import annotations

from random import Random

import pytest

from tests.fuzz.valid.passing import STAGES
from tests.fuzz.valid.table import GENERATORS

FIRST = 1_000_000
"""Numbers that the long run does not come to."""


@pytest.mark.parametrize("kind", GENERATORS)
def test_the_same_seed_gives_the_same_program(kind: str) -> None:
    one, two = (GENERATORS[kind](Random(kind)) for _ in range(2))
    assert one == two
    assert one[0] != GENERATORS[kind](Random("another"))[0]


@pytest.mark.parametrize("number", range(2))
@pytest.mark.parametrize("kind", GENERATORS)
def test_valid_programs_are_read(kind: str, number: int) -> None:
    for at in range(4):
        seed = f"{kind} {FIRST + 4 * number + at}"
        text, _ = GENERATORS[kind](Random(seed))
        STAGES[kind][0].run(kind, text, Random(seed))


@pytest.mark.parametrize("kind", GENERATORS)
def test_valid_programs_pass(kind: str) -> None:
    for number in range(2):
        seed = f"{kind} {FIRST + number}"
        text, _ = GENERATORS[kind](Random(seed))
        for stage in STAGES[kind][1:]:
            stage.run(kind, text, Random(f"{seed} {stage.name}"))


@pytest.mark.slow
@pytest.mark.parametrize("kind", GENERATORS)
def test_many_valid_programs_pass(kind: str) -> None:
    for number in range(200):
        seed = f"{kind} {FIRST + number}"
        text, _ = GENERATORS[kind](Random(seed))
        for stage in STAGES[kind]:
            stage.run(kind, text, Random(f"{seed} {stage.name}"))
