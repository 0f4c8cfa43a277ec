"""Bringing a program into what a language can say: passes, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import wraps

from assistant.program.diagnostics import Findings, Rule
from assistant.program.passes.watching import passed
from assistant.program.program import Program


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What a language can say of what programs ask for, and the rules that tell of the rest.

    functions: procedures have parameters, results and variables of their own. most_dimensions,
    most_elements: of an array, the elements of one dimension. cannot_say: has the fields what and
    cure. as_variables: of a procedure (name) whose parameters and result become variables.
    recursive: of one (name) that calls itself though its data exist once.
    """

    functions: bool
    most_dimensions: int
    most_elements: int
    cannot_say: Rule
    as_variables: Rule
    recursive: Rule


@dataclass(frozen=True, slots=True)
class Legalising:
    """A program on its way into a language. findings: what is said differently, or not at all."""

    program: Program
    can: Capabilities
    findings: Findings


Pass = Callable[[Legalising], Program]


def pure(change: Callable[[Program], Program]) -> Pass:
    """A pass that needs nothing but the program, and finds nothing."""

    @wraps(change)
    def changed(job: Legalising) -> Program:
        return change(job.program)

    return changed


def legalised(job: Legalising, passes: Sequence[Pass]) -> Program:
    """The program after all passes, each shown under its name to whoever watches."""
    for one in passes:
        name = getattr(one, "__name__", "").replace("_", "-")
        job = replace(job, program=passed(name, one(job)))
    return job.program
