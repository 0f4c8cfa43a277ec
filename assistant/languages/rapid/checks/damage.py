"""Syntax errors: what is found elsewhere must not follow from what cannot be read there."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from assistant.languages.rapid.tables.standard import FUNCTIONS, INSTRUCTIONS, OF_OPTIONS
from assistant.languages.rapid.tables.words import PREDEFINED, RESERVED, TYPES
from assistant.languages.rapid.tree import syntax as s
from assistant.program.diagnostics import Diagnostic, Severity

MOST_LINES: Final = 50
"""Of a statement; a finding of a whole routine or table is not of one damaged place."""
NEAR: Final = 1
"""Lines around a damaged one that its statement may go on in."""
_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_KNOWN: Final = frozenset(
    word.lower()
    for table in (INSTRUCTIONS, FUNCTIONS, OF_OPTIONS, PREDEFINED, RESERVED, TYPES)
    for word in table
)


@dataclass(frozen=True, slots=True)
class Damage:
    """Lines with syntax errors and those around them, with their files, and the names in them."""

    lines: frozenset[tuple[str | None, int]]
    names: frozenset[str]

    def explains(self, finding: Diagnostic, tree: s.File) -> bool:
        """Whether a finding in a file may follow from the damage."""
        lines = list(_lines(finding))
        if any((finding.path, line) in self.lines for line in lines):
            return True
        named = (name for line in lines[:1] for name in _names(tree, line))
        return not self.names.isdisjoint(named)


def damage_of(trees: Sequence[s.File]) -> Damage | None:
    """What is damaged in the modules of a program, None for nothing."""
    lines: set[tuple[str | None, int]] = set()
    names: set[str] = set()
    for tree in trees:
        for finding in tree.findings:
            if finding.severity is Severity.ERROR:
                for line in _lines(finding):
                    lines |= {(finding.path, line + by) for by in range(-NEAR, NEAR + 1)}
                    names |= {*_names(tree, line), *_parted(tree, line)}
    return Damage(frozenset(lines), frozenset(names)) if lines else None


def _lines(finding: Diagnostic) -> Iterator[int]:
    first = finding.line or 0
    yield from range(first, min(finding.end_line or first, first + MOST_LINES) + 1)


def _names(tree: s.File, line: int) -> Iterator[str]:
    """Names in a line that are no words of the language, in lower case."""
    if tree.source is not None and line:
        for word in _NAME.findall(tree.source.line_text(line)):
            if word.lower() not in _KNOWN:
                yield word.lower()


def _parted(tree: s.File, line: int) -> Iterator[str]:
    """Names that a blank may have parted in two."""
    words = [] if tree.source is None or not line else _NAME.findall(tree.source.line_text(line))
    for before, after in pairwise(words):
        yield (before + after).lower()
