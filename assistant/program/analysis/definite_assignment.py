"""Variables that may be read before they have a value, and other assumptions of a program.

Controllers differ in the values of unset variables, in loops whose limits change inside, and in
bits of numbers below 0; the program is asked whether it depends on any of that.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import field
from typing import Any, Literal

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import EXIT, ControlFlowGraph, Dataflow, reachable
from assistant.program.analysis.integer_inference import NumberFacts
from assistant.program.analysis.uses import (
    base_variable,
    handed_over,
    indices_of,
    locals_of,
    names_in_procedure,
)
from assistant.program.program import Procedure, Program, Variable, walk
from assistant.program.rewriting import Body, head, records
from assistant.program.statement_index import records_in_body
from assistant.program.undeclared_names import interrupts
from assistant.program.vendor_statements import effect_of

_Element = tuple[str, tuple[int, ...]]
Known = frozenset[str | _Element]
State = Known | None
"""Data with a value on every path to a position: names in lower case; None if no path leads there.

For arrays these include single elements, and the array once all elements have a value.
"""


@dataclass(slots=True)
class Run:
    """Result of running a procedure: names in lower case.

    read: perhaps read before they have a value. own: such names that are the procedure's variables.
    given: have a value on every path back. ends: true if any path returns.
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
        """Return the names that a call may read, and those that it surely gives a value.

        For procedures that call each other this is the worst case.

        A procedure that calls itself reads no more by that than it reads from its top.
        """
        key = procedure.name.lower()
        # A direct recursion reads nothing more; the paths after it go on, unlike with None.
        if self._running and key == self._running[-1]:
            return Run(given=frozenset())
        # Procedures that call each other: all names count as read.
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
                    if (callee := self.program.procedure(name)) is not None:
                        yield from map(base_variable, handed_over(callee, arguments))


class _ReadsFromTop:
    """One procedure, along the ways through it from its top."""

    def __init__(self, assigning: AssignmentAnalysis, procedure: Procedure) -> None:
        self.assigning, self.run = assigning, Run()
        self.own = {q.name.lower() for q in procedure.parameters}
        self.own |= {name.lower() for name in procedure.variables}
        self.sizes = {name: n for name, n in assigning.sizes.items() if name not in self.own}
        self.sizes |= {n.lower(): v.size for n, v in procedure.variables.items() if v.size}
        self.graph = ControlFlowGraph(
            procedure.body, lambda node: bool(_filled_array(node, self.sizes))
        )
        flow = Dataflow(self.graph.after, self.behind, frozenset[str | _Element].intersection)
        flow.spread([(self.graph.start, frozenset())])
        given = flow.found.get(EXIT)
        self.run.given = None if given is None else self.others(given)

    def behind(self, node: int, given: Known) -> State:
        state: State = given
        for part in self.graph.runs[node]:
            state = None if state is None else self.ran(part, state)
        return state

    def ran(self, node: Any, state: Known) -> State:
        """Return the names with a value after a statement, or after a condition is evaluated."""
        match node:
            case p.Assign(e.Name(name), value):
                return self.reads(value, state) | {name.lower()}
            case p.Assign(e.Index() | e.Member() as target, value):
                return self.reads((indices_of(target), value), state) | self.element(target, state)
            case p.For(variable):
                given = _filled_array(node, self.sizes) or variable.lower()
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

    def element(self, target: e.Expression, state: Known) -> set[str | _Element]:
        """Return the element that an assignment gives a value, and its array once all have one."""
        place = _assigned_element(target, self.sizes)
        if place is None:
            return set()
        name, _ = place
        if math.prod(self.sizes[name]) > len(state) + 1:  # not all of them, then
            return {place}
        every = itertools.product(*(range(1, n + 1) for n in self.sizes[name]))
        return {place} if {(name, at) for at in every} - state - {place} else {place, name}

    def reads(self, value: Any, state: Known) -> Known:
        """Record the reads of an expression or a plain statement, and its calls of functions."""
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
        """Return the names with a value that are not the procedure's own."""
        return frozenset(x for x in state if (x if isinstance(x, str) else x[0]) not in self.own)


