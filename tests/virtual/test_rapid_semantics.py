"""What RAPID means, case by case, each with what states it.

`semantics/rapid/*.toml` holds the cases. `cites`: a number is a section of the reference of RAPID
that was collected for this project, `kernel` and `overview` are manuals of the language, and the
name of an instruction or function its page in the manual of instructions, functions and data types.
`program`: the body of `main`; `data` and `routines`: more of its module; `modules`: further ones.
`expected`: what the program writes, to the pendant and to the event log. `ended`, `message`: how it
ends, `end` where nothing is stated. `options`: of the controller. `signals`: inputs that are set
from outside, each a time in seconds, a name and a value. `answers`: of a person, each with a part
of the question and the seconds that it takes, or without. `tasks`: further tasks, each its module.
`files`, `left`: what is on the disk before and behind the run, in Latin-1.
"""

from __future__ import annotations

import tomllib
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from assistant import languages
from assistant.virtual.events import Reported, Said
from assistant.virtual.kernel import Board, Kernel, Signals
from assistant.virtual.kernel.script import Answer
from assistant.virtual.rapid.controller import Controller, Options
from assistant.virtual.rapid.disk import Disk
from assistant.virtual.rapid.interpreter import start_task
from tests.virtual.tables import failures

FILES = sorted((Path(__file__).parent / "semantics" / "rapid").glob("*.toml"))


def cases(file: Path) -> dict[str, dict[str, Any]]:
    return tomllib.loads(file.read_text(encoding="utf-8"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_the_cases_of_a_file(file: Path, tmp_path: Path) -> None:
    assert not failures(
        (name, partial(holds, case, tmp_path / str(number)))
        for number, (name, case) in enumerate(cases(file).items())
    )


def holds(case: dict[str, Any], folder: Path) -> None:
    """Asserts what a case states. folder: that of its disk."""
    assert case["cites"]
    folder.mkdir()
    main = f"PROC main()\n{case['program']}\nENDPROC\n"
    own = f"MODULE Cell\n{case.get('data', '')}\n{main}{case.get('routines', '')}\nENDMODULE\n"
    files = [languages.get("rapid").parse(text) for text in (own, *case.get("modules", ()))]
    assert not [finding for file in files for finding in file.findings]
    controller = Controller(Options(**case.get("options", {})), disk=Disk(folder))
    for name, text in case.get("files", {}).items():
        controller.disk.path(name).write_bytes(text.encode("latin-1"))
    inputs = dict.fromkeys((name for _, name, _ in case.get("signals", ())), 0.0)
    kernel = Kernel(Board(Signals(inputs)))
    for seconds, name, value in case.get("signals", ()):
        kernel.at(seconds, partial(kernel.board.inputs.set, name, float(value)))
    for value, *to in case.get("answers", ()):
        fits = dict(zip(("to", "after"), to, strict=False))
        kernel.person.answers.append(Answer(value=value, **fits))
    start_task(kernel, files, controller=controller)
    for number, task in enumerate(case.get("tasks", ()), 2):
        file = languages.get("rapid").parse(task["module"])
        assert not file.findings
        kind = task.get("kind", "normal")
        start_task(kernel, [file], name=f"T_ROB{number}", controller=controller, kind=kind)
    found = kernel.run()
    told = [line for event in found.events if (line := _line(event)) is not None]
    assert (told, found.ended) == (case["expected"], case.get("ended", "end"))
    assert case.get("message", "") in found.message
    for name, text in case.get("left", {}).items():
        assert controller.disk.path(name).read_bytes() == text.encode("latin-1")


def _line(event: object) -> str | None:
    match event:
        case Said(text):
            return text
        case Reported(kind, header, lines):
            return " | ".join((kind, header, *lines))
    return None


def test_no_case_is_lost() -> None:
    assert sum(len(cases(file)) for file in FILES) >= 337
