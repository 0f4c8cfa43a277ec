"""The rules of the toy language: blocks are whole, names are declared, each once."""

from __future__ import annotations

from collections.abc import Iterator

from assistant.base.diagnostics import Diagnostic, Rule, has_errors
from assistant.base.source_text import finding_in
from assistant.languages.checks.names import repeated
from assistant.languages.checks.registry import Check, Needs, findings
from assistant.languages.line_blocks import ANY
from assistant.program.geometry import BASE, FLANGE

from . import tables
from .tree import File, Line, Value, blocks_of

BUILT_IN = (Line("tool", (FLANGE,)), Line("frame", (BASE,)))
"""What need not be declared, as lines would declare it."""


def check(file: File) -> Iterator[Diagnostic]:
    lacks = Needs.ORDER | Needs.NAMES if has_errors(file.findings) else Needs.NOTHING
    return findings(CHECKS, file, lacks)


def _told(file: File, line: Line, rule: Rule, **fields: Value) -> Diagnostic:
    return finding_in(file.source, rule, line.span, **fields)


def blocks(file: File) -> Iterator[Diagnostic]:
    """Each begins and ends, and stands where it may."""
    found = blocks_of(file.lines)
    wrong = {at: "belongs to no `if`" for block in found.all for at in block.parts[1:]}
    for misfit in found.wrong:
        wrong[misfit.at] = f"belongs to no {'block' if misfit.kind == ANY else '`if`'}"
    for block in found.all:
        if block.last is None:
            yield _told(file, file.lines[block.first], tables.NOT_ENDED)
        if block.depth > tables.MOST_BLOCKS + 1:
            wrong[block.first] = "is in too many blocks"
    for at, line in enumerate(file.lines):
        if line.word in tables.INSIDE and found.around[at] is None:
            wrong[at] = "stands in no procedure"
        if at in wrong:
            yield _told(file, line, tables.MISPLACED, word=line.word, why=wrong[at])


def names(file: File) -> Iterator[Diagnostic]:
    """Each is declared, and declared once."""
    declaring = [*BUILT_IN, *(line for line in file.lines if line.word in tables.DECLARES)]
    for line in repeated(declaring, _declared):
        kind, name = _declared(line)
        yield _told(file, line, tables.TWICE, kind=kind, name=name)
    declared = set(map(_declared, declaring))
    for line in file.lines:
        for kind, name in zip(tables.USES.get(line.word, ()), line.values, strict=False):
            if kind and (kind, name) not in declared:
                yield _told(file, line, tables.UNDECLARED, kind=kind, name=name)


def _declared(line: Line) -> tuple[str, Value]:
    """The kind and the name of what a line declares."""
    return tables.DECLARES[line.word], line.values[0]


CHECKS = (Check(blocks, Needs.ORDER), Check(names, Needs.NAMES))
