"""What every controller of a language has: constants whose values mean the same, variables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import chain
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import declared
from assistant.program.contents import names_in_procedures, records_in_procedures
from assistant.program.program import Program, ValueType, Variable
from assistant.program.rewriting import records, rewrite


def with_constants(program: Program, predefined: Mapping[str, float | str]) -> Program:
    """The program with the values instead of the names, where these mean nothing else in it.

    predefined: by lower-case name.
    """
    loops = (x.variable.lower() for x in program.statements() if isinstance(x, p.For))
    taken = {*declared(program), *loops}
    values = {
        name: e.Text(value) if isinstance(value, str) else e.Number(value)
        for name, value in predefined.items()
        if name not in taken
    }
    used = chain(records_in_procedures(program, e.Name), records(program.variables))
    if not any(isinstance(one, e.Name) and one.name.lower() in values for one in used):
        return program

    def meant(part: Any) -> Any:
        return values.get(part.name.lower(), part) if isinstance(part, e.Name) else part

    return rewrite(program, meant)


def with_predefined(program: Program, types: Mapping[str, tuple[str, ValueType]]) -> Program:
    """The program with the variables that every controller has, where it declares none.

    types: by lower-case name the name as it is spelled, and the type.
    """
    taken = set(declared(program))
    used = (name.lower() for name in names_in_procedures(program))
    found = dict(types[name] for name in used if name in types and name not in taken)
    made = {name: Variable(type) for name, type in found.items()}
    return replace(program, variables={**program.variables, **made}) if made else program
