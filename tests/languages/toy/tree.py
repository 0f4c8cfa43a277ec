"""The tree of a toy file: its lines."""

from __future__ import annotations

from dataclasses import dataclass, field

from assistant.program.diagnostics import Diagnostic, Span
from assistant.program.text import SourceText

Value = str | float


@dataclass(frozen=True, slots=True)
class Line:
    """A word of the language and what stands behind it, as `toy.lark` has it.

    word: `#` for a comment, empty for a line that is wrong; its text is the value then.
    span: where it stands in the text that was read, None if it was built.
    """

    word: str
    values: tuple[Value, ...] = ()
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class File:
    """read: the lines as they were read, so that a file which nobody changed is known by them."""

    lines: tuple[Line, ...]
    findings: tuple[Diagnostic, ...] = field(default=(), compare=False, repr=False)
    source: SourceText | None = field(default=None, compare=False, repr=False)
    read: tuple[Line, ...] = field(default=(), compare=False, repr=False)
