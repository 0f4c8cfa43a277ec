"""Text of languages with one statement a line: new files, changed files, and their layout.

A line has a step number or none, code, and a comment after it. Words of the code that stay keep
their bytes with the blanks between them; a new line is indented like those around it at the same
block level. Lines of one kind may form tables, `Run`s: rows of a changed table that did not change
keep their bytes. `lay_out` gives a file the standard blanks, indentation and comment columns.
"""

from __future__ import annotations

import abc
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from difflib import SequenceMatcher
from typing import Any, Final, TypeVar

import numpy as np

from assistant.base.arrays import Ints, Rows
from assistant.base.data_classes import dataclass
from assistant.base.source_text import SourceText, dominant_newline, one_line
from assistant.languages.line_blocks import NO_WORD, Block, BlockWord, blocks_of
from assistant.languages.runs.columns import Run, joined_runs, rows_of
from assistant.languages.runs.row_text import after_digits
from assistant.languages.texts.layout import INDENT, TAB, LaidOutLine, align_comments
from assistant.languages.texts.printed_trees import aligned, same
from assistant.languages.texts.words import Word

_PARTS: Final = re.compile(r"([ \t]*)([0-9]*)([ \t\f]*)")


@dataclass(frozen=True, slots=True)
class Line:
    """Content of a line.

    number: of the step. code: can be compared, None without code. comment: with its mark.
    """

    number: int | None
    code: Any
    comment: str | None

    @property
    def is_comment(self) -> bool:
        """True if it is only a comment."""
        return self.code is None and self.comment is not None


class Code(abc.ABC):
    """Text form of a language's code lines."""

    @abc.abstractmethod
    def printed(self, code: Any) -> str:
        """Its canonical text."""

    @abc.abstractmethod
    def words(self, text: str) -> Sequence[Word]:
        """The words of code that can be read."""

    @abc.abstractmethod
    def spaced(self, words: Sequence[Word]) -> str:
        """Words of code as they are to be spelled, with the blanks that belong between them."""

    @abc.abstractmethod
    def key(self, word: Word) -> object:
        """Return the meaning of a word, independent of its spelling."""

    @abc.abstractmethod
    def says(self, text: str, code: Any) -> bool:
        """True if a text is read as exactly that code."""


@dataclass(frozen=True, slots=True)
class _Parts:
    """The text of a code line: what stands before its number, the number, and so on to its end."""

    margin: str
    number: str
    indent: str
    code: str
    gap: str
    comment: str
    trail: str

    @property
    def text(self) -> str:
        return "".join(
            (self.margin, self.number, self.indent, self.code, self.gap, self.comment, self.trail)
        )


def _parts_of(text: str, line: Line) -> _Parts:
    """The parts of a line that was read. text: with its line end."""
    plain = text.rstrip("\r\n").rstrip()
    trail = text[len(plain) :]
    comment = line.comment or ""
    plain = plain.removesuffix(comment) if comment else plain
    found = _PARTS.match(plain)
    assert found is not None
    margin, number, indent = found.groups() if line.number is not None else ("", "", "")
    if line.number is None:
        indent = plain[: len(plain) - len(plain.lstrip(" \t\f"))]
    rest = plain[len(margin) + len(number) + len(indent) :]
    code = rest.rstrip(" \t\f")
    return _Parts(margin, number, indent, code, rest[len(code) :], comment, trail)


def _changed_line(parts: _Parts, old: Line, new: Line, language: Code) -> str:
    """The text of `new` in that of `old`, which has those parts."""
    if new.number != old.number:
        number = "" if new.number is None else str(new.number)
        indent = parts.indent
        # A number that appears or disappears takes the blank after it along.
        if old.number is None:
            indent = " " + indent
        elif new.number is None:
            indent = indent[1:]
        parts = replace(parts, number=number, indent=indent)
    if new.code != old.code:
        parts = replace(parts, code=_changed_code(parts.code, old.code, new.code, language))
        if old.code is None and parts.comment:
            parts = replace(parts, gap=" ")
        elif not parts.code:
            parts = replace(parts, gap="")
    if new.comment != old.comment:
        behind = bool(parts.code or parts.number)
        gap = parts.gap
        if old.comment is None:
            gap = " " * (behind and not parts.indent.endswith(" "))
            gap = " " if parts.code else gap
        parts = replace(parts, gap=gap if new.comment else "", comment=one_line(new.comment or ""))
    return parts.text


