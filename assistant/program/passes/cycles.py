"""Cycles that begin with what the one before left, for controllers that begin each one anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.assignment import AssignmentAnalysis
from assistant.program.analysis.interrupts import interrupts
from assistant.program.analysis.left_settings import Setting, left_settings
from assistant.program.contents import records_in_body
from assistant.program.passes.legalising import Legalisation
from assistant.program.program import Procedure, Program, identifier
from assistant.program.subjects import Declared

CYCLE: Final = "cycle"
"""Name of the procedure that becomes of the one that a program begins with."""
FOR_EVER: Final = e.Number(1)
MOST_NAMES_REPORTED: Final = 5
"""Names that a finding tells."""
_SETTING_WORDS: Final[Mapping[type[Setting], str]] = {
    p.SetOverride: "the override of speeds",
    p.SetAcceleration: "the acceleration",
}


def with_kept_values(job: Legalisation) -> Program:
    """The program with a loop without end around its cycle, where one leaves values to the next.

    Such a controller gives variables their first values at the first line, to which it goes back
    behind each cycle, and moves as fast as usual again. A program of the same kin has no such
    values, and nothing becomes of it.
    """
    program, can = job.program, job.can.variables
    entry = program.procedure(program.entry) if program.entry else None
    kept = program.origin is not None and program.origin.language in job.can.kin
    if entry is None or can is None or kept or _is_called(program, entry):
        return program
    if any(one.ends is not None for one in interrupts(program)):  # which lead out of the loop
        return program
    assigning = AssignmentAnalysis(program)
    run = assigning.run(entry)
    left = [
        name
        for name, variable in program.variables.items()
        if variable.storage != "constant"
        and name.lower() in run.read & assigning.written
        and (variable.initial is not None or not can.external(name, variable))
    ]
    told = [_SETTING_WORDS[type(one)] for one in left_settings(program, entry)]
    if not (left or told) or not run.ends:
        return program
    with job.findings.at(entry.span):
        about = Declared(entry.name, "procedures")
        job.findings.append(can.repeated(names=_names_in_words(left, told), about=about))
    taken = {*(q.name for q in program.procedures), *program.variables, *program.targets}
    cycle = replace(entry, name=identifier(CYCLE, taken))
    loop = Procedure(entry.name, (p.While(FOR_EVER, (p.Call(cycle.name),)),), span=entry.span)
    others = tuple(q for q in program.procedures if q is not entry)
    return replace(program, procedures=(loop, cycle, *others))


def repeats_cycle(program: Program) -> bool:
    """Whether the cycle of a program stands in a loop of its own, behind first values."""
    entry = program.procedure(program.entry) if program.entry else None
    match entry.body if entry is not None else ():
        case (*_, p.While(condition, (p.Call(arguments=()),))):
            return condition == FOR_EVER
    return False


def _is_called(program: Program, entry: Procedure) -> bool:
    key = entry.name.lower()
    return any(
        (isinstance(one, p.Call) and one.procedure.lower() == key)
        or (isinstance(one, e.Apply) and one.function.lower() == key)
        for procedure in program.procedures
        for one in records_in_body(procedure, p.Call, e.Apply)
    )


def _names_in_words(names: Sequence[str], more: Sequence[str]) -> str:
    told = [f"`{name}`" for name in names[:MOST_NAMES_REPORTED]] + list(more)
    others = len(names) - MOST_NAMES_REPORTED
    return ", ".join(told) if others <= 0 else f"{', '.join(told)} and {others} more"
