"""Which channels of a program may be open at the same time.

Two that never are may have one number, as files are opened one after the other. A channel counts
as open from where it is attached to where it is surely detached, along every way; what is named
while another one may be open is apart from that one, so that no text goes to a wrong place.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.channels import channel_named, channels
from assistant.program.program import Procedure, Program, walk
from assistant.program.rewriting import Body, head, records

OpenChannels = frozenset[str]
"""Channels, in lower case, that may be open."""
_NONE: OpenChannels = frozenset()
_SaidOfChannel: TypeAlias = tuple[OpenChannels, tuple[str, ...]]


@dataclass(slots=True)
class _ChannelEffect:
    """What a procedure does to channels. left: of those open before it, which may be so behind it.
    opened: what it may leave open itself.
    """

    left: OpenChannels
    opened: OpenChannels = _NONE

    def behind(self, before: OpenChannels) -> OpenChannels:
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
    every: OpenChannels = _NONE
    procedures: dict[str, Procedure] = field(default_factory=dict)
    ways: dict[str, _ChannelEffect] = field(default_factory=dict)
    begins: dict[str, OpenChannels] = field(default_factory=dict)
    found: set[frozenset[str]] = field(default_factory=set)
    left: OpenChannels = _NONE
    said: dict[int, _SaidOfChannel] = field(default_factory=dict)

    def pairs(self) -> frozenset[frozenset[str]]:
        self.every = frozenset(name.lower() for name in channels(self.program))
        self.procedures = {q.name.lower(): q for q in self.program.procedures}
        called = {name for _, calls in map(self.of, self.program.statements()) for name in calls}
        self.ways = {name: _ChannelEffect(_NONE) for name in self.procedures}
        while self.more_ways():
            pass
        entry = (self.program.entry or "").lower()
        alone = {name for name in self.procedures if name == entry or name not in called}
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
        """Whether the procedures do more than was known of those that they call."""
        changed = False
        for name, procedure in self.procedures.items():
            opened = self.through(procedure, _NONE)
            way = _ChannelEffect(self.through(procedure, self.every), opened)
            if way != self.ways[name]:
                self.ways[name], changed = way, True
        return changed

    def more_begins(self) -> bool:
        """Whether more may be open somewhere than was known; tells all that is open together."""
        before = dict(self.begins)
        for name, procedure in self.procedures.items():
            self.through(procedure, self.begins[name])
        return before != self.begins

    def through(self, procedure: Procedure, before: OpenChannels) -> OpenChannels:
        """What may be open behind a procedure."""
        self.left = _NONE
        if any(isinstance(one, p.Goto) for one in walk(procedure.body)):
            before |= frozenset(
                one.channel.lower() for one in walk(procedure.body) if isinstance(one, p.Attach)
            )
            for one in walk(procedure.body):
                before |= self.step(one, before)
        behind = self.body(procedure.body, before)
        return (behind or _NONE) | self.left

    def body(self, body: Body, before: OpenChannels | None) -> OpenChannels | None:
        """What may be open behind statements; None where nothing goes on."""
        for node in body:
            if before is None:
                return None
            before = self.statement(node, before)
        return before

    def statement(self, node: p.Statement, before: OpenChannels) -> OpenChannels | None:
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

    def step(self, node: p.Statement, before: OpenChannels) -> OpenChannels:
        """What may be open behind one statement, without those that stand in it."""
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
        """Channels that a statement names by itself, and procedures that it calls."""
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


def _either_effect(ways: Iterator[OpenChannels | None]) -> OpenChannels | None:
    known = [one for one in ways if one is not None]
    return frozenset().union(*known) if known else None
