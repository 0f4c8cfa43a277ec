"""Interrupts of a language that defines them where its program begins."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.interrupts import interrupts
from assistant.program.analysis.uses import locals_of
from assistant.program.passes.legalising import Legalisation
from assistant.program.passes.procedures import has_form, has_functions
from assistant.program.program import Procedure, Program, walk
from assistant.program.rewriting import Body, map_bodies, records


def with_interrupts_first(job: Legalisation) -> Program:
    """The program that defines its interrupts at its top, in the order of the text.

    They do nothing before they are switched on. One that is defined in several ways, or asks for
    what its procedure alone has, cannot be said.
    """
    program = job.program
    entry = program.procedure(program.entry) if program.entry else None
    found = [
        (q, node)
        for q in program.procedures
        for node in walk(q.body)
        if isinstance(node, p.Interrupt)
    ]
    if not found or entry is None:
        return program
    for node, why in _shared_interrupts(job):
        with job.findings.at(node.span):
            cure = "write what both need twice, and count the time of one in a loop"
            job.cannot(what=f"the interrupt `{node.name}`, which {why}", cure=cure)
    first: dict[str, p.Interrupt] = {}
    for procedure, node in found:
        with job.findings.at(node.span):
            for why, cure in _refused(program, procedure, node, first):
                job.cannot(what=f"the interrupt `{node.name}`, which {why}", cure=cure)
        first.setdefault(node.name.lower(), node)

    def without(body: Body) -> Body:
        return tuple(map_bodies(n, without) for n in body if not isinstance(n, p.Interrupt))

    procedures = [replace(q, body=without(q.body)) for q in program.procedures]
    at = next(i for i, q in enumerate(program.procedures) if q is entry)
    procedures[at] = replace(procedures[at], body=(*first.values(), *procedures[at].body))
    return replace(program, procedures=tuple(procedures))


def _refused(
    program: Program, procedure: Procedure, node: p.Interrupt, others: dict[str, p.Interrupt]
) -> Iterator[tuple[str, str]]:
    """Why an interrupt cannot be defined elsewhere, and what to do."""
    if others.get(node.name.lower(), node) != node:
        yield "is defined in several ways", "give each of them a name of its own"
    if procedure.unit is not None:
        yield "is defined in a program that is loaded", "define it in the main program"
    names = {one.name.lower() for one in records(node.condition) if isinstance(one, e.Name)}
    if own := sorted(names & locals_of(procedure)):
        yield f"asks for `{own[0]}` of `{procedure.name}`", "keep that in a variable of the program"
    if program.procedure(node.call.procedure) is None:
        yield f"calls `{node.call.procedure}`, which is not there", "write it"


def _shared_interrupts(job: Legalisation) -> Iterator[tuple[p.Interrupt, str]]:
    """Interrupts that call what they may interrupt, and what that is.

    It has data of its own which are there once, or a timer.
    """
    program, can = job.program, job.can.procedures
    if can is None:  # each call has data of its own
        return
    calls = {q.name.lower(): _direct_calls(q) for q in program.procedures}
    outside = _reached_procedures({(program.entry or "").lower()}, calls)
    waits = any(map(_waits_with_limit, map(program.procedure, outside)))
    for node in interrupts(program):
        for name in sorted(_reached_procedures({node.call.procedure.lower()}, calls)):
            called = program.procedure(name)
            assert called is not None
            functions = has_functions(program, called.unit, can.functions)
            own = not functions and (has_form(called) or called.variables)
            if name in outside and (own or _starts_timer(called)):
                yield node, f"calls `{called.name}`, as what it interrupts does"
            elif waits and _waits_with_limit(called):
                yield node, "waits with a time limit, as what it interrupts does"


def _direct_calls(procedure: Procedure) -> set[str]:
    """What a procedure calls itself, without its interrupts."""
    answered = {id(one.call) for one in walk(procedure.body) if isinstance(one, p.Interrupt)}
    return {
        (one.procedure if isinstance(one, p.Call) else one.function).lower()
        for one in records(procedure.body)
        if isinstance(one, p.Call | e.Apply) and id(one) not in answered
    }


def _reached_procedures(names: set[str], calls: dict[str, set[str]]) -> set[str]:
    """Procedures that are called, with those that these call."""
    found: set[str] = set()
    while pending := (names & calls.keys()) - found:
        found |= pending
        names = set().union(*(calls[name] for name in pending))
    return found


def _starts_timer(procedure: Procedure) -> bool:
    """Whether it starts a timer."""
    return any(isinstance(one, p.StartTimer) for one in walk(procedure.body)) or _waits_with_limit(
        procedure
    )


def _waits_with_limit(procedure: Procedure | None) -> bool:
    """Whether it waits with a time limit."""
    return procedure is not None and any(
        isinstance(one, p.WaitSignal | p.WaitUntil) and one.timeout is not None
        for one in walk(procedure.body)
    )
