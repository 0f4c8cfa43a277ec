"""Rules of data: what is assigned to, initial values, storage where it may not stand."""

from __future__ import annotations

from typing import Final

from assistant.languages.checks.registry import Found
from assistant.languages.rapid.checks import plain_rules as rules
from assistant.languages.rapid.checks.kinds import Scope
from assistant.languages.rapid.checks.module_view import RuleContext
from assistant.languages.rapid.checks.places import scoped_nodes_of
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.words import MOST_DIMENSIONS
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number, literal_values
from assistant.languages.rapid.tree.walk import nodes, root
from assistant.languages.records import shape

DECLARED_AS: Final = {
    "VAR": "a variable",
    "PERS": "a persistent",
    "IN": "a parameter",
    "INOUT": "a parameter",
    "PROC": "a procedure",
    "FUNC": "a function",
    "TRAP": "a trap",
}


def read_only_data(look: RuleContext) -> Found:
    """Constants and variables of FOR are read only."""
    for node, scope in scoped_nodes_of(look, s.Assignment):
        data = root(node.target)
        kind = _declared_kind(scope, data.name) if data is not None else ""
        if data is not None and kind == "FOR":
            yield look.finding(rules.ASSIGNED_LOOP, node, name=data.name)
        elif data is not None and kind == "CONST":
            yield look.finding(rules.ASSIGNED_CONST, node, name=data.name)


def initial_values(look: RuleContext) -> Found:
    """Those of PERS are literals, those of VAR and CONST constant expressions."""
    for node, scope in scoped_nodes_of(look, s.Data):
        if node.storage == "PERS" and node.value is not None and not _is_literal(node.value):
            yield look.finding(rules.NOT_LITERAL, node, name=node.name)
        if id(node) not in look.once(_in_place):
            continue
        if node.value is None:
            if node.storage == "CONST":
                yield look.finding(rules.CONSTANT_WITHOUT_VALUE, node, name=node.name)
            continue
        if predefined.is_handle(node.type) and not _is_numbered(node):
            yield look.finding(rules.HANDLE_VALUE, node, name=node.name, type=node.type)
        if node.storage == "PERS":
            continue
        for part in nodes(node.value):
            what = ""
            if isinstance(part, s.FunctionCall):
                what = f"the function `{part.name}`"
            elif isinstance(part, s.NameRef):
                kind = _declared_kind(scope, part.name)
                if kind in DECLARED_AS:
                    what = f"`{part.name}`, {DECLARED_AS[kind]}"
            if what:
                yield look.finding(rules.NOT_CONSTANT, node, name=node.name, what=what)
                break


def _is_numbered(node: s.Data) -> bool:
    """True for a handle of a type that may have a number in brackets, or an array of those."""
    form = shape(literal_values(node.value))
    single = form == "n" if not node.dimensions else not form.replace("[n]", "")
    return single and node.type.lower() in predefined.NUMBERED


def _is_literal(value: s.Expression) -> bool:
    if isinstance(value, s.AggregateNode):
        return all(_is_literal(v) for v in value.items)
    return (
        isinstance(value, s.BoolLiteral | s.StringLiteral | s.Placeholder)
        or literal_number(value) is not None
    )


def _declared_kind(scope: Scope, name: str) -> str:
    """What declares a name, empty where that is not sure, as for the numbers of errors."""
    found = scope.find(name)
    if found is not None:
        return found.kind
    standard = predefined.data().get(name.lower())
    return standard.storage if standard is not None and standard.type != "errnum" else ""


def storage_places(look: RuleContext) -> Found:
    """Storage classes and scopes where they may not stand."""
    items = {id(item) for item in look.module.items}
    for node in look.all(s.Data):
        if id(node) in items:
            if node.scope == "TASK" and node.storage == "CONST":
                yield look.finding(rules.NO_PLACE, node, what="TASK", where="before CONST")
        elif node.storage == "PERS" or node.scope:
            what = "PERS" if node.storage == "PERS" else node.scope
            yield look.finding(rules.NO_PLACE, node, what=what, where="inside a routine")
        elif id(node) not in look.once(_in_place):
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


def _in_place(look: RuleContext) -> set[int]:
    """The `id` of everything that stands in the module itself or in the body of a routine."""
    bodies = (look.module.items, *(routine.body for routine in look.routines))
    return {id(node) for body in bodies for node in body}


def array_dimensions(look: RuleContext) -> Found:
    for node in look.all(s.Data):
        if len(node.dimensions) > MOST_DIMENSIONS:
            what = f"has {len(node.dimensions)} dimensions"
            yield look.finding(rules.DIMENSIONS, node, name=node.name, what=what)
        for size in node.dimensions:
            number = literal_number(size)
            if number is not None and (number < 1 or not float(number).is_integer()):
                what = f"has a dimension of {number:g}"
                yield look.finding(rules.DIMENSIONS, node, name=node.name, what=what)


def traps_and_aliases(look: RuleContext) -> Found:
    """What CONNECT names is a trap; an alias is not of another alias."""
    for connect in look.all(s.Connect):
        found = look.find(connect.trap)
        if found is not None and found.kind != "TRAP":
            yield look.finding(rules.NO_TRAP, connect, name=connect.trap)
    for alias in look.all(s.Alias):
        of = look.find(alias.type)
        if of is not None and of.kind == "ALIAS":
            yield look.finding(rules.ALIAS_OF_ALIAS, alias, name=alias.name, of=alias.type)
