"""Random RAPID programs do in MELFA-BASIC what they did, as two interpreters tell it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path as FilePath

import pytest

from assistant import languages
from assistant.virtual import melfa, rapid
from assistant.virtual.events import Run
from tests.virtual import rapid_words
from tests.virtual.one_cycle import one_cycle
from tests.virtual.random_rapid import program
from tests.virtual.translating import START, Inputs, Tally, judge

NUMBERS = rapid_words.numbers()
LANGUAGES = {"melfa-basic-4": 0.4, "melfa-basic-5": 0.6, "melfa-basic-6": 0.6}
"""With the part of programs that has to be translated."""


def run_rapid(text: str, inputs: Inputs, most_steps: int) -> Run:
    tree = languages.get("rapid").parse(text)
    return rapid.run(tree, inputs=inputs, start=START, most_steps=most_steps)


def run_melfa(language: str, text: str, inputs: Inputs, most_steps: int) -> Run:
    tree = languages.get(language).parse(one_cycle(text))
    bits = {
        number: int(value) >> place & 1
        for name, value in inputs.items()
        for place, number in enumerate(NUMBERS[name])
    }
    return melfa.run(tree, inputs=bits, start=START, most_steps=most_steps)


Case = tuple[str, str, Sequence[Inputs]]
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


def tally_of(language: str, seeds: range, folder: FilePath) -> Tally:
    """Programs of some seeds."""
    drawn = ((seed, program(seed)) for seed in seeds)
    tally = judged(language, ((f"seed {n}", one.text, one.scenarios) for n, one in drawn), folder)
    print(f"rapid to {language}: {tally}")  # noqa: T201
    return tally


@pytest.mark.parametrize("language", LANGUAGES)
def test_random_programs_do_the_same(language: str, tmp_path: FilePath) -> None:
    tally = tally_of(language, range(5), tmp_path)
    assert tally.kept == []
    assert tally.counts["equal"] > 0


@pytest.mark.slow
@pytest.mark.parametrize("language", LANGUAGES)
def test_a_thousand_random_programs_do_the_same(language: str, tmp_path: FilePath) -> None:
    tally = tally_of(language, range(1000), tmp_path)
    assert tally.kept == []
    assert tally.counts["translated"] >= LANGUAGES[language] * tally.counts["tried"], tally.reasons
