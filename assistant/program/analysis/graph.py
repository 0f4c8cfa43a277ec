"""The ways through a procedure: what runs after what."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.kept import effect_of
from assistant.program.program import walk
from assistant.program.rewriting import Body, head

EXIT: Final = 0
"""The node that all ways back to the caller lead to; nothing runs there."""
_STEERING: Final = p.If | p.While | p.For | p.Switch | p.Label | p.Goto | p.Return | p.Stop


class ControlFlowGraph:
    """The statements of a body as nodes, which are numbers; kept text may go to what it names.

    runs: by node, what is worked out there, in order: statements, and of those that hold others
    their conditions or their heads. after: by node, those that may follow. start: the first one.
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
        """The node that a body begins at. after: the one behind it."""
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
                loop = self._node((condition,), *(() if is_always_true(condition) else (after,)))
                self.after[loop].append(self._body(body, loop))
                return loop
            case p.For(body=body):
                loop = self._node((head(node),), after)
                self.after[loop].append(self._body(body, loop))
                return loop
        return self._node((node,), after, *self._named(node))


def is_always_true(condition: e.Expression) -> bool:
    """Whether a condition always holds."""
    match condition:
        case e.Truth(value) | e.Number(value):
            return bool(value)
    return False
