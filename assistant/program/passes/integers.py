"""Whole numbers in variables, for a language whose numbers are of one type."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from assistant.program.program import Program, Variable


def with_one_kind_of_numbers(program: Program) -> Program:
    """The program with numbers for variables, parameters and results of whole numbers."""
    return replace(
        program,
        variables=_variables(program.variables),
        procedures=tuple(
            replace(
                q,
                variables=_variables(q.variables),
                parameters=tuple(map(_number, q.parameters)),
                result="number" if q.result == "integer" else q.result,
            )
            for q in program.procedures
        ),
    )


def _variables(variables: Mapping[str, Variable]) -> dict[str, Variable]:
    return {name: _number(variable) for name, variable in variables.items()}


def _number(declared: Any) -> Any:
    return replace(declared, type="number") if declared.type == "integer" else declared
