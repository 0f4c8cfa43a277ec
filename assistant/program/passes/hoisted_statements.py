"""Statements hoisted before another one, inside any control flow.

The pass calls functions that move the robot before the move that takes their value. It serves
languages whose speed, corner, tool and frame are separate statements: such a function sets them for
its moves, and the settings of the calling move would be lost when that begins.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field, replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import along_calls
from assistant.program.program import Procedure, Program, ValueType, Variable
from assistant.program.rewriting import Body, head, map_bodies, map_head, records
from assistant.program.statement_index import (
    records_in_body,
    records_in_procedures,
    statements_with,
)

_POLL: Final = 0.01
"""Seconds between two looks at a condition that takes statements to work out."""


@dataclass(slots=True)
class Taken:
    """A statement with what was taken out of it: what stands before and after it."""

    statement: Any
    before: list[p.Statement] = field(default_factory=list)
    after: list[p.Statement] = field(default_factory=list)


Take = Callable[[p.Statement], Taken]
"""Takes out of a statement's own expressions; the bodies that it holds are not its business."""


def hoisted(body: Body, take: Take) -> Body:
    """Return the body with the statements that `take` returns, before and after each statement.

    A loop's condition is computed before each cycle; the conditions of an `If` in their order, each
    only if those before it are false.
    """
    made: list[p.Statement] = []
    for node in body:
        made += (x if x.span else replace(x, span=node.span) for x in _one(node, take))
    return tuple(made)


def _one(node: p.Statement, take: Take) -> Iterator[p.Statement]:
    if isinstance(node, p.If) and node.branches:
        yield from _if(node, take)
        return
    taken = take(node)
    before = taken.before
    inside = map_bodies(taken.statement, lambda b: hoisted(b, take))
    match inside:
        case p.While() if before:
            inside = replace(inside, body=(*inside.body, *before))
        case p.WaitUntil(condition, None) if before:
            again = (p.Wait(e.Number(_POLL)), *before)
            inside = p.While(e.Unary("not", condition), again)
    yield from before
    yield inside
    yield from taken.after


def _if(node: p.If, take: Take) -> Iterator[p.Statement]:
    first, *rest = node.branches
    taken = take(p.If((replace(first, body=()),)))
    (test,) = taken.statement.branches
    branch = replace(test, body=hoisted(first.body, take))
    yield from taken.before
    if not rest:
        yield replace(node, branches=(branch,), otherwise=hoisted(node.otherwise, take))
        return
    match tuple(_if(replace(node, branches=tuple(rest)), take)):
        case (p.If(others, otherwise),):
            yield replace(node, branches=(branch, *others), otherwise=otherwise)
        case several:
            yield replace(node, branches=(branch,), otherwise=several)


def with_functions_before_moves(program: Program) -> Program:
    """The program with a variable for each value of a move that a moving function gives."""
    results = {q.name.lower(): q.result for q in program.procedures if q.result is not None}
    counts = any(map(_is_of_arm, records_in_procedures(program, e.Apply)))
    if not results and not counts:
        return program
    sets = along_calls(program, {q.name.lower(): _sets_motion(q) for q in program.procedures})
    moving = {name: result for name, result in results.items() if sets[name]}
    moving |= _OF_ARM if counts else {}
    if not moving:
        return program
    taken = {n.lower() for t in (program.variables, program.targets, program.signals) for n in t}
    taken |= {name.lower() for q in program.procedures for name in q.variables}
    return replace(
        program,
        procedures=tuple(
            _with_values_before_moves(procedure, moving, taken) for procedure in program.procedures
        ),
    )


def _sets_motion(procedure: Procedure) -> frozenset[str]:
    """Return a non-empty set if a procedure moves, or reads the robot's position, in a tool and a
    frame.
    """
    kinds = (*p.Moving.__args__, e.Here, p.Opaque)
    asks = any(True for _ in statements_with(procedure, *kinds))
    asks = asks or any(map(_is_of_arm, records_in_body(procedure, e.Apply)))
    return frozenset({"settings"} if asks else ())


_OF_ARM: Final[Mapping[str, ValueType]] = {"flange_at": "position", "joints_at": "joints"}
"""Functions that depend on a tool and a frame, and the types of their results."""


def _is_of_arm(value: object) -> bool:
    return isinstance(value, e.Apply) and value.function.lower() in _OF_ARM


def _with_values_before_moves(
    procedure: Procedure, moving: dict[str, ValueType], taken: set[str]
) -> Procedure:
    variables: dict[str, Variable] = {}

    def name_of(place: int, type: ValueType) -> str:
        known = [name for name, variable in variables.items() if variable.type == type]
        if place < len(known):
            return known[place]
        name = next(n for k in itertools.count(1) if (n := f"value_{k}") not in taken)
        taken.add(name)
        variables[name] = Variable(type)
        return name

    def take(node: p.Statement) -> Taken:
        made = Taken(node)
        if not isinstance(node, p.MoveStatement) or not any(
            _is_one(r) for r in records(head(node))
        ):
            return made
        used: dict[ValueType, int] = {}

        def visit(value: e.Expression) -> e.Expression:
            if not isinstance(value, e.Apply) or not _is_one(value):
                return value
            type = moving[value.function.lower()]
            name = e.Name(name_of(used.get(type, 0), type))
            used[type] = used.get(type, 0) + 1
            made.before.append(p.Assign(name, value))
            return name

        made.statement = map_head(node, visit)
        return made

    def _is_one(value: object) -> bool:
        return isinstance(value, e.Apply) and value.function.lower() in moving

    body = hoisted(procedure.body, take)
    if body == procedure.body:
        return procedure
    return replace(procedure, body=body, variables={**procedure.variables, **variables})
