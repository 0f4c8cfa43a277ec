"""The rules of the toy language: blocks are whole, names are declared, each once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from assistant.languages.checks.registry import Check, Needs, findings
from assistant.languages.checks.repeats import repeated
from assistant.program.diagnostics import Diagnostic, Rule, Span, has_errors
from assistant.program.geometry import BASE, FLANGE

from . import tables
from .tree import File, Line, Value

Wrong = tuple[Line, Rule, dict[str, Value]]
"""The line that breaks a rule, and what the rule's sentences are filled with."""


BUILT_IN = (Line("tool", (FLANGE,)), Line("frame", (BASE,)))
"""What need not be declared, as lines would declare it."""


def check(file: File) -> Iterator[Diagnostic]:
    lacks = Needs.ORDER | Needs.NAMES if has_errors(file.findings) else Needs.NOTHING
    return findings(CHECKS, file, lacks)


def _told(file: File, found: Iterable[Wrong]) -> Iterator[Diagnostic]:
    for line, rule, fields in found:
        if file.source is None:
            yield rule(**fields)
        else:
            yield file.source.finding(rule, line.span or Span(0, 0), **fields)


def blocks(file: File) -> Iterator[Diagnostic]:
    """Each begins and ends, and stands where it may."""
    return _told(file, _blocks(file))


def names(file: File) -> Iterator[Diagnostic]:
    """Each is declared, and declared once."""
    return _told(file, _names(file))


CHECKS = (Check(blocks, Needs.ORDER), Check(names, Needs.NAMES))


def _blocks(file: File) -> Iterator[Wrong]:
    blocks: list[Line] = []
    for line in file.lines:
        why = ""
        match line.word:
            case "procedure":
                yield from ((block, tables.NOT_ENDED, {}) for block in blocks)
                blocks = [line]
            case "else" if not blocks or blocks[-1].word != "if":
                why = "belongs to no `if`"
            case "else":
                blocks[-1] = line
            case "end" if not blocks:
                why = "belongs to no block"
            case "end":
                blocks.pop()
            case word if word in tables.INSIDE:
                why = "" if blocks else "stands in no procedure"
                if word in ("if", "while"):
                    why = "is in too many blocks" if len(blocks) > tables.MOST_BLOCKS else why
                    blocks.append(line)
        if why:
            yield line, tables.MISPLACED, {"word": line.word, "why": why}
    yield from ((block, tables.NOT_ENDED, {}) for block in blocks)


def _names(file: File) -> Iterator[Wrong]:
    declaring = [*BUILT_IN, *(line for line in file.lines if line.word in tables.DECLARES)]
    for line in repeated(declaring, _declared):
        kind, name = _declared(line)
        yield line, tables.TWICE, {"kind": kind, "name": name}
    declared = set(map(_declared, declaring))
    for line in file.lines:
        for kind, name in zip(tables.USES.get(line.word, ()), line.values, strict=False):
            if kind and (kind, name) not in declared:
                yield line, tables.UNDECLARED, {"kind": kind, "name": name}


def _declared(line: Line) -> tuple[str, Value]:
    """The kind and the name of what a line declares."""
    return tables.DECLARES[line.word], line.values[0]
