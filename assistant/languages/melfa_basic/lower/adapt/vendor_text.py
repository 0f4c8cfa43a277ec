"""Vendor text of another dialect: in the layout of this one, with the names that are written."""

from __future__ import annotations

from collections.abc import Iterator

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.convert.names import variables_of
from assistant.languages.melfa_basic.lower.names import Names
from assistant.languages.melfa_basic.reading.parser import statement as read_statement
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.tables.vocabulary import function, status
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.targets import targets_in
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Findings
from assistant.program.program import Procedure, Program, walk
from assistant.program.rewriting import head, records


def plain_verbatim(value: e.Verbatim, dialect: Dialect) -> e.Verbatim:
    """The text as this dialect spells it, if it has all of it."""
    origin = DIALECTS.get(value.language)
    line = None if origin is None else _assignment(value.text)
    if line is None or not isinstance(line.statement, s.Assign) or not _has_all(line, dialect):
        return value
    text = printer.expression(line.statement.value, dialect.upper)
    return e.Verbatim(dialect.name, text, effect=value.effect)


def _has_all(line: s.Line, dialect: Dialect) -> bool:
    """Whether the dialect has the functions, status variables and type marks of a line."""
    for record in records(line.statement):
        if isinstance(record, s.Variable):
            known = function(record.key) or status(record.key)
            if known is not None and dialect.level not in known.dialects:
                return False
        mark = record.suffix if isinstance(record, s.Variable | s.Number) else ""
        if mark not in ("", "$") and mark not in dialect.suffixes:
            return False
    return True


def check_names(program: Program, names: Names, findings: Findings) -> None:
    """Complains of vendor text whose variables and labels are written under other names."""
    for procedure in program.procedures:
        for node in walk(procedure.body):
            for text, line in _vendor_lines(node):
                renamed = sorted(set(_renamed(line, procedure, names)))
                if renamed:
                    with findings.at(node.span):
                        findings.append(rules.RENAMED_IN_TEXT(
                            text=text, names=", ".join(f"`{name}`" for name in renamed)
                        ))  # fmt: skip


def _vendor_lines(node: p.Statement) -> Iterator[tuple[str, s.Line]]:
    """Texts of a statement in any dialect, and what they read as."""
    for record in records(head(node)):
        line = None
        if isinstance(record, p.Opaque) and record.language in DIALECTS:
            line = read_statement(record.text)
        elif isinstance(record, e.Verbatim) and record.language in DIALECTS:
            line = _assignment(record.text)
        if line is not None:
            yield record.text, line


def _assignment(text: str) -> s.Line | None:
    """The line of an expression: an assignment to a number that is nobody's."""
    line = read_statement("M0=" + text)
    return None if line is None or line.comment else line


def _renamed(line: s.Line, procedure: Procedure, names: Names) -> Iterator[str]:
    owner = procedure.name.lower()
    for name in variables_of([line]):
        key = name.lower()
        tables = names.targets, names.joints, names.tools, names.frames
        short = (
            names.variables.get((owner, key))
            or names.variables.get(("", key))
            or names.loops.get((owner, key))
            or next((table[key] for table in tables if key in table), None)
        )
        if short is not None and short != name.upper():
            yield name
    for target in targets_in([line]):
        if isinstance(target.place, str):
            key = target.place.lstrip("*").lower()
            short = names.labels.get((owner, key)) or names.procedures.get(key)
            if short is not None and short != key.upper():
                yield target.place
