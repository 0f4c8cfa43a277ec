"""Functions that move the robot themselves, called before the move that they are a value of.

For languages whose speed, corner, tool and frame are statements of their own: such a function sets
them for its own moves, and those of the move that calls it would be gone when that begins.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import along_calls
from assistant.program.contents import records_in_body, records_in_procedures, statements_with
from assistant.program.passes.hoisting import Taken, hoisted
from assistant.program.program import Procedure, Program, ValueType, Variable
from assistant.program.rewriting import head, map_head, records


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
    """Whether a procedure moves, or reads where the robot stands, in a tool and a frame."""
    kinds = (*p.Moving.__args__, e.Here, p.Opaque)
    asks = any(True for _ in statements_with(procedure, *kinds))
    asks = asks or any(map(_is_of_arm, records_in_body(procedure, e.Apply)))
    return frozenset({"settings"} if asks else ())


_OF_ARM: Final[Mapping[str, ValueType]] = {"flange_at": "position", "joints_at": "joints"}
"""Functions that are asked for under a tool and a frame, and the types of what they give."""


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
