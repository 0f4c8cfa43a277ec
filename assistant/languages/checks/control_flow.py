"""Control flow in checks: call chains, statements that are never reached, subroutines.

`call_chain` and `call_depth` follow calls of anything. `Reachability` works on nested lists of
statements, `Subroutines` on the graph of a language with one statement a line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import field
from typing import Generic, TypeVar

from assistant.base.data_classes import dataclass
from assistant.languages.line_blocks import EXIT, Graph
from assistant.program.analysis.dataflow import reachable

T = TypeVar("T")
Callees = Callable[[T], Iterable[T]]


def call_chain(goal: T, start: T, called: Callees[T]) -> list[T] | None:
    """Return the chain of calls from a start to a goal, both included; None if no chain leads
    there.
    """
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
    """Return the greatest depth of nested calls; a cycle ends where it closes."""
    if start in above:
        return 0
    inner = (call_depth(other, called, (*above, start)) for other in called(start))
    return max((1 + deep for deep in inner), default=0)


S = TypeVar("S")


@dataclass(frozen=True, slots=True)
class Reachability(Generic[S]):
    """Control flow through nested lists of statements.

    blocks: the lists directly inside a statement. leaves: why control does not reach the code after
    a statement, in words; empty for most. entered: True if jumps may lead into it. silent: True if
    it does nothing that would be missed.
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
        """True if control can reach the end of a list of statements."""
        return not self._ends(body)[-1]

    def _ends(self, body: Sequence[S]) -> list[str]:
        """For each statement and the end of a list why it is not reached, empty where it is."""
        found = [""]
        for statement in body:
            # A label that jumps lead to makes the code below it reachable again.
            if found[-1] and self.entered(statement):
                found[-1] = ""
            found.append(found[-1] or self.leaves(statement))
        return found


@dataclass(slots=True)
class Subroutines:
    """The subroutines of some lines; all by their places.

    start: the first line. returns: of each way back that a line has, whether it says where to, as
    subroutines of interrupts do. handlers: those subroutines.
    """

    graph: Graph
    start: int
    returns: Callable[[int], Iterable[bool]]
    handlers: list[int] = field(init=False)

    leaving: set[int] = field(init=False)
    """Places from which there is a way back."""

    def __post_init__(self) -> None:
        self.handlers = sorted(at for at, (_, called) in self.graph.handlers.items() if called)
        before: dict[int, list[int]] = {}
        for at, places in self.graph.after.items():
            for place in places:
                before.setdefault(place, []).append(at)
        ends = (at for at in self.graph.after if at != EXIT and [*self.returns(at)])
        # Backwards from the lines that return.
        self.leaving = reachable(ends, lambda at: before.get(at, ()))

    def endless(self) -> Iterator[int]:
        """Those that never come back."""
        yield from (
            at for at in (*sorted(self.graph.called), *self.handlers) if at not in self.leaving
        )

    def within(self, sub: int) -> set[int]:
        """Places that a subroutine comes to, in those that it calls as well; empty if the program
        may end there, or call the subroutine again.
        """
        found = self.graph.reached((sub,), through_calls=True)
        after = self.graph.after
        ends = (
            at for at in found if (not after[at] or EXIT in after[at]) and not [*self.returns(at)]
        )
        calls = (at for at in found if sub in self.graph.calls.get(at, ()))
        return set() if any(True for _ in (*ends, *calls)) else found

    def entered(self) -> tuple[dict[int, int], list[int]]:
        """Those that control comes to without a call, each with the place that leads there; and
        ways back that it comes to outside of them.
        """
        subs = self.graph.called.union(self.handlers)
        into, met = self.graph.entered(self.start, subs & self.leaving)
        return dict(sorted(into.items())), [at for at in sorted(met) for _ in self.returns(at)]

    def of_wrong_kind(self) -> Iterator[tuple[int, int, bool]]:
        """Ways back with a subroutine that only calls, or only interrupts, can take.

        The last one of each says whether it tells where to.
        """
        called = self.graph.called
        plain = self.graph.reached(called)
        handled = self._from(reversed(self.handlers))
        for at in sorted(handled.keys() - plain):
            yield from ((at, handled[at], told) for told in self.returns(at) if not told)
        only_called = self._from(sorted(called - handled.keys()))
        for at in sorted(only_called.keys() - handled.keys()):
            yield from ((at, only_called[at], told) for told in self.returns(at) if told)

    def _from(self, subs: Iterable[int]) -> dict[int, int]:
        """The places that some subroutines come to, each with the first of them that does."""
        # EXIT counts as found, so that the search ends there.
        found: dict[int, int] = {EXIT: EXIT}
        for sub in subs:
            left = [sub]
            while left:
                at = left.pop()
                if at not in found:
                    found[at] = sub
                    left += self.graph.after[at]
        del found[EXIT]
        return found
