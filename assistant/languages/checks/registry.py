"""Checks of a language: how they are registered and run, and what syntax errors take away.

Each `Check` names the view it looks at and what must be sound for it to run: a finding must not
follow from a passage that cannot be read (`Damage`). Also phrases that many findings share.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from typing import Final, Generic, TypeVar

from assistant.base.arrays import Rows
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Severity
from assistant.base.source_text import SourceText
from assistant.languages.language_types import Tree

V = TypeVar("V")

Found = Iterator[Diagnostic]
"""Findings of a rule."""


class Needs(enum.Flag):
    """Requirements of a rule that a text with syntax errors may not meet, so that the rule would
    report false findings.
    """

    NOTHING = 0
    ORDER = enum.auto()
    """The order of the lines, and which lines belong together."""
    NAMES = enum.auto()
    """Everything that is defined."""
    WHOLE = enum.auto()
    """All of the text."""


@dataclass(frozen=True, slots=True)
class Check(Generic[V]):
    """A rule over a view of a file or module.

    advice: it is about how a program is written, and is not asked about what was compiled: the
    program that this comes from has been checked, and its author wrote no vendor language.
    """

    find: Callable[[V], Found]
    needs: Needs = Needs.NOTHING
    advice: bool = False


def findings(
    checks: Iterable[Check[V]], view: V, lacks: Needs = Needs.NOTHING, *, compiled: bool = False
) -> Found:
    """Yield the findings of the checks that are reliable for this view. lacks: what syntax errors
    have spoilt.
    """
    for check in checks:
        if not (check.needs & lacks or (check.advice and compiled)):
            yield from check.find(view)


NamesIn = Callable[[str], Iterable[str]]
"""Function that returns the names in a text, without the words of the language, in one spelling."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Damage:
    """Unreadable parts of the files of a program.

    texts: the lines with a syntax error. lines: numbers of the damaged lines, with their files.
    names: the names on them, without the words of the language. names_in: finds such names in any
    text. most_lines: lines of a finding that are compared; named_lines: those of them whose names
    are compared; None for all.
    """

    texts: tuple[str, ...]
    lines: frozenset[tuple[str | None, int]]
    names: frozenset[str]
    names_in: NamesIn
    most_lines: int | None = None
    named_lines: int | None = None

    def explains(self, finding: Diagnostic, source: SourceText | None) -> bool:
        """True if a finding in a file may follow from the damage."""
        lines = list(islice(_lines_of(finding), self.most_lines))
        if any((finding.path, line) in self.lines for line in lines):
            return True
        named = lines[: self.named_lines]
        return source is not None and not all(
            self.names.isdisjoint(self.names_in(source.line_text(line))) for line in named if line
        )


def _lines_of(finding: Diagnostic) -> Iterator[int]:
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
    """Return the damage in the files of a program; None if they are undamaged.

    hidden: further names that a damaged line may hold. near: number of lines around a damaged one
    that its statement may extend to. most_lines, named_lines: see `Damage`.
    """
    found = {
        (finding.path, line): tree.source.line_text(line) if tree.source else ""
        for tree in trees
        for finding in tree.findings
        if finding.severity is Severity.ERROR
        for line in islice(_lines_of(finding), most_lines)
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


N = TypeVar("N")

SHOWN_NAMES: Final = 6
"""Names that one finding lists."""


class Listing(Generic[N]):
    """Many things that one finding is about.

    first: where it stands, a node and a row of it; None if there is nothing. names: those that the
    finding lists. count: of all things.
    """

    def __init__(self) -> None:
        self.first: tuple[N, int] | None = None
        self.names: list[str] = []
        self.count = 0

    def add(self, node: N, name: str) -> None:
        self.add_rows(node, (0,), lambda _: name)

    def add_rows(self, node: N, rows: Sequence[int] | Rows, name: Callable[[int], str]) -> None:
        """Some rows of a table. name: what a row is called."""
        if len(rows) and self.first is None:
            self.first = node, int(rows[0])
        self.names += [name(int(row)) for row in rows[: SHOWN_NAMES - len(self.names)]]
        self.count += len(rows)

    @property
    def words(self) -> dict[str, str]:
        """The `names` and `them` of the finding."""
        shown = ", ".join(f"`{name}`" for name in self.names)
        more = f" and {self.count - SHOWN_NAMES} more" if self.count > SHOWN_NAMES else ""
        return {"names": shown + more, "them": "them" if self.count > 1 else "it"}


def like_it(count: int) -> str:
    """Return the words after the last listed finding for this many more of its kind."""
    return f" and {count} more like it" if count > 0 else ""


def alternatives(least: int, most: int | None, what: str) -> str:
    """Return the accepted number of things in words: `1 argument`, `2 to 3 arguments`."""
    if most is None:
        return f"{least} {what}s or more"
    if least != most:
        return f"{least} to {most} {what}s"
    return f"{least or 'no'} {what}" + "s" * (least != 1)
