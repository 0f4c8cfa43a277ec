"""Which nodes of a changed list are the old ones: what stays, what was changed, what is new."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from difflib import SequenceMatcher
from typing import Any, Final

import numpy as np

MOST_COMPARED: Final = 1 << 20
"""Pairs of a stretch that are compared in full; longer stretches only from both ends."""
MOST_RELATED: Final = 1 << 12
"""Pairs of a stretch that are looked at for likeness; longer ones are taken in order."""


def same(a: object, b: object) -> bool:
    return a is b or a == b


def common_ends(old: Sequence[Any], new: Sequence[Any]) -> tuple[int, int]:
    """How many items at the beginning and at the end are the same objects."""
    most = min(len(old), len(new))
    head = 0
    while head < most and old[head] is new[head]:
        head += 1
    tail = 0
    while tail < most - head and old[-1 - tail] is new[-1 - tail]:
        tail += 1
    return head, tail


def aligned(
    old: Sequence[Any], new: Sequence[Any], says: Callable[[Any], object] | None = None
) -> list[int | None]:
    """For each new node the index of the old one that it came from, None for one that is new.

    Indices rise. The same object comes first, then an equal one, then one that is alike; what
    is left over takes the place of what is left over, whatever it is.
    says: what has to be equal of two nodes that are, the whole node if not given; hashable.
    """
    partner: list[int | None] = [None] * len(new)
    places = {id(node): at for at, node in enumerate(old)}
    for j, i in _rising([(j, places[id(n)]) for j, n in enumerate(new) if id(n) in places]):
        partner[j] = i
    mine, theirs = (nodes if says is None else list(map(says, nodes)) for nodes in (old, new))
    for step, before, after in ((_equal, mine, theirs), (_alike, old, new), (_in_order, old, new)):
        for (i1, i2), (j1, j2) in list(_unpaired_stretches(partner, len(old))):
            for i, j in step(before[i1:i2], after[j1:j2]):
                partner[j1 + j] = i1 + i
    return partner


def _rising(pairs: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """The longest choice of the pairs whose second numbers rise."""
    ends: list[int] = []
    chosen: list[int] = []
    before: list[int] = []
    for at, (_, i) in enumerate(pairs):
        length = bisect_left(ends, i)
        before.append(chosen[length - 1] if length else -1)
        ends[length : length + 1] = [i]
        chosen[length : length + 1] = [at]
    out = []
    at = chosen[-1] if chosen else -1
    while at >= 0:
        out.append(pairs[at])
        at = before[at]
    return out[::-1]


def _unpaired_stretches(
    partner: Sequence[int | None], length: int
) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """The stretches of old and new between partners, where both have something."""
    i1 = j1 = 0
    for j, i in [*enumerate(partner), (len(partner), length)]:
        if i is None:
            continue
        if i1 < i and j1 < j:
            yield (i1, i), (j1, j)
        i1, j1 = i + 1, j + 1


def _equal(old: Sequence[Any], new: Sequence[Any]) -> Iterator[tuple[int, int]]:
    most = min(len(old), len(new))
    head = tail = 0
    while head < most and old[head] == new[head]:
        yield head, head
        head += 1
    while tail < most - head and old[-1 - tail] == new[-1 - tail]:
        tail += 1
        yield len(old) - tail, len(new) - tail
    old, new = old[head : len(old) - tail], new[head : len(new) - tail]
    if len(old) * len(new) <= MOST_COMPARED:
        for block in SequenceMatcher(None, old, new, autojunk=False).get_matching_blocks():
            for k in range(block.size):
                yield head + block.a + k, head + block.b + k


def _alike(old: Sequence[Any], new: Sequence[Any]) -> Iterator[tuple[int, int]]:
    if len(old) == len(new) or len(old) * len(new) > MOST_RELATED:
        return
    at = 0
    for j, node in enumerate(new):
        scores = [likeness(other, node) for other in old[at:]]
        best = max(scores, default=0)
        if best:
            at += scores.index(best)
            yield at, j
            at += 1


def _in_order(old: Sequence[Any], new: Sequence[Any]) -> Iterator[tuple[int, int]]:
    return iter([(k, k) for k in range(min(len(old), len(new)))])


def likeness(a: object, b: object) -> int:
    """How many fields two nodes of one kind share; empty ones do not count."""
    if type(a) is not type(b) or not is_dataclass(a):
        return 0
    count = 0
    for field in fields(a):
        if field.compare:
            mine, other = getattr(a, field.name), getattr(b, field.name)
            if isinstance(mine, np.ndarray):
                count += np.array_equal(mine, other)
            elif mine and isinstance(mine, tuple) and isinstance(other, tuple):
                count += not {id(x) for x in mine}.isdisjoint(id(x) for x in other)
            else:
                count += bool(mine) and same(mine, other)
    return count
