"""Diagnostics: what is wrong, where, and what to do about it.

A `Rule` is the row of a table: a stable code with a sentence of what is wrong and one of
what to do. Calling it fills in the fields and gives a `Diagnostic`:

    NO_UNITS = warning("DX101", "the drawing names no unit", "set $INSUNITS")
    NO_UNITS(path="part.dxf", place="header")
"""

from __future__ import annotations

import enum
import string
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, Final, Self

from assistant.lazy import pictured
from assistant.program.subjects import Repeated, Subject

MOST_IN_EXCEPTION: Final = 5
"""Findings that the text of an exception tells; the rest is counted."""
LONGEST_EXCERPT: Final = 240
"""Characters of a source line that are shown with a finding."""


class Severity(enum.StrEnum):
    """How bad a finding is; an error keeps anything from being written."""

    ERROR = "error"
    WARNING = "warning"
    INFO = "info"


@dataclass(frozen=True, slots=True)
class Span:
    """A half-open range of character offsets in a source text."""

    start: int
    end: int

    def moved(self, by: int) -> Span:
        return Span(self.start + by, self.end + by)


def span_over(first: Span | None, last: Span | None) -> Span | None:
    """From the begin of one to the end of the other, None if one of them is not known."""
    return Span(first.start, last.end) if first and last else None


@dataclass(frozen=True, slots=True)
class Stretch:
    """Neighbouring statements that have the same fault, of which users read one finding.

    key: which ones. badness: of the statement at hand; the worst one is shown.
    """

    key: str
    badness: float


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding.

    code: stable identifier, two letters for the family and three digits.
    message: one sentence of what is wrong. cure: one sentence of what to do.
    path: the file, as the user named it. span: offsets in its text.
    line, column: counted from 1, None where the input has no lines. end_line, end_column:
    just behind the last character, None where only the start is known.
    about: what it is about, where that is no statement: a part of a program, or, in words, the
    entity, cell or field of other input.
    excerpt: the source line that `column` points into. missing: a name that is not declared.
    stretch: of neighbouring statements that have the same fault.
    """

    code: str
    severity: Severity
    message: str
    cure: str = ""
    path: str | None = None
    span: Span | None = None
    line: int | None = None
    column: int | None = None
    about: Subject | str | None = None
    excerpt: str | None = None
    end_line: int | None = None
    end_column: int | None = None
    missing: str | None = None
    stretch: Stretch | None = None

    @property
    def place(self) -> str | None:
        """What it is about, in words."""
        return None if self.about is None else str(self.about)

    def where(self) -> str:
        """`file:line:column place`, as far as each is known."""
        numbers = [str(n) for n in (self.line, self.column) if n is not None]
        head = ":".join([self.path or "", *numbers] if self.path or numbers else [])
        return " ".join(part for part in (head.strip(":"), self.place) if part)

    def __str__(self) -> str:
        """Code, place, what is wrong and, in brackets, what to do: one line."""
        where = self.where()
        head = f"{self.code} {where}: " if where else f"{self.code}: "
        return f"{head}{self.message}{f' ({self.cure})' if self.cure else ''}"

    def __repr__(self) -> str:
        return f"<{self.severity.upper()} {self}>"

    def _repr_html_(self) -> str:
        return pictured(self)

    def within(self, path: str | None) -> Diagnostic:
        """The same finding, placed in a file if it names none yet."""
        return self if self.path or not path else replace(self, path=path)


@dataclass(frozen=True, slots=True)
class Rule:
    """A row of a table of findings; `message` and `cure` are `str.format` templates.

    misses: whether it tells that what its `{name}` stands for is not declared, or not in full.
    """

    code: str
    severity: Severity
    message: str
    cure: str = ""
    misses: bool = False

    def __call__(
        self,
        *,
        path: str | None = None,
        span: Span | None = None,
        line: int | None = None,
        column: int | None = None,
        about: Subject | str | None = None,
        place: str | None = None,
        excerpt: str | None = None,
        end_line: int | None = None,
        end_column: int | None = None,
        severity: Severity | None = None,
        missed: str | None = None,
        **fields: Any,
    ) -> Diagnostic:
        """about: see `Diagnostic`; place: the same in words, of what is no part of a program."""
        return Diagnostic(
            self.code,
            severity or self.severity,
            self.message.format(**fields),
            self.cure.format(**fields),
            path,
            span,
            line,
            column,
            place if about is None else about,
            excerpt,
            end_line,
            end_column,
            fields["name"] if self.misses else missed,
        )

    def sentence(self, template: str) -> str:
        """The message or the cure with its fields in capitals, to be read without a finding.

        A field right behind a word is what only some findings add, and is left out.
        """
        said = ""
        for text, field, _, _ in string.Formatter().parse(template):
            said += text
            if field and not (said[-1:].isalnum() or said.endswith("]")):
                said += field.upper()
        return said


def error(code: str, message: str, cure: str = "", *, misses: bool = False) -> Rule:
    """A rule whose findings keep anything from being written."""
    return Rule(code, Severity.ERROR, message, cure, misses)


def warning(code: str, message: str, cure: str = "", *, misses: bool = False) -> Rule:
    """A rule of what should be looked at."""
    return Rule(code, Severity.WARNING, message, cure, misses)


def info(code: str, message: str, cure: str = "") -> Rule:
    """A rule of what is good to know."""
    return Rule(code, Severity.INFO, message, cure)


class Refused(ValueError):
    """The input cannot be used; `findings` say why.

    exit_status: 2 if it could not be read at all, 1 if what it says is wrong.
    """

    exit_status: int = 1

    def __init__(self, *findings: Diagnostic, exit_status: int | None = None) -> None:
        more = len(findings) - MOST_IN_EXCEPTION
        told = [
            *map(str, findings[:MOST_IN_EXCEPTION]),
            *([f"and {more} more"] if more > 0 else []),
        ]
        super().__init__("; ".join(told))
        self.findings: Final = findings
        if exit_status is not None:
            self.exit_status = exit_status


class Unreadable(Refused):
    """The input is missing, no file, not permitted, or not of the kind it claims to be."""

    exit_status = 2


def worst(findings: Iterable[Diagnostic]) -> Severity | None:
    """The highest severity among the findings, None if there are none."""
    order = list(Severity)
    return min((f.severity for f in findings), key=order.index, default=None)


def has_errors(findings: Iterable[Diagnostic]) -> bool:
    return any(f.severity is Severity.ERROR for f in findings)


class Findings(list[Diagnostic]):
    """Findings in the order in which they are made, each at the part of the source at hand."""

    _span: Span | None = None

    @contextmanager
    def at(self, span: Span | None) -> Iterator[None]:
        """Findings that are added in here stand at the span; with None, at the one around it.

        A span of their own would be one in a fragment of text, and is left out.
        """
        before, self._span = self._span, span or self._span
        try:
            yield
        finally:
            self._span = before

    def append(self, finding: Diagnostic) -> None:
        super().append(self.placed(finding))

    def extend(self, findings: Iterable[Diagnostic]) -> None:
        super().extend(map(self.placed, findings))

    def __iadd__(self, findings: Iterable[Diagnostic]) -> Self:  # type: ignore[override, misc]
        self.extend(findings)
        return self

    def placed(self, finding: Diagnostic) -> Diagnostic:
        """The finding at the part of the source at hand, without being added."""
        if self._span is None:
            return finding
        return replace(
            finding,
            span=self._span,
            line=None,
            column=None,
            excerpt=None,
            end_line=None,
            end_column=None,
        )


MOST_PLACES: Final = 3
"""How many places a folded finding names before it counts the rest."""


def fold(findings: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Join findings that differ only in their place, and those of a stretch, into one with a count.

    Findings at statements stay apart until their lines are known.
    """
    groups: dict[tuple[str, str, str | None, Span | None], list[Diagnostic]] = {}
    for finding in findings:
        said = finding.message if finding.stretch is None else finding.stretch.key
        apart = finding.span if finding.line is None else None
        groups.setdefault((finding.code, said, finding.path, apart), []).append(finding)
    return tuple(group[0] if len(group) == 1 else _folded(group) for group in groups.values())


