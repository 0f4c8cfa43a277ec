"""How the statements of a program use its signals."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program, Signal
from assistant.program.rewriting import head, records


class AddressedSignals:
    """Signals that a language names by their addresses: each gets one name.

    signals: those that have one, by name; the others are put there. free: gives a free name near to
    another one.
    """

    def __init__(self, signals: dict[str, Signal], free: Callable[[str], str]) -> None:
        self.signals, self.free = signals, free
        self.names = {signal: name for name, signal in signals.items()}

    def name(self, signal: Signal, wanted: str = "") -> str:
        """The name of a signal, made of its address if none is wanted: `do_5`, `gi_16_32`."""
        if signal not in self.names:
            width = f"{signal.bits}_" if signal.kind == "group" else ""
            letters = f"{signal.kind[0]}{signal.direction[0]}"
            self.names[signal] = self.free(wanted or f"{letters}_{width}{signal.number}")
            self.signals[self.names[signal]] = signal
        return self.names[signal]


def with_one_name(program: Program) -> Program:
    """The program for a language that names signals by their addresses: of several names of one
    address the one that is used, or the first. Where more are used, all of them stay.
    """
    by_address: dict[Signal, list[str]] = defaultdict(list)
    for name, signal in program.signals.items():
        if signal.number is not None:
            by_address[signal].append(name)
    shared = [names for names in by_address.values() if len(names) > 1]
    if not shared:
        return program
    used = used_signal_names(program)
    gone: set[str] = set()
    for names in shared:
        left = [name for name in names if name.lower() in used] or names[:1]
        gone.update(name for name in names if name not in left)
    signals = {name: one for name, one in program.signals.items() if name not in gone}
    return replace(program, signals=signals)


def used_signal_names(program: Program) -> set[str]:
    """Lower-case names of all signals that statements or kept texts read, wait for or set."""
    found = set()
    for statement in program.statements():
        found |= {one.signal.lower() for one in p.outputs(statement)}
        if isinstance(statement, p.WaitSignal):
            found.add(statement.signal.lower())
        for part in records(head(statement)):
            if isinstance(part, e.Name):
                found.add(part.name.lower())
            elif (effect := getattr(part, "effect", None)) is not None:
                found |= effect.names
    return found


def with_used_signals(
    declared: Mapping[str, Signal], used: Iterable[tuple[str, Signal]]
) -> dict[str, Signal]:
    """The declared signals, and each other one as it is used first."""
    found = dict(declared)
    known = {name.lower() for name in declared}
    for name, signal in used:
        if name.lower() not in known:
            known.add(name.lower())
            found[name] = signal
    return found


def signal_uses(statements: Iterable[p.Statement]) -> Iterator[tuple[str, Signal]]:
    """The signals that statements set and wait for, digital as far as one can see."""
    for statement in statements:
        for one in p.outputs(statement):
            yield one.signal, Signal("digital", "output")
        if isinstance(statement, p.WaitSignal):
            yield statement.signal, Signal("digital", "input")


def read_by_another_name(program: Program) -> Iterator[tuple[p.Statement, str, str]]:
    """Statements that read an output which others set as part of a signal of another name.

    With each the name that it reads and the one that is set. Digital outputs and groups share
    numbers.
    """
    outputs = {
        name.lower(): range(signal.number, signal.number + signal.bits)
        for name, signal in program.signals.items()
        if signal.number is not None and signal.direction == "output" and signal.kind != "analog"
    }
    statements = tuple(program.statements())
    written = {x.signal.lower(): x.signal for one in statements for x in p.outputs(one)}
    writing: dict[int, dict[str, str]] = defaultdict(dict)  # of each number, the names set there
    for key, name in written.items():
        for number in outputs.get(key, ()):
            writing[number][key] = name
    for statement in statements:
        names = [r.name for r in records(head(statement)) if isinstance(r, e.Name)]
        names += [statement.signal] if isinstance(statement, p.WaitSignal) else []
        for name in names:
            numbers = outputs.get(name.lower(), ())
            set_there = {k: n for number in numbers for k, n in writing.get(number, {}).items()}
            set_there.pop(name.lower(), None)
            for other in set_there.values():
                yield statement, name, other