def _changed_code(text: str, old: Any, new: Any, language: Code) -> str:
    """The code of `new`, with the words of `text` that stay."""
    after = language.printed(new)
    if not text or not after:
        return after
    before, here = language.words(language.printed(old)), language.words(text)
    edited = _edited_words(text, here, before, after, language.words(after), language.key)
    # Edits of words may change the meaning of the line; then it is printed as a whole.
    return after if edited is None or not language.says(edited, new) else edited


def _edited_words(
    text: str,
    here: Sequence[Word],
    old: Sequence[Word],
    after: str,
    new: Sequence[Word],
    key: Callable[[Word], object],
) -> str | None:
    """Return the text with the edits that lead from the printed old line to the printed new one.

    here: words of the text. after, new: the new line as it is printed, and its words. key: key by
    which words are compared. None if a changed part is not in the text as it is printed.
    """
    # Word of the text for each word of the printed old line.
    place: dict[int, int] = {}
    mine, theirs = ([key(word) for word in listed] for listed in (old, here))
    for block in SequenceMatcher(None, mine, theirs, autojunk=False).get_matching_blocks():
        place |= {block.a + k: block.b + k for k in range(block.size)}
    steps = SequenceMatcher(None, [w.text for w in old], [w.text for w in new], autojunk=False)
    edits: list[tuple[int, int, str]] = []
    for step, i1, i2, j1, j2 in steps.get_opcodes():
        if step == "equal":
            continue
        # An insertion follows the word before it, which has to be in the text as well.
        first = i1 if i1 < i2 else i1 - 1
        if not all(at in place for at in (*range(i1, i2), first) if at >= 0):
            return None
        if step == "replace":
            start, end = here[place[i1]].start, here[place[i2 - 1]].end
            edits.append((start, end, after[new[j1].start : new[j2 - 1].end]))
        elif i1 == 0:  # at the very beginning
            end = here[place[i2]].start if step == "delete" and i2 in place else 0
            tail = after[new[j2 - 1].end : new[j2].start] if j2 and j2 < len(new) else ""
            edits.append((0, end, after[: new[j2 - 1].end] + tail if step == "insert" else ""))
        elif i1 - 1 in place:
            start = here[place[i1 - 1]].end
            end = here[place[i2 - 1]].end if step == "delete" else start
            put = after[new[j1 - 1].end : new[j2 - 1].end] if step == "insert" else ""
            edits.append((start, end, put))
        else:
            return None
    # From the last to the first, so that the offsets of those in front stay right.
    for start, end, put in reversed(edits):
        text = text[:start] + put + text[end:]
    return text


class _Indentation:
    """Indentation of lines at each level of blocks."""

    def __init__(self) -> None:
        self._known: dict[int, str] = {}

    def __contains__(self, level: int) -> bool:
        return level in self._known

    def note(self, level: int, indent: str) -> None:
        """Keeps in mind how the last line was indented that stands at a level."""
        self._known[level] = indent

    def of(self, level: int) -> str:
        """The blanks in front of a new line's code, as they are written around."""
        known = [one for one in self._known if one <= level]
        if not known:
            # One blank after the step number, besides the indentation.
            return " " * (1 + INDENT * level)
        nearest = max(known)
        return self._known[nearest] + " " * (INDENT * (level - nearest))


