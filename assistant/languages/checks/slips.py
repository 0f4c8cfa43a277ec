"""Names that look like a slip of another one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

SHORTEST_COMPARED: Final = 4
"""Characters of a name that can be told from another short name at all."""
LONG_NAME: Final = 8
"""Characters of a name in which two slips may happen."""


def misspelt(name: str, known: Iterable[str], ending: str = "") -> str:
    """The known name that one or two slips of typing turn into this one; empty if there is none.

    Digits do not count as slips: `p10` is not `p20` by mistake. Neither does the ending, in lower
    case, that many names have in common: `caldata` may well be one beside `capdata`.
    """
    low = name.lower()
    if ending and low.endswith(ending):
        stems = [one[: -len(ending)] for one in known if one.lower().endswith(ending)]
        stem = misspelt(low.removesuffix(ending), stems, ending)
        return stem + ending if stem else ""
    most = 2 if len(low) >= LONG_NAME else 1
    if len(low) < SHORTEST_COMPARED:
        return ""
    letters = set(low)
    near = (
        (typing_distance(low, other.lower(), most), other)
        for other in known
        # One slip changes the length by one and the set of letters by two at most.
        if abs(len(other) - len(low)) <= most
        and len(letters.symmetric_difference(other.lower())) <= 2 * most
        and digits(other) == digits(low)
    )
    return min((found for found in near if found[0] <= most), default=(0, ""))[1]


def digits(name: str) -> str:
    return "".join(c for c in name if c.isdigit())


def typing_distance(one: str, other: str, most: int) -> int:
    """Letters to add, leave out, change or swap with the next; `most + 1` for any more."""
    before: list[int] = []
    row = list(range(len(other) + 1))
    for i, a in enumerate(one, 1):
        before, last, row = row, before, [i]
        for j, b in enumerate(other, 1):
            cost = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (a != b))
            if i > 1 and j > 1 and a == other[j - 2] and one[i - 2] == b:
                cost = min(cost, last[j - 2] + 1)
            row.append(cost)
        if min(row) > most:
            return most + 1
    return row[-1]
