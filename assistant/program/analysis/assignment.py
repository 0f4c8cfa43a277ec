"""Which variables a procedure may read before it gives them a value."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import Dataflow
from assistant.program.analysis.graph import EXIT, ControlFlowGraph
from assistant.program.analysis.interrupts import interrupts
from assistant.program.analysis.uses import base_variable, indices_of, names_in_procedure
from assistant.program.contents import records_in_body
from assistant.program.kept import effect_of
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import head, records

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


class AssignmentAnalysis:
    """The procedures of a program.

    written: names that anything in it may change. sizes: of its arrays, by lower-case name.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        self.sizes = {n.lower(): v.size for n, v in program.variables.items() if v.size}
        self.written = {name for q in program.procedures for name in self._written(q)}
        self.interrupts: dict[str, list[p.Interrupt]] = {}
        """By lower-case name, what each may be."""
        for one in interrupts(program):
            self.interrupts.setdefault(one.name.lower(), []).append(one)
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
            read = set().union(*map(names_in_procedure, self.program.procedures))
            return Run(read, given=frozenset())
        if key not in self._runs:
            self._running.append(key)
            self._runs[key] = _ReadsFromTop(self, procedure).run
            self._running.pop()
        return self._runs[key]

    def _written(self, procedure: Procedure) -> Iterator[str]:
        kinds = p.Assign, p.For, p.Opaque, e.Verbatim, p.Call, e.Apply
        for record in records_in_body(procedure, *kinds):
            match record:
                case p.Assign(target):
                    yield base_variable(target)
                case p.For(variable):
                    yield variable.lower()
                case p.Opaque() | e.Verbatim():
                    yield from effect_of(record).names
                case p.Call(name, arguments) | e.Apply(name, arguments):
                    callee = self.program.procedure(name)
                    given = zip(callee.parameters, arguments, strict=False) if callee else ()
                    for parameter, value in given:
                        if parameter.mode == "inout":
                            yield base_variable(value)


class _ReadsFromTop:
    """One procedure, along the ways through it from its top."""

    def __init__(self, assigning: AssignmentAnalysis, procedure: Procedure) -> None:
        self.assigning, self.run = assigning, Run()
        self.own = {q.name.lower() for q in procedure.parameters}
        self.own |= {name.lower() for name in procedure.variables}
        self.sizes = {name: n for name, n in assigning.sizes.items() if name not in self.own}
        self.sizes |= {n.lower(): v.size for n, v in procedure.variables.items() if v.size}
        self.graph = ControlFlowGraph(
            procedure.body, lambda node: bool(filled_array(node, self.sizes))
        )
        flow = Dataflow(self.graph.after, self.behind, frozenset[str | Element].intersection)
        flow.spread([(self.graph.start, frozenset())])
        given = flow.found.get(EXIT)
        self.run.given = None if given is None else self.others(given)

    def behind(self, node: int, given: Known) -> State:
        state: State = given
        for part in self.graph.runs[node]:
            state = None if state is None else self.ran(part, state)
        return state

    def ran(self, node: Any, state: Known) -> State:
        """What has a value behind a statement, or behind a condition that is worked out."""
        match node:
            case p.Assign(e.Name(name), value):
                return self.reads(value, state) | {name.lower()}
            case p.Assign(e.Index() | e.Member() as target, value):
                return self.reads((indices_of(target), value), state) | self.element(target, state)
            case p.For(variable):
                given = filled_array(node, self.sizes) or variable.lower()
                return self.reads(head(node), state) | {given}
            case p.Call(name):
                return self.called(name, self.reads(node, state))
            case p.Interrupt():
                return state
            case p.SwitchInterrupt(name, "on"):  # it may come at once, or never
                for one in self.assigning.interrupts.get(name.lower(), ()):
                    self.called(one.call.procedure, self.reads((one.condition, one.ends), state))
                return state
        return self.reads(node, state)

    def element(self, target: e.Expression, state: Known) -> set[str | Element]:
        """What has a value behind an assignment to an element: that, and its array if all have."""
        place = assigned_element(target, self.sizes)
        if place is None:
            return set()
        name, _ = place
        if math.prod(self.sizes[name]) > len(state) + 1:  # not all of them, then
            return {place}
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

    def others(self, state: Known) -> Known:
        """What has a value of data that is not the procedure's own."""
        return frozenset(x for x in state if (x if isinstance(x, str) else x[0]) not in self.own)


def assigned_element(target: e.Expression, sizes: Mapping[str, tuple[int, ...]]) -> Element | None:
    """The element that an assignment changes: its array in lower case, and its known indices."""
    match target:
        case e.Index(e.Name(name), indices) if name.lower() in sizes:
            known = tuple(int(x.value) for x in indices if isinstance(x, e.Number))
            return (name.lower(), known) if len(known) == len(indices) else None
    return None


def filled_array(node: p.Statement, sizes: Mapping[str, tuple[int, ...]]) -> str:
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
