"""What the words of MELFA-BASIC come down to for those who read and write them."""

from __future__ import annotations

from typing import Final

from assistant.languages.melfa_basic.tables.vocabulary import functions, statement, statements
from assistant.program.program import TakenNames

MOST_PULSES: Final = 4
"""Pulses that run at a time; one more is an error (COSIROP help: DLY)."""


def keyword_spelling(word: str) -> str:
    """A keyword of any case as the tools spell it; words that are not listed stay."""
    known = statement(word)
    return " ".join(word.split()) if known is None else known.word


RESERVED_WORDS: Final = frozenset(statements()) | frozenset(functions())
"""Words that no variable or label may be called, in upper case."""

ARC_START: Final = "PSTART"
"""Holds the present position for an arc whose start is no known position."""


def free_name(name: str, most: int, taken: set[str]) -> str:
    """A name of at most so many characters that begins like the given one; then it is taken.

    taken: in upper case, as names that differ in case alone are the same.
    """
    found = name[:most].rstrip("_")
    if found.upper() in taken:
        mark = "Z" if name[-1:].isdigit() else ""
        counts = taken.counts if isinstance(taken, TakenNames) else {}
        key = found.upper(), mark, most
        count = counts.get(key, 2)
        while (found := name[: most - len(f"{mark}{count}")] + f"{mark}{count}").upper() in taken:
            count += 1
        counts[key] = count
    taken.add(found.upper())
    return found


OPTIMUM_SPEED: Final = 10000.0
"""mm/s that `M_NSpd` stands for: as fast as the arm can. A higher speed is this one."""
