"""Ways along calls, whatever calls whatever."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

T = TypeVar("T")
Callees = Callable[[T], Iterable[T]]


def call_chain(goal: T, start: T, called: Callees[T]) -> list[T] | None:
    """What is called from a start to a goal, both included; None if it does not lead there."""
    left: list[tuple[T, ...]] = [(start,)]
    seen: set[T] = set()
    while left:
        chain = left.pop()
        if chain[-1] == goal:
            return list(chain)
        if chain[-1] not in seen:
            seen.add(chain[-1])
            left += [(*chain, other) for other in called(chain[-1])]
    return None


def call_depth(start: T, called: Callees[T], above: tuple[T, ...] = ()) -> int:
    """How many calls stand inside each other at most; a circle ends where it closes."""
    if start in above:
        return 0
    inner = (call_depth(other, called, (*above, start)) for other in called(start))
    return max((1 + deep for deep in inner), default=0)
