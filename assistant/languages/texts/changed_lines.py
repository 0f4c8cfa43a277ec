"""Text of a language of lines, changed in place: what stays of a line keeps its text.

A line has a step number or none, code, and a comment behind it. The words of the code that stay
keep their bytes with the blanks between them; a new line is indented as those around it are that
stand as deep in blocks.
"""

from __future__ import annotations

import abc
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from typing import Any, Final

from assistant.base.source_text import one_line
from assistant.languages.texts.alignment import aligned
from assistant.languages.texts.laying_out import INDENT
from assistant.languages.texts.words import Word

_PARTS: Final = re.compile(r"([ \t]*)([0-9]*)([ \t\f]*)")


@dataclass(frozen=True, slots=True)
class Line:
    """What a line says.

    number: of the step. code: can be compared, None for none. comment: with its mark.
    """

    number: int | None
    code: Any
    comment: str | None

    @property
    def is_comment(self) -> bool:
        """Whether it is a comment and nothing else."""
        return self.code is None and self.comment is not None


class Code(abc.ABC):
    """How a language writes the code of a line."""

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
        """What a word says, however it is written."""

    @abc.abstractmethod
    def says(self, text: str, code: Any) -> bool:
        """Whether a text is read as that code and nothing else."""


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


def parts_of(text: str, line: Line) -> Parts:
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
    return Parts(margin, number, indent, code, rest[len(code) :], comment, trail)


def changed_line(parts: Parts, old: Line, new: Line, language: Code) -> str:
    """The text of `new` in that of `old`, which has those parts."""
    if new.number != old.number:
        number = "" if new.number is None else str(new.number)
        indent = parts.indent
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
    edited = edited_words(text, here, before, after, language.words(after), language.key)
    return after if edited is None or not language.says(edited, new) else edited


def edited_words(
    text: str,
    here: Sequence[Word],
    old: Sequence[Word],
    after: str,
    new: Sequence[Word],
    key: Callable[[Word], object],
) -> str | None:
    """The text with the edits that lead from an old line as it is printed to the new one.

    here: words of the text. after, new: the new line as it is printed, and its words. key: what
    words are compared by. None where what changes does not stand in the text as it is printed.
    """
    place: dict[int, int] = {}
    mine, theirs = ([key(word) for word in listed] for listed in (old, here))
    for block in SequenceMatcher(None, mine, theirs, autojunk=False).get_matching_blocks():
        place |= {block.a + k: block.b + k for k in range(block.size)}
    steps = SequenceMatcher(None, [w.text for w in old], [w.text for w in new], autojunk=False)
    edits: list[tuple[int, int, str]] = []
    for step, i1, i2, j1, j2 in steps.get_opcodes():
        if step == "equal":
            continue
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
    for start, end, put in reversed(edits):
        text = text[:start] + put + text[end:]
    return text


class Indentation:
    """How deep lines are indented that stand at some level of blocks."""

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
            return " " * (1 + INDENT * level)
        nearest = max(known)
        return self._known[nearest] + " " * (INDENT * (level - nearest))


def partners(
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
