"""What a program of MELFA-BASIC means, case by case, each with what states it.

`semantics/melfa/*.toml` holds the cases. `cites`: COSIROP is the help of that tool, by its page;
CR1D a page of the manual of that controller; four digits an entry of the lists of errors;
`melfa.md` a section of the reference that was collected for this project. `levels`: of MELFA-BASIC,
5 where none is stated. `values`: expressions and what each comes to. `program`: its text; `before`:
what stands in front of an expression; `programs`: further ones by name. `expected`: what the
program does. `options`: what the manuals leave open. `inputs`: those that are on. `ended`,
`message`: how it ends, `end` where nothing is stated. `Show` is a plug-in that tells a value.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from assistant import languages, robots
from assistant.virtual import melfa
from assistant.virtual.events import Moved, Run, Said, Stopped, Switched, Waited
from assistant.virtual.melfa import Given, Options
from assistant.virtual.melfa.values import Bare, Joints, Position, Value
from tests.virtual.melfa_cell import POSITIONS, START
from tests.virtual.tables import failures

FILES = sorted((Path(__file__).parent / "semantics" / "melfa").glob("*.toml"))


def cases(file: Path) -> Iterator[tuple[str, dict[str, Any], int, list[list[Any]]]]:
    """Names of the cases of a file, each with what it is, a version, and the values of one run."""
    for name, case in tomllib.loads(file.read_text(encoding="utf-8")).items():
        assert case["cites"]
        for level in case.get("levels", [5]):
            kept = [v for v in case.get("values", ()) if not _ends(v)]
            alone = [[v] for v in case.get("values", ()) if _ends(v)]
            for at, values in enumerate([kept, *alone] if kept else alone):
                yield f"{name}-{level}-{at}", case, level, values
            if "program" in case:
                yield f"{name}-{level}", case, level, []


def _ends(value: list[Any]) -> bool:
    """Whether an expression ends the run."""
    return str(value[1]).startswith(("error", "unknown"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_the_cases_of_a_file(file: Path) -> None:
    assert not failures((name, partial(holds, *case)) for name, *case in cases(file))


def holds(case: dict[str, Any], level: int, values: list[list[Any]]) -> None:
    """Asserts what a case states."""
    if not values:
        done, told = run(case, case["program"], level)
        assert (told, done.ended) == (case["expected"], case.get("ended", "end")), done.message
        assert case.get("message", "") in done.message
        assert set(case.get("notes", ())) <= set(done.notes)
        return
    lines = [f"M99=Show({expression})" for expression, _ in values]
    done, told = run(case, "\n".join([case.get("before", ""), *lines]), level)
    if _ends(values[0]):
        assert done.ended == values[0][1].split()[0]
        assert values[0][1] in f"unknown {done.message}", done.message
        return
    shown = [line for line in told if line.startswith("show ")]
    wanted = [(expression, f"show {_written(gives)}") for expression, gives in values]
    assert list(zip((e for e, _ in values), shown, strict=False)) == wanted, done.message
    assert done.ended == "end", done.message


def run(case: dict[str, Any], text: str, level: int) -> tuple[Run, list[str]]:
    """Runs the program of a case; what it does, as lines."""
    told: list[str] = []

    def show(given: Given) -> int:
        (shown,) = given.arguments
        assert shown is not None
        given.task.tell(Said(f"show {_written(shown)}"))
        return 0

    language = languages.get(f"melfa-basic-{level}")
    texts = [text.strip() + POSITIONS, *(t.strip() for t in case.get("programs", {}).values())]
    files = [language.parse(numbered(t)) for t in texts]
    assert not [finding for file in files for finding in file.findings]
    done = melfa.run(
        files,
        names=["MAIN", *case.get("programs", {})],
        inputs=dict.fromkeys(case.get("inputs", ()), 1),
        start=START,
        robot=robots.get(case["robot"]) if "robot" in case else None,
        options=Options(**_options(case.get("options", {}))),
        commands={"Show": show},
        repeat=case.get("repeat", False),
        most_steps=case.get("most_steps", 5000),
    )
    told += [line for event in done.events if (line := _line(event))]
    return done, told


def _options(given: dict[str, Any]) -> dict[str, Any]:
    tables = {
        name: {int(number): tuple(frame) for number, frame in given[name].items()}
        for name in ("tools", "bases")
        if name in given
    }
    return {**given, **tables}


def numbered(text: str) -> str:
    """The lines of a program with step numbers, and its positions behind them."""
    lines = text.splitlines()
    code = [line for line in lines if line and "=(+" not in line]
    rest = [line for line in lines if "=(+" in line]
    return "\n".join([*(f"{10 * at} {line}" for at, line in enumerate(code, 1)), *rest])


def _written(value: Value) -> str:
    match value:
        case str():
            return value
        case Position(values, flags):
            marks = ",".join("?" if flag is None else str(flag) for flag in flags)
            return f"({_elements(values)})({marks})"
        case Joints(values) | Bare(values):
            return f"({_elements(values)})"
    return f"{float(value):.9g}"


def _elements(values: Sequence[float | None]) -> str:
    """Up to the last that is defined."""
    count = max((i + 1 for i, v in enumerate(values) if v is not None), default=0)
    return ",".join("" if v is None else f"{round(v, 4) + 0.0:g}" for v in values[:count])


def _line(event: object) -> str:
    match event:
        case Switched(signal, value, at):
            return f"{signal}={value:g}" + ("" if at is None else f" {at.measure} {at.amount:g}")
        case Waited(seconds):
            return f"wait {seconds:g}"
        case Said(text):
            return text
        case Stopped():
            return "stopped"
        case Moved():
            return _move(event)
    return ""


def _move(event: Moved) -> str:
    if event.joints is not None:
        goal = "joints " + _elements(event.joints)
    else:
        assert event.flange is not None
        goal = _elements((event.flange @ event.tool).position)
    via = "" if event.via is None else " by " + _elements((event.via @ event.tool).position)
    speed = "" if event.speed is None else f" at {event.speed:g} mm/s"
    percent = "" if event.percent in (None, 100.0) else f" at {event.percent:g} %"
    corner = "" if event.blend == 0 else f" corner {event.blend:g}"
    return f"{event.kind}{via} to {goal}{speed}{percent}{corner}"


def test_there_are_enough_cases() -> None:
    """Each with what states it; those of several versions and expressions are counted once."""
    found = [case for file in FILES for _, case, _, _ in cases(file)]
    assert len({(case["cites"], str(case)) for case in found}) >= 150
    assert len(found) >= 690
