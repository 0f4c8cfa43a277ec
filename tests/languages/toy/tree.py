"""The tree of a toy file: its lines."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import SourceText
from assistant.languages import line_blocks
from assistant.languages.line_blocks import ANY, NO_WORD, Blocks, BlockWord

Value = str | float
BLOCKS = {
    "procedure": BlockWord("procedure", bounds="begins"),
    "if": BlockWord("if"),
    "while": BlockWord("while", "loop"),
    "else": BlockWord(parts="if", certain=True),
    "end": BlockWord(closes=(ANY,)),
}


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


def word_of(line: Line) -> BlockWord:
    """What a line is to blocks."""
    return BLOCKS.get(line.word, NO_WORD)


def blocks_of(lines: Iterable[Line]) -> Blocks:
    """The blocks of lines, by their places."""
    return line_blocks.blocks_of(enumerate(map(word_of, lines)))
