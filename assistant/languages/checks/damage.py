"""Syntax errors: what is found elsewhere must not follow from what cannot be read there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice

from assistant.base.diagnostics import Diagnostic, Severity
from assistant.base.source_text import SourceText
from assistant.languages.answers import (
    Tree,
)

NamesIn = Callable[[str], Iterable[str]]
"""Names in a text that are no words of the language, in one spelling."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Damage:
    """What cannot be read in the files of a program.

    texts: the lines with a syntax error. lines: numbers of those that are damaged, with their
    files. names: what stands on them and is no word of the language. names_in: such names in any
    text. most_lines: of a finding that are looked at; named_lines: those of them whose names are;
    None for all.
    """

    texts: tuple[str, ...]
    lines: frozenset[tuple[str | None, int]]
    names: frozenset[str]
    names_in: NamesIn
    most_lines: int | None = None
    named_lines: int | None = None

    def explains(self, finding: Diagnostic, source: SourceText | None) -> bool:
        """Whether a finding in a file may follow from the damage."""
        lines = list(islice(lines_of(finding), self.most_lines))
        if any((finding.path, line) in self.lines for line in lines):
            return True
        named = lines[: self.named_lines]
        return source is not None and not all(
            self.names.isdisjoint(self.names_in(source.line_text(line))) for line in named if line
        )


def lines_of(finding: Diagnostic) -> Iterator[int]:
    """Numbers of the lines that a finding is about; 0 if it has none."""
    first = finding.line or 0
    yield from range(first, (finding.end_line or first) + 1)


def damage_of(
    trees: Iterable[Tree],
    names_in: NamesIn,
    *,
    hidden: NamesIn = lambda _: (),
    near: int = 0,
    most_lines: int | None = None,
    named_lines: int | None = None,
) -> Damage | None:
    """What is damaged in the files of a program, None for nothing.

    hidden: further names that a damaged line may hold. near: lines around a damaged one that its
    statement may go on in. most_lines, named_lines: see `Damage`.
    """
    found = {
        (finding.path, line): tree.source.line_text(line) if tree.source else ""
        for tree in trees
        for finding in tree.findings
        if finding.severity is Severity.ERROR
        for line in islice(lines_of(finding), most_lines)
        if line
    }
    if not found:
        return None
    around = range(-near, near + 1)
    return Damage(
        texts=tuple(found.values()),
        lines=frozenset((path, line + by) for path, line in found for by in around),
        names=frozenset(
            name for text in found.values() for name in (*names_in(text), *hidden(text))
        ),
        names_in=names_in,
        most_lines=most_lines,
        named_lines=named_lines,
    )


def undamaged_findings(
    findings: Iterable[Diagnostic], damage: Damage | None, source: SourceText | None
) -> Iterator[Diagnostic]:
    """The findings in a file that do not follow from what is damaged."""
    return (f for f in findings if damage is None or not damage.explains(f, source))
