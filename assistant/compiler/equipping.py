"""A robot program in another cell: its tools, frames and signals as a process file states them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar

from assistant.program import expressions as e
from assistant.program.diagnostics import Diagnostic, Rule, Severity
from assistant.program.program import Program, Signal
from assistant.program.rewriting import records
from assistant.sources.process import Process

NOT_USED = Rule(
    "CO006",
    Severity.WARNING,
    "the program has no {kind} `{name}`, so what the process file says of it changes nothing",
    "write the name as the program does",
)

V = TypeVar("V")


def equipped(
    program: Program, stated: Process, path: str
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """The program with the tools, frames and signals of the same name in a process file.

    Signals of other programs in the same cell may be in it as well. path: of the file.
    """
    findings = [*stated.findings]
    program = _with_read(program, stated.signals)
    for kind, given, there in _tables(program, stated):
        known = {name.lower() for name in there}
        findings += [
            NOT_USED(kind=kind, name=name, place=f"{kind}s.{name}", path=path)
            for name in given
            if name.lower() not in known
        ]
    return replace(
        program,
        tools=_with(program.tools, stated.tools),
        frames=_with(program.frames, stated.frames),
        signals=_with(program.signals, stated.signals),
    ), tuple(findings)


def _with_read(program: Program, stated: Mapping[str, Signal]) -> Program:
    """With the signals that expressions read: only the cell knows that those are no data."""
    known = {name.lower() for name in (*program.signals, *program.variables)}
    given = {name.lower(): signal for name, signal in stated.items()}
    found: dict[str, Signal] = {}
    for part in records(program.procedures):
        if isinstance(part, e.Name) and part.name.lower() in given:
            if part.name.lower() not in known:
                known.add(part.name.lower())
                found[part.name] = given[part.name.lower()]
    return replace(program, signals={**program.signals, **found})


def _tables(
    program: Program, stated: Process
) -> tuple[tuple[str, Mapping[str, object], Mapping[str, object]], ...]:
    return (
        ("tool", stated.tools, program.tools),
        ("frame", stated.frames, program.frames),
    )


def _with(there: dict[str, V], given: Mapping[str, V]) -> dict[str, V]:
    """Values by the program's own names."""
    stated = {name.lower(): value for name, value in given.items()}
    return {name: stated.get(name.lower(), value) for name, value in there.items()}
