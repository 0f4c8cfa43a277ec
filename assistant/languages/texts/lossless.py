"""Text of a changed tree: unchanged nodes keep their bytes, blanks and comments included.

Old and new tree are compared in parallel. A list of nodes on separate lines is aligned, and
unchanged neighbours keep the exact text of the nodes and of the space between them. For a node that
changed, the words before, between and after its lists are compared as the language prints them;
words that stay keep their text, and comments between them stay as well. New words are printed. A
vendor language describes its printing in a `Layout`; a changed run of similar lines is compared
with each line as a node.
"""

from __future__ import annotations

import abc
import re
from collections.abc import Iterator, Sequence
from dataclasses import field, fields, is_dataclass
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Rows
from assistant.base.data_classes import dataclass
from assistant.base.source_text import SourceText, lines_of
from assistant.languages.texts import printed_trees
from assistant.languages.texts.printed_trees import (
    MOST_WORDS,
    Block,
    Extent,
    Layout,
    Piece,
    Sketch,
    Spread,
    aligned,
    common_ends,
    differences,
    equal_sketches,
    name_blocks,
    pieces_of,
    same,
    same_word,
    spelling,
)
from assistant.languages.texts.words import Word


class Original:
    """A source with the extents of its nodes, as offsets into its text."""

    def __init__(self, source: SourceText, layout: Layout) -> None:
        self.text, self._newline, self._layout = source.text, source.newline, layout
        self.extents: dict[int, Extent] = {}
        """Extents of nodes that represent one line of many, by the id of the node."""

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
        """Locate the pieces in the source; False if their words are not the source's words."""
        at, waiting, first = extent.start, [], True
        # The words before a block, or before the end, have to be those of the source up to there.
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
        # A block reaches from the word before it to the word after it.
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


__all__ = ["Block", "Extent", "Layout", "Sketch", "Spread", "render"]

_LINE_END: Final = "\n"


def render(source: SourceText, old: Any, new: Any, layout: Layout) -> str:
    """The text of `new`, a tree made from `old`, which was read from the source."""
    return _Writer(source, layout).changed(old, new, Extent(0, len(source.text)))


class _Writer:
    def __init__(self, source: SourceText, layout: Layout) -> None:
        self._source, self._layout = Original(source, layout), layout
        # New lines are indented as the first indented line of the source is.
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
            # Long nodes are printed anew: comparing their words takes quadratic time.
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
            # Words that take each other's place one by one leave the text between them as it is.
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
        # If the words were not located, only blocks were exchanged: there are no words to compare.
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
        # The gaps before, between and after the old pieces hold blanks, and comments that have to
        # stay.
        marks = [room.start, *(at for p in removed for at in (p.start, p.end)), room.end]
        gaps = [self._source.text[a:b] for a, b in zip(marks[::2], marks[1::2], strict=True)]
        first, last = gaps[0] if removed else "", gaps[-1]
        notes = "".join(gap for gap in gaps[1:-1] if self._layout.noted(gap))
        begins, ends = room.start == marks[1] and not first, room.end == marks[-2] and not last
        if not inserted:
            yield from (g for g in (first if self._layout.noted(first) else "", notes) if g)
            if self._layout.noted(last) or self._layout.noted(first) or notes:
                yield last
            # One of the two gaps that meet is enough.
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
        lacking = (
            following if not last or (_LINE_END in following and _LINE_END not in last) else ""
        )
        yield lacking or last

    def _says(self, out: list[str | Piece], after: list[Piece]) -> bool:
        """True if the text consists of the expected words."""
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
        """Return the text from the word before a block to the word after it."""
        if old.children is new.children or old.children == new.children:
            return self._source.text[room.start : room.end]
        entries = _Entries(self, room, base, base + self._step * new.depth)
        # Equal ends are most of a long list, and cost no comparison.
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
        if _LINE_END not in text:
            return text
        head, *lines = text.split(_LINE_END)
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
        """Return the text that stays between two nodes once those between them are removed."""
        text, extent = self._writer._source.text, self._writer._source.extent
        marks = [start, *(at for node in removed for at in extent(node)), end]
        gaps = [text[a:b] for a, b in zip(marks[::2], marks[1::2], strict=True)]
        first, last = gaps[0], gaps[-1]
        if len(gaps) == 1:
            return first
        if any(gap.strip() for gap in gaps):  # what could not be read
            return "".join([first, *(g for g in gaps[1:-1] if g.strip()), last])
        if _LINE_END in first and _LINE_END in last:
            return first[: first.rindex(_LINE_END) + 1] + last[last.index(_LINE_END) + 1 :]
        # A line end counts more than any number of blanks.
        return max((first, last), key=lambda gap: (_LINE_END in gap, len(gap)))

    def _mended(self, gap: str, before: Any, after: Any, put: bool, newline: str) -> str:
        """The room between two neighbours, one of which is not what it was."""
        ends = self._writer._layout.line_ends(before, after)
        if ends == 0:
            return " " if _LINE_END in gap and not gap.strip() else gap
        if (ends or put) and _LINE_END not in gap:
            gap = gap.rstrip(" \t") + newline + (self._base if after is None else self._indent)
        if put and ends == 2 and gap.count(_LINE_END) < 2:
            gap = newline + gap
        return gap


def _joined(out: Sequence[str | Piece]) -> str:
    return "".join(p if isinstance(p, str) else str(p.what) for p in out)


_MOST_ROWS: Final = 4096
"""Rows of a run that are written one by one; if more of it changed it is printed as a whole."""


@dataclass(frozen=True, slots=True)
class RunRow:
    """A row of a run. key: its content, for comparison; text: as it is printed."""

    key: str
    text: str = field(compare=False)


