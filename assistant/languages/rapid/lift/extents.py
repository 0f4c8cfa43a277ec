"""`Dim` of arrays that a program declares: how many elements they have is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from assistant.program import expressions as e
from assistant.program.analysis.uses import names_in
from assistant.program.program import Program
from assistant.program.rewriting import rewrite
from assistant.program.statement_index import records_in_procedures

ArraySizes = Mapping[str, tuple[int, ...]]
"""Extents of arrays by lower-case name, none where they are not known."""


def with_known_extents(program: Program) -> Program:
    """The program with numbers for `Dim(array,1)`; of an array parameter it stays a call."""
    if not any(part.function.lower() == "dim" for part in records_in_procedures(program, e.Apply)):
        return program
    shared = {name.lower(): v.size for name, v in program.variables.items()}
    procedures = []
    for procedure in program.procedures:
        own: dict[str, tuple[int, ...]] = {q.name.lower(): () for q in procedure.parameters}
        own |= {name.lower(): v.size for name, v in procedure.variables.items()}
        sizes: ArraySizes = {**shared, **own}
        body = rewrite(procedure.body, lambda x: _extent_number(x, sizes))  # noqa: B023
        procedures.append(replace(procedure, body=body))
    return replace(program, procedures=tuple(procedures))


def _extent_number(x: Any, sizes: ArraySizes) -> Any:
    match x:
        case e.Apply(function, (array, e.Number(int(place)))) if function.lower() == "dim":
            name = next(names_in(array), "").lower()  # of a record that is taken apart any part
            size = sizes.get(name, ())
            return e.Number(size[place - 1]) if 0 < place <= len(size) else x
    return x
