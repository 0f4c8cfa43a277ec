"""The rules of the toy language: blocks are whole, names are declared, each once."""

from __future__ import annotations

from collections.abc import Iterator

from assistant.program.diagnostics import Diagnostic, Rule, Span
from assistant.program.geometry import BASE, FLANGE

from . import tables
from .tree import File, Line, Value

Wrong = tuple[Line, Rule, dict[str, Value]]
"""The line that breaks a rule, and what the rule's sentences are filled with."""


def check(file: File) -> Iterator[Diagnostic]:
    for line, rule, fields in (*_blocks(file), *_names(file)):
        if file.source is None:
            yield rule(**fields)
        else:
            yield file.source.finding(rule, line.span or Span(0, 0), **fields)


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
    declared: set[tuple[str, Value]] = {("tool", FLANGE), ("frame", BASE)}
    for line in file.lines:
        if kind := tables.DECLARES.get(line.word):
            if (kind, line.values[0]) in declared:
                yield line, tables.TWICE, {"kind": kind, "name": line.values[0]}
            declared.add((kind, line.values[0]))
    for line in file.lines:
        for kind, name in zip(tables.USES.get(line.word, ()), line.values, strict=False):
            if kind and (kind, name) not in declared:
                yield line, tables.UNDECLARED, {"kind": kind, "name": name}
