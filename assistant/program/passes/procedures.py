"""Procedures: variables that begin anew with each call, and which have parameters."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.assignment import Assigning
from assistant.program.analysis.uses import called
from assistant.program.geometry import IDENTITY, Configuration, JointTarget, Target
from assistant.program.program import (
    Procedure,
    Program,
    ValueType,
)
from assistant.program.rewriting import records

NOTHING: Final[dict[ValueType, e.Expression]] = {
    "number": e.Number(0),
    "integer": e.Number(0),
    "truth": e.Number(0),
    "text": e.Text(""),
    "position": e.TargetValue(Target(IDENTITY, Configuration())),
    "pose": e.PoseValue(IDENTITY),
    "joints": e.JointValue(JointTarget((0.0,) * 6)),
}
"""What a variable holds that was given no value; of a position no arm may be sent to it."""


def with_fresh_variables(program: Program) -> Program:
    """The program whose procedures give their variables the first value at each call."""
    assigning = Assigning(program)
    fresh = (_with_fresh(q, assigning.run(q).own) for q in program.procedures)
    return replace(program, procedures=tuple(fresh))


def _with_fresh(procedure: Procedure, read: set[str]) -> Procedure:
    """The procedure that gives its variables their first value at its top; `with_filled_arrays`
    does so for arrays.

    read: in lower case those that may be read before they are given one.
    """
    first: list[p.Statement] = []
    variables = dict(procedure.variables)
    for name, variable in procedure.variables.items():
        if variable.storage != "variable":
            continue
        value = variable.initial
        if value is None and name.lower() in read:
            value = NOTHING[variable.type]
        if variable.size:
            variables[name] = replace(variable, initial=value)
        elif value is not None:
            variables[name] = replace(variable, initial=None)
            first.append(p.Assign(e.Name(name), value, span=variable.span))
    if not first and variables == procedure.variables:
        return procedure
    return replace(procedure, variables=variables, body=(*first, *procedure.body))


def has_form(procedure: Procedure) -> bool:
    return bool(procedure.parameters) or procedure.result is not None


def is_called_with_arguments(procedure: Procedure, program: Program) -> bool:
    """Whether another unit hands a procedure its arguments: it begins its own, and takes copies."""
    if procedure.unit is None or procedure.result is not None:
        return False
    first = next(q for q in program.procedures if q.unit == procedure.unit)
    return first.name == procedure.name and all(q.mode == "in" for q in procedure.parameters)


def recursive(program: Program) -> Iterator[Procedure]:
    """Procedures with parameters, a result or variables that call themselves, in the end.

    The counter of a loop is a variable of its procedure, unless the program has one of that name.
    """
    shared = {name.lower() for name in program.variables}
    calls = {q.name.lower(): set(called(q)) for q in program.procedures}
    for procedure in program.procedures:
        loops = (r.variable.lower() for r in records(procedure.body) if isinstance(r, p.For))
        own = procedure.variables or any(counter not in shared for counter in loops)
        if not has_form(procedure) and not own:
            continue
        name = procedure.name.lower()
        reached: set[str] = set()
        pending = list(calls[name])
        while pending:
            callee = pending.pop()
            if callee in calls and callee not in reached:
                reached.add(callee)
                pending += calls[callee]
        if name in reached:
            yield procedure
