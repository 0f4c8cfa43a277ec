"""The text that a tree was read from, and where its nodes and their words stand in it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from assistant.base.source_text import SourceText
from assistant.languages.texts.printed_blocks import (
    Block,
    Extent,
    Layout,
    Piece,
    same_word,
    spelling,
)
from assistant.languages.texts.words import Word


class Original:
    """A source with the extents of its nodes, as offsets into its text."""

    def __init__(self, source: SourceText, layout: Layout) -> None:
        self.text, self._newline, self._layout = source.text, source.newline, layout
        self.extents: dict[int, Extent] = {}
        """Of nodes that stand for a line of many, by the id of the node."""

    def extent(self, node: Any) -> Extent:
        extent = self.extents.get(id(node)) or self._layout.extent(self.text, node)
        if extent is None:
            raise ValueError(f"{type(node).__name__} of the tree that was read has no span")
        return extent

    def indent(self, at: int) -> str | None:
        """The blanks that begin a line, None if something else stands before the offset."""
        begin = self.text.rfind("\n", 0, at) + 1
        before = self.text[begin:at]
        return None if before.strip() else before

    def line_indent(self, at: int) -> str:
        begin = self.text.rfind("\n", 0, at) + 1
        line = self.text[begin:at]
        return line[: len(line) - len(line.lstrip())]

    def newline(self, at: int) -> str:
        """The line end that is used at an offset."""
        end = self.text.rfind("\n", 0, at)
        if end < 0:
            end = self.text.find("\n", at)
        if end < 0:
            return self._newline
        return "\r\n" if self.text[end - 1 : end] == "\r" else "\n"

    def same_words(self, pieces: Sequence[Piece], words: Sequence[Word]) -> bool:
        return all(same_word(self._layout, p, w) for p, w in zip(pieces, words, strict=True))

    def locate(self, pieces: list[Piece], extent: Extent) -> bool:
        """Finds the pieces in the source; False if their words are not those that stand there."""
        at, waiting, first = extent.start, [], True
        for piece in [*pieces, None]:
            children = piece.what.children if piece and isinstance(piece.what, Block) else None
            if piece is not None and children is None:
                waiting.append(piece)
            elif piece is None or children:
                stop = self.extent(children[0]).start if children else extent.end
                words = list(self._layout.words(self.text, at, stop))
                # What could not be read may stand around a block.
                last = len(words) - len(waiting)
                shifts = [0] if first else [last] if piece is None else range(last + 1)
                if last < 0 or (first and piece is None and last):
                    return False
                for shift in shifts:
                    some = words[shift : shift + len(waiting)]
                    if self.same_words(waiting, some):
                        break
                else:
                    return False
                for held, word in zip(waiting, some, strict=True):
                    held.start, held.end = word.start, word.end
                if children:
                    at = self.extent(children[-1]).end
                waiting, first = [], False
        at = extent.start
        for piece, following in zip(pieces, [*pieces[1:], None], strict=True):
            if isinstance(piece.what, Block):
                piece.start = at
                if following is None:
                    piece.end = extent.end
                elif isinstance(following.what, str):
                    piece.end = following.start
                else:
                    children = piece.what.children
                    piece.end = self.extent(children[-1]).end if children else at
            at = piece.end
        return True

    def locate_blocks(self, before: list[Piece], after: list[Piece], extent: Extent) -> bool:
        """Finds the blocks between words that are not understood, if only blocks have changed."""
        if list(map(spelling, before)) != list(map(spelling, after)):
            return False
        at = extent.start
        for had, has in zip(before, after, strict=True):
            had.start = had.end = at
            if isinstance(had.what, Block) and isinstance(has.what, Block):
                if had.what.children:
                    had.start = self.extent(had.what.children[0]).start
                    had.end = at = self.extent(had.what.children[-1]).end
                elif has.what.children:
                    return False
        return True
