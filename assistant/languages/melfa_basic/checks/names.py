"""Rules of names: how they are written, what gives them a value, what nothing uses."""

from __future__ import annotations

import re
from collections.abc import Iterator

from assistant.languages.checks.names import firsts, repeated
from assistant.languages.checks.registry import Found
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import PROGRAM_NAME
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import declarations, program_name

# ---------------------------------------------------------------------------------- as written


def name_forms(look: Look) -> Found:
    """Names and labels are within the limits of the version."""
    most = look.dialect.longest
    long = (one for one in _named_things(look) if len(one[1]) > most and not _is_known(one[1]))
    for item, name, where in firsts(long, lambda one: one[1].upper()):
        yield look.at(rules.LONG_NAME, item, where, name=name, most=most)
    for line in look.lines if not look.dialect.label_underscores else ():
        if line.label is not None and "_" in line.label.upper().removeprefix("L_"):
            name, title = line.label, look.dialect.title
            yield look.at(rules.LABEL_FORM, line, f"*{name}", name=name, title=title)


def _named_things(look: Look) -> Iterator[tuple[s.Item, str, str]]:
    """Names with what they stand in, and the word there; those of tables are short enough."""
    for line in look.lines:
        if line.label is not None:
            yield line, line.label, f"*{line.label}"
    for line, use in look.uses:
        yield line, use.variable.name, use.variable.name
    for item in look.tree.items:
        if isinstance(item, s.Data):
            yield item, item.variable.name, item.variable.name


def _is_known(name: str) -> bool:
    return vocabulary.status(name) is not None or vocabulary.function(name) is not None


def program_name_form(look: Look) -> Found:
    """The name of the file is the name that the controller stores the program by."""
    path = look.source.path if look.source else None
    name = program_name(look.tree)
    if not name or not path or not path.lower().endswith((".prg", ".mb4", ".mb5", ".mb6")):
        return
    first = next((line for line in look.lines if line.statement or line.label), None)
    if first is None:
        return  # a list of positions
    what, number = "", 4130
    if len(name) > PROGRAM_NAME:
        what, number = f"it has {len(name)} characters", 4120
    elif bad := re.search(r"[^A-Za-z0-9]", name):
        what = f"`{bad[0]}` is no letter and no digit"
    if what:
        yield look.finding(rules.PROGRAM_NAME, None, name=name, what=what, number=number)


# --------------------------------------------------------------------------------- definitions


def declared_twice(look: Look) -> Found:
    """Variables that are declared twice."""
    for scope in look.scopes:
        lines = look.lines_of(scope)
        declared = [(line, one) for line in lines for one, _ in declarations(line.statement)]
        for line, variable in repeated(declared, lambda one: one[1].key):
            yield look.at(rules.DECLARED_TWICE, line, variable)
