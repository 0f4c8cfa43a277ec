"""Rules of declarations: names, storage, initial values, and whether anything uses them.

A name is declared twice, too long or reserved; a constant is assigned to; an initial value is no
literal; storage is where it may not be; nothing uses a declaration, or nothing declares a name.

A module that people wrote may use data and signals of the controller or of other modules, so
undeclared names are reported in compiled modules only: those have everything in them, their signals
in the header.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import fields
from itertools import chain
from typing import Any, Final

import numpy as np

from assistant.base.diagnostics import Rule, Severity
from assistant.languages.checks.names import NameSet, repeated
from assistant.languages.checks.registry import Found, Listing
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks.motions import MOVE_WORDS
from assistant.languages.rapid.checks.rule_context import (
    Declared,
    RuleContext,
    Scope,
    Task,
    declaration,
    parameters,
    scoped_nodes_of,
)
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.constants import (
    LONGEST_NAME,
    LONGEST_STRING,
    MOST_DIMENSIONS,
    SPEEDS,
    ZONES,
)
from assistant.languages.rapid.tables.equivalents import STATEMENT_ROWS
from assistant.languages.rapid.tables.predefined import INSTRUCTIONS, OPTION_ROUTINES, taken_names
from assistant.languages.rapid.tables.signals import hand_of
from assistant.languages.rapid.text.header import module_header
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number, literal_values
from assistant.languages.rapid.tree.walk import nodes, root
from assistant.languages.records import shape

_LONGEST_PLAIN_NUMBER: Final = 24
"""Characters of a number without an exponent that any type holds."""
_LARGEST_NUM: Final = 3.40282347e38
"""A `num` is an IEEE 754 number of 32 bits, a `dnum` one of 64 bits (RAPID manual 3HAC050917)."""
_DECLARING_NODES: Final[tuple[Any, ...]] = (s.Data, s.Routine, s.Record, s.Alias, s.ParameterNode)


def module_names(look: RuleContext) -> Found:
    """A task has one `main`, and one module of a name."""
    before = list(look.before)
    if any(other.name.lower() == look.module.name.lower() for other in before):
        yield look.finding(rules.SAME_MODULE, look.module, name=look.module.name)
    # At most one of two modules with one name is loaded: two `main` need no finding.
    elif (main := look.task.main(look.module)) is not None:
        first = next((other for other in before if look.task.main(other) is not None), None)
        if first is not None:
            yield look.finding(rules.SECOND_MAIN, main, other=first.name)
    main = look.task.main(look.module)
    if main is not None and main.parameters:
        words = ", ".join(f"`{one.name}`" for one in parameters(main))
        yield look.finding(rules.MAIN_TAKES, main, parameters=words)
    own = look.find(look.module.name)
    if own is not None and own.module is look.module:
        what = "routine" if isinstance(own.node, s.Routine) else "data"
        yield look.finding(rules.MODULE_NAME, look.module, what=what, name=own.name)


def duplicate_names(look: RuleContext) -> Found:
    """Names of a module that it declares again, or that another module declares as well.

    Modules that cannot all be in one task, as two have a `main` or the same name, are not
    compared: they are several programs, or states of one, and which belong together nobody says.
    """
    own: set[str] = set()
    earlier = set() if look.task.mixed else {id(other) for other in look.before}
    before: dict[str, bool] = {}
    for item in look.module.items:
        declared = declaration(item, look.module)
        if declared is None or isinstance(item, s.TargetRunNode):  # rows have names of their own
            continue
        name = declared.name.lower()
        if name not in before:
            before[name] = any(id(one.module) in earlier for one in look.task.shared.all(name))
        here = name in own
        if here or (before[name] and not declared.local):
            # Modules that people wrote may come with others that are never loaded together.
            sure = here or look.compiled
            severity = Severity.ERROR if sure else Severity.WARNING
            yield look.finding(rules.DUPLICATE, item, severity=severity, name=declared.name)
        own.add(name)
    for routine in look.routines:
        inner = map(declaration, chain(parameters(routine), routine.body))
        for declared in repeated([one for one in inner if one], _name_key):
            yield look.finding(rules.DUPLICATE, declared.node, name=declared.name)
    for record in look.all(s.Record):
        names = [name.lower() for _, name in record.components]
        for name in dict.fromkeys(repeated(names, str)):
            yield look.finding(rules.DUPLICATE, record, name=name)


def _name_key(declared: Declared) -> str | None:
    """Return the key that identifies a declared name; None for runs of rows, which have no name
    here.
    """
    return declared.name.lower() or None


def name_spelling(look: RuleContext) -> Found:
    """No name is longer than 32 characters, and predefined speeds and zones stay as they are."""
    yield from _check_name(look, look.module, look.module.name)
    for declared in chain.from_iterable(map(look.all, _DECLARING_NODES)):
        yield from _check_name(look, declared, declared.name)
    for record in look.all(s.Record):
        for _, name in record.components:
            yield from _check_name(look, record, name)
    for loop in look.all(s.ForLoop):
        yield from _check_name(look, loop, loop.variable)
    for mark in look.all(s.LabelMark):
        yield from _check_name(look, mark, mark.name)


def string_lengths(look: RuleContext) -> Found:
    """No string is longer than 80 characters."""
    for node in look.all(s.StringLiteral):
        if len(node.value) > LONGEST_STRING:
            yield look.finding(rules.LONG_STRING, node, length=len(node.value))


def number_sizes(look: RuleContext) -> Found:
    """No number is larger than a `dnum` holds, nor the first value of a `num` than that one."""
    for node in look.all(s.NumberLiteral):
        # Short numbers without an exponent fit any type, so that long tables need no conversion.
        if len(node.text) > _LONGEST_PLAIN_NUMBER or "e" in node.text.lower():
            number = literal_number(node)
            if number is not None and math.isinf(number):
                yield look.finding(
                    rules.LARGE_NUMBER, node, number=_short_number(node.text), type="dnum"
                )
    for data in look.all(s.Data):
        number = literal_number(data.value) if data.type.lower() == "num" and data.value else None
        if number is not None and _LARGEST_NUM < abs(number) < math.inf:
            yield look.finding(rules.LARGE_NUMBER, data, number=f"{number:g}", type="num")


def _short_number(text: str) -> str:
    """Shorten a number for use in a message."""
    return text if len(text) <= _LONGEST_PLAIN_NUMBER else text[: _LONGEST_PLAIN_NUMBER - 1] + "…"


def _check_name(look: RuleContext, node: s.Node, name: str) -> Found:
    if len(name) > LONGEST_NAME:
        yield look.finding(rules.LONG_NAME, node, name=name, length=len(name))
    taken = name.lower() in SPEEDS or name.lower() in ZONES
    if isinstance(node, s.Data | s.Routine) and taken:
        yield look.finding(rules.RESERVED_NAME, node, name=name)


_DECLARED_AS: Final = {
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
        # Declarations in the wrong place have a finding of their own.
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
                if kind in _DECLARED_AS:
                    what = f"`{part.name}`, {_DECLARED_AS[kind]}"
            if what:
                yield look.finding(rules.NOT_CONSTANT, node, name=node.name, what=what)
                # One finding for each declaration.
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
    """Return the kind of declaration of a name, empty if it is uncertain, as for error numbers."""
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
    """Return the `id` of every node directly in the module or in the body of a routine."""
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
    """Report a CONNECT to anything but a trap, and an alias of another alias."""
    for connect in look.all(s.Connect):
        found = look.find(connect.trap)
        if found is not None and found.kind != "TRAP":
            yield look.finding(rules.NO_TRAP, connect, name=connect.trap)
    for alias in look.all(s.Alias):
        of = look.find(alias.type)
        if of is not None and of.kind == "ALIAS":
            yield look.finding(rules.ALIAS_OF_ALIAS, alias, name=alias.name, of=alias.type)


_UNTRANSLATED: Final = (
    (INSTRUCTIONS | OPTION_ROUTINES) - STATEMENT_ROWS.written - {"tpwrite"} - MOVE_WORDS
)
"""Instructions that the pseudo-program has no word for: their data may be of other modules."""
_MOTION_ARGUMENTS: Final = 3
"""Number of last arguments of a move with separate rules: speed, zone and tool."""


def undeclared_names(look: RuleContext) -> Found:
    """The first use of each name that nothing declares; none in a module that people wrote."""
    header = module_header(look.module)
    if not (header.program or header.unit):
        return
    signals = look.task.once(_header_signals)
    seen: set[str] = set()
    for item in look.module.items:
        own = frozenset(look.frame(item).names) if isinstance(item, s.Routine) else frozenset()
        for used in _used_names(item, own):
            low = used.name.lower()
            if low in seen or low in taken_names() or low in signals or hand_of(low):
                continue
            seen.add(low)
            if look.find(low) is None:
                yield look.finding(rules.UNDECLARED, used, name=used.name)


def _header_signals(task: Task) -> set[str]:
    """Signals that the headers of a task's modules name, and the names they are written as."""
    found: set[str] = set()
    for module in task.modules:
        header = module_header(module)
        signals = {name.lower() for name in header.signals}
        found |= signals
        found |= {n for n, original in header.names.items() if original.lower() in signals}
    return found


