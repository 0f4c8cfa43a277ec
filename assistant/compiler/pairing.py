"""Pairs the signals and data of two programs that have other names for them.

A pair has the same name or the same number (from headers, process files and cell files), or the
user states it. The rest is paired in order of use, if both programs have as many of that kind.

    [names]                       # name in the first program = name in the second
    diPart = 4                    # the number of a signal, or
    doGrip = "doGripper"          # its name
    nTotal = "MTOTAL"             # data that outlives a run
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.budgets import SETTINGS_FILE
from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors, info
from assistant.base.source_text import decode, read_bytes
from assistant.program import expressions as e
from assistant.program import settings_tables
from assistant.program import statements as p
from assistant.program.program import Program
from assistant.program.settings_tables import Wrong
from assistant.program.statement_index import names_in_procedures, records_in_procedures
from assistant.sources.process.file import ENCODINGS, read_toml

SIGNAL_WITHOUT_PAIR: Final = error(
    "CO120",
    "nothing says which {kind} of the second program is `{name}`: it has {others}",
    "write in a file for --names what it is there",
)
PAIRED_BY_ORDER: Final = info(
    "CO121",
    "`{name}` is taken for `{other}`, as each is the {kind} with number {number} in its program",
    "say with --names what it is, if that is wrong",
)
PAIR_UNKNOWN: Final = error(
    "CO122",
    "there is no signal and no data `{name}` in the {which} program",
    "write a name that it has",
)


@dataclass(frozen=True, slots=True)
class PairedNames:
    """names: the second program's names by the first program's names, in lower case."""

    names: Mapping[str, str]
    findings: tuple[Diagnostic, ...] = ()


def read_names(path: str | FilePath) -> dict[str, str]:
    """The names of a file; raises Unreadable or Refused."""
    data = read_bytes(path, most=SETTINGS_FILE)
    whole = read_toml(decode(data, str(path), ENCODINGS))
    whole.read({"names": lambda value: value})
    table = whole.table("names")
    found = table.read(dict.fromkeys(table.content, _read_name))
    if has_errors(whole.page.findings):
        raise Refused(*whole.page.findings, exit_status=2)
    return found


def _read_name(value: Any) -> str:
    if isinstance(value, int) and not isinstance(value, bool) and value >= 0:
        return str(value)
    name: str = settings_tables.text(value).strip()
    if not name:
        raise Wrong("is empty", "write a name, or the number of a signal")
    return name


def pair_names(first: Program, second: Program, stated: Mapping[str, str]) -> PairedNames:
    """Pairs the signals and data of two programs.

    stated: pairs of the user. Raises Refused (exit status 2) if signals cannot be paired.
    """
    names = {own.lower(): other.lower() for own, other in stated.items()}
    findings = list(_unknown_names(first, second, stated))
    mine = _unpaired_signals(first, second, {*names})
    theirs = _unpaired_signals(second, first, {*names.values()})
    for kind in mine:
        own, other = mine[kind], theirs.get(kind, [])
        if _numbers_of(first, own) and _numbers_of(second, other):  # these are other signals
            continue
        if len(own) == len(other):
            for place, pair in enumerate(zip(own, other, strict=True), 1):
                names[pair[0].lower()] = pair[1].lower()
                findings.append(
                    PAIRED_BY_ORDER(name=pair[0], other=pair[1], kind=kind, number=place)
                )
        elif other:
            listed = ", ".join(f"`{name}`" for name in other)
            findings.append(SIGNAL_WITHOUT_PAIR(name=own[0], kind=kind, others=listed))
    if has_errors(findings):
        raise Refused(*findings, exit_status=2)
    return PairedNames(names, tuple(findings))


def _unknown_names(
    first: Program, second: Program, stated: Mapping[str, str]
) -> Iterator[Diagnostic]:
    """A finding for each stated name that a program does not have."""
    for own, other in stated.items():
        for name, program, which in ((own, first, "first"), (other, second, "second")):
            if not name.isdecimal() and name.lower() not in _data_names(program):
                yield PAIR_UNKNOWN(name=name, which=which)


def _data_names(program: Program) -> set[str]:
    return {
        name.lower()
        for name in (*program.signals, *program.variables, *names_in_procedures(program))
    }


def _unpaired_signals(program: Program, other: Program, stated: set[str]) -> dict[str, list[str]]:
    """By their kinds the signals that only one program has, in the order in which it uses them.

    A number that the other program does not use is a number all the same, and says which signal it
    is; a signal without one may be any that is left.
    """
    known = {name.lower() for name in other.signals} | stated
    numbers = {signal.number for signal in other.signals.values()} - {None}
    used = dict.fromkeys(name.lower() for name in _signals_used(program))
    order = {name: place for place, name in enumerate(used)}
    found: dict[str, list[str]] = {}
    for name in sorted(program.signals, key=lambda one: order.get(one.lower(), len(order))):
        signal = program.signals[name]
        if name.lower() in known or signal.number in numbers or str(signal.number) in stated:
            continue
        found.setdefault(f"{signal.kind} {signal.direction}", []).append(name)
    return found


def _numbers_of(program: Program, names: list[str]) -> bool:
    return all(program.signals[name].number is not None for name in names)


def _signals_used(program: Program) -> Iterator[str]:
    """Names of signals, in order of the text."""
    used: Iterator[Any] = records_in_procedures(
        program, p.WaitSignal, p.SetSignal, p.Trigger, e.Name
    )
    for part in used:
        yield part.name if isinstance(part, e.Name) else part.signal
