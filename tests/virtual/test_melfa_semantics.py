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
from pathlib import Path
from typing import Any

import pytest

from assistant import languages, robots
from assistant.virtual import melfa
from assistant.virtual.events import Moved, Run, Said, Stopped, Switched, Waited
from assistant.virtual.melfa import Given, Options
from assistant.virtual.melfa.values import Bare, Joints, Position, Value
from tests.virtual.melfa_cell import POSITIONS, START

CASES = Path(__file__).parent / "semantics" / "melfa"


def cases() -> Iterator[Any]:
    for path in sorted(CASES.glob("*.toml")):
        for name, case in tomllib.loads(path.read_text(encoding="utf-8")).items():
            for level in case.get("levels", [5]):
                for at, value in enumerate(case.get("values", [None])):
                    yield pytest.param(case, level, value, id=f"{path.stem}-{name}-{level}-{at}")


@pytest.mark.parametrize(("case", "level", "value"), list(cases()))
def test_a_case(case: dict[str, Any], level: int, value: list[Any] | None) -> None:
    assert case["cites"]
    if value is None:
        done, told = run(case, case["program"], level)
        assert (told, done.ended) == (case["expected"], case.get("ended", "end")), done.message
        assert case.get("message", "") in done.message
        assert set(case.get("notes", ())) <= set(done.notes)
        return
    expression, gives = value
    done, told = run(case, f"{case.get('before', '')}\nM99=Show({expression})", level)
    if str(gives).startswith(("error", "unknown")):
        assert done.ended == gives.split()[0] and gives in f"unknown {done.message}", done.message
    else:
        assert (told[-1:], done.ended) == ([f"show {_written(gives)}"], "end"), done.message


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
    """Of expressions each is one; the versions of the language are counted once."""
    named = {(p.values[0]["cites"], str(p.values[0]), str(p.values[2])) for p in cases()}
    assert len(named) >= 150
