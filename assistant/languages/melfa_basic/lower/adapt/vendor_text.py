"""Vendor text of another dialect: in the layout of this one, with the names that are written."""

from __future__ import annotations

from collections.abc import Iterator

from assistant.base.diagnostics import Findings
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.convert.names import is_program_name
from assistant.languages.melfa_basic.lower.names import Names
from assistant.languages.melfa_basic.reading.line import expression, statement
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.tables.vocabulary import function, status
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program
from assistant.program.rewriting import records
from assistant.program.statement_index import statements_with_vendor_text


def respelled_expression(value: e.Verbatim, dialect: Dialect) -> e.Verbatim:
    """The text as this dialect spells it, if it has all of it."""
    node = expression(value.text) if value.language in DIALECTS else None
    if node is None or not _dialect_has(node, dialect):
        return value
    return e.Verbatim(dialect.name, printer.expression(node, dialect.upper), effect=value.effect)


def _dialect_has(node: s.Expression, dialect: Dialect) -> bool:
    """Whether the dialect has the functions, status variables and type marks of an expression."""
    for record in records(node):
        if isinstance(record, s.Variable):
            known = function(record.key) or status(record.key)
            if known is not None and dialect.level not in known.dialects:
                return False
        mark = record.suffix if isinstance(record, s.Variable | s.Number) else ""
        if mark not in ("", "$") and mark not in dialect.suffixes:
            return False
    return True


def check_vendor_names(program: Program, names: Names, findings: Findings) -> None:
    """Complains of vendor text whose variables and labels are written under other names."""
    for procedure in program.procedures:
        for node, parts in statements_with_vendor_text(procedure):
            for kept in parts:
                if kept.language in DIALECTS:
                    read = statement if isinstance(kept, p.Opaque) else expression
                    renamed = sorted(set(_renamed_in_text(read(kept.text), procedure.name, names)))
                    if renamed:
                        with findings.at(node.span):
                            findings.append(rules.RENAMED_IN_TEXT(
                                text=kept.text, names=", ".join(f"`{name}`" for name in renamed)
                            ))  # fmt: skip


def _renamed_in_text(tree: s.Line | s.Expression | None, owner: str, names: Names) -> Iterator[str]:
    """Names in a text of a procedure, the owner, that are written otherwise elsewhere."""
    for node in records(tree):
        match node:
            case s.Variable(name=name) | s.FunctionParameter(name=name) | s.DefFunction(name=name):
                short = names.value(owner, name) if is_program_name(name) else None
            case s.Target(place=str() as name):
                short = names.label(owner, name.lstrip("*"))
            case _:
                continue
        if short is not None and short != name.lstrip("*").upper():
            yield name
