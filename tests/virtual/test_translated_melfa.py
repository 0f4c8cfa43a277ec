"""Random MELFA-BASIC programs do in RAPID what they did, as two interpreters tell it."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import pytest

from assistant import robots
from assistant.virtual import melfa
from assistant.virtual.events import Run
from assistant.virtual.kernel import Board, Kernel, Signals
from assistant.virtual.proving.compared_programs import STATEMENT_TIME
from assistant.virtual.rapid.interpreter import start_task
from tests.virtual.random_melfa import drawn, program
from tests.virtual.translating import (
    START,
    Arms,
    Changing,
    Inputs,
    Tally,
    Text,
    judge,
    parsed,
)

ARMS = ("rv-4frl", "irb1200-7-0.7")
LEAST = {4: 0.4, 5: 0.6, 6: 0.6}
"""The part of the programs of MELFA-BASIC IV, V and VI that has to be translated."""
HANDS = {"hand1": 9001, "hand1_open": 9001, "hand2": 9002, "hand2_open": 9002}
"""Numbers of no signals."""
GROUPS = {"do": 1, "di": 1, "go_8": 8, **{f"gi_{bits}": bits for bits in range(1, 9)}}
"""How signals are named that come from MELFA-BASIC, and their bits."""
NUMBERS = range(1, 40)
SIGNALS = {name: [number] for name, number in HANDS.items()} | {
    f"{kind}_{first}": list(range(first, first + bits))
    for kind, bits in GROUPS.items()
    for first in NUMBERS
}

SCENARIOS: tuple[Inputs, ...] = (
    {},
    {"1": 1, "8": 1, "9": 1, "24": 1},
    {"2": 1, "3": 1, "10": 1, "25": 1, "27": 1},
)
"""Inputs that are on, by number."""


def run_melfa(level: int, arms: Arms | None, text: Text, inputs: Inputs, most_steps: int) -> Run:
    trees, names = parsed(f"melfa-basic-{level}", text)
    robot = None if arms is None else robots.get(arms[0])
    return melfa.run(
        trees, inputs=bits(inputs), names=names, start=START, robot=robot, most_steps=most_steps
    )


def run_rapid(arms: Arms | None, text: Text, inputs: Inputs, most_steps: int) -> Run:
    trees, _ = parsed("rapid", text)
    bit = bits(inputs)
    robot = None if arms is None else robots.get(arms[1])
    board = Board(Signals(lambda name: signal(name, bit)))
    kernel = Kernel(board, most_steps=most_steps, statement_time=STATEMENT_TIME)
    start_task(kernel, trees, robot=robot, start=START)
    return kernel.run()


def bits(inputs: Inputs) -> Callable[[int], int]:
    """Value of an input bit at each read."""
    if isinstance(inputs, Changing):
        return inputs.bits()
    return lambda number: int(inputs.get(str(number), 0))


def signal(name: str, bit: Callable[[int], int]) -> float:
    return float(sum(bit(number) << at for at, number in enumerate(SIGNALS.get(name, ()))))


def more_tally_of(level: int, seeds: Iterable[int]) -> Tally:
    """Programs of `drawn`, several files each, with inputs that change at each read."""
    language = f"melfa-basic-{level}"
    tally = Tally()
    for seed in seeds:
        judge(
            tally,
            f"seed {seed}",
            drawn(level, seed),
            (*SCENARIOS[:2], Changing(seed), Changing(-seed)),
            source=(language, lambda *given: run_melfa(level, None, *given)),
            target=("rapid", lambda *given: run_rapid(None, *given)),
            signals=SIGNALS,
        )
    print(f"{language} to rapid, changing inputs: {tally}")  # noqa: T201
    return tally


def tally_of(level: int, seeds: Iterable[int], arms: Arms | None = None) -> Tally:
    """Programs of some seeds, translated to RAPID and compared."""
    language = f"melfa-basic-{level}"
    tally = Tally()
    for seed in seeds:
        judge(
            tally,
            f"seed {seed}",
            program(level, seed, arms is not None),
            SCENARIOS,
            source=(language, lambda *given: run_melfa(level, arms, *given)),
            target=("rapid", lambda *given: run_rapid(arms, *given)),
            signals=SIGNALS,
            arms=arms,
        )
    print(f"{language} to rapid, {'two arms' if arms else 'no arm'}: {tally}")  # noqa: T201
    return tally


SEEDS = {4: (3, 6), 5: (1, 4), 6: (2, 4)}
"""Of the first eight those whose programs reach most."""
CHANGING = {4: (5,), 5: (0,), 6: (5,)}


@pytest.mark.parametrize("level", LEAST)
def test_random_programs_do_the_same(level: int) -> None:
    tally = tally_of(level, SEEDS[level])
    assert tally.kept == []
    assert tally.counts["equal"] > 0


def test_random_programs_do_the_same_with_two_arms() -> None:
    tally = tally_of(5, (0, 3), ARMS)
    assert tally.kept == []
    assert tally.counts["equal"] > 0


@pytest.mark.parametrize("level", LEAST)
def test_programs_with_changing_inputs_do_the_same(level: int) -> None:
    tally = more_tally_of(level, CHANGING[level])
    assert tally.kept == []


@pytest.mark.slow
@pytest.mark.parametrize("level", LEAST)
def test_many_programs_with_changing_inputs_do_the_same(level: int) -> None:
    tally = more_tally_of(level, range(60))
    assert tally.kept == []


@pytest.mark.slow
@pytest.mark.parametrize("arms", [None, ARMS], ids=["no arm", "two arms"])
@pytest.mark.parametrize("level", LEAST)
def test_many_random_programs_do_the_same(level: int, arms: Arms | None) -> None:
    tally = tally_of(level, range(60), arms)
    assert tally.kept == []
    assert tally.counts["not judged"] == 0
    assert tally.counts["failing"] <= max(1, 0.01 * tally.counts["tried"])
    assert tally.counts["translated"] >= LEAST[level] * tally.counts["tried"], tally.reasons
