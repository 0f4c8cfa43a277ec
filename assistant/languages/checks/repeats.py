"""What comes again among things, and what comes for the first time."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")


def repeated(things: Iterable[T], key: Callable[[T], Hashable | None]) -> Iterator[T]:
    """The things whose key an earlier one has; those without a key are like no other."""
    seen: set[Hashable] = set()
    for thing in things:
        of = key(thing)
        if of is not None and of in seen:
            yield thing
        seen.add(of)


def firsts(things: Iterable[T], key: Callable[[T], Hashable]) -> Iterator[T]:
    """The first thing of each key."""
    seen: set[Hashable] = set()
    for thing in things:
        of = key(thing)
        if of not in seen:
            seen.add(of)
            yield thing
