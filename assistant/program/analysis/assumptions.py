"""What a program relies on that languages understand differently."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Literal

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.assignment import AssignmentAnalysis
from assistant.program.diagnostics import Span
from assistant.program.program import Program, Variable, walk
from assistant.program.rewriting import Body, head, records
from assistant.program.wholes import NumberFacts


def first_move(program: Program, name: str, of: Literal["tool", "frame"]) -> Span | None:
    """Where the program first moves with the tool, or in the frame, of that name."""
    for statement in program.statements():
        match statement:
            case p.Follow(path=path):
                used = set(path.tools if of == "tool" else path.frames)
            case (
                p.Move(motion=motion) | p.MoveCircular(motion=motion) | p.MoveJoints(motion=motion)
            ):
                used = {motion.tool if of == "tool" else motion.frame}
            case _:
                continue
        if name in used:
            return statement.span
    return None


def variables_read_unset(program: Program) -> Iterator[tuple[str, Variable, Span | None]]:
    """Variables of the program that are read before they have a value, but for arrays.

    With the place that first names one, else that of its declaration.
    """
    entry = program.procedure(program.entry) if program.entry else None
    read = AssignmentAnalysis(program).run(entry).read if entry is not None else set()
    met: dict[str, Span | None] | None = None
    for name, variable in program.variables.items():
        own = variable.storage == "variable" and variable.initial is None and not variable.size
        if own and name.lower() in read:
            met = _first_named(program) if met is None else met
            yield name, variable, met.get(name.lower(), variable.span)


def _first_named(program: Program) -> dict[str, Span | None]:
    """Names in lower case of the program's own, each with the place of the first statement that
    holds it.
    """
    found: dict[str, Span | None] = {}
    for procedure in program.procedures:
        own = {name.lower() for name in procedure.variables}
        own |= {parameter.name.lower() for parameter in procedure.parameters}
        for statement in walk(procedure.body):
            for part in records(head(statement)):
                if isinstance(part, e.Name) and part.name.lower() not in own:
                    found.setdefault(part.name.lower(), statement.span)
    return found


def functions_of_signed_bits(
    program: Program, functions: Collection[str]
) -> Iterator[tuple[str, Span | None]]:
    """Functions of bits, of those given, whose numbers may be below 0."""
    numbers: NumberFacts | None = None
    for procedure in program.procedures:
        for statement in walk(procedure.body):
            for part in records(head(statement)):
                if isinstance(part, e.Apply) and part.function in functions:
                    numbers = numbers or NumberFacts(program)
                    if not all(numbers.of(x, procedure).positive for x in part.arguments):
                        yield part.function, statement.span


def loops_with_changing_limits(program: Program) -> Iterator[tuple[p.For, list[str]]]:
    """Loops whose end or step changes inside, with the names that do, in lower case.

    Not those that change their own variable, which are no plain counts.
    """
    written = {q.name.lower(): set(_written_variables(q.body)) for q in program.procedures}
    called = {q.name.lower(): set(_called_names(q.body)) for q in program.procedures}
    for statement in program.statements():
        if not isinstance(statement, p.For):
            continue
        changed = set(_written_variables(statement.body))
        for name in _reached_procedures(set(_called_names(statement.body)), called):
            changed |= written.get(name, set())
        limits = {
            r.name.lower()
            for r in records((statement.last, statement.step))
            if isinstance(r, e.Name)
        }
        found = sorted(limits & changed)
        if found and statement.variable.lower() not in changed:
            yield statement, found


def _written_variables(body: Body) -> Iterator[str]:
    """Names in lower case of variables that statements write."""
    for statement in walk(body):
        if isinstance(statement, p.For):
            yield statement.variable.lower()
        if isinstance(statement, p.Assign):
            yield next(r.name.lower() for r in records(statement.target) if isinstance(r, e.Name))


def _called_names(body: Body) -> Iterator[str]:
    for statement in walk(body):
        if isinstance(statement, p.Call):
            yield statement.procedure.lower()


def _reached_procedures(names: set[str], called: Mapping[str, set[str]]) -> set[str]:
    """Procedures that are called, with those that these call."""
    found: set[str] = set()
    while names - found:
        name = (names - found).pop()
        found.add(name)
        names = names | called.get(name, set())
    return found
