"""Counting loops whose bounds and direction are settled before their first turn.

A `for` of the pseudo-program works its bounds out once and may count towards its end, whichever
way that is. Where a loop counts upwards unless a step says otherwise, and no manual tells what it
makes of a bound that changes while it runs, such values get variables of their own.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import replace
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import base_variable
from assistant.program.kept import effect_of
from assistant.program.passes.counted_loops import ascends
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier
from assistant.program.rewriting import Body, map_bodies, records, rewrite

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

    def procedure(self, procedure: Procedure) -> Procedure:
        self.variables = {}
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
        match node.first, node.last:
            case e.Number(low), e.Number(high) if node.step is None:
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
        if step is None:
            step = yield from self._kept(node, "by", p.ONE)
            backwards = p.Branch(e.Binary(">", first, last), (p.Assign(step, _BACKWARDS),))
            yield p.If((backwards,))
        elif not self._stays(step, changed):
            step = yield from self._kept(node, "by", step)
        yield replace(node, first=first, last=last, step=step)

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