def _used_names(node: Any, own: frozenset[str]) -> Iterator[s.NameRef]:
    """Names of values in a tree that are not those of its routine or of loops around them."""
    match node:
        case tuple():
            for item in node:
                yield from _used_names(item, own)
        case s.NameRef(name):
            if name.lower() not in own:
                yield node
        case s.ForLoop(variable, first, last, step, body):
            yield from _used_names((first, last, step), own)
            yield from _used_names(body, own | {variable.lower()})
        case s.ProcedureCall(str(name), arguments) if name.lower() in MOVE_WORDS:
            plain = tuple(a for a in arguments if isinstance(a, s.Positional))
            # Speed, zone and tool have rules of their own.
            yield from _used_names(plain[:-_MOTION_ARGUMENTS], own)
        case s.ProcedureCall(str(name)) if name.lower() in _UNTRANSLATED:
            pass
        case s.Option(name) if name.lower() in ("tool", "wobj"):
            pass
        case s.Node():
            for f in fields(node):
                yield from _used_names(getattr(node, f.name), own)


_STRING_WORD: Final = re.compile(r"[^\W\d]\w*")
_SHORTEST_BEGINNING: Final = 3
"""Letters of a string that count as the begin of a name."""


def unused_declarations(look: RuleContext) -> Found:
    """LOCAL items that nothing uses, and data of routines; global ones in a task with a `main`.

    One finding for all data and one for all routines of a module, at the first of them. What is
    global may be started by hand or by an event if it is a PROC without parameters, and PERS
    data may be shared with other tasks: those are never unused. Nor is what system modules
    declare, which serve many programs.
    """
    used = look.task.once(used_names)
    data: Listing[s.Node] = Listing()
    routines: Listing[s.Node] = Listing()
    system = "SYSMODULE" in look.module.attributes or look.file in look.task.common
    open_to_all = system or not look.task.has_main
    for item in look.module.items:
        match item:
            case s.TargetRunNode(scope, run) if scope == "LOCAL" or not open_to_all:
                data.add_rows(item, np.flatnonzero(~used.among(run.names)), run.names.name)
            case s.Data(scope, storage, _, name):
                kept = scope != "LOCAL" and (open_to_all or storage == "PERS")
                if not kept and name.lower() not in used:
                    data.add(item, name)
            case s.Routine(kind, local, name):
                started = not local and (open_to_all or (kind == "PROC" and not item.parameters))
                if not started and name.lower() not in used:
                    routines.add(item, name)
    yield from _listing_finding(look, rules.UNUSED_DATA, data)
    yield from _listing_finding(look, rules.UNUSED_ROUTINE, routines)
    for routine in look.routines:
        yield from _unused_inner_data(look, routine)