def _partners(
    old: Sequence[Any], new: Sequence[Any], said: Callable[[Any], object]
) -> list[int | None]:
    """For each item the index of the one that it was made from, None for a new one.

    said: what has to be equal of two that are the same; what is left over between such is taken
    for what it is like.
    """
    return [
        k if k is not None and type(old[k]) is type(item) else None
        for k, item in zip(aligned(old, new, said), new, strict=True)
    ]


class LinePrinter(Code, abc.ABC):
    """Prints the items of a file in its language.

    Lines of one kind may be in tables. table: those of the program, with their step numbers.
    number: the column of tables of data that identifies the row. blocks: true if lines are indented
    by the blocks around them. most: bytes of a line that controllers take.
    """

    items: Sequence[Any]
    table: type[Run]
    number: str
    blocks: bool
    most: int

    @abc.abstractmethod
    def line(self, item: Any) -> Line | None:
        """Return the content of a line of the program, with hashable code; None for other items."""

    @abc.abstractmethod
    def word(self, code: Any) -> BlockWord:
        """Return the role in blocks of the code of a line."""

    @abc.abstractmethod
    def text(self, at: int, newline: str, level: int = 0) -> str:
        """Prints the item at an index with its line ends.

        Raises ValueError for a table with a number that none is printed as.
        """

    @abc.abstractmethod
    def respelled(self, at: int, text: str) -> str:
        """The text of an item that is neither a line of the program nor a table, laid out."""

    @abc.abstractmethod
    def rows(self, table: Any, newline: str, indent: int) -> Callable[[Any], str]:
        """Prints rows of a table. indent: blanks more behind the numbers of lines."""

    @abc.abstractmethod
    def as_data(self, item: Any) -> Run | None:
        """A table of data as it is, a line that could be in one as a table, None for others."""

    def levels(self, said: Sequence[Line | None]) -> list[int]:
        """The level of each item, from 0; what is closed but was never opened is passed over."""
        if not self.blocks:
            return [0] * len(said)
        words = [NO_WORD if line is None else self.word(line.code) for line in said]
        blocks = blocks_of(enumerate(words))
        made: list[int] = []
        routine, choice = 0, False
        for at, (line, word) in enumerate(zip(said, words, strict=True)):
            if word.bounds:
                routine = 0
            block = blocks.around[at]
            level = routine if block is None else routine + _level_in_blocks(block, at)
            routine = 1 if word.bounds == "begins" else routine
            if line is not None and line.is_comment:
                level -= choice  # before the first part it is that one's
            elif line is not None:
                choice = bool(word.opens) and word.form == "choice"
                level = max(level - 1, 0) if word.parts else level
            made.append(level)
        return made


def _level_in_blocks(block: Block, at: int) -> int:
    """Return the extra depth of a line in its blocks; in a choice two levels a part."""
    open_there = (one for one in block.chain if one.crossed is None or at < one.crossed)
    return sum(2 if one.form == "choice" else 1 for one in open_there)


def print_items(lines: LinePrinter, newline: str) -> Iterator[str]:
    """The text of each item of a new file, with its line ends."""
    said = list(map(lines.line, lines.items))
    for at, (line, level) in enumerate(zip(said, lines.levels(said), strict=True)):
        text = lines.text(at, newline, level)
        if line is not None and len(text.rstrip("\r\n").encode(errors="replace")) > lines.most:
            text = lines.text(at, newline)  # rather than too long
        yield text


R = TypeVar("R", bound=Run)

_SEGMENTS: Final = 1 << 16
"""Pieces of text that are put together at a time."""


@dataclass(frozen=True, slots=True)
class _RunLines:
    """The text of a run and where its lines begin and end, offsets (n,)."""

    text: bytes
    starts: Rows
    ends: Rows

    @classmethod
    def of(cls, text: str) -> _RunLines:
        data = text.encode("ascii")
        ends = np.flatnonzero(np.frombuffer(data, dtype=np.uint8) == ord("\n")) + 1
        return cls(data, np.concatenate([[0], ends])[:-1].astype(np.intp), ends)

    def digits(self) -> Rows:
        """The offsets behind the number that each line begins with."""
        return after_digits(np.frombuffer(self.text, dtype=np.uint8), self.starts)


