"""Declarations that stay as their text, and that another language need not be told.

Data that have no value of their own (a socket, a file) say nothing alone: what is done with them
is told by itself. Data of any other type are left out where nothing speaks of them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.predefined import is_handle
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Findings
from assistant.program.kept import effect_of
from assistant.program.program import Declaration, Program
from assistant.program.rewriting import exchanged, records


def with_needed_declarations(program: Program, findings: Findings) -> Program:
    """The program without declarations that say nothing, with a finding for each."""
    data = {d: item for d in program.declarations if (item := _data(d)) is not None}
    if data:
        said = Counter(_names(program))
        idle = {d for d, item in data.items() if is_handle(item.type) or not _said(said, item, d)}
        for one in idle:
            _tell(findings, data[one], one)
        kept = tuple(d for d in program.declarations if d not in idle)
        program = replace(program, declarations=kept)

    def needed(node: p.Opaque) -> Iterator[p.Statement]:
        item = _local(node)
        if item is None or not is_handle(item.type):
            yield node
        else:
            _tell(findings, item, node)

    return exchanged(program, needed) if any(map(_local, _texts(program))) else program


def _tell(findings: Findings, item: s.Data, node: Declaration | p.Opaque) -> None:
    with findings.at(node.span):
        findings.append(rules.NOT_NEEDED(name=item.name))


def _data(declaration: Declaration) -> s.Data | None:
    if declaration.language != verbatim.LANGUAGE:
        return None
    match verbatim.understood(verbatim.items, declaration.text):
        case (s.Data() as item,):
            return item
    return None


def _texts(program: Program) -> Iterator[p.Opaque]:
    return (node for node in program.statements() if isinstance(node, p.Opaque))


def _local(node: p.Opaque) -> s.Data | None:
    """The data that a statement declares."""
    if node.language != verbatim.LANGUAGE:
        return None
    match verbatim.understood(verbatim.statements, node.text):
        case (s.Data() as item,):
            return item
    return None


def _names(program: Program) -> Iterator[str]:
    """Names in lower case that the program uses, also in text that is kept."""
    for part in records((program.procedures, program.declarations, program.variables)):
        match part:
            case e.Name(name):
                yield name.lower()
            case p.Opaque() | e.Verbatim() | Declaration():
                yield from effect_of(part).names
            case p.Motion(tool=tool, frame=frame):
                yield from (tool.lower(), frame.lower())


def _said(said: Counter[str], item: s.Data, declaration: Declaration) -> bool:
    """Whether anything but its own declaration speaks of some data."""
    low = item.name.lower()
    return said[low] > (low in effect_of(declaration).names)
