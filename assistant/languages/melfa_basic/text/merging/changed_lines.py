"""A code line that changed: number, indentation, words and comment that stay keep their text."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from typing import Final

from assistant.languages.melfa_basic.reading.parser import statement as read
from assistant.languages.melfa_basic.text.layout.tokens import Token, tokens
from assistant.languages.melfa_basic.text.printer import line as printed
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.text import one_line

_PARTS: Final = re.compile(r"([ \t]*)([0-9]*)([ \t\f]*)")


@dataclass(frozen=True, slots=True)
class Parts:
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


def parts_of(text: str, item: s.Line) -> Parts:
    """The parts of a line that was read. text: with its line end."""
    plain = text.rstrip("\r\n").rstrip()
    trail = text[len(plain) :]
    comment = item.comment or ""
    plain = plain.removesuffix(comment) if comment else plain
    found = _PARTS.match(plain)
    assert found is not None
    margin, number, indent = found.groups() if item.number is not None else ("", "", "")
    if item.number is None:
        indent = plain[: len(plain) - len(plain.lstrip(" \t\f"))]
    rest = plain[len(margin) + len(number) + len(indent) :]
    code = rest.rstrip(" \t\f")
    return Parts(margin, number, indent, code, rest[len(code) :], comment, trail)


def changed_line(text: str, old: s.Line, new: s.Line, upper: bool) -> str:
    """The text of `new` in that of `old`, both with the line end."""
    parts = parts_of(text, old)
    if new.number != old.number:
        number = "" if new.number is None else str(new.number)
        indent = parts.indent
        if old.number is None:
            indent = " " + indent
        elif new.number is None:
            indent = indent[1:]
        parts = replace(parts, number=number, indent=indent)
    if (new.label, new.statement) != (old.label, old.statement):
        parts = replace(parts, code=_code(parts.code, old, new, upper))
        if not old.label and not old.statement and parts.comment:
            parts = replace(parts, gap=" ")
        elif not parts.code:
            parts = replace(parts, gap="")
    if new.comment != old.comment:
        behind = bool(parts.code or parts.number)
        gap = (
            parts.gap
            if old.comment is not None
            else " " * (behind and not parts.indent.endswith(" "))
        )
        if old.comment is None and parts.code:
            gap = " "
        parts = replace(parts, gap=gap if new.comment else "", comment=one_line(new.comment or ""))
    return parts.text


def _code(text: str, old: s.Line, new: s.Line, upper: bool) -> str:
    """Label and statement of `new`, with the words of `text` that stay."""
    wanted = replace(new, number=None, comment=None, span=None)
    after = printed(wanted, upper)
    if not text or not after:
        return after
    before = printed(replace(old, number=None, comment=None), upper)
    edited = _edited(text, tokens(text), tokens(before), after, tokens(after))
    if edited is None:
        return after
    again = read(edited)
    return edited if again == wanted else after


def _edited(
    text: str, here: Sequence[Token], old: Sequence[Token], after: str, new: Sequence[Token]
) -> str | None:
    """The text with the edits that lead from an old line as it is printed to the new one.

    here: tokens of the text. after, new: the new line as it is printed, and its tokens.
    None where what changes does not stand in the text as it is printed.
    """
    place: dict[int, int] = {}
    mine, theirs = ([_plain(t) for t in listed] for listed in (old, here))
    for block in SequenceMatcher(None, mine, theirs, autojunk=False).get_matching_blocks():
        place |= {block.a + k: block.b + k for k in range(block.size)}
    steps = SequenceMatcher(None, [t.text for t in old], [t.text for t in new], autojunk=False)
    edits: list[tuple[int, int, str]] = []
    for step, i1, i2, j1, j2 in steps.get_opcodes():
        if step == "equal":
            continue
        first = i1 if i1 < i2 else i1 - 1
        if not all(at in place for at in (*range(i1, i2), first) if at >= 0):
            return None
        if step == "replace":
            start, end = here[place[i1]].start, _end(here[place[i2 - 1]])
            edits.append((start, end, after[new[j1].start : _end(new[j2 - 1])]))
        elif i1 == 0:  # at the very beginning
            end = here[place[i2]].start if step == "delete" and i2 in place else 0
            tail = after[_end(new[j2 - 1]) : new[j2].start] if j2 and j2 < len(new) else ""
            edits.append((0, end, after[: _end(new[j2 - 1])] + tail if step == "insert" else ""))
        elif i1 - 1 in place:
            start = _end(here[place[i1 - 1]])
            end = _end(here[place[i2 - 1]]) if step == "delete" else start
            put = after[_end(new[j1 - 1]) : _end(new[j2 - 1])] if step == "insert" else ""
            edits.append((start, end, put))
        else:
            return None
    for start, end, put in reversed(edits):
        text = text[:start] + put + text[end:]
    return text


def _end(token: Token) -> int:
    return token.start + len(token.text)


def _plain(token: Token) -> str | float:
    """What a token is compared by: its number, else its text without blanks in lower case."""
    if token.kind == "NUMBER":
        return float(token.text)
    return "".join(token.text.split()).casefold()
