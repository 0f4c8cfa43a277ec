"""The text of a changed tree: what did not change keeps its bytes, blanks and comments included.

Old and new tree are walked together. A list of nodes that stand on lines of their own is
aligned, and unchanged neighbours keep the very text that they and the room between them had.
Of a node that changed the words in front of, between and behind its lists are compared as its
language prints them; the words that stay keep their text, comments between them stay as well.
What is new is printed. A vendor language says how in a `Layout`.
"""

from __future__ import annotations

import abc
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from difflib import SequenceMatcher
from typing import Any, Final, NamedTuple

from assistant.languages.alignment import aligned, common_ends, same
from assistant.program.text import SourceText

MOST_WORDS: Final = 1 << 14
"""Words of one node that are compared; a longer one that changed is printed as a whole."""
LINE_END: Final = "\n"


@dataclass(frozen=True, slots=True)
class Block:
    """Children that stand on lines of their own, `depth` steps deeper than what holds them."""

    children: tuple[Any, ...]
    depth: int = 1


Sketch = Sequence["str | Block"]
"""How a language prints a node: lines that end with a line feed, with its blocks between them."""


class Extent(NamedTuple):
    """Offsets in the source."""

    start: int
    end: int


class Layout(abc.ABC):
    """What the text of one vendor language looks like.

    words: matches words, and what stands between them; that is what has no group, but for the
    group `note`, a comment. The names of other groups are kinds of words; words of a kind in
    `spelled` may be written in several ways. indent: one step of the printer's.
    """

    words: re.Pattern[str]
    spelled: frozenset[str]
    indent: str

    @abc.abstractmethod
    def sketch(self, node: Any) -> Sketch:
        """The canonical text of a node, without outer indentation."""

    @abc.abstractmethod
    def extent(self, text: str, node: Any) -> Extent | None:
        """Where a node of a block stands, without outer blanks; None if it has no place."""

    @abc.abstractmethod
    def line_ends(self, before: Any, after: Any) -> int | None:
        """How many line ends two neighbours of a block want; None for the ends of the block.

        0 if they must share a line, 1 if they must not, 2 if a blank line looks well between
        new ones, None if anything goes.
        """

    def spread(self, text: str, old: Sequence[Any], new: Sequence[Any]) -> Spread | None:  # noqa: ARG002
        """Nodes that stand for many lines as nodes of one line each; None if there are none."""
        return None


@dataclass(frozen=True, slots=True)
class Spread:
    """Two lists for the comparison. extents: of the nodes of `old`."""

    old: Sequence[Any]
    extents: Sequence[Extent]
    new: Sequence[Any]


def render(source: SourceText, old: Any, new: Any, layout: Layout) -> str:
    """The text of `new`, a tree made from `old`, which was read from the source."""
    return _Writer(source, layout).changed(old, new, Extent(0, len(source.text)))


@dataclass(slots=True)
class _Piece:
    """A word or a block. gap: what is printed in front of it. start, end: in the source.

    A block's extent goes from the word before it to the word behind it.
    """

    what: str | Block
    kind: str
    gap: str = ""
    start: int = -1
    end: int = -1
    key: object = None


