"""How subroutines of a language of lines are entered and left, along every way through them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from assistant.languages.line_graph import Graph


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

    def __post_init__(self) -> None:
        self.handlers = sorted(at for at, (_, called) in self.graph.handlers.items() if called)

    def endless(self) -> Iterator[int]:
        """Those that never come back."""
        yield from (at for at in (*sorted(self.graph.called), *self.handlers) if not self._back(at))

    def entered(self) -> tuple[dict[int, int], list[int]]:
        """Those that control comes to without a call, each with the place that leads there; and
        ways back that it comes to outside of them.
        """
        subs = self.graph.called.union(self.handlers)
        into, met = self.graph.entered(self.start, {at for at in subs if self._back(at)})
        return dict(sorted(into.items())), [at for at in sorted(met) for _ in self.returns(at)]

    def of_wrong_kind(self) -> Iterator[tuple[int, int, bool]]:
        """Ways back with their subroutine that only calls, or only interrupts, can take.

        The last one of each says whether it tells where to.
        """
        plain = self.graph.reached(self.graph.called)
        handled = {at: sub for sub in self.handlers for at in self.graph.reached([sub])}
        for at in sorted(handled.keys() - plain):
            yield from ((at, handled[at], told) for told in self.returns(at) if not told)
        for sub in sorted(self.graph.called - handled.keys()):
            for at in sorted(self.graph.reached([sub]) - handled.keys()):
                yield from ((at, sub, told) for told in self.returns(at) if told)

    def _back(self, sub: int) -> bool:
        """Whether there is a way back from a subroutine."""
        return any(list(self.returns(at)) for at in self.graph.reached([sub]))
