"""Which variables a procedure may read before it gives them a value."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import base, indices_of, named
from assistant.program.kept import effect_of
from assistant.program.program import Procedure, Program, bodies
from assistant.program.rewriting import Body, head, records

Element = tuple[str, tuple[int, ...]]
Known = frozenset[str | Element]
State = Known | None
"""What has a value on every way to a place: names in lower case; None where no way leads to.

Of arrays single elements too, and the array once all of them have one.
"""


@dataclass(slots=True)
class Run:
    """Names in lower case.

    read: perhaps read before a value is given. own: those of its own variables.
    given: have one on every way back. ends: whether any way comes back.
    """

    read: set[str] = field(default_factory=set)
    own: set[str] = field(default_factory=set)
    given: State = None

    @property
    def ends(self) -> bool:
        return self.given is not None


class Assigning:
    """The procedures of a program.

    written: names that anything in it may change. sizes: of its arrays, by lower-case name.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        self.sizes = {n.lower(): v.size for n, v in program.variables.items() if v.size}
        self.written = {name for q in program.procedures for name in self._written(q)}
        self._runs: dict[str, Run] = {}
        self._running: list[str] = []

    def run(self, procedure: Procedure) -> Run:
        """What a call may read and surely gives; of those that call each other the worst.

        One that calls itself reads no more by that than what it reads from its top.
        """
        key = procedure.name.lower()
        if self._running and key == self._running[-1]:
            return Run(given=frozenset())
        if key in self._running:
            read = set().union(*map(named, self.program.procedures))
            return Run(read, given=frozenset())
        if key not in self._runs:
            self._running.append(key)
            self._runs[key] = _Reading(self, procedure).run
            self._running.pop()
        return self._runs[key]

    def _written(self, procedure: Procedure) -> Iterator[str]:
        for record in records(procedure.body):
            match record:
                case p.Assign(target):
                    yield base(target)
                case p.For(variable):
                    yield variable.lower()
                case p.Opaque() | e.Verbatim():
                    yield from effect_of(record).names
                case p.Call(name, arguments) | e.Apply(name, arguments):
                    callee = self.program.procedure(name)
                    given = zip(callee.parameters, arguments, strict=False) if callee else ()
                    for parameter, value in given:
                        if parameter.mode == "inout":
                            yield base(value)


