"""Moves of the tool that some path leads to without any `Spd`, as fast as the arm can be."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from assistant.languages.line_graph import EXIT
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import blocks_of, statement_of
from assistant.languages.melfa_basic.tree.columnar import MOV, MoveRows, row_spans
from assistant.languages.melfa_basic.tree.targets import graph_of, labelled
from assistant.languages.melfa_basic.tree.walk import (
    nodes,
    program_key,
    program_name,
    statements_in,
)
from assistant.program.diagnostics import Span

JOINT: Final = ("Mov", "Mva")
"""Moves whose speed `JOvrd` sets."""


def unset_speeds(trees: Sequence[Any]) -> Iterator[Span | None]:
    """The lines of such moves, in a program of several files of which the first one begins."""
    starts, at = [], 0
    for tree in trees:
        starts.append(at)
        at += len(tree.source.text if tree.source else "") + 1
    code = [_Code(tree) for tree in trees]
    named = {program_key(program_name(tree)): k for k, tree in enumerate(trees)}
    while sum(one.settle(code, named) for one in code):
        pass
    pending, seen = [0] if code else [], set[int]()
    while pending:
        if (number := pending.pop()) in seen:
            continue
        seen.add(number)
        one = code[number]
        for at in sorted(one.unset([0] if one.items else [], code, named, into=True)):
            item = one.items[at]
            pending += [named[key] for key in _called(item) if key in named]
            for span in _tool_moves(item):
                yield None if span is None else span.moved(starts[number])


class _Code:
    """The lines of a file, and its subroutines from which a path leads back without `Spd`."""

    def __init__(self, tree: s.File) -> None:
        self.items, _ = labelled(tree.code)
        self.graph = graph_of(self.items, range(len(self.items)), blocks_of(self.items))
        self.transparent: set[int] = set()
        self.passes = False
        """True if a path leads through the whole file without `Spd`."""

    def settle(self, code: Sequence[_Code], named: Mapping[str, int]) -> bool:
        """Finds more of them by what is known of all files; true if there are any."""
        before = len(self.transparent), self.passes
        for entry in self.graph.called - self.transparent:
            if self._leaves(self.unset([entry], code, named)):
                self.transparent.add(entry)
        if self.items and not self.passes:
            found = self.unset([0], code, named)
            self.passes = self._leaves(found) or any(
                any(one == s.Command("End") for one in statements_in(statement_of(self.items[at])))
                for at in found
            )
        return (len(self.transparent), self.passes) != before

    def _leaves(self, found: set[int]) -> bool:
        return any(EXIT in self.graph.after[at] for at in found)

    def unset(
        self,
        starts: Sequence[int],
        code: Sequence[_Code],
        named: Mapping[str, int],
        *,
        into: bool = False,
    ) -> set[int]:
        """The lines that some path leads to from others without `Spd`. into: also those called."""
        found, pending = set[int](), list(starts)
        while pending:
            at = pending.pop()
            if at == EXIT or at in found:
                continue
            found.add(at)
            item, calls = self.items[at], self.graph.calls.get(at, ())
            if into:
                pending += calls
            if _sets(statement_of(item)):
                continue
            if calls and self.transparent.isdisjoint(calls) and _calls_surely(statement_of(item)):
                continue
            programs = [named[key] for key in _called(item) if key in named]
            if programs and not any(code[k].passes for k in programs):
                continue
            pending += self.graph.after[at]
        return found


def _sets(node: s.Statement | s.Target | None) -> bool:
    """True if a statement sets the speed whatever its condition is."""
    match node:
        case s.Command(keyword="Spd"):
            return True
        case s.If(then=then, otherwise=otherwise) if then is not None:
            return _sets(then) and _sets(otherwise)
    return False


def _calls_surely(node: s.Statement | None) -> bool:
    return isinstance(node, s.Jump)


def _called(item: Any) -> Iterator[str]:
    """The programs that a line calls."""
    for node in statements_in(statement_of(item)):
        if isinstance(node, s.CallP) and isinstance(node.program, s.String):
            yield program_key(node.program.value)


def _tool_moves(item: Any) -> Iterator[Span | None]:
    """The lines of an item that move the tool by its own speed."""
    if isinstance(item, MoveRows):
        moves = (item.kinds != MOV).tolist()
        yield from (span for span, is_one in zip(row_spans(item), moves, strict=False) if is_one)
    elif any(
        isinstance(one, s.Motion) and one.keyword not in JOINT for one in nodes(statement_of(item))
    ):
        yield item.span
