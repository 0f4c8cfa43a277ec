"""Valid programs as targets of `make fuzz`: an input is the seed of a program."""

from __future__ import annotations

from functools import partial
from random import Random
from typing import Final

from tests.fuzz.target import Target
from tests.fuzz.valid.passing import STAGES
from tests.fuzz.valid.table import GENERATORS


def run(kind: str, data: bytes) -> None:
    """Draws the program of a seed, and takes it through every stage."""
    seed = f"{kind} {data.hex()}"
    text, _ = GENERATORS[kind](Random(seed))
    for stage in STAGES[kind]:
        stage.run(kind, text, Random(f"{seed} {stage.name}"))


TARGETS: Final = tuple(
    Target(
        f"valid-{kind}", partial(run, kind), lambda: [b"one", b"two"], most=16, seconds=20, tried=1
    )
    for kind in GENERATORS
)
