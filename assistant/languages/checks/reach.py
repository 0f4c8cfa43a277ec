"""What is never reached of statements in lists that stand inside each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

S = TypeVar("S")


@dataclass(frozen=True, slots=True)
class Reachability(Generic[S]):
    """How control goes through lists of statements.

    blocks: the lists directly inside a statement. leaves: what keeps control from what stands
    behind a statement, in words; empty for most. entered: whether jumps may lead into it. silent:
    whether it does nothing that is missed.
    """

    blocks: Callable[[S], Sequence[Sequence[S]]]
    leaves: Callable[[S], str]
    entered: Callable[[S], bool]
    silent: Callable[[S], bool]

    def dead(self, body: Sequence[S]) -> Iterator[tuple[S, str]]:
        """The first statement of each stretch that is not reached, and why."""
        told = False
        for statement, before in zip(body, self._ends(body), strict=False):
            if self.silent(statement):
                continue
            if before and not told:
                yield statement, before
            told = bool(before)
            for block in () if before else self.blocks(statement):
                yield from self.dead(block)

    def falls_through(self, body: Sequence[S]) -> bool:
        """Whether the end of a list of statements can be reached."""
        return not self._ends(body)[-1]

    def _ends(self, body: Sequence[S]) -> list[str]:
        """For each statement and the end of a list why it is not reached, empty where it is."""
        found = [""]
        for statement in body:
            if found[-1] and self.entered(statement):
                found[-1] = ""
            found.append(found[-1] or self.leaves(statement))
        return found
