"""Where a call that is taken out of its statement would say another thing.

RAPID evaluates from left to right. A call that stands before its statement runs before what is
read to the left of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from assistant.languages.melfa_basic.lower.writer import words
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import records


def base(place: Any) -> str:
    """The variable that a place belongs to, in lower case; empty for other expressions."""
    while isinstance(place, e.Index | e.Member):
        place = place.value
    return place.name.lower() if isinstance(place, e.Name) else ""


def altered(program: Program) -> dict[str, frozenset[str]]:
    """Variables of the program that each procedure, or one that it calls, changes by their names.

    All names in lower case. What a call lets a procedure change is not among them.
    """
    procedures = {q.name.lower(): q for q in program.procedures}
    own = {key: _changed(q, procedures) for key, q in procedures.items()}
    return along_calls(program, _of_program(program, own))


def mentioned(program: Program) -> dict[str, frozenset[str]]:
    """Variables of the program that each procedure, or one that it calls, names: lower case."""
    own = {q.name.lower(): _named(q) for q in program.procedures}
    return along_calls(program, _of_program(program, own))


def along_calls(program: Program, own: Mapping[str, frozenset[str]]) -> dict[str, frozenset[str]]:
    """What each procedure has, by lower-case name, with what those have that it calls."""
    found = dict(own)
    calls = {q.name.lower(): found.keys() & set(called(q)) for q in program.procedures}
    changed = True
    while changed:
        changed = False
        for key, callees in calls.items():
            more = found[key].union(*(found[c] for c in callees))
            changed = changed or more != found[key]
            found[key] = more
    return found


def _of_program(program: Program, names: Mapping[str, frozenset[str]]) -> dict[str, frozenset[str]]:
    shared = {name.lower() for name in program.variables}
    own = {q.name.lower(): locals_of(q) for q in program.procedures}
    return {key: (found - own[key]) & shared for key, found in names.items()}


def called(procedure: Procedure) -> Iterator[str]:
    """Procedures and functions that a body calls, in lower case."""
    for record in records(procedure.body):
        match record:
            case p.Call(name) | e.Apply(name):
                yield name.lower()


def locals_of(procedure: Procedure) -> frozenset[str]:
    """Parameters and variables of a procedure, in lower case."""
    names = (*procedure.variables, *(q.name for q in procedure.parameters))
    return frozenset(name.lower() for name in names)


def handed_over(procedure: Procedure, arguments: tuple[Any, ...]) -> Iterator[e.Expression]:
    """The places that a call lets a procedure change."""
    for parameter, value in zip(procedure.parameters, arguments, strict=False):
        if parameter.mode == "inout" and base(value):
            yield value


def read_before(
    statement: Any, functions: Mapping[str, Procedure], alters: Mapping[str, frozenset[str]]
) -> Iterator[tuple[str, str]]:
    """Variables that a statement reads before a function changes them: their names, and its.

    statement: one without the bodies that it holds. functions: that are taken out of it, by
    lower-case name. alters: what each changes outside of itself, as `altered` tells.
    """
    pending: list[str] = []

    def walk(value: Any, read: bool = True) -> Iterator[tuple[str, str]]:
        match value:
            case e.Name(name):
                if read:
                    pending.append(name)
            case p.Call(name, arguments) if name.lower() in functions:
                yield from given(functions[name.lower()], arguments)
            case e.Apply(function, arguments) if function.lower() in functions:
                callee = functions[function.lower()]
                mark = len(pending)
                yield from given(callee, arguments)
                del pending[mark:]
                names = alters[function.lower()] | set(map(base, handed_over(callee, arguments)))
                yield from ((x, function) for x in pending if x.lower() in names)
            case e.Index(inner, indices):
                yield from walk(indices)
                yield from walk(inner, read)
            case e.Member(inner):
                yield from walk(inner, read)
            case p.Assign(target, assigned):
                yield from walk(target, read=False)
                yield from walk(assigned)
            case tuple():
                for item in value:
                    yield from walk(item)
            case _ if is_dataclass(value):
                for part in fields(value):
                    yield from walk(getattr(value, part.name))

    def given(callee: Procedure, arguments: tuple[Any, ...]) -> Iterator[tuple[str, str]]:
        places = {id(place) for place in handed_over(callee, arguments)}
        for value in arguments:
            yield from walk(value, read=id(value) not in places)

    yield from walk(statement)


def _changed(procedure: Procedure, procedures: Mapping[str, Procedure]) -> frozenset[str]:
    names = set()
    for record in records(procedure.body):
        match record:
            case p.Assign(target):
                names.add(base(target))
            case p.For(variable):
                names.add(variable.lower())
            case p.Call(name, arguments) | e.Apply(name, arguments) if name.lower() in procedures:
                callee = procedures[name.lower()]
                names |= {base(place) for place in handed_over(callee, arguments)}
    return frozenset(names)


def _named(procedure: Procedure) -> frozenset[str]:
    names: set[str] = set()
    for record in records(procedure.body):
        match record:
            case e.Name(name):
                names.add(name.lower())
            case p.For(variable):
                names.add(variable.lower())
            case p.Opaque(_, text) | e.Verbatim(_, text):
                names.update(words(text))
    return frozenset(names)