def merged_run_text(
    new: R, old: R, text: str, at: Rows, fresh: Callable[[R], str], number: str | None = None
) -> str:
    """Return the lines of a run made from another, which was read from a text.

    at: (n,) row of the old run that each row may be, -1 for a new row. fresh: prints the lines of
    new rows. number: column of the numbers that lines begin with; a line of which only the number
    changed keeps the rest of its text.
    """
    lines = _RunLines.of(text)
    kept = old.equal(at, new)
    moved = ~kept & old.equal(at, new, {number}) if number is not None else np.zeros_like(kept)
    if kept.all():
        return _gather_pieces(lines.text, lines.starts[at], lines.ends[at])
    printed = _RunLines.of(fresh(new.rows(~kept)))
    # The two texts are joined: offsets of printed lines count from the end of the old text.
    base = len(lines.text)
    # A line of which only the number changed has two pieces: its new number and its old rest.
    starts, ends = np.zeros((2, len(new), 2 if moved.any() else 1), dtype=np.int64)
    starts[kept, 0], ends[kept, 0] = lines.starts[at[kept]], lines.ends[at[kept]]
    starts[~kept, 0], ends[~kept, 0] = printed.starts + base, printed.ends + base
    if moved.any():
        ends[moved, 0] = printed.digits()[moved[~kept]] + base
        starts[moved, 1], ends[moved, 1] = lines.digits()[at[moved]], lines.ends[at[moved]]
    return _gather_pieces(lines.text + printed.text, starts.ravel(), ends.ravel())


def _gather_pieces(text: bytes, starts: Ints, ends: Ints) -> str:
    """Pieces of a text one behind the other."""
    letters = np.frombuffer(text, dtype=np.uint8)
    parts = []
    for first in range(0, len(starts), _SEGMENTS):
        part = slice(first, first + _SEGMENTS)
        lengths = ends[part] - starts[part]
        # Each byte of the result has an offset in the text: the shift of its piece plus its place.
        shifts = starts[part] - np.cumsum(lengths) + lengths
        index = np.repeat(shifts, lengths) + np.arange(lengths.sum())
        parts.append(letters[index].tobytes())
    return b"".join(parts).decode("ascii")


def render_changed_file(source: SourceText, old: Sequence[Any], lines: LinePrinter) -> str:
    """The text of items that were made from old ones, which were read from the source."""
    newline = dominant_newline(source.text) if "\n" in source.text else source.newline
    parts: list[str] = []
    for part in _FileChanges(source.text, old, lines, newline).texts():
        if parts and parts[-1] and not parts[-1].endswith("\n"):
            parts.append(newline)  # the last line of a file may have no line end
        parts.append(part)
    return "".join(parts)


