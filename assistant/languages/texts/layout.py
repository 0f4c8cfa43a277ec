"""Standard layout of texts whose statements may take several lines.

A language cuts its text into segments (statements, headings, ends of blocks, comments) and states
how their words are spelt and spaced; see `Style`. Line breaks within a statement stay, comments
stay between the words where they were, and comments at line ends that were in one column are in
one column again.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import Final, Literal

from assistant.base.data_classes import dataclass
from assistant.base.source_text import dominant_newline
from assistant.languages.texts.words import Word

INDENT: Final = 4
"""Columns of a level."""
TAB: Final = 4
"""Columns between the tab stops of a text that is read."""

Form = Literal["plain", "opens", "divides", "closes", "comment", "rows", "header"]
"""opens, closes: the first and the last line of a block; divides: one like ELSE inside it."""


@dataclass(frozen=True, slots=True)
class Segment:
    """Words that belong on one line, or on one with lines that continue it.

    word: the lower-case keyword that says what it is; empty for a statement that begins with a
    name. breaks: how many line ends stand before it.
    """

    form: Form
    word: str
    words: list[Word]
    breaks: int

    @property
    def trails(self) -> bool:
        """A comment behind something on its line."""
        return self.form == "comment" and not self.breaks


class Spacing(abc.ABC):
    """Blanks between the words of one segment, asked in order, without line ends and comments."""

    begins_statement: bool = False
    """True if the last word begins a statement inside the segment."""

    @abc.abstractmethod
    def before(self, word: Word) -> bool:
        """True if a blank precedes the next word."""


@dataclass(frozen=True, slots=True)
class Style:
    """Layout rules of one language.

    spacing: of a segment. spelt: spelling of a word. table: the lines of a table of similar lines,
    without the last line end, from its text, indentation and line ends. separate: words of blocks
    with a blank line before them. outermost: words of blocks whose first inner item needs no blank
    line. choosing: words whose blocks begin with a line that divides them.
    """

    spacing: Callable[[Segment], Spacing]
    spelt: Callable[[Word], str]
    table: Callable[[str, str, str], str]
    separate: frozenset[str]
    outermost: frozenset[str]
    choosing: frozenset[str]
    opening: frozenset[str] = frozenset("([{")
    closing: frozenset[str] = frozenset(")]}")


def lay_out(text: str, segments: Sequence[Segment], style: Style) -> str:
    """The segments of a text in the one layout.

    Line ends become the ones that most lines of the text have.
    """
    newline = dominant_newline(text)
    lines: list[LaidOutLine] = []
    for placed in _with_blank_lines(_placed(segments, text, style), style):
        segment, indent = placed.segment, " " * (INDENT * placed.level)
        if placed.blank:
            lines.append(LaidOutLine(""))
        if segment.trails and lines:
            _put_behind(lines[-1], segment.words[0], text)
        elif segment.form == "rows":
            lines.append(LaidOutLine(style.table(segment.words[0].text, indent, newline)))
        else:
            lines += _segment_lines(segment, indent, text, style)
    return "".join(piece for line in align_comments(lines) for piece in (line, newline))


# Levels and blank lines


@dataclass(slots=True)
class _Placed:
    """blank: a blank line stands before it."""

    segment: Segment
    level: int
    blank: bool = False


def _placed(read: Sequence[Segment], text: str, style: Style) -> list[_Placed]:
    """Every segment with its level; a comment has the one of what follows in its block."""
    placed: list[_Placed] = []
    level = 0
    above: Segment | None = None
    for segment, below in zip(read, _code_below(read), strict=True):
        outside = segment.form in ("closes", "divides") or (
            segment.form == "comment"
            and not segment.trails
            and _heads_division(segment, above, below, text, style)
        )
        placed.append(_Placed(segment, max(level - outside, 0)))
        level = max(level + (segment.form == "opens") - (segment.form == "closes"), 0)
        above = above if segment.form == "comment" else segment
    return placed


def _code_below(read: Sequence[Segment]) -> list[Segment | None]:
    """Return for each segment the first one at or below it that is not a comment."""
    below: list[Segment | None] = []
    last: Segment | None = None
    for segment in reversed(read):
        last = last if segment.form == "comment" else segment
        below.append(last)
    return below[::-1]


def _heads_division(
    comment: Segment, above: Segment | None, below: Segment | None, text: str, style: Style
) -> bool:
    """True if a comment belongs to a line below that divides a block, not to the code above.

    This holds if it is in the column of that word and the code above is deeper.
    """
    if below is None or below.form != "divides" or above is None:
        return False
    if above.form in ("opens", "divides"):  # nothing stands between but the comment
        return above.word in style.choosing
    own, word, other = (_column(text, s.words[0].start) for s in (comment, below, above))
    return own == word < other


def _with_blank_lines(placed: list[_Placed], style: Style) -> list[_Placed]:
    """Keep one blank line of several, and put one before each separate block with its comments."""
    for at, one in enumerate(placed):
        one.blank = at > 0 and one.segment.breaks > 1
        if one.segment.word in style.separate:
            first = at
            while first > 0 and not placed[first].blank and _own_comment(placed[first - 1]):
                first -= 1
            before = first - 1
            while before >= 0 and placed[before].segment.trails:
                before -= 1
            above = placed[before].segment if before >= 0 else None
            if above and above.word not in style.outermost and above.form != "header":
                placed[first].blank = True
    return placed


def _own_comment(placed: _Placed) -> bool:
    return placed.segment.form == "comment" and not placed.segment.trails


def _column(text: str, at: int) -> int:
    """Column, counted from 0, at which an offset stands."""
    return len(text[text.rfind("\n", 0, at) + 1 : at].expandtabs(TAB))


# Lines


@dataclass(slots=True)
class LaidOutLine:
    """A laid-out line. code: with its indentation. comment: after it. lead: before it, not counted.

    column, gap: of the comment in the text that was read, and its distance from the code.
    """

    code: str
    comment: str = ""
    column: int = 0
    gap: int = 0
    lead: str = ""

    def put_behind(self, comment: str, before: str) -> None:
        """Gives the line a comment. before: what stood before that on its line."""
        before = before.expandtabs(TAB)
        self.comment = comment
        # At least one blank separates a comment from the code.
        self.column, self.gap = len(before), max(len(before) - len(before.rstrip()), 1)


def align_comments(
    lines: Sequence[LaidOutLine], fits: Callable[[str], bool] | None = None
) -> Iterator[str]:
    """The lines with their comments; neighbours that stood in one column do so again.

    fits: whether a line is short enough; where one is not, comments stand right behind the code.
    """
    for (commented, _), group in groupby(
        lines, key=lambda line: (bool(line.code and line.comment), line.column)
    ):
        together = list(group)
        if commented:
            yield from _columns(together, fits)
        else:
            yield from (line.lead + line.code + line.comment for line in together)


def _columns(lines: Sequence[LaidOutLine], fits: Callable[[str], bool] | None) -> list[str]:
    # The column that the longest code leaves room for, as near as one of the comments was.
    column = max(len(line.code) for line in lines) + min(line.gap for line in lines)
    texts = [line.lead + line.code.ljust(column) + line.comment for line in lines]
    if fits is None or all(map(fits, texts)):
        return texts
    return [f"{line.lead}{line.code} {line.comment}" for line in lines]


def _put_behind(line: LaidOutLine, comment: Word, text: str) -> None:
    start = text.rfind("\n", 0, comment.start) + 1
    line.put_behind(comment.text.rstrip(), text[start : comment.start])


@dataclass(frozen=True, slots=True)
class _Bracket:
    """Columns of lines inside an open bracket and of one that begins by closing it."""

    inside: int
    closing: int


def _segment_lines(segment: Segment, indent: str, text: str, style: Style) -> list[LaidOutLine]:
    """A segment on one line or, where its words stood on several, on as many."""
    lines = [LaidOutLine(indent)]
    brackets: list[_Bracket] = []
    spacing = style.spacing(segment)
    broken = False
    for at, word in enumerate(segment.words):
        if word.kind == "newline":
            broken = True
            continue
        comment = word.kind == "comment"
        if comment and at and not broken:
            _put_behind(lines[-1], word, text)
            broken = True
            continue
        blank = not comment and spacing.before(word)
        if broken:
            column = _continuation(word, spacing, brackets, len(indent), style)
            lines.append(LaidOutLine(" " * column))
        elif blank:
            lines[-1].code += " "
        if word.kind == "mark" and word.text in style.opening:
            following = segment.words[at + 1 : at + 2]
            brackets.append(_bracket(lines[-1].code, following))
        elif word.kind == "mark" and word.text in style.closing and brackets:
            brackets.pop()
        lines[-1].code += style.spelt(word)
        broken = comment
    return lines


def _bracket(code: str, following: Sequence[Word]) -> _Bracket:
    """The one that opens behind some code; what follows on its line is what others align with."""
    if following and following[0].kind in ("newline", "comment"):
        indent = len(code) - len(code.lstrip())
        return _Bracket(indent + INDENT, indent)
    return _Bracket(len(code) + 1, len(code))


def _continuation(
    word: Word, spacing: Spacing, brackets: Sequence[_Bracket], indent: int, style: Style
) -> int:
    if spacing.begins_statement:
        return indent + INDENT
    if not brackets:
        return indent + 2 * INDENT
    return brackets[-1].closing if word.text in style.closing else brackets[-1].inside


@dataclass(frozen=True, slots=True)
class Cutter:
    """Cuts texts of a language into segments; words are given in lower case.

    words: of a text, tables of similar lines as one word of kind `rows`. plain: of a table that
    begins at an offset, word by word. scopes: may precede the word that determines the kind of a
    segment. opens, divides, closes: effects of words on blocks; opening: a word that opens a block
    if another word ends its segment. alone: words that are complete segments. end: ends any other
    segment, unless ended_by or ended_before lists the words that end it, or before which it ends.
    named: words of a heading that ends with a name; headed: of one that continues after the name.
    bracketed: words of headings that end with a pair of parentheses, if one follows. label: follows
    the name of a label.
    """

    words: Callable[[str], Iterator[Word]]
    plain: Callable[[str, int], Iterator[Word]]
    scopes: frozenset[str]
    opens: frozenset[str]
    opening: Mapping[str, str]
    divides: frozenset[str]
    closes: frozenset[str]
    alone: frozenset[str]
    end: str
    ended_by: Mapping[str, frozenset[str]]
    ended_before: Mapping[str, frozenset[str]]
    named: frozenset[str]
    headed: frozenset[str]
    bracketed: frozenset[str]
    label: str

    def segments(self, text: str) -> Iterator[Segment]:
        """The segments of a text that the grammar takes; of any other text some segments."""
        read = list(self.words(text))
        at, breaks = 0, 1
        while at < len(read):
            item = read[at]
            match item.kind:
                case "newline":
                    at, breaks = at + 1, breaks + 1
                    continue
                case "comment" | "rows" | "header":
                    form: Form = item.kind
                    yield Segment(form, "", [item], breaks)
                    at, breaks = at + 1, int(item.kind == "rows")
                case _:
                    end = self._end(read, at)
                    inside = read[at:end]
                    word = self._word(inside)
                    yield Segment(self._form(word, inside), word, inside, breaks)
                    at, breaks = end, 0

    def _word(self, inside: list[Word]) -> str:
        for item in inside:
            if item.kind in ("key", "hole") and item.text.lower() not in self.scopes:
                return item.text.lower()
            if item.kind not in ("key", "newline", "comment"):
                break
        return ""

    def _form(self, word: str, inside: list[Word]) -> Form:
        if word in self.opens or inside[-1].text.lower() == self.opening.get(word):
            return "opens"
        if word in self.divides:
            return "divides"
        return "closes" if word in self.closes else "plain"

    def _end(self, read: list[Word], start: int) -> int:
        """Return the index after the last item of the segment that begins at an index."""
        seen = self._significant(read, start)
        at = next(seen)
        word = read[at].text.lower()
        # A word such as LOCAL precedes the one that determines the kind.
        if word in self.scopes:
            at = next(seen, at)
            word = read[at].text.lower()
        if word in self.ended_before:
            for following in seen:
                if read[following].text.lower() in self.ended_before[word]:
                    break
                at = following
            return at + 1
        if word in self.named or word in self.headed or word in self.bracketed:
            return self._end_of_heading(read, at, word)
        if word in self.alone:
            return at + 1
        stops = self.ended_by.get(word, {self.end})
        label = read[at].kind == "word"
        for number, following in enumerate(seen):
            text = read[following].text.lower()
            at = following
            if text in stops or (label and number == 0 and text == self.label):
                break
        return at + 1

    def _end_of_heading(self, read: list[Word], at: int, word: str) -> int:
        """Behind the parentheses of a heading, or behind its name if it has none."""
        depth, last = 0, at
        names = 1 if word in self.named else 0
        for following in self._significant(read, at + 1):
            text = read[following].text
            if text == "(" and word in self.bracketed:
                depth += 1
            elif text == ")" and depth:
                depth -= 1
                if not depth:
                    return following + 1
            elif not depth:
                if word in self.headed:
                    pass
                elif names:
                    names -= 1
                else:
                    return last + 1
            last = following
        return last + 1

    def _significant(self, read: list[Word], start: int) -> Iterator[int]:
        """Indices of what the grammar sees; a table in a statement is taken apart on the way."""
        at = start
        while at < len(read):
            item = read[at]
            if item.kind == "rows":  # its first line ends the statement that stands before it
                length = item.text.find("\n") + 1 or len(item.text)
                first = self.plain(item.text[:length], item.start)
                rest = Word("rows", item.text[length:], item.start + length)
                read[at : at + 1] = [*first, *([rest] if rest.text else [])]
                continue
            if item.kind not in ("newline", "comment"):
                yield at
            at += 1
