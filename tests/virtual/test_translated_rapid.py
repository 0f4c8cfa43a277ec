"""Random RAPID programs do in MELFA-BASIC what they did, as two interpreters tell it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path as FilePath

import pytest

from assistant.virtual import melfa, rapid
from assistant.virtual.events import Run
from assistant.virtual.kernel.kernel import Source
from tests.virtual import rapid_words
from tests.virtual.one_cycle import one_cycle
from tests.virtual.random_rapid import drawn_with_more, program
from tests.virtual.translating import START, Changing, Inputs, Tally, Text, judge, parsed

NUMBERS = rapid_words.numbers()
LANGUAGES = {"melfa-basic-4": 0.4, "melfa-basic-5": 0.6, "melfa-basic-6": 0.6}
"""With the part of programs that has to be translated."""


def run_rapid(text: Text, inputs: Inputs, most_steps: int) -> Run:
    trees, _ = parsed("rapid", text)
    read: Source = inputs
    if isinstance(inputs, Changing):
        bit = inputs.bits()

        def read(name: str) -> float:
            return float(sum(bit(number) << at for at, number in enumerate(NUMBERS.get(name, ()))))

    return rapid.run(trees, inputs=read, start=START, most_steps=most_steps)


def run_melfa(language: str, text: Text, inputs: Inputs, most_steps: int) -> Run:
    texts = {"MAIN": text} if isinstance(text, str) else text
    trees, names = parsed(language, {name: one_cycle(one) for name, one in texts.items()})
    bits: Callable[[int], int] | dict[int, int] = {
        number: int(value) >> place & 1
        for name, value in inputs.items()
        for place, number in enumerate(NUMBERS[name])
    }
    if isinstance(inputs, Changing):
        bits = inputs.bits()
    return melfa.run(trees, inputs=bits, names=names, start=START, most_steps=most_steps)


Case = tuple[str, Text, Sequence[Inputs]]
"""What a program is called, its text, and the inputs that it is run with."""


def judged(language: str, cases: Iterable[Case], folder: FilePath) -> Tally:
    """Programs translated to a language and compared."""
    process = folder / "cell.process.toml"
    process.write_text(rapid_words.process_file(), encoding="utf-8")
    tally = Tally()
    for name, text, scenarios in cases:
        judge(
            tally,
            name,
            text,
            scenarios,
            source=("rapid", run_rapid),
            target=(language, lambda *given: run_melfa(language, *given)),
            process=process,
            signals=NUMBERS,
        )
    return tally


def says_the_same(case: Case, language: str, folder: FilePath) -> None:
    """Asserts that one program is translated whole, and does the same."""
    tally = judged(language, [case], folder)
    assert tally.kept == []
    assert not tally.reasons
    assert tally.counts["equal"] == 1


def tally_of(language: str, seeds: Iterable[int], folder: FilePath) -> Tally:
    """Programs of some seeds."""
    drawn = ((seed, program(seed)) for seed in seeds)
    tally = judged(language, ((f"seed {n}", one.text, one.scenarios) for n, one in drawn), folder)
    print(f"rapid to {language}: {tally}")  # noqa: T201
    return tally


def more_tally_of(language: str, seeds: Iterable[int], folder: FilePath) -> Tally:
    """Programs of `drawn_with_more`, with inputs that change at each read."""
    drawn = ((seed, drawn_with_more(seed)) for seed in seeds)
    tally = judged(language, ((f"seed {n}", one.texts, one.scenarios) for n, one in drawn), folder)
    print(f"rapid to {language}, changing inputs: {tally}")  # noqa: T201
    return tally


@pytest.mark.one_in(3)
@pytest.mark.parametrize("language", LANGUAGES)
def test_random_programs_do_the_same(language: str, tmp_path: FilePath) -> None:
    tally = tally_of(language, (2, 4), tmp_path)  # of the first five those that reach most
    assert tally.kept == []
    assert tally.counts["equal"] > 0


def test_programs_with_changing_inputs_do_the_same(tmp_path: FilePath) -> None:
    tally = more_tally_of("melfa-basic-6", (1,), tmp_path)
    assert tally.kept == []
    assert tally.counts["equal"] > 0


@pytest.mark.slow
@pytest.mark.parametrize("language", LANGUAGES)
def test_many_programs_with_changing_inputs_do_the_same(language: str, tmp_path: FilePath) -> None:
    tally = more_tally_of(language, range(60), tmp_path)
    assert tally.kept == []


@pytest.mark.slow
@pytest.mark.parametrize("language", LANGUAGES)
def test_many_random_programs_do_the_same(language: str, tmp_path: FilePath) -> None:
    tally = tally_of(language, range(60), tmp_path)
    assert tally.kept == []
    assert tally.counts["translated"] >= LANGUAGES[language] * tally.counts["tried"], tally.reasons