class _FileChanges:
    """The items of a file against those that were read from its text. newline: of new lines."""

    def __init__(self, text: str, old: Sequence[Any], lines: LinePrinter, newline: str) -> None:
        self._text, self._old, self._new = text, old, lines.items
        self._lines, self._newline = lines, newline
        self._as_line = {id(item): lines.line(item) for item in (*old, *self._new)}
        self._partner = _partners(old, self._new, self._said)
        kept = {
            at
            for at, item in zip(self._partner, self._new, strict=True)
            if at is not None and same(old[at], item)
        }
        self._lost = [
            (rows, text if (text := self._source(item)).endswith("\n") else text + newline)
            for at, item in enumerate(old)
            if at not in kept and (rows := lines.as_data(item)) is not None
        ]
        self._indents = _Indentation()
        # The first line of each level counts, until a later one shows otherwise.
        for item, level in zip(old, self._levels(old), strict=True):
            if level not in self._indents:
                self._note(item, self._source(item), level)

    def _levels(self, items: Sequence[Any]) -> Sequence[int]:
        return self._lines.levels([self._as_line[id(item)] for item in items])

    def _said(self, item: Any) -> object:
        """Return the content of an item without its numbers; it can be compared and hashed."""
        if isinstance(item, self._lines.table):
            return item.said({"steps"})
        line = self._as_line[id(item)]
        return item if line is None else (line.code, line.comment)

    def _note(self, item: Any, text: str, level: int) -> None:
        """Keeps in mind how lines as deep are indented."""
        if isinstance(item, self._lines.table):
            first = _parts_of(text[: text.index("\n")], Line(0, None, None))
            self._indents.note(level, first.indent)
        elif (line := self._as_line[id(item)]) is not None and line.code is not None:
            self._indents.note(level, _parts_of(text, line).indent)

    def texts(self) -> Iterator[str]:
        """The text of each item, with its line ends."""
        levels = self._levels(self._new)
        for k, (item, at, level) in enumerate(zip(self._new, self._partner, levels, strict=True)):
            old = None if at is None else self._old[at]
            if old is not None and same(old, item):
                text = self._source(old)
                self._note(old, text, level)
                yield text
            else:
                changed = self._changed(item, old, level)
                yield self._indented(k, level) if changed is None else changed

    def _source(self, item: Any) -> str:
        return self._text[item.span.start : item.span.end]

    def _changed(self, item: Any, old: Any, level: int) -> str | None:
        """An item that is not what it was, None for one that is new."""
        was, now = self._as_line.get(id(old)), self._as_line[id(item)]
        if was is not None and now is not None:
            text = _changed_line(_parts_of(self._source(old), was), was, now, self._lines)
            self._note(item, text, level)
            return text
        if isinstance(item, self._lines.table) and isinstance(old, self._lines.table):
            text = self._source(old)
            self._note(old, text, level)
            deep = len(self._indents.of(level)) - 1
            return self._rows(item, [(old, text)], deep)
        rows = self._lines.as_data(item)
        return None if rows is None or not self._lost else self._rows(rows, self._lost, 0)

    def _rows(self, new: Run, olds: Sequence[tuple[Run, str]], indent: int) -> str:
        """The lines of a table made from others, which were read from the texts beside them."""
        fresh = self._lines.rows(new, self._newline, indent)
        fitting = [(rows, text) for rows, text in olds if rows.fits(new)]
        if not fitting:
            return fresh(new)
        old, text = joined_runs([rows for rows, _ in fitting]), "".join(text for _, text in fitting)
        steps = isinstance(new, self._lines.table)
        number = "steps" if steps else self._lines.number
        # With the same number of rows only the steps changed; otherwise steps identify the rows.
        if steps and len(old) == len(new):
            at = np.arange(len(new))
        else:
            at = rows_of(getattr(old, number), getattr(new, number))
        return merged_run_text(new, old, text, at, fresh, number if steps else None)

    def _indented(self, at: int, level: int) -> str:
        """A new item, a line as deep as those around it."""
        printed = self._lines.text(at, self._newline)
        line = self._as_line[id(self._new[at])]
        if line is None or not (line.code or line.comment):
            return printed
        number = "" if line.number is None else str(line.number)
        indent = self._indents.of(level)
        if not number and level not in self._indents:
            indent = indent.removeprefix(" ")
        return number + (indent or " " * bool(number)) + printed.removeprefix(number).lstrip(" ")


def lay_out(source: SourceText, lines: LinePrinter) -> str:
    """The text of items that were read from a source in the one layout; idempotent.

    Line ends become the ones that most lines have.
    """
    return "".join(_FileLayout(source, lines).pieces())


