r"""One layout for every RAPID text: indentation, blanks, blank lines and upper-case keywords.

The layout is RobotStudio's: four columns a level, `CASE` and `ERROR` at the level of what they
belong to, no blanks around operators and commas. Tokens are never added, dropped or respelt,
except that keywords become upper case; comments stay between the tokens where they stood.

    MODULE m
        PROC main()
            IF x=1 AND NOT y THEN
                MoveL p1,v100,z10,tool0\WObj:=w;  ! comments behind lines that stood aligned
                Stop;                             ! stay aligned
            ENDIF
            Foo a,
                    b;          a line that goes on stands two levels in,
            x:=Bar(a,
                   b);          or under what the open bracket begins with,
            y:=[
                1,2             or one level in if its line ends with it
            ];
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final

from assistant.languages.rapid.text.layout.segments import Segment, segments
from assistant.languages.rapid.text.layout.spacing import CLOSING, OPENING, Spacing
from assistant.languages.rapid.text.layout.tokens import Token
from assistant.program.text import dominant_newline

INDENT: Final = 4
"""Columns of a level."""
TAB: Final = 4
"""Columns between the tab stops of a text that is read."""


def lay_out(text: str) -> str:
    """The text in the one layout, for any text that the grammar takes; idempotent.

    Line ends become the ones that most lines of the text have.
    """
    newline = dominant_newline(text)
    lines: list[_Line] = []
    for placed in _with_blank_lines(_placed(list(segments(text)), text)):
        segment, indent = placed.segment, " " * (INDENT * placed.level)
        if placed.blank:
            lines.append(_Line(""))
        if segment.trails and lines:
            _put_behind(lines[-1], segment.tokens[0], text)
        elif segment.form == "rows":
            lines.append(_Line(_rows(segment.tokens[0].text, indent, newline)))
        else:
            lines += _lines(segment, indent, text)
    return "".join(piece for line in _aligned(lines) for piece in (line, newline))


# Levels and blank lines


@dataclass(slots=True)
class _Placed:
    """blank: a blank line stands before it."""

    segment: Segment
    level: int
    blank: bool = False


def _placed(read: Sequence[Segment], text: str) -> list[_Placed]:
    """Every segment with its level; a comment has the one of what follows in its block."""
    placed: list[_Placed] = []
    level = 0
    above: Segment | None = None
    for segment, below in zip(read, _code_below(read), strict=True):
        outside = segment.form in ("closes", "divides") or (
            segment.form == "comment"
            and not segment.trails
            and _heads_division(segment, above, below, text)
        )
        placed.append(_Placed(segment, max(level - outside, 0)))
        level = max(level + (segment.form == "opens") - (segment.form == "closes"), 0)
        above = above if segment.form == "comment" else segment
    return placed


def _code_below(read: Sequence[Segment]) -> list[Segment | None]:
    """For each segment the first at or below it that is no comment."""
    below: list[Segment | None] = []
    last: Segment | None = None
    for segment in reversed(read):
        last = last if segment.form == "comment" else segment
        below.append(last)
    return below[::-1]


def _heads_division(
    comment: Segment, above: Segment | None, below: Segment | None, text: str
) -> bool:
    """Whether a comment belongs to an ELSE, CASE or ERROR below rather than to what is above.

    It does where it stands at that word's column and what is above stands deeper.
    """
    if below is None or below.form != "divides" or above is None:
        return False
    if above.form in ("opens", "divides"):  # nothing stands between but the comment
        return above.word == "test"
    own, word, other = (_column(text, s.tokens[0].start) for s in (comment, below, above))
    return own == word < other


def _with_blank_lines(placed: list[_Placed]) -> list[_Placed]:
    """One where one or more stood, and one before each routine with its comments."""
    for at, one in enumerate(placed):
        one.blank = at > 0 and one.segment.breaks > 1
        if one.segment.word in ("proc", "func", "trap", "module"):
            first = at
            while first > 0 and not placed[first].blank and _own_comment(placed[first - 1]):
                first -= 1
            before = first - 1
            while before >= 0 and placed[before].segment.trails:
                before -= 1
            above = placed[before].segment if before >= 0 else None
            if above and above.word != "module" and above.form != "header":
                placed[first].blank = True
    return placed


def _own_comment(placed: _Placed) -> bool:
    return placed.segment.form == "comment" and not placed.segment.trails


def _column(text: str, at: int) -> int:
    """Column, counted from 0, at which an offset stands."""
    return len(text[text.rfind("\n", 0, at) + 1 : at].expandtabs(TAB))


# Lines


@dataclass(slots=True)
class _Line:
    """code: with its indentation. comment: behind it. column, gap: of the comment in the text
    that was read, and how far it stood from the code.
    """

    code: str
    comment: str = ""
    column: int = 0
    gap: int = 0


def _aligned(lines: Sequence[_Line]) -> Iterator[str]:
    """The lines with their comments; neighbours that stood in one column do so again."""
    for (commented, _), group in groupby(
        lines, key=lambda line: (bool(line.code and line.comment), line.column)
    ):
        together = list(group)
        if not commented:
            yield from (line.code + line.comment for line in together)
            continue
        column = max(len(line.code) for line in together) + min(line.gap for line in together)
        yield from (line.code.ljust(column) + line.comment for line in together)


def _put_behind(line: _Line, comment: Token, text: str) -> None:
    start = text.rfind("\n", 0, comment.start) + 1
    before = text[start : comment.start].expandtabs(TAB)
    line.comment = comment.text.rstrip()
    line.column, line.gap = len(before), max(len(before) - len(before.rstrip()), 1)


def _rows(table: str, indent: str, newline: str) -> str:
    """The lines of a table without the last line end: few long replacements, none by line."""
    tight = table.replace(" ", "").replace("\t", "").replace("\r", "")
    tight = "\n" + tight.removesuffix("\n")
    for head in ("CONST robtarget ", "LOCAL CONST robtarget ", "MoveJ ", "MoveL ", "MoveC "):
        tight = tight.replace("\n" + head.replace(" ", ""), "\n" + indent + head)
    return tight[1:].replace("\n", newline)


@dataclass(frozen=True, slots=True)
class _Bracket:
    """Columns of lines inside an open bracket and of one that begins by closing it."""

    inside: int
    closing: int


def _lines(segment: Segment, indent: str, text: str) -> list[_Line]:
    """A segment on one line or, where its tokens stood on several, on as many."""
    lines = [_Line(indent)]
    brackets: list[_Bracket] = []
    spacing = Spacing(segment)
    broken = False
    for at, token in enumerate(segment.tokens):
        if token.kind == "break":
            broken = True
            continue
        comment = token.kind == "comment"
        if comment and at and not broken:
            _put_behind(lines[-1], token, text)
            broken = True
            continue
        blank = not comment and spacing.before(token)
        if broken:
            column = _continuation(token, spacing, brackets, len(indent))
            lines.append(_Line(" " * column))
        elif blank:
            lines[-1].code += " "
        if token.kind == "mark" and token.text in OPENING:
            following = segment.tokens[at + 1 : at + 2]
            brackets.append(_bracket(lines[-1].code, following))
        elif token.kind == "mark" and token.text in CLOSING and brackets:
            brackets.pop()
        lines[-1].code += _spelt(token)
        broken = comment
    return lines


def _bracket(code: str, following: Sequence[Token]) -> _Bracket:
    """The one that opens behind some code; what follows on its line is what others align with."""
    if following and following[0].kind in ("break", "comment"):
        indent = len(code) - len(code.lstrip())
        return _Bracket(indent + INDENT, indent)
    return _Bracket(len(code) + 1, len(code))


def _continuation(token: Token, spacing: Spacing, brackets: Sequence[_Bracket], indent: int) -> int:
    if spacing.begins_statement:
        return indent + INDENT
    if not brackets:
        return indent + 2 * INDENT
    return brackets[-1].closing if token.text in CLOSING else brackets[-1].inside


def _spelt(token: Token) -> str:
    match token.kind:
        case "key" | "hole":
            return token.text.upper()
        case "comment":
            return token.text.rstrip()
    return token.text
