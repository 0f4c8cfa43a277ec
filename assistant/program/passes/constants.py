"""Predefined constants of a language whose values mean the same to every controller."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program
from assistant.program.rewriting import records, rewrite


def with_constants(program: Program, predefined: Mapping[str, float]) -> Program:
    """The program with the numbers instead of the names, where these mean nothing else in it.

    predefined: by lower-case name.
    """
    taken = set(_declared(program))
    values = {name: e.Number(value) for name, value in predefined.items() if name not in taken}
    if not values:
        return program

    def meant(part: Any) -> Any:
        return values.get(part.name.lower(), part) if isinstance(part, e.Name) else part

    return rewrite(program, meant)


def _declared(program: Program) -> Iterator[str]:
    """Names of all data, in lower case."""
    tables = (program.variables, program.targets, program.joint_targets, program.signals)
    for table in tables:
        yield from (name.lower() for name in table)
    for procedure in program.procedures:
        yield from (name.lower() for name in procedure.variables)
        yield from (parameter.name.lower() for parameter in procedure.parameters)
        for record in records(procedure.body):
            if isinstance(record, p.For):
                yield record.variable.lower()
