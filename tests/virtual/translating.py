"""Random programs translated, and both run: what becomes of them, counted."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path as FilePath
from tempfile import TemporaryDirectory
from typing import Any, TypeVar
from zlib import crc32

import pytest

import assistant
from assistant import languages, robots
from assistant.base.diagnostics import Severity
from assistant.base.source_text import SourceText
from assistant.compiler.arms import Arms as KnownArms
from assistant.compiler.loader import Loaded, load, load_text
from assistant.compiler.motion_proof import Proving, prove_motion
from assistant.compiler.motion_proof import written_pair as written_files
from assistant.compiler.program_files import Task, load_task
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.virtual.events import Run
from assistant.virtual.proving.compared_programs import Side
from assistant.virtual.proving.comparison import Bits, Rounding, difference

START = Pose((320.0, 10.0, 420.0), (0.0, 0.0, 1.0, 0.0))
"""Where the flange is before both programs."""
MOST_STEPS = 20_000
MORE_STEPS = 400_000
"""Of what is written: one statement may become several."""

Inputs = Mapping[str, float]
Arms = tuple[str, str]
Text = str | Mapping[str, str]
"""A text, or the texts of programs by their names, of which the first one calls the others."""
Running = Callable[[Text, Inputs, int], Run]
"""Runs a text with inputs by the names of the source, for at most some steps."""


Version = TypeVar("Version", str, int)


def in_turn(
    cases: Iterable[str],
    versions: Sequence[Version],
    also: Collection[tuple[str, Version]] = (),
) -> list[Any]:
    """Parameters of each case with each version. `make test` runs a case with one version, which
    is the next one for each case, and the pairs of `also`: together they reach what all reach.
    """
    return [
        pytest.param(
            case,
            version,
            marks=[] if turn == at % len(versions) or (case, version) in also else pytest.mark.slow,
        )
        for at, case in enumerate(cases)
        for turn, version in enumerate(versions)
    ]


class Changing(dict[str, float]):
    """Inputs that may change at each read: a bit is drawn by its number and how often it was read.

    The programs that are compared get the same values as long as each reads as often as the other.
    """

    def __init__(self, seed: int) -> None:
        super().__init__()
        self.seed = seed

    def bits(self) -> Callable[[int], int]:
        """Value of an input bit at its next read, from the first one on."""
        reads: Counter[int] = Counter()

        def read(number: int) -> int:
            reads[number] += 1
            return crc32(f"{self.seed} {number} {reads[number]}".encode()) >> 7 & 1

        return read


def parsed(language: str, text: Text) -> tuple[list[Any], tuple[str, ...]]:
    """The trees of a text in a language, and their names."""
    texts = {"MAIN": text} if isinstance(text, str) else text
    return [tree_of(language, one) for one in texts.values()], tuple(texts)


@lru_cache(maxsize=16)
def tree_of(language: str, text: str) -> Any:
    """The tree of a text, which is parsed once for all scenarios that it is run in."""
    return languages.get(language).parse(text)


RUN = ("equal", "different", "open", "not judged", "failing")
"""What may become of a program that is translated and run."""
OPEN = frozenset({"MB259"})
"""Findings on what the controller of the source leaves open."""


@dataclass(slots=True)
class Tally:
    """What became of programs. kept: a line on each that is different or crashed.

    reasons: how often each code refused one.
    """

    counts: Counter[str] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    kept: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        words = ("tried", "translated", *RUN, "refused", "crashed")
        return ", ".join(f"{self.counts[word]} {word}" for word in words)


def judge(
    tally: Tally,
    name: str,
    text: Text,
    scenarios: Sequence[Inputs],
    *,
    source: tuple[str, Running],
    target: tuple[str, Running],
    signals: Bits,
    process: FilePath | None = None,
    arms: Arms | None = None,
) -> str:
    """Translates a program and compares both; the word that it is counted under.

    The scenarios are run, and a few that are sought for its branches. Places may be apart by what
    the decimals of the translation leave open.

    source, target: a language and what runs its texts. arms: for which robot it is written, and for
    which it is to be. A program that comes to nothing its interpreter knows is `not judged`, one
    whose source stops with an error whatever its inputs are is `failing`, and one that is different
    where a finding says that its own controller leaves it open is `open`.
    """
    tally.counts["tried"] += 1
    word, said = _judged(text, scenarios, source, target, process, signals, arms, tally)
    if word in RUN:
        tally.counts["translated"] += 1
    tally.counts[word] += 1
    if word in ("different", "open", "crashed"):
        tally.kept.append(f"{name}: {word}: {said}")
    return word


def _judged(
    text: Text,
    scenarios: Sequence[Inputs],
    source: tuple[str, Running],
    target: tuple[str, Running],
    process: FilePath | None,
    signals: Bits,
    arms: Arms | None,
    tally: Tally,
) -> tuple[str, str]:
    try:
        first, second = (None, None) if arms is None else (robots.get(name) for name in arms)
        loaded = loaded_as(source[0], text, process, first)
        translation = assistant.translate(loaded, to=target[0], robot=second, from_robot=first)
    except Exception as error:  # noqa: BLE001 - a crash is what is looked for
        return "crashed", repr(error)
    errors = [f for f in translation.findings if f.severity is Severity.ERROR]
    crashes = [f for f in errors if f.code in CRASHES]
    if crashes:
        return "crashed", f"{crashes[0].code} {crashes[0].message}"
    if not translation.ok:
        tally.reasons.update({f"{f.code} {f.message}" for f in errors})
        return "refused", ""
    language = languages.get(target[0])
    made = {
        FilePath(name).stem: language.decode(data).text for name, data in translation.files.items()
    }
    written: Text = made if len(made) > 1 else next(iter(made.values()))
    rounding = rounding_of(target[0], written)
    different = "open" if OPEN & {f.code for f in translation.findings} else "different"
    judged, ends = False, set()
    for inputs in scenarios:
        one = source[1](text, inputs, MOST_STEPS)
        ends.add(one.ended)
        if one.ended in ("unknown", "error"):
            continue
        two = target[1](written, inputs, MORE_STEPS)
        found = difference(one, two, signals, rounding)
        if found is not None:
            return different, found
        judged = judged or two.ended != "unknown"
    compiled = translation.compiled
    whole = written_files(compiled.source, compiled.program, compiled.language, translation.files)
    proof = prove_motion(whole, KnownArms(second, first), SOUGHT)
    for finding in proof.findings:
        if finding.code == "CO110" and not FAILS_ITSELF.search(finding.message):
            return different, finding.message
    if judged or proof.holds:
        return "equal", ""
    return ("failing" if ends == {"error"} else "not judged"), ""


def loaded_as(
    language: str, text: Text, process: FilePath | None = None, robot: Robot | None = None
) -> Loaded:
    """A text as it is loaded; programs that call each other from the files that they are."""
    if isinstance(text, str):
        return load_text(SourceText(text), process=process, robot=robot, language=language)
    with TemporaryDirectory() as name:
        files = [FilePath(name, f"{one}{SUFFIXES[language]}") for one in text]
        for file, own in zip(files, text.values(), strict=True):
            file.write_text(own, encoding="ascii")
        if language == "rapid":
            task = Task(str(files[0]), tuple(map(str, files)), language)
            return load_task(task, process=process, robot=robot)
        return load(files[0], process=process, robot=robot, language=language)


SUFFIXES = {"rapid": ".mod", "melfa-basic-4": ".mb4", "melfa-basic-5": ".mb5"}
SUFFIXES["melfa-basic-6"] = ".mb6"


def rounding_of(language: str, text: Text) -> Rounding:
    """What a text in a language leaves open of the places in it."""
    spoken = languages.get(language)
    precision = spoken.precision
    side = Side(family=spoken.family, trees=tuple(parsed(language, text)[0]))
    return Rounding(precision.position, precision.angle, precision.position).of(side.constants())


FAILS_ITSELF = re.compile(r"event \d+: ended as `error`")
"""The source stops with an error of its own, which the written program need not have: an arm of
another maker has other ones.
"""
SOUGHT = Proving(runs=3, seconds=5.0)

CRASHES = ("CL900", "CO102", "CO103")
"""That the project itself failed, or wrote what it would refuse."""
