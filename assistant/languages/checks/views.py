"""What a rule sees of a file, kept from one rule to the next."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any, Self, TypeVar, cast

T = TypeVar("T")


class CachedResults:
    """Keeps what functions make of an object, for the next rule that asks."""

    def once(self, work: Callable[[Self], T]) -> T:
        """What a function makes of the object, worked out when it is first asked for."""
        if work not in self._worked:
            self._worked[work] = work(self)
        return cast("T", self._worked[work])

    def first(self, what: str, name: str) -> bool:
        """Whether this is the first time that this is said of a name, in any case."""
        known = (what, name.lower()) in self._told
        self._told.add((what, name.lower()))
        return not known

    @cached_property
    def _told(self) -> set[tuple[str, str]]:
        return set()

    @cached_property
    def _worked(self) -> dict[Callable[[Any], Any], Any]:
        return {}


def by_type(nodes: Iterable[tuple[object, T]]) -> dict[type, list[T]]:
    """Things by the class of the node that each comes with, in their order."""
    found: dict[type, list[T]] = {}
    for node, thing in nodes:
        found.setdefault(type(node), []).append(thing)
    return found