def _assigned_element(
    target: e.Expression, sizes: Mapping[str, tuple[int, ...]]
) -> _Element | None:
    """The element that an assignment changes: its array in lower case, and its known indices."""
    match target:
        case e.Index(e.Name(name), indices) if name.lower() in sizes:
            known = tuple(int(x.value) for x in indices if isinstance(x, e.Number))
            return (name.lower(), known) if len(known) == len(indices) else None
    return None


def _filled_array(node: p.Statement, sizes: Mapping[str, tuple[int, ...]]) -> str:
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


def first_move(program: Program, name: str, of: Literal["tool", "frame"]) -> Span | None:
    """Return the span of the first move with the tool, or in the frame, of that name."""
    for statement in program.statements():
        match statement:
            case p.Follow(path=path):
                used = set(path.tools if of == "tool" else path.frames)
            case (
                p.Move(motion=motion) | p.MoveCircular(motion=motion) | p.MoveJoints(motion=motion)
            ):
                used = {motion.tool if of == "tool" else motion.frame}
            case _:
                continue
        if name in used:
            return statement.span
    return None


def variables_read_unset(program: Program) -> Iterator[tuple[str, Variable, Span | None]]:
    """Variables of the program that are read before they have a value, but for arrays.

    With the place that first names one, else that of its declaration.
    """
    entry = program.procedure(program.entry) if program.entry else None
    read = AssignmentAnalysis(program).run(entry).read if entry is not None else set()
    met: dict[str, Span | None] | None = None
    for name, variable in program.variables.items():
        own = variable.storage == "variable" and variable.initial is None and not variable.size
        if own and name.lower() in read:
            met = _first_named(program) if met is None else met
            yield name, variable, met.get(name.lower(), variable.span)


def _first_named(program: Program) -> dict[str, Span | None]:
    """Names in lower case of the program's own, each with the place of the first statement that
    holds it.
    """
    found: dict[str, Span | None] = {}
    for procedure in program.procedures:
        own = {name.lower() for name in procedure.variables}
        own |= {parameter.name.lower() for parameter in procedure.parameters}
        for statement in walk(procedure.body):
            for part in records(head(statement)):
                if isinstance(part, e.Name) and part.name.lower() not in own:
                    found.setdefault(part.name.lower(), statement.span)
    return found


def functions_of_signed_bits(
    program: Program, functions: Collection[str]
) -> Iterator[tuple[str, Span | None]]:
    """Functions of bits, of those given, whose numbers may be below 0."""
    numbers: NumberFacts | None = None
    for procedure in program.procedures:
        for statement in walk(procedure.body):
            for part in records(head(statement)):
                if isinstance(part, e.Apply) and part.function in functions:
                    numbers = numbers or NumberFacts(program)
                    if not all(numbers.of(x, procedure).positive for x in part.arguments):
                        yield part.function, statement.span


def loops_with_changing_limits(program: Program) -> Iterator[tuple[p.For, list[str]]]:
    """Loops whose end or step changes inside, with the names that do, in lower case.

    Not those that change their own variable, which are no plain counts.
    """
    written = {
        q.name.lower(): set(_written_variables(program, q.body)) - locals_of(q)
        for q in program.procedures
    }
    called = {q.name.lower(): set(_called_names(q.body)) for q in program.procedures}
    for statement in program.statements():
        if not isinstance(statement, p.For):
            continue
        changed = set(_written_variables(program, statement.body))
        for name in reachable(_called_names(statement.body), lambda one: called.get(one, ())):
            changed |= written.get(name, set())
        limits = {
            r.name.lower()
            for r in records((statement.last, statement.step))
            if isinstance(r, e.Name)
        }
        found = sorted(limits & changed)
        if found and statement.variable.lower() not in changed:
            yield statement, found


def _written_variables(program: Program, body: Body) -> Iterator[str]:
    """Names in lower case of variables that statements write, or let a call write."""
    for record in records(body):
        match record:
            case p.For(variable):
                yield variable.lower()
            case p.Assign(target):
                yield base_variable(target)
            case p.Call(name, arguments) | e.Apply(name, arguments):
                if (callee := program.procedure(name)) is not None:
                    yield from map(base_variable, handed_over(callee, arguments))


def _called_names(body: Body) -> Iterator[str]:
    """Names in lower case of the procedures and functions that statements call."""
    for record in records(body):
        match record:
            case p.Call(name) | e.Apply(name):
                yield name.lower()
