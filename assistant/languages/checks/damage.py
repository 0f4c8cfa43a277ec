"""Syntax errors: what is found elsewhere must not follow from what cannot be read there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice

from assistant.languages.language import Tree
from assistant.program.diagnostics import Diagnostic, Severity
from assistant.program.text import SourceText


@dataclass(frozen=True, slots=True, kw_only=True)
class Damage:
    """What cannot be read in the files of a program.

    lines: numbers of the lines, with their files. names: what stands on them and is no word of the
    language. names_in: such names in any text, as `names` spells them. most_lines: of a finding
    that are looked at; named_lines: those of them whose names are; None for all.
    """

    lines: frozenset[tuple[str | None, int]]
    names: frozenset[str]
    names_in: Callable[[str], Iterable[str]]
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


def damaged(
    trees: Iterable[Tree], most_lines: int | None = None
) -> Iterator[tuple[str | None, int, str]]:
    """Each line with a syntax error: its file, its number and its text, empty if not known."""
    for tree in trees:
        for finding in tree.findings:
            if finding.severity is Severity.ERROR:
                for line in islice(lines_of(finding), most_lines):
                    source = tree.source
                    text = source.line_text(line) if source is not None and line else ""
                    yield finding.path, line, text


def sound(
    findings: Iterable[Diagnostic], damage: Damage | None, source: SourceText | None
) -> Iterator[Diagnostic]:
    """The findings in a file that do not follow from what is damaged."""
    return (f for f in findings if damage is None or not damage.explains(f, source))