class _Reading:
    """One procedure, read once from its top.

    A label may be come to with nothing given but what stands before the first label or jump.
    """

    def __init__(self, assigning: Assigning, procedure: Procedure) -> None:
        self.assigning, self.run = assigning, Run()
        self.own = {q.name.lower() for q in procedure.parameters}
        self.own |= {name.lower() for name in procedure.variables}
        self.sizes = {name: n for name, n in assigning.sizes.items() if name not in self.own}
        self.sizes |= {n.lower(): v.size for n, v in procedure.variables.items() if v.size}
        self.labels = any(isinstance(r, p.Goto) for r in records(procedure.body))
        jumps = (any(isinstance(r, p.Label | p.Goto) for r in records(x)) for x in procedure.body)
        first = next((at for at, found in enumerate(jumps) if found), len(procedure.body))
        state = self.body(procedure.body[:first], frozenset())
        self.at_label: State = state or frozenset()
        self.leave(self.body(procedure.body[first:], state))

    def body(self, body: Body, state: State) -> State:
        for node in body:
            state = self.statement(node, state)
        return state

    def statement(self, node: p.Statement, state: State) -> State:
        if isinstance(node, p.Label):
            return self.at_label if self.labels else state
        if state is None:
            # what stands behind is run by nobody, but a label in it may be
            _ = [self.body(inner, None) for inner in bodies(node)]
            return None
        match node:
            case p.Assign(e.Name(name), value):
                return self.reads(value, state) | {name.lower()}
            case p.Assign(e.Index() | e.Member() as target, value):
                return self.reads((indices_of(target), value), state) | self.element(target, state)
            case p.For() if name := filled(node, self.sizes):
                return self.reads(head(node), state) | {name}
            case p.For(variable, first, last, body, step):
                begun = self.reads((first, last, step), state) | {variable.lower()}
                self.body(body, begun)
                return begun
            case p.While(condition, body):
                state = self.reads(condition, state)
                self.body(body, state)
                return None if _is_true(condition) else state
            case p.If(branches, otherwise):
                ways = []
                for branch in branches:
                    state = self.reads(branch.condition, state)
                    ways.append(self.body(branch.body, state))
                return _met(*ways, self.body(otherwise, state))
            case p.Switch(subject, cases, otherwise):
                state = self.reads((subject, tuple(c.values for c in cases)), state)
                ways = [self.body(c.body, state) for c in cases]
                return _met(*ways, self.body(otherwise, state))
            case p.Return(value):
                self.leave(self.reads(value, state))
                return None
            case p.Goto():
                return None
            case p.Stop(end=True):
                return None
            case p.Call(name):
                return self.called(name, self.reads(node, state))
        return self.reads(head(node), state)

    def element(self, target: e.Expression, state: State) -> set[str | Element]:
        """What has a value behind an assignment to an element: that, and its array if all have."""
        place = element(target, self.sizes)
        if place is None or state is None:
            return set()
        name, _ = place
        every = itertools.product(*(range(1, n + 1) for n in self.sizes[name]))
        return {place} if {(name, at) for at in every} - state - {place} else {place, name}

    def reads(self, value: Any, state: Known) -> Known:
        """What an expression or a plain statement reads, and its calls of functions."""
        for record in records(value):
            match record:
                case e.Name(name):
                    self.read({name.lower()}, state)
                case p.Opaque() | e.Verbatim():
                    self.read(set(effect_of(record).names), state)
                case e.Apply(name):
                    self.called(name, state)
        return state

    def called(self, name: str, state: Known) -> State:
        callee = self.assigning.program.procedure(name)
        if callee is None:
            return state
        run = self.assigning.run(callee)
        # what the caller has of its own hides nothing from what it calls
        self.run.read |= run.read - self.others(state)
        return None if run.given is None else state | self.others(run.given)

    def read(self, names: set[str], state: Known) -> None:
        self.run.read |= names - self.own - state
        self.run.own |= (names & self.own) - state

    def leave(self, state: State) -> None:
        if state is not None:
            self.run.given = _met(self.run.given, self.others(state))

    def others(self, state: Known) -> Known:
        """What has a value of data that is not the procedure's own."""
        return frozenset(x for x in state if (x if isinstance(x, str) else x[0]) not in self.own)


def element(target: e.Expression, sizes: Mapping[str, tuple[int, ...]]) -> Element | None:
    """The element that an assignment changes: its array in lower case, and its known indices."""
    match target:
        case e.Index(e.Name(name), indices) if name.lower() in sizes:
            known = tuple(int(x.value) for x in indices if isinstance(x, e.Number))
            return (name.lower(), known) if len(known) == len(indices) else None
    return None


def filled(node: p.Statement, sizes: Mapping[str, tuple[int, ...]]) -> str:
    """The array (lower case) all of whose elements loops give one value; empty for none."""
    counters: list[str] = []
    extents: list[float] = []
    while isinstance(node, p.For) and (node.first, node.step) == (p.ONE, p.ONE):
        if not isinstance(node.last, e.Number) or len(node.body) != 1:
            return ""
        counters.append(node.variable.lower())
        extents.append(node.last.value)
        node = node.body[0]
    match node:
        case p.Assign(e.Index(e.Name(name), indices), e.Number() | e.Text() | e.TargetValue()
                      | e.PoseValue() | e.JointValue()):  # fmt: skip
            counted = [x.name.lower() for x in indices if isinstance(x, e.Name)]
            if counted == counters and sizes.get(name.lower()) == tuple(extents):
                return name.lower()
    return ""


def _met(*ways: State) -> State:
    """What is given on all of the ways that lead on."""
    known = [way for way in ways if way is not None]
    return frozenset.intersection(*known) if known else None


def _is_true(condition: e.Expression) -> bool:
    match condition:
        case e.Truth(value) | e.Number(value):
            return bool(value)
    return False
