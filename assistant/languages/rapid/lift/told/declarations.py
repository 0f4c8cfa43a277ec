"""Declarations that stay as their text, and that another language need not be told.

Data that have no value of their own (a socket, a file) say nothing alone: what is done with them
is told by itself. Data of any other type are left out where nothing speaks of them, and so are
targets with more external axes than an arm of another controller has, and tools whose tip is where
none can be.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Set
from dataclasses import replace
from typing import Any, Final, TypeVar

from assistant.base.diagnostics import Declared, Findings, ProgramTable
from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.predefined import is_handle
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import names_in, texts_in
from assistant.program.geometry import JointTarget, Target, Tool
from assistant.program.program import Declaration, Procedure, Program, walk
from assistant.program.rewriting import records, with_vendor_statements_replaced
from assistant.program.vendor_statements import effect_of

T = TypeVar("T")

FARTHEST_TIP: Final = 1e6
"""mm from the flange; no tool is that long, and other controllers refuse the number."""
MOST_EXTERNAL_AXES: Final = 2
"""External axes at most of a target in the other languages here."""


def with_needed_declarations(program: Program, findings: Findings) -> Program:
    """The program without declarations that say nothing, with a finding for each."""
    data = {d: item for d in program.declarations if (item := _declared_data(d)) is not None}
    if data:
        said = Counter(_used_names(program))
        idle = {
            d for d, item in data.items() if is_handle(item.type) or not _is_used(said, item, d)
        }
        for one in idle:
            _report_omission(findings, data[one], one)
        kept = tuple(d for d in program.declarations if d not in idle)
        program = replace(program, declarations=kept)

    program = _without_idle_targets(program, findings)

    if not any(map(_local_data, _vendor_texts(program))):
        return program
    procedures = tuple(_without_idle_locals(program, q, findings) for q in program.procedures)
    return replace(program, procedures=procedures)


def _without_idle_locals(program: Program, procedure: Procedure, findings: Findings) -> Procedure:
    """A procedure without declarations of handles, and of what nothing in it speaks of."""
    if not any(isinstance(node, p.Opaque) and _local_data(node) for node in walk(procedure.body)):
        return procedure
    said = Counter(_names_in_record((procedure.body, procedure.variables)))

    def needed(node: p.Opaque) -> Iterator[p.Statement]:
        item = _local_data(node)
        if item is None or not (is_handle(item.type) or not _is_used(said, item, node)):
            yield node
        else:
            _report_omission(findings, item, node)

    (made,) = with_vendor_statements_replaced(
        replace(program, procedures=(procedure,)), needed
    ).procedures
    return made


def _without_idle_targets(program: Program, findings: Findings) -> Program:
    """The program without such targets and tools that nothing speaks of."""
    idle: dict[ProgramTable, set[str]] = {
        "targets": {n for n, one in program.targets.items() if _has_too_many_axes(one)},
        "joint_targets": {n for n, one in program.joint_targets.items() if _has_too_many_axes(one)},
        "tools": {n for n, one in program.tools.items() if _is_out_of_reach(one)},
        "variables": {n for n, one in program.variables.items() if _has_too_many_axes(one.initial)},
    }
    if not any(idle.values()):
        return program
    parts = (program.procedures, tuple(program.variables.values()))
    said = texts_in(parts) | {name.lower() for name in names_in(parts)}
    for one in program.declarations:
        said |= effect_of(one).names
    for table, names in idle.items():
        names -= {name for name in names if name.lower() in said}
        for name in sorted(names):
            findings.append(rules.NOT_NEEDED(name=name, about=Declared(name, table)))
    return replace(
        program,
        targets=_without_names(program.targets, idle["targets"]),
        joint_targets=_without_names(program.joint_targets, idle["joint_targets"]),
        tools=_without_names(program.tools, idle["tools"]),
        variables=_without_names(program.variables, idle["variables"]),
    )


def _without_names(table: Mapping[str, T], names: Set[str]) -> dict[str, T]:
    return {name: one for name, one in table.items() if name not in names}


def _is_out_of_reach(tool: Tool) -> bool:
    """Whether the tip of a tool is where none can be, as after a calibration that went wrong."""
    return not all(abs(value) < FARTHEST_TIP for value in tool.tip.position)


def _has_too_many_axes(value: Target | JointTarget | e.Expression | None) -> bool:
    match value:
        case e.TargetValue(target) | e.JointValue(target):
            return _has_too_many_axes(target)
        case Target() | JointTarget():
            return any(place == place for place in value.external[MOST_EXTERNAL_AXES:])
    return False


def _report_omission(findings: Findings, item: s.Data, node: Declaration | p.Opaque) -> None:
    with findings.at(node.span):
        findings.append(rules.NOT_NEEDED(name=item.name))


def _declared_data(declaration: Declaration) -> s.Data | None:
    if declaration.language != verbatim.LANGUAGE:
        return None
    match verbatim.understood(verbatim.items, declaration.text):
        case (s.Data() as item,):
            return item
    return None


def _vendor_texts(program: Program) -> Iterator[p.Opaque]:
    return (node for node in program.statements() if isinstance(node, p.Opaque))


def _local_data(node: p.Opaque) -> s.Data | None:
    """The data that a statement declares."""
    if node.language != verbatim.LANGUAGE:
        return None
    match verbatim.understood(verbatim.statements, node.text):
        case (s.Data() as item,):
            return item
    return None


def _used_names(program: Program) -> Iterator[str]:
    """Names in lower case that the program uses, also in text that is kept."""
    yield from _names_in_record((program.procedures, program.declarations, program.variables))


def _names_in_record(value: Any) -> Iterator[str]:
    for part in records(value):
        match part:
            case e.Name(name):
                yield name.lower()
            case p.Opaque() | e.Verbatim() | Declaration():
                yield from effect_of(part).names
            case p.Motion(tool=tool, frame=frame):
                yield from (tool.lower(), frame.lower())


def _is_used(said: Counter[str], item: s.Data, declaration: Declaration | p.Opaque) -> bool:
    """Whether anything but its own declaration speaks of some data."""
    low = item.name.lower()
    return said[low] > (low in effect_of(declaration).names)