def _folded(group: list[Diagnostic]) -> Diagnostic:
    first = group[0]
    if first.stretch is not None:
        return _worst_of(group)
    named = [f.place or (f"line {f.line}" if f.line else "") for f in group[:MOST_PLACES]]
    if not any(named):
        return first
    parts = tuple(finding.about for finding in group)
    return replace(first, about=Repeated(parts, tuple(named)))


def _worst_of(group: list[Diagnostic]) -> Diagnostic:
    """The worst finding of a stretch, with the lines of all."""
    shown = max(group, key=lambda one: 0.0 if one.stretch is None else one.stretch.badness)
    lines = sorted(one.line for one in group if one.line is not None)
    between = f", lines {lines[0]} to {lines[-1]}" if lines else ""
    return replace(shown, about=f"{len(group)} moves{between}", stretch=None)


def fold_files(findings: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """The same of findings of many files, joined where more than a few say the same.

    Errors are only joined within their file: each file that has one is named.
    """
    groups: dict[tuple[str, str, str, str | None], list[Diagnostic]] = {}
    for finding in fold(findings):
        alone = finding.path if finding.severity is Severity.ERROR else None
        groups.setdefault((finding.code, finding.message, finding.cure, alone), []).append(finding)
    return tuple(
        one
        for group in groups.values()
        for one in (group if len(group) <= MOST_PLACES else [_over_files(group)])
    )


def _over_files(group: list[Diagnostic]) -> Diagnostic:
    first, rest = group[0], len(group) - MOST_PLACES
    named = ", ".join(f.path or "" for f in group[:MOST_PLACES])
    return Diagnostic(
        first.code,
        first.severity,
        first.message,
        first.cure,
        about=f"in {len(group)} files: {named} and {rest} more",
    )
