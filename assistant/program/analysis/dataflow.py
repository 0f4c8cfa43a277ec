"""Data flow: the control-flow graph of a procedure, and one solver for facts along all its paths.

Nodes pass the facts after them on to those that may follow, until nothing changes any more.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Hashable, Iterable, Mapping
from itertools import groupby
from typing import Any, Final, Generic, TypeVar

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import walk
from assistant.program.rewriting import Body, head
from assistant.program.vendor_statements import effect_of

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
    """Value that holds at the beginning of each node: `found`, for the nodes that a start reaches.

    after: node → the nodes that may follow it. effect: returns the value after a node from the
    value at its beginning; None if nothing follows. join: returns the value that is certain where
    two paths meet. The values are those of a lattice of finite height: repeated joins must end.
    """

    def __init__(
        self,
        after: Mapping[N, Iterable[N]],
        effect: Callable[[N, V], V | None],
        join: Callable[[V, V], V],
    ) -> None:
        self.after, self.effect, self.join = after, effect, join
        self.found: dict[N, V] = {}
        # Reverse postorder: a node mostly comes after all that lead to it.
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

        # A start is visited even if its value is known.
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


EXIT: Final = 0
"""The node that all ways back to the caller lead to; nothing runs there."""
_STEERING: Final = p.If | p.While | p.For | p.Switch | p.Label | p.Goto | p.Return | p.Stop


class ControlFlowGraph:
    """The statements of a body as numbered nodes; vendor statements may lead to labels they name.

    runs: by node, its statements and expressions in order: for a statement that holds others, its
    condition or its head. after: by node, those that may follow. start: the first one.
    """

    def __init__(self, body: Body, whole: Callable[[p.Statement], bool] = lambda _: False) -> None:
        """whole: statements that are not taken apart, whatever they hold."""
        self._whole = whole
        self.runs: list[tuple[Any, ...]] = []
        self.after: dict[int, list[int]] = {}
        end = self._node(())
        named = {n.name if isinstance(n, p.Label) else n.label for n in walk(body)
                 if isinstance(n, p.Label | p.Goto)}  # fmt: skip
        self._labels = {name.lower(): self._node(()) for name in sorted(named)}
        self.start = self._body(body, end)

    def _node(self, runs: tuple[Any, ...], *after: int) -> int:
        number = len(self.runs)
        self.runs.append(runs)
        self.after[number] = list(after)
        return number

    def _named(self, node: p.Statement) -> list[int]:
        """The labels that a statement which is kept as its text may lead to."""
        if not self._labels or not isinstance(node, p.Opaque):
            return []
        return [self._labels[name] for name in effect_of(node).names & self._labels.keys()]

    def _body(self, body: Body, after: int) -> int:
        """Return the node at the beginning of a body. after: the node that follows the body."""
        # Backwards, as each part needs the node that follows it. Plain statements share one node.
        for steers, nodes in groupby(reversed(body), self._steers):
            if steers:
                for node in nodes:
                    after = self._statement(node, after)
            else:
                after = self._node(tuple(nodes)[::-1], after)
        return after

    def _steers(self, node: p.Statement) -> bool:
        if isinstance(node, _STEERING):
            return not self._whole(node)
        return bool(self._named(node))

    def _statement(self, node: p.Statement, after: int) -> int:
        match node:
            case p.Label(name):
                label = self._labels[name.lower()]
                self.after[label] = [after]
                return label
            case p.Goto(name):
                return self._node((), self._labels[name.lower()])
            case p.Return():
                return self._node((node,), EXIT)
            case p.Stop(end=True):
                # An end of the program: nothing follows.
                return self._node((node,))
            case p.If(branches, otherwise):
                other = self._body(otherwise, after)
                for branch in reversed(branches):
                    first = self._body(branch.body, after)
                    other = self._node((branch.condition,), first, other)
                return other
            case p.Switch(_, cases, otherwise):
                bodies = [*(case.body for case in cases), otherwise]
                return self._node((head(node),), *(self._body(body, after) for body in bodies))
            case p.While(condition, body):
                # A loop without end is left only by jumps.
                loop = self._node((condition,), *(() if _is_always_true(condition) else (after,)))
                self.after[loop].append(self._body(body, loop))
                return loop
            case p.For(body=body):
                loop = self._node((head(node),), after)
                self.after[loop].append(self._body(body, loop))
                return loop
        return self._node((node,), after, *self._named(node))


def _is_always_true(condition: e.Expression) -> bool:
    """True if a condition always holds."""
    match condition:
        case e.Truth(value) | e.Number(value):
            return bool(value)
    return False