def _unused_inner_data(look: RuleContext, routine: s.Routine) -> Found:
    declared = [item for item in routine.body if isinstance(item, s.Data)]
    if not declared:
        return
    used = _mentioned_names(nodes((routine.body, *(h.body for h in routine.handlers))))
    idle: Listing[s.Node] = Listing()
    for item in declared:
        if item.name.lower() not in used:
            idle.add(item, item.name)
    yield from _listing_finding(look, rules.UNUSED_DATA, idle)


def _listing_finding(look: RuleContext, rule: Rule, found: Listing[s.Node]) -> Found:
    if found.first is not None:
        node, row = found.first
        yield look.finding(rule, node, row=row, **found.words)


def used_names(task: Task) -> NameSet:
    """Return the names that a task mentions anywhere."""
    return _mentioned_names(nodes(task.modules))


def _mentioned_names(places: Iterable[s.Node]) -> NameSet:
    """Names that some nodes mention, in lower case.

    A word in a string counts: routines are called and data are found by name. Where a name is
    put together while the program runs, whatever begins like it counts as well.
    """
    names = NameSet()
    for node in places:
        match node:
            case s.NameRef(name) | s.FunctionCall(name) | s.ProcedureCall(str(name)):
                names.words.add(name.lower())
            case s.Connect(trap=trap):
                names.words.add(trap.lower())
            case s.StringLiteral(value):
                words = [word.lower() for word in _STRING_WORD.findall(value)]
                names.words.update(words)
                # A name may be put together from this text and something else.
                names.beginnings.update(word for word in words if len(word) >= _SHORTEST_BEGINNING)
            case s.MoveRunNode(run):
                names.columns += [run.names, run.vias]
                for m in run.motions.table:
                    names.words.update(w.lower() for w in (m.speed, m.zone, m.tool, m.frame))
    return names
