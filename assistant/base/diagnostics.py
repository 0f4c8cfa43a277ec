"""Diagnostics: what is wrong, where it is, and what to do about it.

A `Rule` is the row of a table: a stable code with a message and a cure. Calling it fills in
the fields and gives a `Diagnostic`:

    NO_UNITS = warning("DX101", "the drawing names no unit", "set $INSUNITS")
    NO_UNITS(path="part.dxf", place="header")

A finding about a part of a program holds that part as a `Subject`, whose words are made when
they are shown; a statement is identified by its span alone. Also here: the least severity that
fails a check.
"""

from __future__ import annotations

import enum
import string
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final, Literal, Self, TypeAlias

from assistant.base.data_classes import dataclass
from assistant.lazy import pictured

ProgramTable: TypeAlias = Literal[
    "procedures",
    "paths",
    "variables",
    "targets",
    "joint_targets",
    "tools",
    "frames",
    "signals",
    "speeds",
    "blends",
]
"""The tables of names of a program; paths are those of its statements."""

TABLE_NOUNS: Final[Mapping[ProgramTable, str]] = MappingProxyType(
    {
        "procedures": "procedure",
        "paths": "path",
        "variables": "variable",
        "targets": "target",
        "joint_targets": "joint target",
        "tools": "tool",
        "frames": "frame",
        "signals": "signal",
        "speeds": "speed",
        "blends": "blend",
    }
)
"""Table → what one entry of it is called."""
DATA_TABLES: Final[tuple[ProgramTable, ...]] = (
    "variables",
    "targets",
    "joint_targets",
    "tools",
    "frames",
    "signals",
)
"""The tables of a program that hold what it declares beside its procedures."""


@dataclass(frozen=True, slots=True)
class Declared:
    """Something that a program has under a name.

    table: that holds it, None where its name alone is known. owner: the procedure whose own
    variable it is, empty for one of the program. in_full: whether the words say what it is and
    whose, `procedure p variable n` instead of `n`.
    """

    name: str
    table: ProgramTable | None = None
    owner: str = ""
    in_full: bool = False

    def __str__(self) -> str:
        if self.table is None or not self.in_full:
            return self.name
        of = f"procedure {self.owner} " if self.owner else ""
        return f"{of}{TABLE_NOUNS[self.table]} {self.name}"


@dataclass(frozen=True, slots=True)
class PathRow:
    """A row of a path, counted from 1.

    more: how many other rows the same is found of. in_full: whether the words say what it is,
    `path seam row 2` instead of `seam_2`. original: what the source text calls it, if otherwise.
    """

    path: str
    row: int
    more: int = 0
    in_full: bool = False
    original: str = ""

    def __str__(self) -> str:
        name = self.original or f"{self.path}_{self.row}"
        said = f"path {self.path} row {self.row}" if self.in_full else name
        return f"{said} and {self.more} more" if self.more else said


@dataclass(frozen=True, slots=True)
class NumberedMove:
    """A move to a target without a name, counted from 1 among the moves of its procedure."""

    number: int
    procedure: str

    def __str__(self) -> str:
        return f"move {self.number} of {self.procedure}"


Goal: TypeAlias = Declared | PathRow | NumberedMove
"""Goal of a move: a target by its name, a row of a path, or a move to an unnamed target."""


@dataclass(frozen=True, slots=True)
class Neighbours:
    """Targets that follow each other, from the first to the last."""

    first: Goal
    last: Goal

    def __str__(self) -> str:
        return f"{self.first} to {self.last}"


@dataclass(frozen=True, slots=True)
class SomeTargets:
    """Some of the targets of a path, or of the moves of a procedure.

    of: its name. count: how many of the whole. named: the first ones. more: the rest.
    """

    of: str
    count: int
    whole: int
    named: tuple[Goal | Neighbours, ...]
    more: int

    def __str__(self) -> str:
        more = f" and {self.more} more" if self.more else ""
        named = ", ".join(map(str, self.named))
        return f"{self.of}: {self.count} of {self.whole} targets ({named}{more})"


@dataclass(frozen=True, slots=True)
class Several:
    """Targets in several parts of a run of moves. more: how many other parts have some."""

    parts: tuple[SomeTargets | Goal, ...]
    more: int

    def __str__(self) -> str:
        more = f"; and in {self.more} more paths" if self.more else ""
        return "; ".join(map(str, self.parts)) + more


