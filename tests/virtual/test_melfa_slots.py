"""What programs in slots do beside each other, case by case, each with what states it.

`semantics/melfa_slots/*.toml` holds the cases. `cites`: a statement's word names its page in the
help of COSIROP, four digits an entry of the lists of errors, `melfa.md` a section of the reference
that was collected for this project. `programs`: by name; `A` runs in slot 1. `table`: rows of the
slot table. `base`: the user base program. `inputs`: what a signal becomes, by seconds. `sends`:
what comes on lines: seconds, line, text. `options`: what the manuals leave open. `expected`: what
each slot does to the world. `sent`: what goes out on lines. `ended`, `message`: how the run ends,
`end` where nothing is stated.
"""

from __future__ import annotations

import tomllib
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from assistant import languages
from assistant.virtual.events import Logged, Moved, Stopped, Switched
from assistant.virtual.kernel import Kernel
from assistant.virtual.melfa import Controller, Entry, Options
from assistant.virtual.melfa.communication_lines import Wire
from assistant.virtual.melfa.world import STEP_TIME
from tests.virtual.melfa_cell import START
from tests.virtual.tables import failures

FILES = sorted((Path(__file__).parent / "semantics" / "melfa_slots").glob("*.toml"))


def cases(file: Path) -> dict[str, dict[str, Any]]:
    return tomllib.loads(file.read_text(encoding="utf-8"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_the_cases_of_a_file(file: Path) -> None:
    assert not failures((name, partial(holds, case)) for name, case in cases(file).items())


def holds(case: dict[str, Any]) -> None:
    """Asserts what a case states."""
    assert case["cites"]
    language = languages.get(f"melfa-basic-{case.get('level', 4)}")
    programs = {name: language.parse(text.strip()) for name, text in case["programs"].items()}
    assert not [finding for file in programs.values() for finding in file.findings]
    table = {1: Entry("A", "CYC")}
    table |= {int(slot): Entry(**row) for slot, row in case.get("table", {}).items()}
    kernel = Kernel(statement_time=STEP_TIME, most_steps=5000)
    for moment, signals in case.get("inputs", {}).items():
        for name, value in signals.items():
            kernel.at(float(moment), partial(kernel.board.inputs.set, name, float(value)))
    controller = Controller(
        kernel,
        programs,
        table,
        start=START,
        base=language.parse(case["base"].strip()) if "base" in case else None,
        always_may=case.get("always_may", False),
        options=Options(**case.get("options", {})),
        lines=(lines := {name: Wire() for name in ("COM1:", "COM2:")}),
    )
    for moment, name, data in case.get("sends", ()):
        kernel.at(float(moment), partial(lines[name].put, data.encode()))
    controller.start()
    done = kernel.run()
    told = [line for row in done.log if (line := _line(row))]
    assert (told, done.ended) == (case["expected"], case.get("ended", "end")), done.message
    assert case.get("message", "") in done.message
    for name, sent in case.get("sent", {}).items():
        assert lines[name].sent.decode() == sent


def _line(row: Logged) -> str:
    match row.what:
        case Switched(signal, value, at):
            return f"{row.task}: {signal}={value:g}" + ("" if at is None else f" at {at.amount:g}")
        case Moved(kind, flange, tool):
            assert flange is not None
            place = ",".join(f"{round(v, 2):g}" for v in (flange @ tool).position)
            return f"{row.task}: {kind} to {place}"
        case Stopped():
            return f"{row.task}: stopped"
    return ""


def test_there_are_enough_cases() -> None:
    assert sum(len(cases(file)) for file in FILES) >= 82
