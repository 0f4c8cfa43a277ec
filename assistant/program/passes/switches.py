"""Choices among values, for languages whose cases are single numbers, or do not nest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import reduce
from typing import Final, Literal

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import is_value, known_types
from assistant.program.analysis.uses import changed_by_others, declared
from assistant.program.passes.legalisation import Legalisation, Rewording
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier
from assistant.program.rewriting import (
    Body,
    is_steady,
    map_bodies,
    map_expressions,
    map_head,
    records,
)
from assistant.program.statement_index import records_in_procedures


def with_single_reads(job: Legalisation) -> Program:
    """Return the program in which a choice that becomes comparisons reads an input once for all of
    them.

    A value that others change may differ at the next comparison, and then no case would match: it
    is assigned to a variable first.
    """
    can = job.can.switches
    if can is None or not any(isinstance(node, p.Switch) for node in job.program.statements()):
        return job.program
    program = job.program
    changing, taken = changed_by_others(program), TakenNames(declared(program))

    def within(procedure: Procedure) -> Procedure:
        own: dict[str, Variable] = {}
        known = known_types(program, procedure)

        def body(statements: Body, depth: int) -> Body:
            return tuple(part for node in statements for part in said(node, depth))

        def said(node: p.Statement, depth: int) -> Iterator[p.Statement]:
            stays = isinstance(node, p.Switch) and _is_of_numbers(node)
            stays = stays and (can.nested or not depth)
            made: p.Statement = map_bodies(node, lambda inner: body(inner, depth + stays))
            if isinstance(made, p.Switch) and not stays:
                # One comparison reads the value once anyway.
                several = sum(len(case.values) for case in made.cases) > 1
                if several and not is_steady(made.subject, changing):
                    name = identifier(SELECTED, taken)
                    taken.add(name)
                    own[name] = Variable("number" if is_value(made.subject, known) else "text")
                    yield p.Assign(e.Name(name), made.subject, span=node.span)
                    made = replace(made, subject=e.Name(name))
            yield made

        made = body(procedure.body, 0)
        return replace(procedure, body=made, variables=procedure.variables | own)

    return replace(program, procedures=tuple(map(within, program.procedures)))


SELECTED: Final = "selected"
"""Name of a variable that holds what is chosen by."""


def plain_switch(r: Rewording, node: p.Switch) -> Iterator[p.Statement]:
    """A choice, or an `if` for one that the language has no words for.

    A case of no value is never chosen, and goes.
    """
    node = replace(node, cases=tuple(case for case in node.cases if case.values))
    can = r.job.can.switches
    if can is None or (_is_of_numbers(node) and (can.nested or not r.choices)):
        r.choices += 1
        yield r.inside(node)
        r.choices -= 1
        return
    if sum(len(case.values) for case in node.cases) > 1:
        _compare_once(node.subject, r.job)
    if node.cases:
        yield r.inside(_as_if(node))
    else:
        yield from r.body(node.otherwise)


def _compare_once(subject: e.Expression, job: Legalisation) -> None:
    """An error where a subject calls functions, which each comparison would do again."""
    for record in records(subject):
        if isinstance(record, e.Apply) and job.program.procedure(record.function):
            job.cannot(
                what=f"that `{record.function}` is called once for all cases here",
                cure="assign it to a variable, and choose by that",
            )


def _is_of_numbers(node: p.Switch) -> bool:
    """True if each case is one number."""
    return bool(node.cases) and all(
        len(case.values) == 1 and isinstance(case.values[0], e.Number) for case in node.cases
    )


Test = tuple[tuple[str, e.Expression], ...]
"""Comparisons of a value that must all hold: operators, and what it is compared with."""


def chosen(
    value: e.Expression,
    cases: Sequence[tuple[Sequence[Test], Body]],
    otherwise: Body,
) -> p.Switch | p.If:
    """Return a choice whose cases each require one of some tests.

    It is a `switch` if all of them are single values, else an `if` that computes the value anew.
    """
    # Single values can be the cases of a `switch`.
    if all(len(one) == 1 and one[0][0] == "=" for tests, _ in cases for one in tests):
        made = (p.Case(tuple(one[0][1] for one in tests), body) for tests, body in cases)
        return p.Switch(value, tuple(made), otherwise)

    def holds(operator: str, other: e.Expression) -> e.Expression:
        return e.Binary(operator, value, other)  # type: ignore[arg-type]

    def branch(tests: Sequence[Test], body: Body) -> p.Branch:
        every = [_joined("and", [holds(*part) for part in one]) for one in tests]
        return p.Branch(_joined("or", every), body)

    return p.If(tuple(branch(*case) for case in cases), otherwise)


def _joined(operator: Literal["and", "or"], parts: Sequence[e.Expression]) -> e.Expression:
    return reduce(lambda one, other: e.Binary(operator, one, other), parts)


def _as_if(node: p.Switch) -> p.If:
    def chosen(case: p.Case) -> e.Expression:
        return _joined("or", [e.Binary("=", node.subject, v) for v in case.values])

    branches = (p.Branch(chosen(case), case.body) for case in node.cases)
    return p.If(tuple(branches), node.otherwise)


def with_floors_read_once(job: Legalisation) -> Program:
    """The program in which `floor` of what others change has it in a variable.

    For a language that works `floor` out by naming its value several times. Statements that work
    their values out once get an assignment in front; in others it stays.
    """
    program = job.program
    if not any(one.function == "floor" for one in records_in_procedures(program, e.Apply)):
        return program
    changing, taken = changed_by_others(program), TakenNames(declared(program))

    def within(procedure: Procedure) -> Procedure:
        own: dict[str, Variable] = {}

        def body(statements: Body) -> Body:
            return tuple(part for node in statements for part in said(node))

        def said(node: p.Statement) -> Iterator[p.Statement]:
            read: list[p.Statement] = []

            def once(x: e.Expression) -> e.Expression:
                match x:
                    case e.Apply("floor", (inner,)) if not is_steady(inner, changing):
                        name = identifier(_READ, taken)
                        taken.add(name)
                        own[name] = Variable("number")
                        read.append(p.Assign(e.Name(name), inner, span=node.span))
                        return e.Apply("floor", (e.Name(name),))
                return x

            if isinstance(node, _ONCE):
                node = map_head(node, once)
            elif isinstance(node, p.If):
                first, *others = node.branches
                # Only the first condition of an `if` is always computed.
                first = replace(first, condition=map_expressions(first.condition, once))
                node = replace(node, branches=(first, *others))
            yield from read
            made: p.Statement = map_bodies(node, body)
            yield made

        made = body(procedure.body)
        return replace(procedure, body=made, variables=procedure.variables | own)

    return replace(program, procedures=tuple(map(within, program.procedures)))


_READ: Final = "value_read"
"""Name of a variable that holds a value read once."""
_ONCE: Final = (
    p.Assign | p.Call | p.SetSignal | p.Wait | p.Move | p.MoveCircular | p.MoveJoints | p.Switch
    | p.For | p.Return | p.Message | p.Send
)  # fmt: skip
"""Statements that work their values out once, before anything else."""