@dataclass(frozen=True, slots=True, eq=False)
class _UnchangedRows:
    """Rows of a run that did not change."""


class RunLayout(printed_trees.Layout):
    """Layout of a language whose tree has nodes for runs of similar lines.

    row_end: last character of each row. note: first characters of a comment.
    """

    row_end: str
    note: str

    @abc.abstractmethod
    def is_run(self, node: Any) -> bool:
        """True if a node is a run; its rows are in `run`."""

    @abc.abstractmethod
    def may_be_row(self, node: Any) -> bool:
        """True if a node could be a row of a run."""

    def spread(self, text: str, old: Sequence[Any], new: Sequence[Any]) -> Spread | None:
        """Runs as their rows, those that stay in both lists together."""
        shared = {id(node) for node in old} & {id(node) for node in new}
        mine = [node for node in old if id(node) not in shared]
        other = [node for node in new if id(node) not in shared]
        if not any(self.is_run(node) for node in (*mine, *other)):
            return None
        if len(mine) == len(other) == 1 and type(mine[0]) is type(other[0]):
            spread = self._of_one_run(text, mine[0], other[0])
            if spread is None or len(old) == len(new) == 1:
                return spread
            i, j = old.index(mine[0]), new.index(other[0])
            places = [self._place(text, node) for node in old]
            return Spread(
                (*old[:i], *spread.old, *old[i + 1 :]),
                (*places[:i], *spread.extents, *places[i + 1 :]),
                (*new[:j], *spread.new, *new[j + 1 :]),
            )
        return self._of_many(text, old, new, shared)

    def _place(self, text: str, node: Any) -> Extent:
        extent = self.extent(text, node)
        if extent is None:
            raise ValueError(f"{type(node).__name__} of the tree that was read has no span")
        return extent

    def _of_one_run(self, text: str, old: Any, new: Any) -> Spread | None:
        """A run that was changed: only the rows that are different."""
        had, has = self._lines(old), self._lines(new)
        places = self._row_places(text, old, len(had))
        if places is None:
            return None
        # With the same number of rows, those that differ are exchanged; otherwise all between the
        # equal ends.
        if len(had) == len(has):
            differ = [k for k, (a, b) in enumerate(zip(had, has, strict=True)) if a != b]
            stretches = [(k, k + 1, k, k + 1) for k in differ]
        else:
            most = min(len(had), len(has))
            head = next((k for k in range(most) if had[k] != has[k]), most)
            tails = range(1, most - head + 1)
            tail = next((k - 1 for k in tails if had[-k] != has[-k]), most - head)
            stretches = [(head, len(had) - tail, head, len(has) - tail)]
        if sum(i2 - i1 + j2 - j1 for i1, i2, j1, j2 in stretches) > _MOST_ROWS:
            return None
        olds: list[Any] = []
        news: list[Any] = []
        extents: list[Extent] = []
        at = 0
        for i1, i2, j1, j2 in (*stretches, (len(had), len(had), len(has), len(has))):
            if i1 > at:
                olds.append(rows := _UnchangedRows())
                news.append(rows)
                extents.append(Extent(int(places[at, 0]), int(places[i1 - 1, 1])))
            olds += [RunRow(line, line) for line in had[i1:i2]]
            news += [RunRow(line, line) for line in has[j1:j2]]
            extents += [Extent(*map(int, places[k])) for k in range(i1, i2)]
            at = i2
        return Spread(olds, extents, news)

    def _of_many(
        self, text: str, old: Sequence[Any], new: Sequence[Any], shared: set[int]
    ) -> Spread | None:
        """Spread runs next to single rows: each row as a node, equal if its spelling is equal."""
        if sum(len(n.run) for n in (*old, *new) if self.is_run(n)) > _MOST_ROWS:
            return None
        spelled = any(id(node) not in shared and self.may_be_row(node) for node in new)
        olds: list[Any] = []
        news: list[Any] = []
        extents: list[Extent] = []
        for node in old:
            place = self._place(text, node)
            if id(node) in shared or not (self.is_run(node) or self.may_be_row(node)):
                olds.append(node)
                extents.append(place)
                continue
            lines = self._lines(node)
            places = self._row_places(text, node, len(lines))
            if places is None:
                return None
            for line, (start, end) in zip(lines, places.tolist(), strict=True):
                olds.append(RunRow(self._key(text[start:end] if spelled else line), line))
                extents.append(Extent(start, end))
        for node in new:
            if id(node) in shared or not (self.is_run(node) or self.may_be_row(node)):
                news.append(node)
            else:
                news += [RunRow(self._key(line), line) for line in self._lines(node)]
        return Spread(olds, extents, news)

    def _lines(self, node: Any) -> list[str]:
        return lines_of("".join(str(part) for part in self.sketch(node)))

    def _key(self, line: str) -> str:
        return " ".join(word.text for word in self.words(line, 0, len(line)))

    def _row_places(self, text: str, node: Any, rows: int) -> Rows | None:
        """Return offsets (n, 2) of each row, None if a quick scan cannot separate them."""
        place = self._place(text, node)
        if rows == 1:
            return np.array([place])
        inner = text[place.start : place.end]
        if not inner.isascii() or self.note in inner or inner.count(self.row_end) != rows:
            return None
        data = np.frombuffer(inner.encode("ascii"), dtype=np.uint8)
        ends = np.flatnonzero(data == ord(self.row_end)) + 1
        starts = np.concatenate([[0], ends[:-1]])
        # Blanks in front of all rows at once, a column of characters each turn.
        while (blank := data[starts] <= ord(" ")).any():
            starts += blank
        return np.stack([starts, ends], axis=1) + place.start
