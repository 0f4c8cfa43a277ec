"""Use of signals and channels: what statements read and set, and channels open at the same time.

Pulses of outputs that may be on already are found, as languages leave those differently.
Two channels that are never open together may have one number, as files are opened one after the
other. A channel counts as open from where it is attached to where it is surely detached, along
every path; what is named while another one may be open is apart from that one, so that no text
goes to a wrong channel.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import field, replace
from typing import Any, TypeAlias

from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program, Signal, walk
from assistant.program.rewriting import Body, head, records
from assistant.program.statement_index import records_in_procedures
from assistant.program.undeclared_names import channel_named, channels


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
            self.names[signal] = self.free(wanted or address_name(signal))
            self.signals[self.names[signal]] = signal
        return self.names[signal]


def address_name(signal: Signal) -> str:
    """The name that says where a signal is: `do_5`, `gi_16_32`."""
    width = f"{signal.bits}_" if signal.kind == "group" else ""
    return f"{signal.kind[0]}{signal.direction[0]}_{width}{signal.number}"


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
        # Names that nothing uses are dropped; if all are unused, the first stays.
        left = [name for name in names if name.lower() in used] or names[:1]
        gone.update(name for name in names if name not in left)
    signals = {name: one for name, one in program.signals.items() if name not in gone}
    return replace(program, signals=signals)


def used_signal_names(program: Program) -> set[str]:
    """Return the names of all signals that statements or vendor texts read, wait for or set.

    The names are in lower case.
    """
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


def hands_used(program: Program) -> list[int]:
    """Return the numbers of the hands that a program opens or closes, in rising order."""
    return sorted({one.hand for one in records_in_procedures(program, p.Gripper)})


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


OFF_VALUES = (e.Number(0), e.Truth(False))


def doubtful_pulses(program: Program) -> Iterator[p.SetSignal]:
    """Pulses of signals that the program sets to something else than 0 as well.

    One that is set back to what it was, and one that is switched off, differ in these. One at the
    beginning of a branch for the signal being 0 is not among them.
    """
    statements = tuple(program.statements())
    asked = {
        id(first)
        for statement in statements
        if isinstance(statement, p.If)
        for branch in statement.branches
        for first in branch.body[:1]
        if isinstance(first, p.SetSignal) and _is_off(branch.condition, first.signal)
    }
    pulses = [x for x in statements if isinstance(x, p.SetSignal) and x.pulse is not None]
    if not pulses:
        return
    on = {
        one.signal.lower()
        for statement in statements
        for one in p.outputs(statement)
        if one.pulse is None and one.value not in OFF_VALUES
    }
    yield from (one for one in pulses if one.signal.lower() in on and id(one) not in asked)


def _is_off(condition: e.Expression, signal: str) -> bool:
    match condition:
        case e.Binary("=", e.Name(name), e.Number(0)):
            return name.lower() == signal.lower()
    return False


_OpenChannels = frozenset[str]
"""Channels, in lower case, that may be open."""
_NONE: _OpenChannels = frozenset()
_SaidOfChannel: TypeAlias = tuple[_OpenChannels, tuple[str, ...]]


@dataclass(slots=True)
class _ChannelEffect:
    """Effect of a procedure on channels.

    left: channels open before it that may be open after it. opened: channels that it may leave open
    itself.
    """

    left: _OpenChannels
    opened: _OpenChannels = _NONE

    def behind(self, before: _OpenChannels) -> _OpenChannels:
        return (before & self.left) | self.opened


def channels_open_together(program: Program) -> frozenset[frozenset[str]]:
    """Pairs of channels, in lower case, that may be open at once."""
    return _OpenTogether(program).pairs()


@dataclass(slots=True)
class _OpenTogether:
    """every: all channels. ways: of procedures by lower-case name. begins: what may be open where a
    procedure begins. left: what may be open where the one that is walked returns. said: of each
    statement by `id`, see `of`.
    """

    program: Program
    every: _OpenChannels = _NONE
    procedures: dict[str, Procedure] = field(default_factory=dict)
    ways: dict[str, _ChannelEffect] = field(default_factory=dict)
    begins: dict[str, _OpenChannels] = field(default_factory=dict)
    found: set[frozenset[str]] = field(default_factory=set)
    left: _OpenChannels = _NONE
    said: dict[int, _SaidOfChannel] = field(default_factory=dict)

    def pairs(self) -> frozenset[frozenset[str]]:
        self.every = frozenset(name.lower() for name in channels(self.program))
        self.procedures = {q.name.lower(): q for q in self.program.procedures}
        called = {name for _, calls in map(self.of, self.program.statements()) for name in calls}
        self.ways = {name: _ChannelEffect(_NONE) for name in self.procedures}
        # Effects depend on callees: from nothing open upwards until none changes.
        while self.more_ways():
            pass
        entry = (self.program.entry or "").lower()
        alone = {name for name in self.procedures if name == entry or name not in called}
        # Channels that a cycle leaves open are open when the next one begins.
        between = _NONE.union(*(self.ways[name].opened for name in alone))
        self.begins = {name: between if name in alone else _NONE for name in self.procedures}
        for name in self.interrupting():
            self.begins[name] = self.every
        self.found.clear()  # of what procedures do with all channels
        while self.more_begins():
            pass
        return frozenset(self.found)

    def interrupting(self) -> set[str]:
        """Procedures that something else than a call names: they may come in between."""
        found: set[str] = set()
        for node in self.program.statements():
            for part in records(head(node)):
                if not isinstance(part, p.Call | e.Apply | e.Name | e.Text | p.Comment):
                    texts = (getattr(part, name) for name in part.__dataclass_fields__)
                    found |= {x.lower() for x in texts if isinstance(x, str)} & set(self.procedures)
        return found

    def more_ways(self) -> bool:
        """Update the effects of the procedures from their callees; True if any has changed."""
        changed = False
        for name, procedure in self.procedures.items():
            opened = self.through(procedure, _NONE)
            way = _ChannelEffect(self.through(procedure, self.every), opened)
            if way != self.ways[name]:
                self.ways[name], changed = way, True
        return changed

    def more_begins(self) -> bool:
        """Update the channels open at the start of procedures and collect pairs; True on change."""
        before = dict(self.begins)
        for name, procedure in self.procedures.items():
            self.through(procedure, self.begins[name])
        return before != self.begins

    def through(self, procedure: Procedure, before: _OpenChannels) -> _OpenChannels:
        """Return the channels that may be open after a procedure."""
        self.left = _NONE
        # Jumps may lead anywhere in the body: every channel of it may be open from the start.
        if any(isinstance(one, p.Goto) for one in walk(procedure.body)):
            before |= frozenset(
                one.channel.lower() for one in walk(procedure.body) if isinstance(one, p.Attach)
            )
            for one in walk(procedure.body):
                before |= self.step(one, before)
        behind = self.body(procedure.body, before)
        return (behind or _NONE) | self.left

    def body(self, body: Body, before: _OpenChannels | None) -> _OpenChannels | None:
        """Return the channels that may be open after statements; None if nothing follows."""
        for node in body:
            if before is None:
                return None
            before = self.statement(node, before)
        return before

    def statement(self, node: p.Statement, before: _OpenChannels) -> _OpenChannels | None:
        at = self.step(node, before)
        match node:
            case p.If(branches, otherwise):
                return _either_effect(
                    self.body(b, at) for b in (*(x.body for x in branches), otherwise)
                )
            case p.Switch(_, cases, otherwise):
                return _either_effect(
                    self.body(b, at) for b in (*(x.body for x in cases), otherwise)
                )
            case p.While(body=body) | p.For(body=body):
                # A loop may begin with what its own body leaves open.
                while not (behind := self.body(body, at) or _NONE) <= at:
                    at |= behind
                    at = self.step(node, at)
                return at
            case p.Return():
                self.left |= at
                return None
            case p.Stop(end=True):
                return None
        return at

    def step(self, node: p.Statement, before: _OpenChannels) -> _OpenChannels:
        """Return the channels that may be open after one statement, without those inside it."""
        names, calls = self.of(node)
        for name in names:
            self.found |= {frozenset((name, other)) for other in before - {name}}
        for name in calls:
            self.begins[name] = self.begins.get(name, _NONE) | before
            before = self.ways[name].behind(before)
        match node:
            case p.Attach(channel):
                return before | {channel.lower()}
            case p.Detach(channel):
                return before - {channel.lower()}
        return before

    def of(self, node: p.Statement) -> _SaidOfChannel:
        """Return the channels that a statement itself names, and the procedures that it calls."""
        known = self.said.get(id(node))
        if known is None:
            parts = list(records(head(node)))
            names = {name.lower() for part in parts if (name := channel_named(part))}
            calls = [_called_by_record(part) for part in parts]
            known = frozenset(names), tuple(name for name in calls if name in self.procedures)
            self.said[id(node)] = known
        return known


def _called_by_record(part: Any) -> str:
    match part:
        case p.Call(name) | e.Apply(name):
            return name.lower()
    return ""


def _either_effect(ways: Iterator[_OpenChannels | None]) -> _OpenChannels | None:
    known = [one for one in ways if one is not None]
    return frozenset().union(*known) if known else None


def sets_on_way(program: Program) -> bool:
    """True if any move sets outputs during its motion."""
    return any(isinstance(x, p.MoveStatement) and x.triggers for x in program.statements())
