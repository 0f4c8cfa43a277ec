"""Data that vendor languages take and return.

Trees and their parts, printing precision, settings that a project may state, programs legalised
for a language, the outline of a new program; and for languages whose program is several files the
task: what a controller loads from a folder as one program. A language whose every file is a
program has no tasks.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path as FilePath
from types import MappingProxyType
from typing import Any, Final, Generic, Literal, Protocol, TypeAlias, TypeVar

from assistant.base import source_text
from assistant.base.arrays import Rows
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import SourceText
from assistant.program.program import Program, Signal
from assistant.program.undeclared_names import SuppliedValue, WantedKind


class Tree(Protocol):
    """A parsed or built file of a vendor language."""

    @property
    def findings(self) -> tuple[Diagnostic, ...]: ...

    @property
    def source(self) -> SourceText | None:
        """The text that it was read from, None if it was built."""


T = TypeVar("T", bound=Tree)


@dataclass(frozen=True, slots=True)
class Precision:
    """Most change by printing: half a unit of the last printed decimal, and a little float."""

    position: float
    """mm, per component."""
    angle: float
    """degrees, of the whole rotation."""
    number: float = 1e-6
    """relative, of other numbers."""


@dataclass(frozen=True, slots=True)
class Part:
    """A declaration or statement in a text, with its span.

    name: of the declared item. count: rows of a table, 1 for anything else. owner: the procedure
    that owns it, empty for the program. within: for a statement without a separate node in a
    program, the statement that expresses it, whose fate it shares. lines: (count, 2) offsets at
    which each of its lines begins and ends, for many lines of one kind.
    """

    span: Span
    name: str | None = None
    count: int = 1
    owner: str = ""
    within: Span | None = None
    lines: Rows | None = None

    def moved(self, by: int) -> Part:
        """The part of a text that is so much farther on."""
        within = None if self.within is None else self.within.moved(by)
        lines = None if self.lines is None else self.lines + by
        return replace(self, span=self.span.moved(by), within=within, lines=lines)


@dataclass(frozen=True, slots=True)
class Conversion(Generic[T]):
    """A program in another dialect of the same language, statement for statement.

    files: trees by the names of their files, empty if a finding forbids it. compared: returns, for
    the trees that were read back from those files, the two programs that must be the same.
    """

    files: Mapping[str, T]
    compared: Callable[[Sequence[T]], tuple[Program, Program]]
    findings: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True, slots=True)
class Setting:
    """A limit of a controller that a project may state: a whole number. meaning: one sentence."""

    least: int
    most: int
    meaning: str


@dataclass(frozen=True, slots=True)
class Choice:
    """A way of a controller that a project may state: one of the words. meaning: one sentence."""

    words: tuple[str, ...]
    meaning: str


ARITHMETIC: Final[Mapping[str, Choice]] = MappingProxyType(
    {
        "halves": Choice(
            ("away", "even", "up"),
            "say how a number that ends in .5 is rounded: away from zero, to the even one, or up",
        ),
        "remainder": Choice(
            ("dividend", "divisor"),
            "say whose sign the remainder of a division has",
        ),
    }
)
"""Rules of arithmetic that manuals leave open, for all languages; the first word is the default."""


@dataclass(frozen=True, slots=True)
class Adapted:
    """A program as one language can express it, with a finding for every change.

    trees: of its units, if they were built to check that this is possible. wanting: errors that
    follow from others alone: of names whose declarations cannot be expressed.
    """

    program: Program
    findings: tuple[Diagnostic, ...] = ()
    trees: Mapping[str | None, Any] = field(default_factory=dict)
    wanting: tuple[Diagnostic, ...] = ()


Numbering = Callable[[Sequence[str]], list[str]]
"""Gives the lines of a text their step numbers."""


@dataclass(frozen=True, slots=True)
class Outline:
    """Sections of the text of a new program, and the lines that a template may write around them.

    template: its file in `templates/`. sections: divides a text into sections by name; together
    they are all of the text except the frame. within: sections that are parts of other sections:
    the name of that section, and the function that takes the part from its text. name: returns the
    name of the program from its text. frame: patterns of lines that a template writes beside
    comments, by name, with `{name}` for the name of the program. rank: order of sections and frame
    lines; those of one rank may change places. complete: alternatives; a template has each section
    and frame line of one of them exactly once. item: true for a comment that readers take for a
    statement about the program. numbered: returns the step numbering of a dialect, None for a
    dialect without numbers. blank: true if a text may have blank lines. ends: the section after
    which a template writes no comments, empty for none.
    """

    template: str
    sections: Callable[[str], Mapping[str, str]]
    within: Mapping[str, tuple[str, Callable[[str], str]]]
    name: Callable[[str], str]
    rank: Mapping[str, int]
    complete: tuple[tuple[str, ...], ...]
    item: Callable[[str], bool]
    frame: Mapping[str, str]
    numbered: Callable[[str], Numbering | None]
    blank: bool
    ends: str = ""


Sampling = Literal["samples", "full"]
"""Part of a long text that lark parses in a proof: samples of its runs of like lines, or all."""
Frames = Literal["base", "product"]
"""Form in which a language without work objects states the frame of a target."""


@dataclass(frozen=True, slots=True)
class TaskLoading:
    """Rules by which the files of a task are found.

    entry: the procedure that a task begins with, in lower case. lists: suffixes of files that name
    the files of a task. shared: for a folder, as `program_of` gives it, true if every other task
    next to it loads its files as well. closed: true if a task there loads all files of its folders,
    and none from elsewhere but shared ones. loaded: for a file there, true if a task loads it
    though its list does not name it. sharing: the trees of all tasks of a controller, by the name
    of each, with names of data that other controllers share as well.
    """

    entry: str
    lists: tuple[str, ...]
    shared: Callable[[FilePath], bool]
    closed: Callable[[FilePath], bool]
    loaded: Callable[[FilePath], bool]
    sharing: Callable[[Sequence[tuple[str, Sequence[Any]]]], Sequence[SharedData]]


@dataclass(frozen=True, slots=True)
class SharedData:
    """The trees of a task that shares data with others of its controller. findings: on that."""

    trees: tuple[Any, ...]
    findings: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True, slots=True)
class ControllerConfiguration:
    """Statements in the files of a controller about its programs.

    signals: by their names. source: the file that states them. crossed: names in lower case of
    those that the controller sets from others. unread: statements there that cannot be used. known:
    true if the text looks like such a file at all. arm: the robot, by its name in the catalogue;
    told: the same in its maker's words. entry: the procedure that the task begins with, in lower
    case. called: routines that the controller calls, by their names in lower case, each with when.
    values: of names that programs use and do not declare. lines: communication lines by number,
    each with its role, port and address. findings: on the files.
    """

    signals: Mapping[str, Signal] = field(default_factory=dict)
    crossed: frozenset[str] = frozenset()
    unread: tuple[str, ...] = ()
    known: bool = True
    arm: str | None = None
    told: str = ""
    entry: str | None = None
    called: Mapping[str, str] = field(default_factory=dict)
    values: Mapping[tuple[WantedKind, str], SuppliedValue] = field(default_factory=dict)
    lines: Mapping[int, CommunicationLine] = field(default_factory=dict)
    source: FilePath | None = None
    findings: tuple[Diagnostic, ...] = ()


CommunicationLine: TypeAlias = tuple[Literal["server", "client", "serial"], int, str]
Texts: TypeAlias = Callable[[FilePath], str | None]
"""Reads a file of a controller, None where that cannot be done."""
Surroundings: TypeAlias = Callable[[FilePath, Texts], ControllerConfiguration]
"""Reads the controller's configuration from the files next to a program's file."""


def file_named(folder: FilePath, name: str) -> FilePath | None:
    """Return the entry of a folder whose name in lower case is the given one; None without one."""
    try:
        return next((path for path in folder.iterdir() if path.name.lower() == name), None)
    except OSError:
        return None


def catalogue_name(family: str, figures: frozenset[float]) -> str | None:
    """The arm in the catalogue of a family, `irb1200`, with these figures behind its name."""
    from assistant import robots

    for name in robots.names():
        first, *others = name.split("-")
        if first == family and frozenset(map(float, filter(_FIGURE.fullmatch, others))) == figures:
            return name
    return None


_FIGURE: Final = re.compile(r"[0-9]+(?:\.[0-9]+)?")


_WORD: Final = r"[^\W\d]\w*"


def words_of(text: str, mark: str) -> frozenset[str]:
    """Names in a text, in lower case, but for those in comments and in strings ("…")."""
    # Strings and comments match first, so that no name is found inside them.
    apart = rf'"(?:[^"\r\n]|"")*+(?:"|(?=[\r\n])|\Z)|{re.escape(mark)}{source_text.REST}|({_WORD})'
    found = re.finditer(apart, source_text.with_line_feeds(text))
    return frozenset(match[1].lower() for match in found if match[1])
