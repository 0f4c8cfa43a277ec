"""The procedure that a program begins with, where it is named from outside."""

from __future__ import annotations

from dataclasses import replace

from assistant.base.diagnostics import Refused, error
from assistant.program.program import Procedure, Program

NO_SUCH = error("CO011", "there is no procedure `{name}` to begin with", "choose {names}")
NOT_BEGUN = error(
    "CO012",
    "nothing can begin with `{name}`, which has parameters, a result or a unit of its own",
    "choose {names}, or write a procedure that calls it",
)


def entered(program: Program, entry: str | None) -> Program:
    """The program beginning with that procedure, with its own beginning if none is named.

    Raises Refused for one that there is not, or that nothing can begin with.
    """
    if entry is None:
        return program
    known = program.procedure(entry)
    if known is not None and _begins(known):
        return replace(program, entry=known.name)
    begin = ", ".join(q.name for q in program.procedures if _begins(q))
    names = f"one of {begin}" if begin else "a procedure without parameters"
    rule = NO_SUCH if known is None else NOT_BEGUN
    raise Refused(rule(name=entry, names=names), exit_status=2)


def _begins(procedure: Procedure) -> bool:
    return not procedure.parameters and procedure.result is None and procedure.unit is None