@dataclass(frozen=True, slots=True)
class Inner:
    """A part of a program by the fields, names and rows that lead to it from the outside."""

    steps: tuple[str, ...]

    def __str__(self) -> str:
        return " ".join(self.steps)

    @property
    def declared(self) -> Declared | None:
        """The variable, target, tool … that it is, or that it is a part of."""
        match self.steps:
            case ("procedure", owner, "variables", name, *_):
                return Declared(name, "variables", owner)
            case (field, name, *_):
                table = next((table for table in DATA_TABLES if table == field), None)
                return Declared(name, table) if table is not None else None
        return None


@dataclass(frozen=True, slots=True)
class Repeated:
    """Parts of which the same is found. named: the first ones, in words."""

    parts: tuple[Subject | str | None, ...]
    named: tuple[str, ...]

    def __str__(self) -> str:
        rest = len(self.parts) - len(self.named)
        more = f" and {rest} more" if rest else ""
        return f"{len(self.parts)} times: {', '.join(filter(None, self.named))}{more}"


Subject: TypeAlias = Declared | PathRow | NumberedMove | SomeTargets | Several | Inner | Repeated


_MOST_IN_EXCEPTION: Final = 5
"""Findings that the text of an exception tells; the rest is counted."""
LONGEST_EXCERPT: Final = 240
"""Characters of a source line that are shown with a finding."""


class Severity(enum.StrEnum):
    """Severity of a finding; an error keeps anything from being written."""

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
    message: one sentence that states the fault. cure: one sentence that states the fix.
    path: the file, as the user named it. span: offsets in its text.
    line, column: counted from 1, None where the input has no lines. end_line, end_column:
    position after the last character, None where only the start is known.
    about: subject of the finding, where that is not a statement: a part of a program, or, in
    words, the entity, cell or field of other input.
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
        """The subject of the finding, in words; None without one."""
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
    """The input cannot be used; `findings` give the reasons.

    exit_status: 2 if it could not be read at all, 1 if its content is wrong.
    """

    exit_status: int = 1

    def __init__(self, *findings: Diagnostic, exit_status: int | None = None) -> None:
        more = len(findings) - _MOST_IN_EXCEPTION
        told = [
            *map(str, findings[:_MOST_IN_EXCEPTION]),
            *([f"and {more} more"] if more > 0 else []),
        ]
        super().__init__("; ".join(told))
        self.findings: Final = findings
        if exit_status is not None:
            self.exit_status = exit_status


class Unreadable(Refused):
    """The input is missing, no file, not permitted, or not of the kind it claims to be."""

    exit_status = 2


class UnknownName(Refused, KeyError):
    """There is nothing of that name."""

    exit_status = 2
    __str__ = Exception.__str__  # a KeyError shows its message in quotes


def worst(findings: Iterable[Diagnostic]) -> Severity | None:
    """Return the highest severity among the findings, None without findings."""
    order = list(Severity)
    return min((f.severity for f in findings), key=order.index, default=None)


def has_errors(findings: Iterable[Diagnostic]) -> bool:
    return any(f.severity is Severity.ERROR for f in findings)


class Findings(list[Diagnostic]):
    """Findings in the order in which they are made, each at the part of the source at hand."""

    _span: Span | None = None

    @contextmanager
    def at(self, span: Span | None) -> Iterator[None]:
        """Place findings that are added in the block at the span; with None, at the enclosing one.

        A finding's own span would be one in a fragment of text, and is left out.
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


_MOST_PLACES: Final = 3
"""Source locations that a folded finding names before it counts the rest."""


def notes_last(findings: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Errors and warnings in their order, then the notes."""
    return sorted(findings, key=lambda finding: finding.severity is Severity.INFO)


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
    named = [f.place or (f"line {f.line}" if f.line else "") for f in group[:_MOST_PLACES]]
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
        for one in (group if len(group) <= _MOST_PLACES else [_over_files(group)])
    )


def _over_files(group: list[Diagnostic]) -> Diagnostic:
    first, rest = group[0], len(group) - _MOST_PLACES
    named = ", ".join(f.path or "" for f in group[:_MOST_PLACES])
    return Diagnostic(
        first.code,
        first.severity,
        first.message,
        first.cure,
        about=f"in {len(group)} files: {named} and {rest} more",
    )


class FailOn(enum.StrEnum):
    """The least severity that fails a check, or that none does."""

    ERROR = "error"
    WARNING = "warning"
    NEVER = "never"

    def counts(self, finding: Diagnostic) -> bool:
        """True if the check fails for this finding."""
        if self is FailOn.NEVER or finding.severity is Severity.INFO:
            return False
        return finding.severity is Severity.ERROR or self is FailOn.WARNING

    def status(self, findings: Iterable[Diagnostic], *, unreadable: bool = False) -> int:
        """The exit status of a check: 0, 1 where it fails, 2 where something was not read."""
        return 2 if unreadable else int(any(map(self.counts, findings)))
