"""Text of a changed RAPID file: what `texts.lossless` has to know of the language."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.reading.scanner import words
from assistant.languages.rapid.text.printer import INDENT, PRINTER
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import plain_row
from assistant.languages.texts import lossless
from assistant.languages.texts.lossless import Block, Extent, Sketch
from assistant.languages.texts.words import Word

_NEXT_OPTION: Final = re.compile(r"(?:[ \t\f\r\n]|![^\r\n]*)*\\")
"""A comma may stand in front of an optional argument."""
_ENDED_BY_SEMICOLON: Final = (
    *(s.Assignment, s.ProcedureCall, s.GotoLabel, s.ReturnFrom, s.RaiseError, s.Word),
    *(s.Connect, s.CompactIf, s.MoveRunNode),
)
"""Statements that end with a semicolon, which their span may leave out."""
_SEMICOLON: Final = re.compile(r"(?:[ \t\f\r\n]|![^\r\n]*)*;")
_FILE_HEADER: Final = re.compile(r"\s*%%%(.*?)%%%", re.DOTALL)


def render(file: s.File, origin: s.Origin) -> str:
    """The text of a file; what is as it was read keeps its bytes."""
    begin = _FILE_HEADER.match(origin.source.text)
    header = begin[1] if begin and origin.parts else None
    if file.parts is origin.parts and file.header == header:
        return origin.source.text
    old = s.File(origin.parts, header)
    text = lossless.render(origin.source, old, replace(file, header=header), FileLayout())
    if file.header == header:
        return text
    newline = origin.source.newline
    new = "" if file.header is None else f"%%%{file.header}%%%"
    if begin is None:
        return new + newline + text
    rest = text[begin.end() :]
    return new + rest if new else re.sub(r"^[ \t]*\r?\n", "", rest)


class FileLayout(lossless.RunLayout):
    """RAPID: statements end with `;`, comments with their line."""

    spelled = frozenset(("string", "number"))
    indent = INDENT
    row_end = ";"
    note = "!"

    def words(self, text: str, start: int, end: int) -> Iterator[Word]:
        for word in words(text, start, end):
            if word.kind not in ("comment", "newline"):
                if word.text != "," or not _NEXT_OPTION.match(text, word.end, end):
                    yield word

    def noted(self, gap: str) -> bool:
        return any(word.kind == "comment" for word in words(gap))

    def sketch(self, node: Any) -> Sketch:
        match node:
            case s.File():
                header = () if node.header is None else (f"%%%{node.header}%%%\n",)
                return (*header, Block(node.parts, 0))
            case lossless.RunRow(text=text):
                return (text,)
        return PRINTER.sketch(node)

    def extent(self, text: str, node: Any) -> Extent | None:
        if node.span is None:
            return None
        start, end = node.span.start, node.span.end
        while start < end and text[start].isspace():
            start += 1
        while start < end and text[end - 1].isspace():
            end -= 1
        if isinstance(node, _ENDED_BY_SEMICOLON) and text[end - 1] != ";":
            if semicolon := _SEMICOLON.match(text, end):
                end = semicolon.end()
        return Extent(start, end)

    def line_ends(self, before: Any, after: Any) -> int | None:
        if isinstance(before, s.CommentLine):
            return 1
        if isinstance(after, s.CommentLine) and before is not None:
            return 0 if after.trailing else 1
        blank = isinstance(before, s.Routine) or isinstance(after, s.Routine)
        return 2 if blank and before is not None and after is not None else None

    def is_run(self, node: Any) -> bool:
        return isinstance(node, s.TargetRunNode | s.MoveRunNode)

    def may_be_row(self, node: Any) -> bool:
        return plain_row(node) is not None
