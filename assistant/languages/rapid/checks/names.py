"""Rules of names and strings: declared twice, too long, taken by the language."""

from __future__ import annotations

import math
from itertools import chain
from typing import Any, Final

from assistant.base.diagnostics import Severity
from assistant.languages.checks.names import repeated
from assistant.languages.checks.registry import Found
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks import plain_rules
from assistant.languages.rapid.checks.module_view import (
    Declared,
    RuleContext,
    declaration,
    parameters,
)
from assistant.languages.rapid.tables.words import LONGEST_NAME, LONGEST_STRING, SPEEDS, ZONES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number

LONGEST_PLAIN_NUMBER: Final = 24
"""Characters of a number without an exponent that any type holds."""
LARGEST_NUM: Final = 3.40282347e38
"""A `num` is an IEEE 754 number of 32 bits, a `dnum` one of 64 bits (RAPID manual 3HAC050917)."""
DECLARING_NODES: Final[tuple[Any, ...]] = (s.Data, s.Routine, s.Record, s.Alias, s.ParameterNode)


def module_names(look: RuleContext) -> Found:
    """A task has one `main`, and one module of a name."""
    before = list(look.before)
    if any(other.name.lower() == look.module.name.lower() for other in before):
        yield look.finding(plain_rules.SAME_MODULE, look.module, name=look.module.name)
    elif (main := look.task.main(look.module)) is not None:
        first = next((other for other in before if look.task.main(other) is not None), None)
        if first is not None:
            yield look.finding(plain_rules.SECOND_MAIN, main, other=first.name)
    main = look.task.main(look.module)
    if main is not None and main.parameters:
        words = ", ".join(f"`{one.name}`" for one in parameters(main))
        yield look.finding(plain_rules.MAIN_TAKES, main, parameters=words)
    own = look.find(look.module.name)
    if own is not None and own.module is look.module:
        what = "routine" if isinstance(own.node, s.Routine) else "data"
        yield look.finding(plain_rules.MODULE_NAME, look.module, what=what, name=own.name)


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
    """What a name is told apart by; nothing of rows, which have no name of their own here."""
    return declared.name.lower() or None


def name_spelling(look: RuleContext) -> Found:
    """No name is longer than 32 characters, and predefined speeds and zones stay as they are."""
    yield from _check_name(look, look.module, look.module.name)
    for declared in chain.from_iterable(map(look.all, DECLARING_NODES)):
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
        if len(node.text) > LONGEST_PLAIN_NUMBER or "e" in node.text.lower():
            number = literal_number(node)
            if number is not None and math.isinf(number):
                yield look.finding(
                    rules.LARGE_NUMBER, node, number=short_number(node.text), type="dnum"
                )
    for data in look.all(s.Data):
        number = literal_number(data.value) if data.type.lower() == "num" and data.value else None
        if number is not None and LARGEST_NUM < abs(number) < math.inf:
            yield look.finding(rules.LARGE_NUMBER, data, number=f"{number:g}", type="num")


def short_number(text: str) -> str:
    """A number as it can stand in a message."""
    return text if len(text) <= LONGEST_PLAIN_NUMBER else text[: LONGEST_PLAIN_NUMBER - 1] + "…"


def _check_name(look: RuleContext, node: s.Node, name: str) -> Found:
    if len(name) > LONGEST_NAME:
        yield look.finding(rules.LONG_NAME, node, name=name, length=len(name))
    taken = name.lower() in SPEEDS or name.lower() in ZONES
    if isinstance(node, s.Data | s.Routine) and taken:
        yield look.finding(rules.RESERVED_NAME, node, name=name)