class _FileLayout:
    """The lines of one file. above, below: indices of the lines of code next to each item."""

    def __init__(self, source: SourceText, lines: LinePrinter) -> None:
        self._lines, self._items = lines, lines.items
        self._text, self._encoding = source.text, source.encoding
        self._newline = dominant_newline(source.text)
        self._said = list(map(lines.line, lines.items))
        places = range(len(lines.items))
        self._above = dict(self._next_to(places))
        self._below = dict(self._next_to(reversed(places)))

    def _next_to(self, places: Iterable[int]) -> Iterator[tuple[int, int | None]]:
        """Each place with the last line of code before it, nothing but lines between them."""
        code: int | None = None
        for at in places:
            yield at, code
            line = self._said[at]
            if line is None and self._source(at).strip():
                code = None
            elif line is not None and not line.is_comment:
                code = at

    def pieces(self) -> Iterator[str]:
        """Lines with their ends; a table is one piece."""
        waiting: list[LaidOutLine] = []
        levels = self._lines.levels(self._said)
        for at, (line, level) in enumerate(zip(self._said, levels, strict=True)):
            if line is not None:
                waiting.append(self._line(at, line, level))
                continue
            yield from self._aligned(waiting)
            waiting = []
            yield self._other(at, level)
        yield from self._aligned(waiting)

    # Levels

    def _heads_division(self, comment: int) -> bool:
        """True if a comment belongs to a line below that divides a block, not to the code above.

        This holds if it is in the column of that word and the code above is not.
        """
        above, below = self._above[comment], self._below[comment]
        if below is None or not self._word(below).parts:
            return False
        word = NO_WORD if above is None else self._word(above)
        if word.parts or word.opens:
            return False  # that one comes to stand at the same column
        column = self._column(comment)
        return column == self._column(below) and (above is None or column != self._column(above))

    def _word(self, at: int) -> BlockWord:
        line = self._said[at]
        return NO_WORD if line is None else self._lines.word(line.code)

    def _column(self, at: int) -> int:
        """The column at which the text behind the number begins."""
        return len(_indent(self._parts(at)).expandtabs(TAB))

    # Lines

    def _source(self, at: int) -> str:
        span = self._items[at].span
        return self._text[span.start : span.end].rstrip("\r\n")

    def _parts(self, at: int) -> _Parts:
        line = self._said[at]
        assert line is not None
        return _parts_of(self._source(at), line)

    def _line(self, at: int, line: Line, level: int) -> LaidOutLine:
        if self._lines.blocks and line.is_comment:
            level -= self._heads_division(at)
        parts = self._parts(at)
        body = self._lines.spaced(self._lines.words(parts.code)) or parts.comment
        number = "" if line.number is None else str(line.number)
        lead = f"{number} " if number and body else number
        indented, before = " " * (INDENT * level) + body, _indent(parts)
        if not self._lines.blocks:  # comments stand under each other as a whole
            lead, indented, before = "", lead + indented, parts.margin + parts.number + parts.indent
        made = LaidOutLine(indented, lead=lead)
        if parts.code and parts.comment:
            made.put_behind(parts.comment, before + parts.code + parts.gap)
        return made

    def _aligned(self, lines: Sequence[LaidOutLine]) -> Iterator[str]:
        return map(self._fitting, align_comments(lines, self._fits))

    def _fitting(self, text: str) -> str:
        """A line that the controller takes, if need be without its indentation."""
        if not self._fits(text):
            text = re.sub(r"^([0-9]*) +", r"\1 " if text[:1].isdigit() else "", text)
        return text + self._newline

    def _fits(self, text: str) -> bool:
        return len(text.encode(self._encoding, "replace")) <= self._lines.most

    def _other(self, at: int, level: int) -> str:
        """Lay out an item that is not a line of the program."""
        text = self._source(at)
        if not isinstance(self._items[at], Run):
            return self._lines.respelled(at, text.strip(" \t\f")) + self._newline
        try:
            return self._lines.text(at, self._newline, level)
        except ValueError:  # more digits than a number of that table holds
            return text.replace("\r", "").replace("\n", self._newline)


def _indent(parts: _Parts) -> str:
    """The blanks in front of the code, but for the one behind a number."""
    return parts.indent[1:] if parts.number else parts.indent
