"""The procedure that a program begins with, where it is named from outside."""

from __future__ import annotations

from dataclasses import replace

from assistant.base.diagnostics import Refused, error
from assistant.program.program import Procedure, Program

NO_SUCH_ENTRY = error("CO011", "there is no procedure `{name}` to begin with", "choose {names}")
ENTRY_WITH_PARAMETERS = error(
    "CO012",
    "nothing can begin with `{name}`, which has parameters, a result or a unit of its own",
    "choose {names}, or write a procedure that calls it",
)


def with_entry(program: Program, entry: str | None) -> Program:
    """The program beginning with that procedure, with its own beginning if none is named.

    Raises Refused for one that there is not, or that nothing can begin with.
    """
    if entry is None:
        return program
    known = program.procedure(entry)
    if known is not None and _can_begin(known):
        return replace(program, entry=known.name)
    begin = ", ".join(q.name for q in program.procedures if _can_begin(q))
    names = f"one of {begin}" if begin else "a procedure without parameters"
    rule = NO_SUCH_ENTRY if known is None else ENTRY_WITH_PARAMETERS
    raise Refused(rule(name=entry, names=names), exit_status=2)


def _can_begin(procedure: Procedure) -> bool:
    return not procedure.parameters and procedure.result is None and procedure.unit is None
