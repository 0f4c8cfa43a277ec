r"""Calls of routines by their names as texts: `%"name"%` and `CallByVar`, as a choice of calls."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from assistant.languages.rapid.lift.instructions import NameResolver
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import is_repeatable

MOST_CASES: Final = 80
"""Routines that one call may choose from."""
_END_PROGRAM: Final = p.Stop(end=True)


def choice_of_calls(
    node: p.Opaque, program: Program, meaning: NameResolver
) -> Iterator[p.Statement]:
    """What a call by a text is, nothing if that is not said."""
    if node.language != verbatim.LANGUAGE:
        return
    match verbatim.understood(verbatim.statements, node.text):
        case (s.ProcedureCall(name=str(word)) as call,) if word.lower() == "callbyvar":
            match called(call):
                case found if found is not None and not found.options:
                    yield from _choice_by_number(found.given, program, meaning)
        case (s.ProcedureCall(name=s.StringLiteral(text)) as call,):
            given = _plain_arguments(call, meaning)
            known = program.procedure(text.rpartition(":")[2])
            if known is not None and given is not None and len(given) == len(known.parameters):
                yield p.Call(known.name, given)
        case (s.ProcedureCall(name=name) as call,) if not isinstance(name, str):
            given = _plain_arguments(call, meaning)
            said = meaning.expression(name)
            if given is not None and is_repeatable(said) and not _names_module(said):
                yield from _procedure_choice(
                    said, given, _matching_procedures(said, program, len(given))
                )


def _names_module(text: e.Expression) -> bool:
    """Whether a text has a part that tells a module: its routines have no such names here."""
    match text:
        case e.Text(value):
            return ":" in value
        case e.Binary("+", left, right):
            return _names_module(left) or _names_module(right)
    return False


def _plain_arguments(
    call: s.ProcedureCall, meaning: NameResolver
) -> tuple[e.Expression, ...] | None:
    found = called(call)
    if found is None or found.options or None in found.given:
        return None
    return tuple(meaning.expression(one) for one in found.given if one is not None)


def _matching_procedures(text: e.Expression, program: Program, count: int) -> list[Procedure]:
    """Procedures that may be meant: those whose names begin and end as the text does."""
    begin = last = text
    while isinstance(begin, e.Binary) and begin.operator == "+":
        begin = begin.left
    while isinstance(last, e.Binary) and last.operator == "+":
        last = last.right
    start = begin.value.lower() if isinstance(begin, e.Text) else ""
    end = last.value.lower() if isinstance(last, e.Text) else ""
    return [
        q
        for q in program.procedures
        if q.name.lower().startswith(start)
        and q.name.lower().endswith(end)
        and q.result is None
        and len(q.parameters) == count
        and q.name != program.entry
        and not any(one.mode == "inout" for one in q.parameters)
    ]


def _procedure_choice(
    text: e.Expression, given: tuple[e.Expression, ...], procedures: Sequence[Procedure]
) -> Iterator[p.Statement]:
    if 0 < len(procedures) <= MOST_CASES:
        cases = (p.Case((e.Text(q.name),), (p.Call(q.name, given),)) for q in procedures)
        yield p.Switch(text, tuple(cases), (_END_PROGRAM,))


def _choice_by_number(
    given: Sequence[s.Expression | None], program: Program, meaning: NameResolver
) -> Iterator[p.Statement]:
    """`CallByVar "name", n`: the routine whose name ends with the number."""
    match given:
        case (s.StringLiteral(start), node) if node is not None:
            number = meaning.expression(node)
            cases = [
                p.Case((e.Number(int(end)),), (p.Call(q.name),))
                for q in program.procedures
                if not q.parameters
                and q.result is None
                and q.name.lower().startswith(start.lower())
                and (end := q.name[len(start) :]).isdecimal()
                and str(int(end)) == end
            ]
            if cases and is_repeatable(number):
                yield p.Switch(number, tuple(cases), (_END_PROGRAM,))
