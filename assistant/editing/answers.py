"""Answers of the editing service as data; positions are those of editors (`text_lines`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Final, Literal

from assistant.base.data_classes import dataclass
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
"""Sorts of words in a program, by number: see `Tokens`."""
MARKS: Final = ("declaration", "readonly", "predefined")
"""Marks of a word: bits 0, 1 and 2 of `Tokens.marks`."""


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
    """A finding and its range.

    range: the first line of the file if the finding has no location. settled: True if the complete
    program was checked since the last change; other findings may still change.
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
    """A word that can be inserted at a position.

    text: the text that replaces `range`. detail: one line beside the label, such as a type. about:
    more text as Markdown, empty if unknown. rank: smaller ones come first.
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
    """Text about the word at a position: Markdown without HTML."""

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
    """A program translated into another language.

    files: text by file name, empty if the program could not be written. pairs: in the order of the
    source. findings: from the translation. draft: statements without a translation are comments
    after a stop.
    """

    language: str
    files: Mapping[str, str] = field(default_factory=dict)
    pairs: tuple[Pair, ...] = ()
    findings: tuple[Found, ...] = ()
    draft: bool = False
