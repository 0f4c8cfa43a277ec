"""The text of a changed tree: what did not change keeps its bytes, blanks and comments included.

Old and new tree are walked together. A list of nodes that stand on lines of their own is
aligned, and unchanged neighbours keep the very text that they and the room between them had.
Of a node that changed the words in front of, between and behind its lists are compared as its
language prints them; the words that stay keep their text, comments between them stay as well.
What is new is printed. A vendor language says how in a `Layout`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, Final

from assistant.base.source_text import SourceText
from assistant.languages.texts.alignment import aligned, common_ends, same
from assistant.languages.texts.original import Original
from assistant.languages.texts.printed_blocks import (
    MOST_WORDS,
    Block,
    Extent,
    Layout,
    Piece,
    Sketch,
    Spread,
    differences,
    equal_sketches,
    name_blocks,
    pieces_of,
)

__all__ = ["Block", "Extent", "Layout", "Sketch", "Spread", "render"]

LINE_END: Final = "\n"


def render(source: SourceText, old: Any, new: Any, layout: Layout) -> str:
    """The text of `new`, a tree made from `old`, which was read from the source."""
    return _Writer(source, layout).changed(old, new, Extent(0, len(source.text)))


class _Writer:
    def __init__(self, source: SourceText, layout: Layout) -> None:
        self._source, self._layout = Original(source, layout), layout
        step = re.search(r"^[ \t]+(?=[^\s])", source.text, re.MULTILINE)
        self._step = step[0] if step else layout.indent
        self._spread: list[Spread] = []  # which keeps those nodes alive
        self._lost: list[Any] = []  # nodes that left their place
        self._known: dict[int, Any] = {}  # what they hold, to be found in other places

    # A node that changed

    def changed(self, old: Any, new: Any, extent: Extent) -> str:
        """The text of a node, from that of the one that it was made from."""
        kept = self._source.text[extent.start : extent.end]
        if same(old, new):
            return kept
        if type(old) is type(new):
            sketches = self._layout.sketch(old), self._layout.sketch(new)
            if equal_sketches(*sketches):
                return kept
            if sum(len(p) for s in sketches for p in s if isinstance(p, str)) < 8 * MOST_WORDS:
                before, after = (pieces_of(self._layout, s) for s in sketches)
                text = self._merged(before, after, extent) if before else None
                if text is not None:
                    return text
        self._lost.append(old)
        return self._written(
            new, self._source.line_indent(extent.start), self._source.newline(extent.start)
        )

    def _merged(self, before: list[Piece], after: list[Piece], extent: Extent) -> str | None:
        """The old text with the words and blocks that changed; None if that cannot be done."""
        located = self._source.locate(before, extent)
        if not located and not self._source.locate_blocks(before, after, extent):
            return None
        name_blocks(before, after)
        base, newline = self._source.line_indent(extent.start), self._source.newline(extent.start)
        for piece in after:
            piece.gap = self._indented(piece.gap, base, newline)
        out: list[str | Piece] = []
        at = extent.start
        for kind, i1, i2, j1, j2 in differences(before, after):
            removed, inserted = before[i1:i2], after[j1:j2]
            words = all(isinstance(p.what, str) for p in [*removed, *inserted])
            if kind == "equal" or (len(removed) == len(inserted) and words):
                for had, has in zip(removed, inserted, strict=True):
                    out.append(self._source.text[at : had.start])
                    if isinstance(has.what, Block):
                        assert isinstance(had.what, Block)
                        inner = Extent(had.start, had.end)
                        out.append(Piece(self._block(had.what, has.what, inner, base), "text"))
                    else:
                        kept = has.what == had.what
                        out.append(self._source.text[had.start : had.end] if kept else has.what)
                    at = had.end
                continue
            stop = before[i2].start if i2 < len(before) else extent.end
            self._lost += [c for p in removed if isinstance(p.what, Block) for c in p.what.children]
            following = after[j2].gap if j2 < len(after) else ""
            out += self._replaced(removed, inserted, Extent(at, stop), following, base, newline)
            at = stop
        out.append(self._source.text[at : extent.end])
        return _joined(out) if not located or self._says(out, after) else None

    def _replaced(
        self,
        removed: list[Piece],
        inserted: list[Piece],
        room: Extent,
        following: str,
        base: str,
        newline: str,
    ) -> Iterator[str | Piece]:
        """New pieces in place of old ones. room: from the last piece that stays to the next."""
        marks = [room.start, *(at for p in removed for at in (p.start, p.end)), room.end]
        gaps = [self._source.text[a:b] for a, b in zip(marks[::2], marks[1::2], strict=True)]
        first, last = gaps[0] if removed else "", gaps[-1]
        notes = "".join(gap for gap in gaps[1:-1] if self._layout.noted(gap))
        begins, ends = room.start == marks[1] and not first, room.end == marks[-2] and not last
        if not inserted:
            yield from (g for g in (first if self._layout.noted(first) else "", notes) if g)
            if self._layout.noted(last) or self._layout.noted(first) or notes:
                yield last
            elif not (begins and not following) and not ends:
                by_length = sorted((first, last), key=len)
                yield by_length[1] if following else by_length[0]
            return
        for number, piece in enumerate(inserted):
            yield first if number == 0 and removed else piece.gap
            if isinstance(piece.what, Block):
                yield Piece(self._new_block(piece.what, base, newline), "text")
            else:
                yield piece.what
        yield notes
        if isinstance(inserted[-1].what, Block) and not last.strip():
            return
        lacking = following if not last or (LINE_END in following and LINE_END not in last) else ""
        yield lacking or last

    def _says(self, out: list[str | Piece], after: list[Piece]) -> bool:
        """Whether a text reads as the words that it should."""
        stretches: list[list[str]] = [[]]
        for part in out:
            if isinstance(part, Piece):
                stretches.append([])
            else:
                stretches[-1].append(part)
        wanted: list[list[Piece]] = [[]]
        for piece in after:
            if isinstance(piece.what, Block):
                wanted.append([])
            else:
                wanted[-1].append(piece)
        if len(wanted) != len(stretches):
            return False
        for pieces, stretch in zip(wanted, stretches, strict=True):
            text = "".join(stretch)
            words = list(self._layout.words(text, 0, len(text)))
            if len(words) != len(pieces) or not self._source.same_words(pieces, words):
                return False
        return True

    # Lists of nodes on lines of their own

    def _block(self, old: Block, new: Block, room: Extent, base: str) -> str:
        """The text from the word before a block to the word behind it."""
        if old.children is new.children or old.children == new.children:
            return self._source.text[room.start : room.end]
        entries = _Entries(self, room, base, base + self._step * new.depth)
        head, tail = common_ends(old.children, new.children)
        middle_old = old.children[head : len(old.children) - tail]
        middle_new = new.children[head : len(new.children) - tail]
        spread = self._layout.spread(self._source.text, middle_old, middle_new)
        if spread is not None:
            self._spread.append(spread)
            self._source.extents |= {
                id(n): e for n, e in zip(spread.old, spread.extents, strict=True)
            }
            middle_old, middle_new = tuple(spread.old), tuple(spread.new)
        olds = (*old.children[:head], *middle_old, *old.children[len(old.children) - tail :])
        partner: list[int | None] = list(range(head))
        partner += [None if i is None else head + i for i in aligned(middle_old, middle_new)]
        partner += range(len(olds) - tail, len(olds))
        kept = {i for i in partner if i is not None}
        self._lost += [n for i, n in enumerate(middle_old, head) if i not in kept]
        news = (*new.children[:head], *middle_new, *new.children[len(new.children) - tail :])
        return entries.text(olds, news, partner)

    def _new_block(self, block: Block, base: str, newline: str) -> str:
        indent = base + self._step * block.depth
        out, before = [], None
        for child in block.children:
            ends = self._layout.line_ends(before, child)
            if ends == 0:
                out.append(" ")
            else:
                out.append(newline * (2 if ends == 2 and before is not None else 1) + indent)
            out.append(self._written(child, indent, newline))
            before = child
        return "".join(out) + newline + base

    def _written(self, node: Any, base: str, newline: str) -> str:
        """A node as it stood elsewhere in the source, else printed."""
        while self._lost:
            self._remember(self._lost.pop())
        if id(node) in self._known and (extent := self._layout.extent(self._source.text, node)):
            return self._source.text[extent.start : extent.end]
        out = ""
        for part in self._layout.sketch(node):
            if isinstance(part, Block):
                out = out.removesuffix(newline + base) + self._new_block(part, base, newline)
            else:
                out += self._indented(part, base, newline)
        return out.removesuffix(newline + base)

    def _remember(self, node: Any) -> None:
        if is_dataclass(node):
            self._known[id(node)] = node
            for field in fields(node):
                value = getattr(node, field.name)
                for child in value if isinstance(value, tuple) else (value,):
                    self._remember(child)

    def _indented(self, text: str, base: str, newline: str) -> str:
        """Printed lines, as deep as they are to stand here."""
        if LINE_END not in text:
            return text
        head, *lines = text.split(LINE_END)
        for number, line in enumerate(lines):
            inner = line.lstrip()
            depth = (len(line) - len(inner)) // max(len(self._layout.indent), 1)
            lines[number] = base + self._step * depth + inner
        return newline.join([head, *lines])


class _Entries:
    """The children of one block, written one behind the other. room: of the block."""

    def __init__(self, writer: _Writer, room: Extent, base: str, indent: str) -> None:
        self._writer, self._room, self._base, self._indent = writer, room, base, indent
        self._out: list[str] = []

    def text(self, old: Sequence[Any], new: Sequence[Any], partner: list[int | None]) -> str:
        w, layout, room = self._writer, self._writer._layout, self._room
        source = w._source
        text, extent = source.text, source.extent
        if old:
            indents = (source.indent(extent(node).start) for node in old)
            self._indent = next((i for i in indents if i is not None), self._indent)
        newline = source.newline(room.start)
        out = self._out
        last = -1  # index of the last old node that has been placed
        at = room.start  # offset up to which the source has been used
        open_end = False  # a stretch of unchanged nodes from `at` on is still to be written
        before, put = None, False
        for j in range(len(new) + 1):
            node = new[j] if j < len(new) else None
            i = partner[j] if j < len(new) else len(old)
            unchanged = i is not None and i < len(old) and same(old[i], node)
            if unchanged and open_end and i == last + 1:
                last, before = last + 1, node
                continue
            if open_end:
                end = extent(old[last]).end
                out.append(text[at:end])
                at, open_end = end, False
            if i is None:
                # Stand on the line of the first node that stays, if it begins one.
                if last >= 0 and (here := source.indent(extent(old[last]).start)) is not None:
                    self._indent = here
                out.append(self._lead(layout.line_ends(before, node), before, newline))
                out.append(w._written(node, self._indent, newline))
                before, put = node, True
                continue
            start = extent(old[i]).start if i < len(old) else room.end
            gap = self._gap(old[last + 1 : i], at, start)
            touched = put or i > last + 1 or not unchanged
            out.append(self._mended(gap, before, node, put, newline) if touched else gap)
            last, before, put = i, node, False
            if i == len(old):
                break
            at = start
            if unchanged:
                open_end = True
            else:
                out.append(w.changed(old[i], node, extent(old[i])))
                at = extent(old[i]).end
        return "".join(out)

    def _lead(self, ends: int | None, before: Any, newline: str) -> str:
        if ends == 0:
            return " "
        if before is None and self._room.start == 0:
            return ""
        return newline * (2 if ends == 2 and before is not None else 1) + self._indent

    def _gap(self, removed: Sequence[Any], start: int, end: int) -> str:
        """What stays between two nodes when those between them are taken out with their lines."""
        text, extent = self._writer._source.text, self._writer._source.extent
        marks = [start, *(at for node in removed for at in extent(node)), end]
        gaps = [text[a:b] for a, b in zip(marks[::2], marks[1::2], strict=True)]
        first, last = gaps[0], gaps[-1]
        if len(gaps) == 1:
            return first
        if any(gap.strip() for gap in gaps):  # what could not be read
            return "".join([first, *(g for g in gaps[1:-1] if g.strip()), last])
        if LINE_END in first and LINE_END in last:
            return first[: first.rindex(LINE_END) + 1] + last[last.index(LINE_END) + 1 :]
        return max((first, last), key=lambda gap: (LINE_END in gap, len(gap)))

    def _mended(self, gap: str, before: Any, after: Any, put: bool, newline: str) -> str:
        """The room between two neighbours, one of which is not what it was."""
        ends = self._writer._layout.line_ends(before, after)
        if ends == 0:
            return " " if LINE_END in gap and not gap.strip() else gap
        if (ends or put) and LINE_END not in gap:
            gap = gap.rstrip(" \t") + newline + (self._base if after is None else self._indent)
        if put and ends == 2 and gap.count(LINE_END) < 2:
            gap = newline + gap
        return gap


def _joined(out: Sequence[str | Piece]) -> str:
    return "".join(p if isinstance(p, str) else str(p.what) for p in out)
