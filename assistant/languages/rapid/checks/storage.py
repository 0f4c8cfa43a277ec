"""Rules of data: what is assigned to, initial values, storage where it may not stand."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from assistant.languages.rapid.checks import plain_rules as rules
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.words import MOST_DIMENSIONS
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.rapid.tree.walk import blocks, nodes, root
from assistant.program.diagnostics import Diagnostic

Found = Iterator[Diagnostic]

WHAT: Final = {
    "VAR": "a variable",
    "PERS": "a persistent",
    "IN": "a parameter",
    "INOUT": "a parameter",
    "PROC": "a procedure",
    "FUNC": "a function",
    "TRAP": "a trap",
}


def assignments(look: Look) -> Found:
    """Constants and variables of FOR are read only."""
    for routine in look.routines:
        for body in (routine.body, *(h.body for h in routine.handlers)):
            yield from _assigned(look, routine, body, frozenset())


def _assigned(
    look: Look, routine: s.Routine, body: Sequence[s.StatementNode], loops: frozenset[str]
) -> Found:
    for statement in body:
        if isinstance(statement, s.Assignment):
            data = root(statement.target)
            name = "" if data is None else data.name
            if name.lower() in loops:
                yield look.finding(rules.ASSIGNED_LOOP, statement, name=name)
            elif name and _kind(look, name, routine) == "CONST":
                yield look.finding(rules.ASSIGNED_CONST, statement, name=name)
        own = {statement.variable.lower()} if isinstance(statement, s.ForLoop) else set()
        for block in blocks(statement):
            yield from _assigned(look, routine, block, loops | own)


def initial_values(look: Look) -> Found:
    """Initial values of VAR and CONST are constant expressions: literals and constants."""
    for node, routine in _data(look):
        if node.value is None:
            if node.storage == "CONST":
                yield look.finding(rules.NO_VALUE, node, name=node.name)
            continue
        if predefined.is_handle(node.type):
            yield look.finding(rules.HANDLE_VALUE, node, name=node.name, type=node.type)
        if node.storage == "PERS":
            continue
        for part in nodes(node.value):
            what = ""
            if isinstance(part, s.FunctionCall):
                what = f"the function `{part.name}`"
            elif isinstance(part, s.NameRef):
                kind = _kind(look, part.name, routine)
                if kind in WHAT:
                    what = f"`{part.name}`, {WHAT[kind]}"
            if what:
                yield look.finding(rules.NOT_CONSTANT, node, name=node.name, what=what)
                break


def _kind(look: Look, name: str, routine: s.Routine | None) -> str:
    """What declares a name, empty where that is not sure, as for the numbers of errors."""
    found = look.find(name, routine)
    if found is not None:
        return found.kind
    standard = predefined.data().get(name.lower())
    return standard.storage if standard is not None and standard.type != "errnum" else ""


def _data(look: Look) -> Iterator[tuple[s.Data, s.Routine | None]]:
    """Every plain declaration with the routine that it stands in."""
    for item in look.module.items:
        if isinstance(item, s.Data):
            yield item, None
        elif isinstance(item, s.Routine):
            for statement in item.body:
                if isinstance(statement, s.Data):
                    yield statement, item


def places(look: Look) -> Found:
    """Storage classes and scopes where they may not stand."""
    items = {id(item) for item in look.module.items}
    tops = {id(statement) for routine in look.routines for statement in routine.body}
    for node in look.all(s.Data):
        if id(node) in items:
            if node.scope == "TASK" and node.storage == "CONST":
                yield look.finding(rules.NO_PLACE, node, what="TASK", where="before CONST")
        elif node.storage == "PERS" or node.scope:
            what = "PERS" if node.storage == "PERS" else node.scope
            yield look.finding(rules.NO_PLACE, node, what=what, where="inside a routine")
        elif id(node) not in tops:
            yield look.finding(rules.NO_PLACE, node, what="a declaration", where="in a block")
        if node.type.lower() == "switch":
            yield look.finding(rules.NO_PLACE, node, what="a switch", where="among data")
    for routine in look.routines:
        for group in routine.parameters:
            for one in group.alternatives:
                if isinstance(one, s.ParameterNode) and one.type.lower() == "switch":
                    if not group.optional:
                        where = "among required parameters"
                        yield look.finding(rules.NO_PLACE, one, what="a switch", where=where)


def dimensions(look: Look) -> Found:
    for node in look.all(s.Data):
        if len(node.dimensions) > MOST_DIMENSIONS:
            what = f"has {len(node.dimensions)} dimensions"
            yield look.finding(rules.DIMENSIONS, node, name=node.name, what=what)
        for size in node.dimensions:
            number = literal_number(size)
            if number is not None and (number < 1 or number != int(number)):
                what = f"has a dimension of {number:g}"
                yield look.finding(rules.DIMENSIONS, node, name=node.name, what=what)


def connections(look: Look) -> Found:
    """What CONNECT names is a trap; an alias is not of another alias."""
    for connect in look.all(s.Connect):
        found = look.find(connect.trap)
        if found is not None and found.kind != "TRAP":
            yield look.finding(rules.NO_TRAP, connect, name=connect.trap)
    for alias in look.all(s.Alias):
        of = look.find(alias.type)
        if of is not None and of.kind == "ALIAS":
            yield look.finding(rules.ALIAS_OF_ALIAS, alias, name=alias.name, of=alias.type)
