"""Procedures and interrupts: variables that begin anew at each call, results, order, recursion.

If a language calls functions in expressions only, a variable takes an unused result. Procedures
that are equal forms of one become one. A language may define interrupts at the start of its
program.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import takewhile
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Declared
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import reachable
from assistant.program.analysis.definite_assignment import AssignmentAnalysis
from assistant.program.analysis.uses import called, declared, locals_of, recursive_names
from assistant.program.geometry import IDENTITY, Configuration, JointTarget, Target
from assistant.program.program import (
    Procedure,
    Program,
    TakenNames,
    ValueType,
    Variable,
    identifier,
    walk,
)
from assistant.program.rewriting import Body, map_bodies, records, rewrite
from assistant.program.statement_index import records_in_body
from assistant.program.undeclared_names import interrupts

if TYPE_CHECKING:
    from assistant.program.passes.legalisation import Legalisation

NOTHING: Final[dict[ValueType, e.Expression]] = {
    "number": e.Number(0),
    "integer": e.Number(0),
    "truth": e.Number(0),
    "text": e.Text(""),
    "position": e.TargetValue(Target(IDENTITY, Configuration())),
    "pose": e.PoseValue(IDENTITY),
    "joints": e.JointValue(JointTarget((0.0,) * 6)),
}
"""Value of a variable that has no first value; an arm must not be sent to such a position."""


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
        # Persistent and constant data keep their values between calls.
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
    # Comments above the procedure stay above it.
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
    """True if another unit passes arguments to a procedure: it is the first in its unit, and takes
    copies.
    """
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
    """True if the procedures that a unit calls are functions; subroutines, in contrast, share all
    variables.
    """
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
            # Loop counters without a declaration are variables of the procedure.
            continue
        loops = (loop.variable.lower() for loop in records_in_body(procedure, p.For))
        if has_form(procedure) or procedure.variables or any(x not in shared for x in loops):
            yield procedure


_UNUSED: Final = "unused"
"""Name of the variable; for another type, the type follows it."""


def with_results_taken(program: Program) -> Program:
    """The program with no function that is called as a procedure."""
    results = {q.name.lower(): q.result for q in program.procedures if q.result is not None}
    called = (node for node in program.statements() if isinstance(node, p.Call))
    if not any(node.procedure.lower() in results for node in called):
        return program
    taken = TakenNames(declared(program))
    names: dict[ValueType, str] = {}

    def within(procedure: Procedure) -> Procedure:
        own: dict[str, Variable] = {}

        def body(statements: Body) -> Body:
            return tuple(map(said, statements))

        def said(node: p.Statement) -> p.Statement:
            match node:
                case p.Call(name, given) if (kind := results.get(name.lower())) is not None:
                    if kind not in names:
                        names[kind] = identifier(f"{_UNUSED}_{kind}" if names else _UNUSED, taken)
                        taken.add(names[kind])
                    own[names[kind]] = Variable(kind)
                    value = e.Apply(name, given)
                    return p.Assign(e.Name(names[kind]), value, span=node.span)
            made: p.Statement = map_bodies(node, body)
            return made

        made = body(procedure.body)
        return replace(procedure, body=made, variables=procedure.variables | own)

    return replace(program, procedures=tuple(map(within, program.procedures)))


def without_equal_procedures(
    procedures: list[Procedure], origin: Mapping[str, int]
) -> list[Procedure]:
    """The procedures without those that another form of the same code says as well.

    origin: of each procedure that is a form of some code, by name, which code that is.
    """
    # Exchanging calls may make further procedures equal.
    while True:
        exchanged: dict[str, str] = {}
        kept: dict[int, list[Procedure]] = {}
        for procedure in procedures:
            if procedure.name not in origin:
                continue
            forms = kept.setdefault(origin[procedure.name], [])
            same = next((q for q in forms if replace(procedure, name=q.name) == q), None)
            if same is None:
                forms.append(procedure)
            else:
                exchanged[procedure.name] = same.name
        if not exchanged:
            return procedures
        procedures = [
            replace(q, body=_with_calls_replaced(q.body, exchanged))
            for q in procedures
            if q.name not in exchanged
        ]


def _with_calls_replaced(
    body: tuple[p.Statement, ...], names: Mapping[str, str]
) -> tuple[p.Statement, ...]:
    def visit(node: Any) -> Any:
        match node:
            case p.Call(procedure=name) if name in names and node.unit is None:
                return replace(node, procedure=names[name])
            case e.Apply(function=name) if name in names:
                return replace(node, function=names[name])
        return node

    return rewrite(body, visit)


def with_interrupts_first(job: Legalisation) -> Program:
    """Return the program that defines its interrupts at its top, in the order of the text.

    They have no effect before they are switched on. An interrupt that is defined in several ways,
    or that needs local data of its procedure, cannot be expressed.
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
    # Definitions have no effect until they are switched on, so the top is early enough.
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
    """Yield interrupts that call a procedure that they may interrupt, with the reason.

    Such a procedure has local data that exist only once, or a timer.
    """
    program, can = job.program, job.can.procedures
    if can is None:  # each call has data of its own
        return
    names = {q.name.lower() for q in program.procedures}
    calls = {q.name.lower(): _direct_calls(q) & names for q in program.procedures}
    outside = reachable({(program.entry or "").lower()} & calls.keys(), calls.__getitem__)
    # Timers exist once: a wait with a limit inside another one would restart it.
    waits = any(map(_waits_with_limit, map(program.procedure, outside)))
    for node in interrupts(program):
        first = {node.call.procedure.lower()} & calls.keys()
        for name in sorted(reachable(first, calls.__getitem__)):
            called = program.procedure(name)
            assert called is not None
            functions = has_functions(program, called.unit, can.functions)
            own = not functions and (has_form(called) or called.variables)
            if name in outside and (own or _starts_timer(called)):
                yield node, f"calls `{called.name}`, as what it interrupts does"
            elif waits and _waits_with_limit(called):
                yield node, "waits with a time limit, as what it interrupts does"


def _direct_calls(procedure: Procedure) -> set[str]:
    """Return the names that a procedure calls directly, without its interrupts."""
    answered = {id(one.call) for one in walk(procedure.body) if isinstance(one, p.Interrupt)}
    return {
        (one.procedure if isinstance(one, p.Call) else one.function).lower()
        for one in records(procedure.body)
        if isinstance(one, p.Call | e.Apply) and id(one) not in answered
    }


def _starts_timer(procedure: Procedure) -> bool:
    """True if it starts a timer."""
    return any(isinstance(one, p.StartTimer) for one in walk(procedure.body)) or _waits_with_limit(
        procedure
    )


def _waits_with_limit(procedure: Procedure | None) -> bool:
    """True if it waits with a time limit."""
    return procedure is not None and any(
        isinstance(one, p.WaitSignal | p.WaitUntil) and one.timeout is not None
        for one in walk(procedure.body)
    )
