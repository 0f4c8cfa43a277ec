"""What the words of MELFA-BASIC come down to for those who read and write them."""

from __future__ import annotations

from typing import Final

from assistant.languages.melfa_basic.tables.vocabulary import functions, statement, statements


def spelled(word: str) -> str:
    """A keyword of any case as the tools spell it; words that are not listed stay."""
    known = statement(word)
    return " ".join(word.split()) if known is None else known.word


RESERVED: Final = frozenset(statements()) | frozenset(functions())
"""Words that no variable or label may be called, in upper case."""

ARC_START: Final = "PSTART"
"""Holds the present position for an arc whose start is no known position."""


def free(name: str, most: int, taken: set[str]) -> str:
    """A name of at most so many characters that begins like the given one; then it is taken."""
    found, count = name[:most], 2
    while found in taken:
        tail = f"Z{count}" if name[-1:].isdigit() else str(count)
        found, count = name[: most - len(tail)] + tail, count + 1
    taken.add(found)
    return found
