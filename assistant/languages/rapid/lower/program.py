"""From the pseudo-program to the typed tree: one module a unit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from assistant.base.diagnostics import Refused
from assistant.languages.rapid import rules
from assistant.languages.rapid.lower.data import (
    controller_data_nodes,
    data_nodes,
    scope_of_paths,
    variable_node,
)
from assistant.languages.rapid.lower.modules import resident_units, with_own_targets
from assistant.languages.rapid.lower.motions import path_targets
from assistant.languages.rapid.lower.names import NAMES
from assistant.languages.rapid.lower.statements import BodyLowering
from assistant.languages.rapid.tables.words import TYPE_OF_VALUE
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.text.elsewhere import header_declaration
from assistant.languages.rapid.text.header import header_lines
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import gathered
from assistant.languages.scoped_names import Naming, spelt
from assistant.program import statements as p
from assistant.program.program import Parameter, Procedure, Program, walk


def build(program: Program, unit: str | None = None) -> s.File:
    """The tree of one unit of an adapted program; raises Refused for what RAPID cannot say."""
    names = NAMES.naming(program)
    here = [q for q in program.procedures if q.unit == unit]
    held = resident_units(program)
    there = (
        [header_declaration(one) for one in controller_data_nodes(program, names)]
        if unit is None
        else ()
    )
    head = header_lines(program, unit, names.changed, resident=unit in held, there=there)
    items: list[Any] = [s.CommentLine(x) for x in head]
    declared = _declared_items(program) if unit is None else []
    items += [i for i in declared if isinstance(i, s.Record | s.Alias)]
    if unit is None or unit in held:
        items += data_nodes(with_own_targets(program, unit, held), names)
    items += [i for i in declared if not isinstance(i, s.Record | s.Alias | s.Routine)]
    for procedure in here:
        items += _path_targets(procedure, names, scope_of_paths(program))
    items += [_routine_node(procedure, program, names) for procedure in here]
    items += [i for i in declared if isinstance(i, s.Routine)]
    return s.File((s.Module(module_name(program, unit), (), gathered(items)),))


def module_name(program: Program, unit: str | None = None) -> str:
    return NAMES.naming(program).get("modules", unit or program.name)


def _declared_items(program: Program) -> list[s.Item]:
    """What the declarations of a program say that only RAPID can say."""
    found: list[s.Item] = []
    for declaration in program.declarations:
        if declaration.language != verbatim.LANGUAGE:
            raise Refused(rules.OTHER_LANGUAGE(**verbatim.foreign(declaration)))
        found += verbatim.items(declaration.text)
    return found


def _path_targets(
    procedure: Procedure, names: Naming, scope: str
) -> Iterator[s.TargetRunNode | s.Data]:
    """Those of the paths that a procedure follows."""
    for statement in walk(procedure.body):
        if isinstance(statement, p.Follow):
            yield from path_targets(statement.path, names.rows[id(statement)], scope)


def _routine_node(procedure: Procedure, program: Program, names: Naming) -> s.Routine:
    inner = names.inner[procedure.name.lower()]
    statements, handlers = _without_handlers(procedure.body)
    body = BodyLowering(program, names, procedure)
    variables = [
        variable_node(spelt(inner, n), v, body.expressions) for n, v in procedure.variables.items()
    ]
    made = gathered([*variables, *body.statements(statements)])
    if body.findings:
        raise Refused(*body.findings)
    return s.Routine(
        "PROC" if procedure.result is None else "FUNC",
        procedure.local,
        names.get("procedures", procedure.name),
        made,
        "" if procedure.result is None else TYPE_OF_VALUE[procedure.result],
        tuple(_parameter_group(q, spelt(inner, q.name)) for q in procedure.parameters),
        handlers,
    )


def _parameter_group(parameter: Parameter, name: str) -> s.ParameterGroup:
    mode = "INOUT" if parameter.mode == "inout" else ""
    node = s.ParameterNode(mode, TYPE_OF_VALUE[parameter.type], name, parameter.dimensions)
    return s.ParameterGroup(False, (node,))


def _without_handlers(
    body: tuple[p.Statement, ...],
) -> tuple[tuple[p.Statement, ...], tuple[s.Handler, ...]]:
    """The statements of a body, and the error handlers that stand verbatim at its end."""
    found: list[s.Handler] = []
    for statement in reversed(body):
        if not isinstance(statement, p.Opaque) or statement.language != verbatim.LANGUAGE:
            break
        handlers = verbatim.error_handlers(statement.text)
        if handlers is None:
            break
        found[:0] = handlers
        body = body[:-1]
    return body, tuple(found)
