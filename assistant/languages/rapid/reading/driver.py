"""The words of RAPID, as far as its tables have room for them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Set
from functools import cache
from typing import Final

from assistant.languages.lalr import END, Rows, Word
from assistant.languages.rapid.reading.grammar import grammar
from assistant.languages.rapid.reading.scanner import scanner

IGNORED: Final = frozenset({"BLANK", "COMMENT"})


def sound_words(text: str, rows: Rows, states: list[int]) -> Iterator[Word]:
    """The words of a text that is thought to be sound.

    states: of the stack that they are read on.
    """
    for match in scanner().finditer(text):
        type = match.lastgroup or ""
        if type in IGNORED or (type == "NOTE" and type not in rows[states[-1]]):
            continue
        yield type, match[0], match.start(), match.end()
    yield END, "", len(text), len(text)


def words(text: str, at: int, rows: Rows, states: list[int]) -> Iterator[Word]:
    """The words behind an offset, each as what there is room for, if it can be read so."""
    while match := scanner().match(text, at):
        type = match.lastgroup or ""
        row = rows[states[-1]]
        at = match.end()
        if type in IGNORED or (type == "NOTE" and type not in row):
            continue
        if type not in row and (fits := _fitting(frozenset(row)).match(text, match.start())):
            match, type, at = fits, fits.lastgroup or "", fits.end()
        yield type, match[0], match.start(), at
    yield END, "", len(text), len(text)


@cache
def _fitting(terminals: Set[str | None]) -> re.Pattern[str]:
    """Some terminals, in the order in which they are tried."""
    known = grammar()
    tried = (name for name in known.order if name in terminals)
    listed = (f"(?P<{name}>{known.terminals[name].regexp})" for name in tried)
    return re.compile("|".join(listed) or r"(?!)", re.MULTILINE)
