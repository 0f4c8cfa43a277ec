"""What comes again among things, what comes for the first time, and what has no counterpart."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
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


@dataclass(frozen=True, slots=True)
class Keyed(Generic[K, T]):
    """The first thing of each key. unsure: there are things whose key is not known."""

    first: Mapping[K, T]
    unsure: bool

    @staticmethod
    def of(pairs: Iterable[tuple[K | None, T]]) -> Keyed[K, T]:
        """pairs: None for a key that is not known."""
        listed = list(pairs)
        known = {key: thing for key, thing in reversed(listed) if key is not None}
        return Keyed(known, any(key is None for key, _ in listed))

    def without(self, others: Keyed[K, T]) -> Iterator[tuple[K, T]]:
        """Those that certainly have no counterpart among others."""
        if not others.unsure:
            yield from ((k, thing) for k, thing in self.first.items() if k not in others.first)
