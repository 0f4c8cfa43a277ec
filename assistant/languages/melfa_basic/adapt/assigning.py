"""Which variables a procedure may read before it gives them a value."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from assistant.languages.melfa_basic.lower.writer import words
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program, bodies
from assistant.program.rewriting import Body, head, records

State = frozenset[str] | None
"""Names (lower case) that have a value on every way to a place; None where no way leads to."""


@dataclass(slots=True)
class Run:
    """Names in lower case.

    read: perhaps read before a value is given. given: have one on every way back.
    ends: whether any way comes back.
    """

    read: set[str] = field(default_factory=set)
    given: State = None

    @property
    def ends(self) -> bool:
        return self.given is not None


class Assigning:
    """The procedures of a program. written: names that anything in it may change."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.written = {name for q in program.procedures for name in self._written(q)}
        self._runs: dict[str, Run] = {}
        self._running: list[str] = []

    def run(self, procedure: Procedure) -> Run:
        """What a call may read and surely gives; of those that call each other the worst.

        One that calls itself reads no more by that than what it reads from its top.
        """
        key = procedure.name.lower()
        if self._running and key == self._running[-1]:
            return Run(set(), frozenset())
        if key in self._running:
            return Run(set().union(*map(_named, self.program.procedures)), frozenset())
        if key not in self._runs:
            self._running.append(key)
            self._runs[key] = _Reading(self, procedure).run
            self._running.pop()
        return self._runs[key]

    def _written(self, procedure: Procedure) -> Iterator[str]:
        for record in records(procedure.body):
            match record:
                case p.Assign(target):
                    yield from _first(target)
                case p.For(variable):
                    yield variable.lower()
                case p.Opaque(_, text) | e.Verbatim(_, text):
                    yield from words(text)
                case p.Call(name, arguments) | e.Apply(name, arguments):
                    callee = self.program.procedure(name)
                    given = zip(callee.parameters, arguments, strict=False) if callee else ()
                    for parameter, value in given:
                        if parameter.mode == "inout":
                            yield from _first(value)


class _Reading:
    """One procedure, read once from its top: a label may be come to with nothing given."""

    def __init__(self, assigning: Assigning, procedure: Procedure) -> None:
        self.assigning, self.run = assigning, Run()
        self.own = {q.name.lower() for q in procedure.parameters}
        self.own |= {name.lower() for name in procedure.variables}
        self.labels = any(isinstance(r, p.Goto) for r in records(procedure.body))
        self.leave(self.body(procedure.body, frozenset()))

    def body(self, body: Body, state: State) -> State:
        for node in body:
            state = self.statement(node, state)
        return state

    def statement(self, node: p.Statement, state: State) -> State:
        if isinstance(node, p.Label):
            return frozenset() if self.labels else state
        if state is None:
            # what stands behind is run by nobody, but a label in it may be
            _ = [self.body(inner, None) for inner in bodies(node)]
            return None
        match node:
            case p.Assign(e.Name(name), value):
                return self.reads(value, state) | {name.lower()}
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

    def reads(self, value: Any, state: frozenset[str]) -> frozenset[str]:
        """What an expression or a plain statement reads, and its calls of functions."""
        for record in records(value):
            match record:
                case e.Name(name):
                    self.read({name.lower()} - state)
                case p.Opaque(_, text) | e.Verbatim(_, text):
                    self.read(set(words(text)) - state)
                case e.Apply(name):
                    self.called(name, state)
        return state

    def called(self, name: str, state: frozenset[str]) -> State:
        callee = self.assigning.program.procedure(name)
        if callee is None:
            return state
        run = self.assigning.run(callee)
        self.read(run.read - state)
        return None if run.given is None else state | run.given

    def read(self, names: set[str]) -> None:
        self.run.read |= names - self.own

    def leave(self, state: State) -> None:
        if state is not None:
            self.run.given = _met(self.run.given, state - self.own)


def _met(*ways: State) -> State:
    """What is given on all of the ways that lead on."""
    known = [way for way in ways if way is not None]
    return frozenset.intersection(*known) if known else None


def _is_true(condition: e.Expression) -> bool:
    match condition:
        case e.Truth(value) | e.Number(value):
            return bool(value)
    return False


def _first(target: e.Expression) -> list[str]:
    """The variable that an assignment changes, or part of which."""
    match target:
        case e.Name(name):
            return [name.lower()]
        case e.Member(value) | e.Index(value):
            return _first(value)
    return []


def _named(procedure: Procedure) -> set[str]:
    names = {r.name.lower() for r in records(procedure.body) if isinstance(r, e.Name)}
    return names | {
        w for r in records(procedure.body) if isinstance(r, p.Opaque) for w in words(r.text)
    }