class _Writer:
    def __init__(self, source: SourceText, layout: Layout) -> None:
        self._source, self._text, self._layout = source, source.text, layout
        step = re.search(r"^[ \t]+(?=[^\s])", self._text, re.MULTILINE)
        self._step = step[0] if step else layout.indent
        self._extents: dict[int, Extent] = {}  # of nodes that stand for a line of many
        self._spread: list[Spread] = []  # which keeps those nodes alive
        self._lost: list[Any] = []  # nodes that left their place
        self._known: dict[int, Any] = {}  # what they hold, to be found in other places

    # Where things are

    def _extent(self, node: Any) -> Extent:
        extent = self._extents.get(id(node)) or self._layout.extent(self._text, node)
        if extent is None:
            raise ValueError(f"{type(node).__name__} of the tree that was read has no span")
        return extent

    def _indent(self, at: int) -> str | None:
        """The blanks that begin a line, None if something else stands before the offset."""
        begin = self._text.rfind("\n", 0, at) + 1
        before = self._text[begin:at]
        return None if before.strip() else before

    def _line_indent(self, at: int) -> str:
        begin = self._text.rfind("\n", 0, at) + 1
        line = self._text[begin:at]
        return line[: len(line) - len(line.lstrip())]

    def _newline(self, at: int) -> str:
        """The line end that is used at an offset."""
        end = self._text.rfind("\n", 0, at)
        if end < 0:
            end = self._text.find("\n", at)
        if end < 0:
            return self._source.newline
        return "\r\n" if self._text[end - 1 : end] == "\r" else "\n"

    # Words

    def _pieces(self, sketch: Sketch) -> list[_Piece]:
        pieces = []
        for part in sketch:
            if isinstance(part, Block):
                pieces.append(_Piece(part, "block"))
                continue
            at = 0
            for word in self._words(part, 0, len(part)):
                pieces.append(_Piece(word[0], str(word.lastgroup), part[at : word.start()]))
                at = word.end()
        return pieces

    def _words(self, text: str, start: int, end: int) -> Iterator[re.Match[str]]:
        for match in self._layout.words.finditer(text, start, end):
            if match.lastgroup not in (None, "note"):
                yield match

    def _noted(self, gap: str) -> bool:
        return any(m.lastgroup == "note" for m in self._layout.words.finditer(gap))

    def _alike(self, piece: _Piece, word: re.Match[str]) -> bool:
        assert isinstance(piece.what, str)
        if piece.what.casefold() == word[0].casefold():
            return True
        return word.lastgroup == piece.kind and piece.kind in self._layout.spelled

    def _locate(self, pieces: list[_Piece], extent: Extent) -> bool:
        """Finds the pieces in the source; False if their words are not those that stand there."""
        at, waiting, first = extent.start, [], True
        for piece in [*pieces, None]:
            children = piece.what.children if piece and isinstance(piece.what, Block) else None
            if piece is not None and children is None:
                waiting.append(piece)
            elif piece is None or children:
                stop = self._extent(children[0]).start if children else extent.end
                words = list(self._words(self._text, at, stop))
                # What could not be read may stand around a block.
                last = len(words) - len(waiting)
                shifts = [0] if first else [last] if piece is None else range(last + 1)
                if last < 0 or (first and piece is None and last):
                    return False
                for shift in shifts:
                    some = words[shift : shift + len(waiting)]
                    if all(map(self._alike, waiting, some)):
                        break
                else:
                    return False
                for held, word in zip(waiting, some, strict=True):
                    held.start, held.end = word.span()
                if children:
                    at = self._extent(children[-1]).end
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
                    piece.end = self._extent(children[-1]).end if children else at
            at = piece.end
        return True

    def _locate_blocks(self, before: list[_Piece], after: list[_Piece], extent: Extent) -> bool:
        """Finds the blocks between words that are not understood, if only blocks have changed."""
        if [_word(piece) for piece in before] != [_word(piece) for piece in after]:
            return False
        at = extent.start
        for had, has in zip(before, after, strict=True):
            had.start = had.end = at
            if isinstance(had.what, Block) and isinstance(has.what, Block):
                if had.what.children:
                    had.start = self._extent(had.what.children[0]).start
                    had.end = at = self._extent(had.what.children[-1]).end
                elif has.what.children:
                    return False
        return True

    # A node that changed

    def changed(self, old: Any, new: Any, extent: Extent) -> str:
        """The text of a node, from that of the one that it was made from."""
        kept = self._text[extent.start : extent.end]
        if same(old, new):
            return kept
        if type(old) is type(new):
            sketches = self._layout.sketch(old), self._layout.sketch(new)
            if _equal_sketches(*sketches):
                return kept
            if sum(len(p) for s in sketches for p in s if isinstance(p, str)) < 8 * MOST_WORDS:
                before, after = map(self._pieces, sketches)
                text = self._merged(before, after, extent) if before else None
                if text is not None:
                    return text
        self._lost.append(old)
        return self._written(new, self._line_indent(extent.start), self._newline(extent.start))

    def _merged(self, before: list[_Piece], after: list[_Piece], extent: Extent) -> str | None:
        """The old text with the words and blocks that changed; None if that cannot be done."""
        located = self._locate(before, extent)
        if not located and not self._locate_blocks(before, after, extent):
            return None
        _name_blocks(before, after)
        base, newline = self._line_indent(extent.start), self._newline(extent.start)
        for piece in after:
            piece.gap = self._indented(piece.gap, base, newline)
        out: list[str | _Piece] = []
        at = extent.start
        for kind, i1, i2, j1, j2 in _differences(before, after):
            removed, inserted = before[i1:i2], after[j1:j2]
            words = all(isinstance(p.what, str) for p in [*removed, *inserted])
            if kind == "equal" or (len(removed) == len(inserted) and words):
                for had, has in zip(removed, inserted, strict=True):
                    out.append(self._text[at : had.start])
                    if isinstance(has.what, Block):
                        assert isinstance(had.what, Block)
                        inner = Extent(had.start, had.end)
                        out.append(_Piece(self._block(had.what, has.what, inner, base), "text"))
                    else:
                        kept = has.what == had.what
                        out.append(self._text[had.start : had.end] if kept else has.what)
                    at = had.end
                continue
            stop = before[i2].start if i2 < len(before) else extent.end
            self._lost += [c for p in removed if isinstance(p.what, Block) for c in p.what.children]
            following = after[j2].gap if j2 < len(after) else ""
            out += self._replaced(removed, inserted, Extent(at, stop), following, base, newline)
            at = stop
        out.append(self._text[at : extent.end])
        return _joined(out) if not located or self._says(out, after) else None

    def _replaced(
        self,
        removed: list[_Piece],
        inserted: list[_Piece],
        room: Extent,
        following: str,
        base: str,
        newline: str,
    ) -> Iterator[str | _Piece]:
        """New pieces in place of old ones. room: from the last piece that stays to the next."""
        marks = [room.start, *(at for p in removed for at in (p.start, p.end)), room.end]
        gaps = [self._text[a:b] for a, b in zip(marks[::2], marks[1::2], strict=True)]
        first, last = gaps[0] if removed else "", gaps[-1]
        notes = "".join(gap for gap in gaps[1:-1] if self._noted(gap))
        begins, ends = room.start == marks[1] and not first, room.end == marks[-2] and not last
        if not inserted:
            yield from (g for g in (first if self._noted(first) else "", notes) if g)
            if self._noted(last) or self._noted(first) or notes:
                yield last
            elif not (begins and not following) and not ends:
                by_length = sorted((first, last), key=len)
                yield by_length[1] if following else by_length[0]
            return
        for number, piece in enumerate(inserted):
            yield first if number == 0 and removed else piece.gap
            if isinstance(piece.what, Block):
                yield _Piece(self._new_block(piece.what, base, newline), "text")
            else:
                yield piece.what
        yield notes
        if isinstance(inserted[-1].what, Block) and not last.strip():
            return
        lacking = following if not last or (LINE_END in following and LINE_END not in last) else ""
        yield lacking or last

    def _says(self, out: list[str | _Piece], after: list[_Piece]) -> bool:
        """Whether a text reads as the words that it should."""
        stretches: list[list[str]] = [[]]
        for part in out:
            if isinstance(part, _Piece):
                stretches.append([])
            else:
                stretches[-1].append(part)
        wanted: list[list[_Piece]] = [[]]
        for piece in after:
            if isinstance(piece.what, Block):
                wanted.append([])
            else:
                wanted[-1].append(piece)
        if len(wanted) != len(stretches):
            return False
        for pieces, stretch in zip(wanted, stretches, strict=True):
            text = "".join(stretch)
            words = list(self._words(text, 0, len(text)))
            if len(words) != len(pieces) or not all(map(self._alike, pieces, words)):
                return False
        return True

    # Lists of nodes on lines of their own

    def _block(self, old: Block, new: Block, room: Extent, base: str) -> str:
        """The text from the word before a block to the word behind it."""
        if old.children is new.children or old.children == new.children:
            return self._text[room.start : room.end]
        entries = _Entries(self, room, base, base + self._step * new.depth)
        head, tail = common_ends(old.children, new.children)
        middle_old = old.children[head : len(old.children) - tail]
        middle_new = new.children[head : len(new.children) - tail]
        spread = self._layout.spread(self._text, middle_old, middle_new)
        if spread is not None:
            self._spread.append(spread)
            self._extents |= {id(n): e for n, e in zip(spread.old, spread.extents, strict=True)}
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
        if id(node) in self._known and (extent := self._layout.extent(self._text, node)):
            return self._text[extent.start : extent.end]
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
        text, extent = w._text, w._extent
        if old:
            indents = (w._indent(extent(node).start) for node in old)
            self._indent = next((i for i in indents if i is not None), self._indent)
        newline = w._newline(room.start)
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
                if last >= 0 and (here := w._indent(extent(old[last]).start)) is not None:
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
        text, extent = self._writer._text, self._writer._extent
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


