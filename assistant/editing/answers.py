"""Answers of the editing service as data; positions are those of editors (`text_lines`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Literal

from assistant.base.diagnostics import Diagnostic
from assistant.editing.text_lines import Range

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Integers = npt.NDArray[np.int32]

SORTS: Final = (
    *("comment", "keyword", "type", "variable", "parameter", "function", "procedure"),
    *("instruction", "target", "number", "string", "operator", "label", "property"),
)
"""What a word of a program is, by number: see `Tokens`."""
MARKS: Final = ("declaration", "readonly", "predefined")
"""What else is said of a word: bit 0, 1 and 2 of `Tokens.marks`."""


@dataclass(frozen=True, slots=True)
class Change:
    """A part of a text that is replaced: `range` by `text`."""

    range: Range
    text: str


Changes = Mapping[str, Sequence[Change]]
"""Changes by the path of the file; those of one file do not overlap, and all name places before any
of them is made."""


@dataclass(frozen=True, slots=True)
class Found:
    """A finding, and where it stands.

    range: the first line of the file where the finding names none. settled: whether the whole
    program was looked at since the last change; what is not may still change.
    """

    diagnostic: Diagnostic
    range: Range
    settled: bool = True


@dataclass(frozen=True, slots=True)
class Fix:
    """A cure that is a definite edit.

    title: what a menu says. code: of the finding. preferred: the one that the finding's own cure
    asks for, and can be made without a question.
    """

    title: str
    code: str
    changes: Changes
    preferred: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Tokens:
    """The words of a text in columns, a row a word, in their order; none goes over a line end.

    line, column, length: (n,) int32; column and length in UTF-16 units. sort: index into SORTS.
    marks: bits, see MARKS.
    """

    line: Integers
    column: Integers
    length: Integers
    sort: Integers
    marks: Integers

    def __len__(self) -> int:
        return len(self.line)


CompletionKind = Literal[
    "keyword", "type", "variable", "parameter", "function", "procedure", "instruction", "target",
    "label", "property", "snippet", "value",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Completion:
    """A word that may stand at a place.

    text: what is put in for `range`. detail: one line beside the label, such as a type.
    about: more, as Markdown, empty if there is none. rank: smaller ones come first.
    """

    label: str
    kind: CompletionKind
    text: str
    range: Range
    detail: str = ""
    about: str = ""
    rank: int = 0


@dataclass(frozen=True, slots=True)
class Hover:
    """What is said about the word at a place: Markdown without HTML."""

    text: str
    range: Range


@dataclass(frozen=True, slots=True, order=True)
class Location:
    """A place in a file of the task. path: as documents are named."""

    path: str
    range: Range


OutlineKind = Literal[
    "program", "module", "procedure", "function", "interrupt", "record", "type", "variable",
    "constant", "target", "label", "step",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class OutlineItem:
    """A declaration or a place in a program.

    range: all of it. selection: its name, inside of `range`. detail: its type or parameters.
    """

    name: str
    kind: OutlineKind
    range: Range
    selection: Range
    detail: str = ""
    children: tuple[OutlineItem, ...] = ()


@dataclass(frozen=True, slots=True)
class Pair:
    """Lines of a source and what they became.

    source, written: numbers of lines from 0; `written` is empty where nothing was written, and
    names the lines of the file `path`. what: in words what became of it, as the report has it.
    """

    source: tuple[int, ...]
    written: tuple[int, ...]
    path: str = ""
    what: str = ""


@dataclass(frozen=True, slots=True)
class Translation:
    """A program as another language says it.

    files: text by file name, empty if it could not be written. pairs: in the order of the source.
    findings: of translating it. draft: what cannot be said stands as a comment behind a stop.
    """

    language: str
    files: Mapping[str, str] = field(default_factory=dict)
    pairs: tuple[Pair, ...] = ()
    findings: tuple[Found, ...] = ()
    draft: bool = False
