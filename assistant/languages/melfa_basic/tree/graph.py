"""The ways through some lines of a program: which line can follow which, and what calls what."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import Block, Blocks, statement_of
from assistant.languages.melfa_basic.tree.targets import ON, exits_of, labels_of
from assistant.program.analysis.dataflow import reachable

EXIT: Final = -1
"""The place that a `Return` leads to, and the last line: behind all of the lines."""


@dataclass(slots=True)
class Graph:
    """The ways through some lines, all by their places.

    labels: upper case → place of the line. after: places that may follow a line. calls: those of
    the labels that it calls. handlers: of a label that interrupts lead to the line that says so,
    and whether it is called. jumps: what a line jumps to, not by running on.
    """

    labels: Mapping[str, int]
    after: dict[int, list[int]] = field(default_factory=dict)
    calls: dict[int, list[int]] = field(default_factory=dict)
    handlers: dict[int, tuple[int, bool]] = field(default_factory=dict)
    jumps: dict[int, list[int]] = field(default_factory=dict)

    @property
    def called(self) -> set[int]:
        """Places of labels that are called as subroutines."""
        return {place for places in self.calls.values() for place in places}

    def reached(self, starts: Iterable[int], *, through_calls: bool = False) -> set[int]:
        """Places that can be come to from some, themselves included."""
        calls = self.calls if through_calls else {}
        return reachable(starts, lambda at: (*self.after[at], *calls.get(at, ()))) - {EXIT}


def graph_of(
    code: Sequence[object],
    places: Sequence[int],
    blocks: Blocks,
    steps: Mapping[int, int] | None = None,
) -> Graph:
    """The ways through the lines at some places, which follow each other in that order.

    steps: place by step number, for jumps to them.
    """
    made = _Maker(code, blocks, steps or {}, Graph(labels_of(code, places)))
    made.following = dict(itertools.pairwise(places))
    for at in places:
        made.graph.after[at] = list(dict.fromkeys(made.after(at)))
    made.graph.after[EXIT] = []
    return made.graph


@dataclass(slots=True)
class _Maker:
    code: Sequence[object]
    blocks: Blocks
    steps: Mapping[int, int]
    graph: Graph
    following: dict[int, int] = field(default_factory=dict)

    def after(self, at: int) -> Iterator[int]:
        """The places that may follow a line."""
        if block := self.blocks.words.get(at):
            yield from self.behind_word(at, block)
            return
        exits = exits_of(statement_of(self.code[at]))
        if exits is ON:
            yield self.on(at)
            return
        for table, targets in (self.graph.jumps, exits.jumps), (self.graph.calls, exits.calls):
            for place in self.places(targets):
                table.setdefault(at, []).append(place)
        for target, called in exits.handlers:
            for place in self.places((target,)):
                self.graph.handlers.setdefault(place, (at, called))
        yield from self.graph.jumps.get(at, ())
        inner = self.blocks.around.get(at)
        if exits.breaks and inner is not None and inner.last is not None:
            yield self.on(inner.last)
        if exits.returns:
            yield EXIT
        if exits.on:
            yield self.on(at)

    def places(self, targets: Iterable[s.Target]) -> Iterator[int]:
        for target in targets:
            place = target.place
            if isinstance(place, int):
                at = self.steps.get(place)
            else:
                at = self.graph.labels.get(place.upper())
            if at is not None:
                yield at

    def on(self, at: int) -> int:
        """Where control runs on behind a line: at the end of a branch, to the end of its block."""
        place = self.following.get(at, EXIT)
        block = self.blocks.words.get(place)
        return place if block is None or place not in block.parts else block.words[-1]

    def behind_word(self, at: int, block: Block) -> Iterator[int]:
        """What follows an opening, middle or closing word."""
        statement = statement_of(self.code[at])
        loops = block.kind in ("For", "While")
        end = block.words[-1]
        if at == end and loops:  # a Next of several variables goes back to any of its loops
            yield from (closed.first for closed in self.blocks.closing[at])
        elif at != end and isinstance(statement, s.Select):  # lines above the first Case never run
            yield from block.parts
            if not any(_is_default(self.code[part]) for part in block.parts):
                yield end
        else:
            yield self.on(at)
            if at != end and loops and not _is_endless(statement):
                yield self.on(end)
            elif block.kind == "If" and at != end:  # also behind Else, which is a finding
                later = [part for part in block.parts if part > at]
                tests = isinstance(statement, s.If | s.ElseIf)
                yield from later[:1] or ([end] if tests else [])


def _is_default(item: object) -> bool:
    return statement_of(item) == s.Command("Default")


def _is_endless(statement: s.Statement | None) -> bool:
    """Whether it is the head of a loop whose condition is a number, and not 0."""
    match statement:
        case s.Command("While", (s.Number(value=value), *_)):
            return value != 0
    return False
