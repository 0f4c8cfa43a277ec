"""A robot program in another cell: its tools, frames and signals as a process file states them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, Final, TypeVar

from assistant.base.diagnostics import Diagnostic, Refused, error, info, warning
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.operator_texts import is_operators
from assistant.program.program import Program, Signal
from assistant.program.rewriting import records, rewrite
from assistant.program.undeclared_names import ChannelLine
from assistant.sources.process import NO_PROCESS, Process

ENTRY_NOT_USED = warning(
    "CO006",
    "the program has no {kind} `{name}`, so what the process file says of it changes nothing",
    "write the name as the program does",
)

KEYS_WITHOUT_EFFECT = info(
    "CO009",
    "what the process file says of {keys} changes nothing in a program that states its own moves",
    "name arms with --robot and --from-robot; the rest is for drawings and tables",
)
SIGNAL_MISMATCH = error(
    "CO010",
    "the program uses `{name}` as {used}, but the process file states {stated}",
    'write kind = "{kind}" and direction = "{direction}", or see which signal the program means',
)
PROGRAM_KEYS: Final = (
    *("tools", "frames", "signals", "lines", "joint_speed", "joint_percent", "interface"),
    *("seen", "findings"),
)
"""What a process file says that a program takes from it."""
KEY_WORDS: Final = {"defaults": "motion"}
"""Keys of a process file that have other names here."""

V = TypeVar("V")


def with_cell_equipment(
    program: Program, stated: Process, path: str, *, sharing: bool = False
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """The program with the tools, frames and signals of the same name in a process file.

    Signals of other programs in the same cell may be in it as well, and where it is shared tools
    and frames. path: of the file.
    """
    findings = [*stated.findings]
    others = [
        f"`{KEY_WORDS.get(f.name, f.name)}`"
        for f in fields(Process)
        if f.name not in PROGRAM_KEYS and getattr(stated, f.name) != getattr(NO_PROCESS, f.name)
    ]
    if others:
        findings.append(KEYS_WITHOUT_EFFECT(keys=", ".join(others), path=path))
    program = with_signals(program, stated.signals)
    program = with_lines(program, stated.lines)
    for kind, given, there in _stated_tables(program, stated):
        known = {name.lower() for name in there}
        findings += [
            ENTRY_NOT_USED(kind=kind, name=name, place=f"{kind}s.{name}", path=path)
            for name in given
            if name.lower() not in known and not sharing
        ]
    return replace(
        program,
        tools=_replaced_entries(program.tools, stated.tools),
        frames=_replaced_entries(program.frames, stated.frames),
        interface=stated.interface or program.interface,
    ), tuple(findings)


def check_signals(program: Program, stated: Process, path: str) -> None:
    """Raises Refused for signals that the program uses as something else than is stated.

    A wait for an input would become one for an output. program: as it was read, without signals of
    which only the name tells what they may be.
    """
    others = []
    given = {name.lower(): signal for name, signal in stated.signals.items()}
    for name, used in program.signals.items():
        one = given.get(name.lower(), used)
        if (one.kind, one.direction) != (used.kind, used.direction):
            others.append(
                SIGNAL_MISMATCH(
                    name=name,
                    used=f"`{used.kind} {used.direction}`",
                    stated=f"`{one.kind} {one.direction}`",
                    kind=used.kind,
                    direction=used.direction,
                    place=f"signals.{name}",
                    path=path,
                )
            )
    if others:
        raise Refused(*others)


def with_signals(program: Program, stated: Mapping[str, Signal]) -> Program:
    """The program with the signals of the same names, those included that expressions read."""
    program = _with_signals_read(program, stated)
    return replace(program, signals=_replaced_entries(program.signals, stated))


def with_lines(program: Program, lines: Mapping[int, ChannelLine]) -> Program:
    """A program with what the cell knows of communication lines in place of their numbers."""

    def stated(part: Any) -> Any:
        match part:
            case p.Attach(kind="line", place=(e.Number(number),)) if number in lines:
                line = lines[int(number)]
                port, address = e.Number(line.port), e.Text(line.address)
                places: dict[str, tuple[e.Expression, ...]] = {
                    "server": (port, address),
                    "client": (address, port),
                    "serial": (port,),
                }
                return replace(part, kind=line.role, place=places[line.role])
        return part

    return rewrite(program, stated) if lines else program


def _with_signals_read(program: Program, stated: Mapping[str, Signal]) -> Program:
    """With the signals that expressions read: only the cell knows that those are no data.

    So are names in what is kept as their text, which another language may read, and
    what a person answers by.
    """
    known = {name.lower() for name in (*program.signals, *program.variables)}
    given = {name.lower(): signal for name, signal in stated.items()}
    found: dict[str, Signal] = {}
    read = [part.name for part in records(program.procedures) if isinstance(part, e.Name)]
    texts = [one.text for one in program.declarations]
    texts += [one.text for one in program.statements() if isinstance(one, p.Opaque)]
    for text in texts:
        read += re.findall(r"\w+", text)
    read += filter(is_operators, stated)
    for name in read:
        if name.lower() in given and name.lower() not in known:
            known.add(name.lower())
            found[name] = given[name.lower()]
    return replace(program, signals={**program.signals, **found})


def _stated_tables(
    program: Program, stated: Process
) -> tuple[tuple[str, Mapping[str, object], Mapping[str, object]], ...]:
    return (
        ("tool", stated.tools, program.tools),
        ("frame", stated.frames, program.frames),
    )


def _replaced_entries(there: dict[str, V], given: Mapping[str, V]) -> dict[str, V]:
    """Values by the program's own names."""
    stated = {name.lower(): value for name, value in given.items()}
    return {name: stated.get(name.lower(), value) for name, value in there.items()}
