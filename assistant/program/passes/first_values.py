"""First values of variables: given at the top of the program, and so again at each cycle.

For controllers that begin the next cycle at the first line. Where a cycle may read what the one
before left there, and stands in no loop (see `cycles`), that is another program: a finding tells
of it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from assistant.program.analysis.assignment import AssignmentAnalysis
from assistant.program.expressions import Name
from assistant.program.passes.legalising import Legalisation
from assistant.program.passes.procedures import NOTHING
from assistant.program.program import Program, Variable
from assistant.program.rewriting import records
from assistant.program.subjects import Declared

SCALAR: Final = frozenset({"number", "integer", "truth", "text"})
"""Types of persistent data that begin with nothing where no text gives them a value."""


def with_first_values(job: Legalisation) -> Program:
    """The program with values for the variables that it reads before it gives them one.

    What a program of the same kin leaves without a value keeps the one that it has there.
    """
    program, findings, can = job.program, job.findings, job.can.variables
    entry = program.procedure(program.entry) if program.entry else None
    if entry is None or can is None:
        return program
    assigning = AssignmentAnalysis(program)
    run = assigning.run(entry)
    kept = program.origin is not None and program.origin.language in job.can.kin
    variables: dict[str, Variable] = {}
    for name, variable in program.variables.items():
        key = name.lower()
        variables[name] = variable
        if variable.storage == "constant" or key not in run.read:
            continue
        if variable.initial is None and can.external(name, variable):
            continue
        place = variable.storage == "persistent" and variable.type not in SCALAR
        if variable.initial is None and not kept and not place:  # which nothing says: no move there
            variable = replace(variable, initial=NOTHING[variable.type])
            variables[name] = variable
        if variable.initial is not None:
            about = Declared(name, "variables")
            changes = key in assigning.written and run.ends
            with findings.at(variable.span):
                if variable.storage == "persistent":
                    findings.append(can.persistent(name=name, about=about))
                if changes:
                    findings.append(can.carried(name=name, about=about))
    return replace(program, variables=_by_dependency(variables))


def _by_dependency(variables: dict[str, Variable]) -> dict[str, Variable]:
    """Variables behind those that their first values name, else as they are declared."""
    spelled = {name.lower(): name for name in variables}
    ordered: dict[str, Variable] = {}
    for name in variables:
        pending = [name]
        while pending:
            first = pending[-1]
            named = (
                x.name.lower() for x in records(variables[first].initial) if isinstance(x, Name)
            )
            needed = [
                spelled[low]
                for low in named
                if low in spelled and spelled[low] not in ordered and spelled[low] not in pending
            ]
            if needed:
                pending += needed[:1]
            else:
                ordered.setdefault(first, variables[first])
                pending.pop()
    return ordered