def _word(piece: _Piece) -> str | None:
    return piece.what if isinstance(piece.what, str) else None


def _joined(out: Sequence[str | _Piece]) -> str:
    return "".join(p if isinstance(p, str) else str(p.what) for p in out)


def _equal_sketches(a: Sketch, b: Sketch) -> bool:
    if len(a) != len(b):
        return False
    return all(
        x is y or (x == y if isinstance(x, str) else isinstance(y, Block) and _same_block(x, y))
        for x, y in zip(a, b, strict=True)
    )


def _same_block(a: Block, b: Block) -> bool:
    return len(a.children) == len(b.children) and all(map(same, a.children, b.children))


def _name_blocks(before: list[_Piece], after: list[_Piece]) -> None:
    """Gives blocks that belong together the same key, words their own text."""
    for piece in [*before, *after]:
        piece.key = piece.what if isinstance(piece.what, str) else id(piece)
    had, has = ([p for p in pieces if isinstance(p.what, Block)] for pieces in (before, after))
    if len(had) == len(has):
        pairs = list(zip(had, has, strict=True))
    else:
        pairs = []
        for new in has:
            mine = {id(child) for child in new.what.children}  # type: ignore[union-attr]
            for old in had:
                theirs = (id(child) for child in old.what.children)  # type: ignore[union-attr]
                if not mine.isdisjoint(theirs) or new.what == old.what:
                    pairs.append((old, new))
                    had.remove(old)
                    break
    for old, new in pairs:
        new.key = old.key


def _differences(
    before: list[_Piece], after: list[_Piece]
) -> Iterator[tuple[str, int, int, int, int]]:
    """Like difflib's opcodes, equal ends first, which also settles which of alike words stay."""
    most = min(len(before), len(after))
    head = tail = 0
    while head < most and before[head].key == after[head].key:
        head += 1
    while tail < most - head and before[-1 - tail].key == after[-1 - tail].key:
        tail += 1
    a = [p.key for p in before[head : len(before) - tail]]
    b = [p.key for p in after[head : len(after) - tail]]
    yield "equal", 0, head, 0, head
    if len(a) * len(b) > MOST_WORDS * 64:
        yield "replace", head, head + len(a), head, head + len(b)
    else:
        for kind, i1, i2, j1, j2 in SequenceMatcher(None, a, b, autojunk=False).get_opcodes():
            yield kind, head + i1, head + i2, head + j1, head + j2
    yield "equal", head + len(a), len(before), head + len(b), len(after)
