"""Procedures: variables that begin anew with each call, and which have parameters."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import takewhile
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.assignment import AssignmentAnalysis
from assistant.program.analysis.circles import recursive_names
from assistant.program.analysis.uses import called
from assistant.program.contents import records_in_body
from assistant.program.geometry import IDENTITY, Configuration, JointTarget, Target
from assistant.program.passes.legalising import Legalisation
from assistant.program.program import (
    Procedure,
    Program,
    ValueType,
)
from assistant.program.rewriting import Body
from assistant.program.subjects import Declared

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
    assigning = AssignmentAnalysis(program)
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
    notes, body = notes_and_body(procedure.body)
    return replace(procedure, variables=variables, body=(*notes, *first, *body))


def notes_and_body(body: Body) -> tuple[Body, Body]:
    """The comments that stood above a procedure, and its statements."""
    notes = tuple(takewhile(_is_note, body))
    return notes, body[len(notes) :]


def _is_note(statement: p.Statement) -> bool:
    return isinstance(statement, p.Comment) and statement.span is None


def has_form(procedure: Procedure) -> bool:
    return bool(procedure.parameters) or procedure.result is not None


def is_called_with_arguments(procedure: Procedure, program: Program) -> bool:
    """Whether another unit hands a procedure its arguments: it begins its own, and takes copies."""
    if procedure.unit is None or procedure.result is not None:
        return False
    first = next(q for q in program.procedures if q.unit == procedure.unit)
    return first.name == procedure.name and all(q.mode == "in" for q in procedure.parameters)


def units(program: Program) -> tuple[str, ...]:
    """The units that are loaded when called, in order of their first procedure."""
    return tuple(dict.fromkeys(p.unit for p in program.procedures if p.unit is not None))


def procedures_of(program: Program, unit: str | None) -> tuple[Procedure | None, list[Procedure]]:
    """The procedure that a unit begins with, and those that it calls."""
    mine = [q for q in program.procedures if q.unit == unit]
    if unit is not None:
        return (mine[0], mine[1:]) if mine else (None, [])
    entry = (program.entry or "").lower()
    first = next((q for q in mine if q.name.lower() == entry), None)
    return first, [q for q in mine if q is not first]


def has_functions(program: Program, unit: str | None, functions: bool) -> bool:
    """Whether what a unit calls are functions; subroutines, if not, share all variables."""
    _, others = procedures_of(program, unit)
    return functions and any(q.parameters or q.result is not None for q in others)


def without_recursion(job: Legalisation) -> Program:
    """The program itself; procedures whose data exist once must not call themselves."""
    can = job.can.procedures
    if can is not None:
        for procedure in recursive_procedures(job.program):
            if not has_functions(job.program, procedure.unit, can.functions):
                with job.findings.at(procedure.span):
                    about = Declared(procedure.name, "procedures")
                    job.findings.append(can.recursive(name=procedure.name, about=about))
    return job.program


def with_entry_first(program: Program) -> Program:
    """The program with its entry first, as its procedure spells it; none that is not there."""
    entry = program.procedure(program.entry) if program.entry else None
    return replace(
        program,
        entry=entry.name if entry else None,
        procedures=tuple(sorted(program.procedures, key=lambda q: q is not entry)),
    )


def with_units_together(program: Program) -> Program:
    """The program with the procedures of each unit together, the main unit first."""
    units: dict[str | None, list[Procedure]] = {None: []}
    for procedure in program.procedures:
        units.setdefault(procedure.unit, []).append(procedure)
    return replace(program, procedures=tuple(q for unit in units.values() for q in unit))


def recursive_procedures(program: Program) -> Iterator[Procedure]:
    """Procedures with parameters, a result or variables that call themselves, in the end.

    The counter of a loop is a variable of its procedure, unless the program has one of that name.
    """
    shared = {name.lower() for name in program.variables}
    again = recursive_names({q.name.lower(): set(called(q)) for q in program.procedures})
    for procedure in program.procedures:
        if procedure.name.lower() not in again:
            continue
        loops = (loop.variable.lower() for loop in records_in_body(procedure, p.For))
        if has_form(procedure) or procedure.variables or any(x not in shared for x in loops):
            yield procedure
