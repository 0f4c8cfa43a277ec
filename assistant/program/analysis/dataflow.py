"""What holds at each place of a program, along every way that leads there: one solver for all.

Nodes pass what holds behind them on to those that may follow, until nothing changes any more.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import Generic, TypeVar

N = TypeVar("N", bound=Hashable)
V = TypeVar("V")


def reachable(starts: Iterable[N], after: Callable[[N], Iterable[N]]) -> set[N]:
    """The nodes that can be come to from some, themselves included."""
    found: set[N] = set()
    left = list(starts)
    while left:
        node = left.pop()
        if node not in found:
            found.add(node)
            left += after(node)
    return found


def postorder(after: Mapping[N, Iterable[N]]) -> list[N]:
    """All nodes, each behind those that may follow it, as far as there is no circle."""
    order: dict[N, None] = {}
    met: set[N] = set()
    for first in after:
        left = [(first, False)]
        while left:
            node, done = left.pop()
            if done:
                order[node] = None
            elif node not in met:
                met.add(node)
                left.append((node, True))
                left += [(other, False) for other in after.get(node, ()) if other not in met]
    return list(order)


class Dataflow(Generic[N, V]):
    """What holds where each node begins: `found`, for those that some start leads to.

    after: node → those that may follow it. effect: what holds behind a node, by what holds where
    it begins; None if nothing runs on. join: what is certain where two ways meet. The values are
    those of a lattice of finite height: joining again and again must come to an end.
    """

    def __init__(
        self,
        after: Mapping[N, Iterable[N]],
        effect: Callable[[N, V], V | None],
        join: Callable[[V, V], V],
    ) -> None:
        self.after, self.effect, self.join = after, effect, join
        self.found: dict[N, V] = {}
        self._nodes = postorder(after)[::-1]
        self._rank = {node: rank for rank, node in enumerate(self._nodes)}

    def spread(self, starts: Iterable[tuple[N, V]]) -> None:
        """Passes on what holds at some nodes, with what is found already, until nothing changes."""
        queue: list[int] = []
        waiting: set[int] = set()

        def put(node: N, value: V) -> bool:
            known = self.found.get(node)
            made = value if known is None else self.join(known, value)
            self.found[node] = made
            return known is None or made != known

        def await_turn(node: N) -> None:
            rank = self._rank[node]
            if rank not in waiting:
                waiting.add(rank)
                heapq.heappush(queue, rank)

        for node, value in starts:
            put(node, value)
            await_turn(node)
        while queue:
            rank = heapq.heappop(queue)
            waiting.discard(rank)
            node = self._nodes[rank]
            behind = self.effect(node, self.found[node])
            if behind is not None:
                for other in self.after[node]:
                    if put(other, behind):
                        await_turn(other)
