"""Where a call that is taken out of its statement, or copied arguments, would say another thing.

RAPID evaluates from left to right, and an inout argument is the variable itself. A call that
stands before its statement runs before what is read to the left of it, and a copied argument
does not see what the procedure does to the variable by its own name.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure
from assistant.program.rewriting import records


def altered(procedures: Sequence[Procedure]) -> dict[str, frozenset[str]]:
    """Names, in lower case, of what each procedure changes outside of itself, also by others."""
    by_name = {q.name.lower(): q for q in procedures}
    own = {key: _own(q, by_name) for key, q in by_name.items()}
    calls = {key: {c for c in _called(q) if c in own} for key, q in by_name.items()}
    changed = True
    while changed:
        changed = False
        for key, callees in calls.items():
            more = own[key].union(*(own[c] for c in callees))
            changed = changed or more != own[key]
            own[key] = more
    return own


def read_before(statement: Any, alters: Mapping[str, frozenset[str]]) -> Iterator[tuple[str, str]]:
    """Variables that a statement reads before a function changes them: their names, and its.

    statement: one without the bodies that it holds. alters: of the functions that are taken
    out of it, in lower case.
    """
    pending: list[str] = []

    def walk(value: Any, read: bool = True) -> Iterator[tuple[str, str]]:
        match value:
            case e.Name(name):
                if read:
                    pending.append(name)
            case e.Apply(function, arguments) if function.lower() in alters:
                mark = len(pending)
                yield from walk(arguments)
                del pending[mark:]
                names = alters[function.lower()]
                yield from ((x, function) for x in pending if x.lower() in names)
            case e.Index(inner, indices):
                yield from walk(indices)
                yield from walk(inner, read)
            case e.Member(inner):
                yield from walk(inner, read)
            case p.Assign(target, given):
                yield from walk(target, read=False)
                yield from walk(given)
            case tuple():
                for item in value:
                    yield from walk(item)
            case _ if is_dataclass(value):
                for part in fields(value):
                    yield from walk(getattr(value, part.name))

    yield from walk(statement)


def shared(
    call: p.Call, callee: Procedure, mentions: Mapping[str, frozenset[str]]
) -> Iterator[str]:
    """Variables that a call hands over to be changed and that it changes in another way too.

    mentions: what each procedure changes outside of itself, as `altered` tells.
    """
    given = list(zip(callee.parameters, call.arguments, strict=False))
    handed = [_name(value) for q, value in given if q.mode == "inout"]
    for at, name in enumerate(handed):
        if name and (name in mentions[callee.name.lower()] or name in handed[:at]):
            yield name
    changed = {*handed, *mentions[callee.name.lower()]}
    for q, value in given:
        if q.mode == "inout" and isinstance(value, e.Index):
            inside = {r.name.lower() for r in records(value.indices) if isinstance(r, e.Name)}
            yield from sorted(inside & changed)


def _own(procedure: Procedure, by_name: Mapping[str, Procedure]) -> frozenset[str]:
    names = set()
    for record in records(procedure.body):
        match record:
            case p.Assign(target):
                names.add(_name(target))
            case p.Call(callee, arguments) if callee.lower() in by_name:
                given = zip(by_name[callee.lower()].parameters, arguments, strict=False)
                names |= {_name(value) for q, value in given if q.mode == "inout"}
    local = {x.lower() for x in procedure.variables}
    local |= {q.name.lower() for q in procedure.parameters}
    return frozenset(names - local - {""})


def _called(procedure: Procedure) -> Iterator[str]:
    for record in records(procedure.body):
        match record:
            case p.Call(name) | e.Apply(name):
                yield name.lower()


def _name(value: Any) -> str:
    """The variable that a place belongs to, in lower case; empty for other expressions."""
    while isinstance(value, e.Index | e.Member):
        value = value.value
    return value.name.lower() if isinstance(value, e.Name) else ""
