"""Rules of names: how they are written, what gives them a value, what nothing uses."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks.file_view import Look, program_name
from assistant.languages.melfa_basic.checks.steps import row_span
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import PROGRAM_NAME
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.program.diagnostics import Diagnostic

Found = Iterator[Diagnostic]


# ---------------------------------------------------------------------------------- as written


def spelling(look: Look) -> Found:
    """Names and labels are within the limits of the version."""
    most = look.dialect.longest
    seen: set[str] = set()

    def long(name: str) -> bool:
        known = vocabulary.status(name) or vocabulary.function(name)
        if len(name) <= most or known is not None or name.upper() in seen:
            return False
        seen.add(name.upper())
        return True

    for line in look.lines:
        label = line.label
        if label is not None:
            if long(label):
                yield look.at(rules.LONG_NAME, line, f"*{label}", name=label, most=most)
            if not look.dialect.label_underscores and "_" in label.upper().removeprefix("L_"):
                title = look.dialect.title
                yield look.at(rules.LABEL_FORM, line, f"*{label}", name=label, title=title)
    for line, use in look.uses:
        name = use.variable.name
        if long(name):
            yield look.at(rules.LONG_NAME, line, name, name=name, most=most)
    for item in look.tree.items:
        if isinstance(item, s.Data):
            if long(item.variable.name):
                name = item.variable.name
                yield look.at(rules.LONG_NAME, item, name, name=name, most=most)
        elif isinstance(item, PositionRows | MoveRows) and len(item):
            numbers = item.numbers if isinstance(item, PositionRows) else item.end
            row = int(np.argmax(numbers))
            if long(name := f"{item.stem}{int(numbers[row])}"):
                where = row_span(look, item, row)
                yield look.finding(rules.LONG_NAME, where, name=name, most=most)


def program(look: Look) -> Found:
    """The name of the file is the name that the controller stores the program by."""
    path = look.tree.source.path if look.tree.source else None
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


def declarations(look: Look) -> Found:
    """Variables that are declared twice, and names that are words of the language."""
    for scope in look.scopes:
        seen: set[str] = set()
        for at in scope.entries:
            line = look.code[at]
            if not isinstance(line, s.Line):
                continue
            for variable in _declared(line.statement):
                if variable.key in seen:
                    yield look.at(rules.DECLARED_TWICE, line, variable, name=variable.name)
                seen.add(variable.key)


def _declared(statement: s.Statement | None) -> tuple[s.Variable, ...]:
    match statement:
        case s.DefNames(_, variables) | s.Dim(variables):
            return variables
        case s.Static(definition):
            return _declared(definition)
        case s.DefIo(variable) | s.Const(_, variable):
            return (variable,)
    return ()
