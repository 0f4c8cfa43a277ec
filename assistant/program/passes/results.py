"""Functions that are called for what they do, and not for what they give back.

Where a language calls functions in expressions only, a variable takes what nobody asks for.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import declared
from assistant.program.program import (
    Procedure,
    Program,
    TakenNames,
    ValueType,
    Variable,
    identifier,
)
from assistant.program.rewriting import Body, map_bodies

UNUSED: Final = "unused"
"""Name of the variable; of another type with the type behind it."""


def with_results_taken(program: Program) -> Program:
    """The program with no function that is called as a procedure."""
    results = {q.name.lower(): q.result for q in program.procedures if q.result is not None}
    called = (node for node in program.statements() if isinstance(node, p.Call))
    if not any(node.procedure.lower() in results for node in called):
        return program
    taken = TakenNames(declared(program))
    names: dict[ValueType, str] = {}

    def within(procedure: Procedure) -> Procedure:
        own: dict[str, Variable] = {}

        def body(statements: Body) -> Body:
            return tuple(map(said, statements))

        def said(node: p.Statement) -> p.Statement:
            match node:
                case p.Call(name, given) if (kind := results.get(name.lower())) is not None:
                    if kind not in names:
                        names[kind] = identifier(f"{UNUSED}_{kind}" if names else UNUSED, taken)
                        taken.add(names[kind])
                    own[names[kind]] = Variable(kind)
                    value = e.Apply(name, given)
                    return p.Assign(e.Name(names[kind]), value, span=node.span)
            made: p.Statement = map_bodies(node, body)
            return made

        made = body(procedure.body)
        return replace(procedure, body=made, variables=procedure.variables | own)

    return replace(program, procedures=tuple(map(within, program.procedures)))
