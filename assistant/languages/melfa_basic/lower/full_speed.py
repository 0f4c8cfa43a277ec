"""Moves of the tool that some path leads to without any `Spd`, as fast as the arm can be."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from assistant.base.diagnostics import Span
from assistant.languages.line_blocks import EXIT, Blocks, Graph
from assistant.languages.melfa_basic.lift.structure.blocks import Structure
from assistant.languages.melfa_basic.lift.structure.regions import Region, procedure_regions
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import blocks_of, statement_of
from assistant.languages.melfa_basic.tree.columnar import MOV, MoveRows, row_spans
from assistant.languages.melfa_basic.tree.targets import graph_of, with_labelled_jumps
from assistant.languages.melfa_basic.tree.walk import (
    nodes,
    program_key,
    program_name,
    statements_in,
)

JOINT_MOVES: Final = ("Mov", "Mva")
"""Moves whose speed `JOvrd` sets."""


def unset_speeds(trees: Sequence[Any]) -> Iterator[Span | None]:
    """The lines of such moves, in a program of several files of which the first one begins."""
    starts, at = [], 0
    for tree in trees:
        starts.append(at)
        at += len(tree.source.text if tree.source else "") + 1
    code = [_FileCode(tree) for tree in trees]
    named = {program_key(program_name(tree)): k for k, tree in enumerate(trees)}
    while sum(one.settle(code, named) for one in code):
        pass
    pending, seen = [0] if code else [], set[int]()
    while pending:
        if (number := pending.pop()) in seen:
            continue
        seen.add(number)
        one = code[number]
        for at in sorted(one.unset(one.start, code, named, into=True) - {EXIT}):
            item = one.items[at]
            pending += [named[key] for key in _called_programs(item) if key in named]
            for span in _tool_moves(item):
                yield None if span is None else span.moved(starts[number])


class _FileCode:
    """The lines of a file, and its subroutines from which a path leads back without `Spd`."""

    def __init__(self, tree: s.File) -> None:
        self.items, _ = with_labelled_jumps(tree.code)
        self.start = [0] if self.items else []
        blocks, functions = blocks_of(self.items), _function_regions(self.items)
        if functions is None:
            self.graph = graph_of(self.items, range(len(self.items)), blocks)
        else:
            self.graph, self.start = _function_graph(self.items, functions, blocks)
        self.transparent: set[int] = set()
        self.passes = False
        """True if a path leads through the whole file without `Spd`."""

    def settle(self, code: Sequence[_FileCode], named: Mapping[str, int]) -> bool:
        """Finds more of them by what is known of all files; true if there are any."""
        before = len(self.transparent), self.passes
        for entry in self.graph.called - self.transparent:
            if EXIT in self.unset([entry], code, named):
                self.transparent.add(entry)
        if self.start and not self.passes:
            found = self.unset(self.start, code, named)
            self.passes = EXIT in found or any(
                any(one == s.Command("End") for one in statements_in(statement_of(self.items[at])))
                for at in found - {EXIT}
            )
        return (len(self.transparent), self.passes) != before

    def unset(
        self,
        starts: Sequence[int],
        code: Sequence[_FileCode],
        named: Mapping[str, int],
        *,
        into: bool = False,
    ) -> set[int]:
        """The lines that some path leads to from others without `Spd`, EXIT among them.

        into: also those called.
        """
        found, pending = set[int](), list(starts)
        while pending:
            at = pending.pop()
            if at in found:
                continue
            found.add(at)
            if at == EXIT:
                continue
            item, calls = self.items[at], self.graph.calls.get(at, ())
            if into:
                pending += calls
            if _sets_speed(statement_of(item)):
                continue
            if _calls_surely(statement_of(item)) and any(c not in self.transparent for c in calls):
                continue
            programs = [named[key] for key in _called_programs(item) if key in named]
            if programs and not any(code[k].passes for k in programs):
                continue
            pending += self.graph.after[at]
        return found


def _sets_speed(node: s.Statement | s.Target | None) -> bool:
    """True if a statement sets the speed whatever its condition is."""
    match node:
        case s.Command(keyword="Spd"):
            return True
        case s.If(then=then, otherwise=otherwise) if then is not None:
            return _sets_speed(then) and _sets_speed(otherwise)
    return False


def _calls_surely(node: s.Statement | None) -> bool:
    """True if a statement calls all that it names; one of `On n GoSub` is called, or none."""
    return isinstance(node, s.Jump | s.Call | s.Assign)


def _function_regions(items: Sequence[Any]) -> list[Region] | None:
    """The procedures of a file of functions, the one that runs first before the others."""
    if not any(isinstance(statement_of(item), s.Function) for item in items):
        return None
    return procedure_regions(items, Structure(items).depth, {}, False)


def _function_graph(
    items: Sequence[Any], parts: Sequence[Region], blocks: Blocks
) -> tuple[Graph, list[int]]:
    """The paths through functions, and the line that the program begins with."""
    graph, first = Graph(), dict[str, int]()
    for part in parts:
        places = part.places()
        graph.after |= graph_of(items, places, blocks).after
        if places and part.function is not None:
            first[part.function.name.upper()] = places[0]
    for at in graph.after.keys() - {EXIT}:
        statement = statement_of(items[at])
        result = getattr(statement, "target", None)  # a function that gives itself a value
        named = (
            one.key for one in nodes(statement) if isinstance(one, s.Variable) and one is not result
        )
        if calls := [first[key] for key in named if key in first]:
            graph.calls[at] = calls
    return graph, parts[0].places()[:1]


def _called_programs(item: Any) -> Iterator[str]:
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
        isinstance(one, s.Motion) and one.keyword not in JOINT_MOVES
        for one in nodes(statement_of(item))
    ):
        yield item.span
