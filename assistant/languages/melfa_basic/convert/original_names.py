"""What a converted program keeps in its heading, so that converting it back restores it.

    ' robot-assistant: melfa-basic-4
    ' named: PSCREWPO = PScrewPosition
    ' labelled: ASSYEND = ASSY_END
    ' steps: L100, L160
    ' robot-assistant: end

A program that was written by this tool has such a heading already (see header); the lines go
into it, and its own short names follow.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile
from typing import Final

from assistant.languages.melfa_basic.convert.names import NAME_TABLES, Names
from assistant.languages.melfa_basic.text import header as headers
from assistant.languages.melfa_basic.tree import syntax as s

LABEL_LISTS: Final = ("steps", "long", "constant")


@dataclass(slots=True)
class OriginalNames(Names):
    """What short names stand for, and more that a dialect does not say; all in upper case.

    steps: labels that stand for step numbers. long: numbers that were whole ones of 32 bits.
    constant: assigned variables that were constants.
    """

    steps: dict[str, None] = field(default_factory=dict)
    long: dict[str, None] = field(default_factory=dict)
    constant: dict[str, None] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return any(getattr(self, kind) for kind in (*NAME_TABLES, *LABEL_LISTS))

    def lines(self) -> Iterator[str]:
        """The comment texts, without their mark."""
        for kind in NAME_TABLES:
            yield from headers.packed(kind, (f"{k} = {v}" for k, v in getattr(self, kind).items()))
        for kind in LABEL_LISTS:
            yield from headers.packed(kind, getattr(self, kind))


_NAME_PAIR: Final = re.compile(r"([A-Z][A-Z0-9_]*) = ([A-Za-z][A-Za-z0-9_]*)")
_NAME: Final = re.compile(r"[A-Z][A-Z0-9_]*")
_SHORT_NAME: Final = re.compile(r"(?<=[ ,])([A-Z][A-Z0-9_]*)(?= = )")


def take_original_names(items: Sequence[s.Item]) -> tuple[list[s.Item], OriginalNames]:
    """The lines without what an earlier conversion has put into the heading, and that.

    A heading that holds nothing else goes as well.
    """
    memory = OriginalNames()
    start, end = _heading(items)
    if end <= start:
        return list(items), memory
    kept = [i for i in items[start + 1 : end] if not _remember_entry(_comment_text(i), memory)]
    if not kept:
        return [*items[:start], *items[end + 1 :]], memory
    return [*items[: start + 1], *kept, *items[end:]], memory


def put_original_names(
    items: Sequence[s.Item], memory: OriginalNames, dialect: str, *, marked: bool = False
) -> list[s.Item]:
    """The lines with the dialect and the memory in the heading.

    marked: with a heading that names the dialect, even if there is nothing else to say.
    """
    told = [_comment(text) for text in memory.lines()]
    start, end = _heading(items)
    if end > start:
        mark, first = "' " + headers.MARK + dialect, items[start]
        if isinstance(first, s.Line) and first.comment != mark:
            first = replace(first, comment=mark)
        return [*items[:start], first, *items[start + 1 : end], *told, *items[end:]]
    if not told and not marked:
        return list(items)
    heading = [_comment(headers.MARK + dialect), *told, _comment(headers.END)]
    return [*heading, *items]


def with_heading_names(items: Sequence[s.Item], names: Mapping[str, str]) -> list[s.Item]:
    """The lines with the short names in the heading exchanged, by upper-case name."""
    start, end = _heading(items)
    lines = list(items)
    for at in range(start + 1, end):
        item = lines[at]
        if not isinstance(item, s.Line) or item.comment is None:
            continue
        text = _SHORT_NAME.sub(lambda m: names.get(m.group(1).upper(), m.group(1)), item.comment)
        if text != item.comment:
            lines[at] = replace(item, comment=text)
    return lines


def _heading(items: Sequence[s.Item]) -> tuple[int, int]:
    """Places of the first and last line of the heading; (0, 0) if there is none."""
    texts = takewhile(lambda text: text is not None, map(_comment_text, items))
    return headers.bounds([text or "" for text in texts]) or (0, 0)


def _comment_text(item: s.Item) -> str | None:
    """The text of a line that is a comment only."""
    if not isinstance(item, s.Line) or item.statement is not None or item.label is not None:
        return None
    comment = item.comment or ""
    return comment[1:].strip() if comment.startswith("'") else None


def _comment(text: str) -> s.Line:
    return s.Line(comment="' " + text.removeprefix("' "))


def _remember_entry(text: str | None, memory: OriginalNames) -> bool:
    key, _, value = (text or "").partition(": ")
    if key in NAME_TABLES:
        pairs = (_NAME_PAIR.fullmatch(entry) for entry in value.split(", "))
        getattr(memory, key).update({p.group(1): p.group(2) for p in pairs if p})
        return True
    if key in LABEL_LISTS:
        names = (entry for entry in value.split(", ") if _NAME.fullmatch(entry))
        getattr(memory, key).update(dict.fromkeys(names))
        return True
    return False
