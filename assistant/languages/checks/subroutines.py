"""How subroutines of a language of lines are entered and left, along every way through them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from assistant.languages.line_graph import EXIT, Graph
from assistant.program.analysis.dataflow import reachable


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
        self.leaving = reachable(ends, lambda at: before.get(at, ()))

    def endless(self) -> Iterator[int]:
        """Those that never come back."""
        yield from (
            at for at in (*sorted(self.graph.called), *self.handlers) if at not in self.leaving
        )

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
