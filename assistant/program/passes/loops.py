"""Counting loops: separate loop variables, and bounds and direction that are fixed once.

In some languages the variable of a loop is read-only, is visible in the loop only and hides an
outer variable of the same name. A `for` of the pseudo-program counts an ordinary variable: changes
in the loop are visible outside, and afterwards it holds the value past the end. Both have the same
meaning if only the loop uses the variable.

A `for` of the pseudo-program computes its bounds once and may count in either direction. In some
languages a loop counts upwards unless a step is given, and no manual describes its behaviour for a
bound that changes while it runs; there, such values get separate variables.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import reachable
from assistant.program.analysis.uses import base_variable, constant_numbers, declared, names_in
from assistant.program.program import (
    Procedure,
    Program,
    TakenNames,
    Variable,
    bodies,
    identifier,
    walk,
)
from assistant.program.rewriting import Body, head, map_bodies, map_head, records, rewrite
from assistant.program.vendor_statements import effect_of, respelled

if TYPE_CHECKING:
    from assistant.program.passes.legalisation import Legalisation

Found = dict[tuple[str, str], Diagnostic]
Tells = Callable[..., Diagnostic]


def counted_loops(job: Legalisation) -> Program:
    """Return the program for a language with separate loop variables."""
    loops = job.can.loops
    if loops is None:
        return job.program

    def as_while(name: str, why: str, **where: Any) -> Diagnostic:
        what = f"the `for` over `{name}`, which {why},"
        return loops.changed(what=what, instead="a `while`", cure=loops.cure, **where)

    program, found = counted(job.program, refused=loops.refused, changed=as_while)
    job.findings.extend(found)
    return program


def without_counters(job: Legalisation) -> Program:
    """A program of another language without variables that only loops count, which declare them."""
    program, origin = job.program, job.program.origin
    if job.can.loops is None or origin is None or origin.language in job.can.kin:
        return program
    uses = _Uses(program)
    used = uses.declared.union(*(one.read for one in uses.of.values()))
    counters = set[str]()
    for statement in program.statements():
        if isinstance(statement, p.For):
            counters.add(statement.variable.lower())
        elif isinstance(statement, p.Assign):
            used.add(base_variable(statement.target))
    gone = counters - used

    def left(variables: Mapping[str, Variable]) -> dict[str, Variable]:
        return {
            name: one
            for name, one in variables.items()
            if name.lower() not in gone or one.storage != "variable"
        }

    procedures = tuple(replace(q, variables=left(q.variables)) for q in program.procedures)
    return replace(program, variables=left(program.variables), procedures=procedures)


def counted(
    program: Program, *, refused: Tells, changed: Tells
) -> tuple[Program, list[Diagnostic]]:
    """Return the program for a language with separate loop variables, and the findings.

    A loop whose variable is used outside becomes a `while`; a finding reports it (`changed`, with
    the fields name and why), or that this is not possible (`refused`).
    """
    found: Found = {}
    # A `while` uses its variable outside of loops, which may affect other loops: repeated until
    # none changes.
    while True:
        uses = _Uses(program)
        rewriter = _Whiles(program, uses, found, refused, changed)
        procedures = tuple(map(rewriter.procedure, program.procedures))
        if not rewriter.changed:
            return program, list(found.values())
        program = replace(program, procedures=procedures)


def with_hiding_loops_renamed(program: Program) -> Program:
    """A program of such a language, in which a loop that hides a name that is used has its own."""
    if not any(isinstance(x, p.For) for x in program.statements()):
        return program
    uses = _Uses(program)
    names = (*_globals(program), *(q.name for q in program.procedures))
    # A new name must hide nothing that any procedure uses.
    taken = TakenNames(n.lower() for n in names)
    for procedure in program.procedures:
        taken.update(_own(procedure), uses.of[id(procedure)].touched)

    def body(statements: Body, procedure: Procedure) -> Body:
        out: list[p.Statement] = []
        for x in statements:
            x = map_bodies(x, lambda b: body(b, procedure))
            if isinstance(x, p.For) and uses.outside(x, procedure, verbatim=False):
                name = identifier(x.variable, taken)
                taken.add(name.lower())
                x = replace(x, variable=name, body=_renamed(x.body, x.variable, name))
            out.append(x)
        return tuple(out)

    procedures = tuple(replace(q, body=body(q.body, q)) for q in program.procedures)
    return replace(program, procedures=procedures)


def _renamed(body: Body, old: str, new: str) -> Body:
    """The body with another name for a variable, but for loops inside that hide it."""
    # Quoted text stays; a name after a dot is a component.
    word = re.compile(rf'"[^"]*"|(?<![\\.\w]){re.escape(old)}(?!\w)', re.IGNORECASE)

    def other(text: str) -> str:
        return word.sub(lambda m: m[0] if m[0].startswith('"') else new, text)

    def change(x: e.Expression) -> e.Expression:
        match x:
            case e.Name(name) if name.lower() == old.lower():
                return e.Name(new)
            case e.Verbatim(text=text):
                return respelled(x, other(text), old.lower(), new.lower())
        return x

    out: list[p.Statement] = []
    for x in body:
        hides = isinstance(x, p.For) and x.variable.lower() == old.lower()
        x = map_head(x, change)
        if isinstance(x, p.Opaque):
            x = respelled(x, other(x.text), old.lower(), new.lower())
        out.append(x if hides else map_bodies(x, lambda b: _renamed(b, old, new)))
    return tuple(out)


# What uses what


@dataclass(slots=True)
class _Use:
    """Lower-case names. read: outside loops that count them. called: of procedures, functions."""

    read: set[str]
    touched: set[str]
    called: set[str]

    @classmethod
    def of(cls, body: Body) -> _Use:
        use = cls(set(), set(), set())
        use.body(body, frozenset())
        return use

    def body(self, body: Body, counts: frozenset[str]) -> None:
        for x in body:
            if isinstance(x, p.Follow):
                continue
            used: Any = head(x)
            # Assigning a variable is no use of its value.
            if isinstance(x, p.Assign) and isinstance(x.target, e.Name):
                self.touched.add(x.target.name.lower())
                used = x.value
            names = {n.lower() for n in names_in(used)}
            self.touched |= names
            self.read |= names - counts
            self.called |= _called_names(used)
            inner = counts
            if isinstance(x, p.For):
                self.touched.add(x.variable.lower())
                inner = counts | {x.variable.lower()}
            for held in bodies(x):
                self.body(held, inner)


class _Uses:
    def __init__(self, program: Program) -> None:
        self.program = program
        self.known = {n.lower() for n in _globals(program)}
        self.declared = {name for d in program.declarations for name in effect_of(d).names}

    @cached_property
    def of(self) -> dict[int, _Use]:
        """By the identity of a procedure, what it uses."""
        return {id(q): _Use.of(q.body) for q in self.program.procedures}

    def outside(self, x: p.For, procedure: Procedure, *, verbatim: bool) -> str:
        """Return the reason why the loop's variable cannot be local to the loop, empty if it can.

        verbatim: True if vendor statements could assign it.
        """
        name = x.variable.lower()
        if name in written_names(x.body, self.program, verbatim=verbatim):
            return "is assigned inside the loop"
        if name in self.of[id(procedure)].read:
            return "is used outside the loop"
        own = next((q for q in procedure.parameters if q.name.lower() == name), None)
        if own is not None:
            return "is handed back to the caller" if own.mode == "inout" else ""
        # An own variable, or one that no table declares, is invisible elsewhere.
        if name in _own(procedure) or name not in self.known:
            return ""
        others = [q for q in self.program.procedures if name not in _own(q)]
        called = self.reached(_Use.of(x.body).called)
        # Other procedures read the variable, or may change it while the loop calls them.
        if (
            name in self.declared
            or any(name in self.of[id(q)].read for q in others)
            or any(name in self.of[id(q)].touched for q in others if q.name.lower() in called)
        ):
            return "is used in another procedure"
        return ""

    def reached(self, called: set[str]) -> set[str]:
        """The names called, and those that procedures of these names call."""
        own = {q.name.lower(): self.of[id(q)].called for q in self.program.procedures}
        return reachable(called, lambda name: own.get(name, ()))


def written_names(body: Body, program: Program, *, verbatim: bool = True) -> set[str]:
    """Lower-case names that a body assigns, counts or hands over to be assigned.

    verbatim: whether statements that are kept as text count as well.
    """
    found: set[str] = set()
    for x in walk(body):
        match x:
            case p.Follow():
                continue
            case p.Assign(target):
                while isinstance(target, e.Member | e.Index):
                    target = target.value
                if isinstance(target, e.Name):
                    found.add(target.name.lower())
            case p.For():
                found.add(x.variable.lower())
            case p.Opaque() if verbatim:
                found |= effect_of(x).writes
        for part in records(head(x)):
            if isinstance(part, p.Call | e.Apply):
                name = part.procedure if isinstance(part, p.Call) else part.function
                called = program.procedure(name)
                pairs = zip(part.arguments, called.parameters if called else (), strict=False)
                for argument, parameter in pairs:
                    if parameter.mode == "inout":
                        found |= {n.lower() for n in names_in(argument)}
    return found


def _called_names(node: Any) -> set[str]:
    found: set[str] = set()
    for part in records(node):
        match part:
            case p.Call():
                found.add(part.procedure.lower())
            case e.Apply():
                found.add(part.function.lower())
            case e.Verbatim() | p.Opaque():
                found |= {n.lower() for n in names_in(part)}
    return found


def _globals(program: Program) -> Iterator[str]:
    for table in (program.variables, program.targets, program.joint_targets, program.signals):
        yield from table


def _own(procedure: Procedure) -> set[str]:
    """Lower-case names of its parameters and variables."""
    names = (*(q.name for q in procedure.parameters), *procedure.variables)
    return {n.lower() for n in names}


# Loops that the language can say


class _Whiles:
    def __init__(
        self, program: Program, uses: _Uses, found: Found, refused: Tells, as_while: Tells
    ) -> None:
        self.program, self.uses, self.found = program, uses, found
        self.tells = {"refused": refused, "changed": as_while}
        self.changed = False
        self.taken = TakenNames(declared(program))
        self.bounds: dict[str, Variable] = {}
        """Variables of the present procedure that hold the end values of its loops."""

    def procedure(self, procedure: Procedure) -> Procedure:
        self.bounds = {}
        body = self.body(procedure.body, procedure)
        variables = {**procedure.variables, **self.bounds} if self.bounds else procedure.variables
        return replace(procedure, body=body, variables=variables)

    def body(self, body: Body, procedure: Procedure) -> Body:
        out: list[p.Statement] = []
        for x in body:
            if isinstance(x, p.For):
                why = self.uses.outside(x, procedure, verbatim=self.declared(x, procedure))
                if why:
                    as_while = self.as_while(x, procedure)
                    place = f"{procedure.name}, `for {x.variable}`"
                    what = "refused" if as_while is None else "changed"
                    fields: dict[str, Any] = {"name": x.variable, "why": why}
                    found = self.tells[what](**fields, place=place, span=x.span)
                    self.found[place, what] = found
                    if as_while is not None:
                        self.changed = True
                        out += as_while
                        continue
            out.append(map_bodies(x, lambda b: self.body(b, procedure)))
        return tuple(out)

    def declared(self, x: p.For, procedure: Procedure) -> bool:
        return x.variable.lower() in self.uses.known | _own(procedure)

    def as_while(self, x: p.For, procedure: Procedure) -> list[p.Statement] | None:
        """Return the same loop as a `while` with a variable, None if that cannot be expressed."""
        # Without a constant step the direction of the comparison is unknown.
        if not isinstance(x.step, e.Number) or not x.step.value:
            return None
        if not _countable(x.variable, procedure, self.program):
            return None
        assigned = written_names(x.body, self.program) | {x.variable.lower()}
        name, step = e.Name(x.variable), x.step.value
        made: list[p.Statement] = []
        last = x.last
        # A `while` computes its bound in each round, a `for` once.
        if not self.steady(last, procedure, x.body, assigned):
            if any(isinstance(one, e.Verbatim) for one in records(last)):
                return None
            bound = identifier(f"{x.variable}_last", self.taken)
            self.taken.add(bound)
            counted = _variable(x.variable, procedure, self.program)
            self.bounds[bound] = Variable("number" if counted is None else counted.type)
            made.append(p.Assign(e.Name(bound), last, span=x.span))
            last = e.Name(bound)
        relation, operator = ("<=", "+") if step > 0 else (">=", "-")
        further = e.Binary(operator, name, e.Number(abs(step)))  # type: ignore[arg-type]
        condition = e.Binary(relation, name, last)  # type: ignore[arg-type]
        body = (*x.body, p.Assign(name, further))
        made.append(p.Assign(name, x.first, span=x.span))
        return [*made, p.While(condition, body, span=x.span)]

    def steady(
        self, last: e.Expression, procedure: Procedure, body: Body, assigned: set[str]
    ) -> bool:
        """True if the last value is the same however often it is computed."""
        match last:
            case e.Number():
                return True
            case e.Unary(_, operand):
                return self.steady(operand, procedure, body, assigned)
            case e.Binary(_, left, right):
                return all(self.steady(q, procedure, body, assigned) for q in (left, right))
            case e.Name(name) if name.lower() not in assigned:
                variable = _variable(name, procedure, self.program)
                if variable is None:
                    return False
                # A call may change what is not the procedure's own.
                alone = name.lower() in _own(procedure) or variable.storage == "constant"
                return alone or not _Use.of(body).called
        return False


def _variable(name: str, procedure: Procedure, program: Program) -> Variable | None:
    """The variable or parameter of that name as a procedure sees it."""
    for q in procedure.parameters:
        if q.name.lower() == name.lower():
            return Variable(q.type)
    tables: tuple[Mapping[str, Variable], ...] = (procedure.variables, program.variables)
    found = (v for table in tables for n, v in table.items() if n.lower() == name.lower())
    return next(found, None)


def _countable(name: str, procedure: Procedure, program: Program) -> bool:
    variable = _variable(name, procedure, program)
    return (
        variable is not None
        and variable.type in _COUNTABLE
        and variable.storage != "constant"
        and not variable.size
    )


_COUNTABLE: Final = ("number", "integer")


def ascends(first: e.Expression, last: e.Expression) -> bool | None:
    """True if the bounds of a loop go upwards; None if they are not plain numbers."""
    bounds = [e.plain_number(x) for x in (first, last)]
    return None if bounds[0] is None or bounds[1] is None else bounds[0] <= bounds[1]


_PLAIN_EXPRESSIONS: Final = (e.Number, e.Truth, e.Name, e.Unary, e.Binary)
"""Expressions that give the same each time, as long as nothing is assigned to their names."""
_BACKWARDS: Final = e.Number(-1)


def with_settled_loops(program: Program) -> Program:
    """The program with a step for each loop, and with bounds that stay as they are."""
    if not any(isinstance(node, p.For) for node in program.statements()):
        return program
    loops = _LoopBounds(program)
    return replace(program, procedures=tuple(map(loops.procedure, program.procedures)))


def with_directions(program: Program) -> Program:
    """The program with a step for each loop whose bounds are numbers, where a reader sees which."""
    return rewrite(program, _directed)


def _directed(part: Any) -> Any:
    if isinstance(part, p.For) and part.step is None:
        upwards = ascends(part.first, part.last)
        if upwards is not None:
            return replace(part, step=p.ONE if upwards else _BACKWARDS)
    return part


class _LoopBounds:
    """Names are in lower case.

    written: those that anything in the program assigns to. own: those of the procedure's own
    variables, which no call changes unless it is given them.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        self.signals = {name.lower() for name in program.signals}
        self.written = {name for q in program.procedures for name in self._written(q.body)}
        tables = (program.variables, program.targets, program.joint_targets, program.signals)
        self.taken = TakenNames(name.lower() for table in tables for name in table)
        self.taken.update(
            name.lower() for q in program.procedures for name in _names_of_procedure(q)
        )
        self.variables: dict[str, Variable] = {}
        self.own: set[str] = set()
        self.constants: Mapping[str, e.Number] = {}

    def procedure(self, procedure: Procedure) -> Procedure:
        self.variables = {}
        self.constants = constant_numbers(self.program, procedure)
        self.own = {name.lower() for name in procedure.variables}
        body = self._body(procedure.body)
        if body == procedure.body:
            return procedure
        return replace(procedure, body=body, variables={**procedure.variables, **self.variables})

    def _body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            node = map_bodies(node, self._body)
            settled = self._settled(node) if isinstance(node, p.For) else (node,)
            made += (x if x.span else replace(x, span=node.span) for x in settled)
        return tuple(made)

    def _settled(self, node: p.For) -> Iterator[p.Statement]:
        if node.step is None:
            low, high = self._number(node.first), self._number(node.last)
            # Numbers and constants alone decide the direction here.
            if low is not None and high is not None:
                yield replace(node, step=p.ONE if low <= high else _BACKWARDS)
                return
        changed = self._changed(node)
        first, last, step = node.first, node.last, node.step
        bounds = (last,) if step is None else (last, step)
        if step is not None and all(self._stays(x, changed) for x in bounds):
            yield node
            return
        if not self._stays(first, set()):
            first = yield from self._kept(node, "first", first)
        if not self._stays(last, changed):
            last = yield from self._kept(node, "last", last)
        # The direction is decided while the program runs.
        if step is None:
            step = yield from self._kept(node, "by", p.ONE)
            backwards = p.Branch(e.Binary(">", first, last), (p.Assign(step, _BACKWARDS),))
            yield p.If((backwards,))
        elif not self._stays(step, changed):
            step = yield from self._kept(node, "by", step)
        yield replace(node, first=first, last=last, step=step)

    def _number(self, value: e.Expression) -> float | None:
        """The value of a bound that is made of numbers and constants."""
        match value:
            case e.Number(number):
                return number
            case e.Name(name):
                known = self.constants.get(name.lower())
                return None if known is None else known.value
            case e.Binary("+" | "-" | "*" as operator, left, right):
                one, two = self._number(left), self._number(right)
                if one is None or two is None:
                    return None
                return {"+": one + two, "-": one - two, "*": one * two}[operator]
        return None

    def _kept(
        self, node: p.For, part: str, value: e.Expression
    ) -> Generator[p.Statement, None, e.Name]:
        """Assigns a value to a variable of the procedure's own, and gives that."""
        name = identifier(f"{node.variable}_{part}", self.taken)
        self.taken.add(name.lower())
        self.variables[name] = Variable("number")
        yield p.Assign(e.Name(name), value)
        return e.Name(name)

    def _stays(self, value: e.Expression, changed: set[str]) -> bool:
        for record in records(value):
            if not isinstance(record, _PLAIN_EXPRESSIONS):
                return False
            if isinstance(record, e.Name):
                key = record.name.lower()
                if key in changed or key in self.signals:
                    return False
        return True

    def _changed(self, node: p.For) -> set[str]:
        """Names that may be assigned to while a loop runs."""
        changed = set(self._written((node,)))
        for record in records(node.body):
            # A call may assign anything but the procedure's own variables.
            match record:
                case p.Call() | p.Opaque() | e.Verbatim():
                    return changed | (self.written - self.own)
                case e.Apply(name) if self.program.procedure(name):
                    return changed | (self.written - self.own)
        return changed

    def _written(self, body: Body) -> Iterator[str]:
        for record in records(body):
            match record:
                case p.Assign(target):
                    yield base_variable(target)
                case p.For(variable):
                    yield variable.lower()
                case p.Call(_, arguments) | e.Apply(_, arguments):
                    yield from map(base_variable, arguments)
                case p.Opaque() | e.Verbatim():
                    yield from effect_of(record).names


def _names_of_procedure(procedure: Procedure) -> Iterator[str]:
    yield from procedure.variables
    yield from (q.name for q in procedure.parameters)
    yield from (r.variable for r in records(procedure.body) if isinstance(r, p.For))
