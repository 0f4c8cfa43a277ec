"""Where statements lead, the labels and steps that they name, and the ways through lines."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, TypeVar

import numpy as np

from assistant.languages import line_graph
from assistant.languages.line_blocks import Blocks
from assistant.languages.line_graph import ON, Exits, Graph
from assistant.languages.melfa_basic.tables.dialects import LAST_STEP
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import statement_of
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.program.arrays import Ints

T = TypeVar("T", s.Item, s.Entry)
I = TypeVar("I", bound=s.Item)  # noqa: E741
Change = Callable[[str | int], str | int]
"""Gives a jump another label or step number."""


_WORDS: Final[Mapping[str, Exits[s.Target]]] = {
    "Break": Exits(on=False, breaks=True),
    "Return": Exits(on=False, returns=True),
    "Exit Function": Exits(on=False, returns=True),
    "FEnd": Exits(on=False, returns=True),
    "End": Exits(on=False),
}
"""`Break` leads behind the innermost block, an `If` too: stated for `If` and `Select` [CR1D 4-208],
for loops as programs use it. An `If` on one line is no block.
"""


def exits_of(statement: s.Statement | s.Target | None) -> Exits[s.Target]:
    """Where a statement leads; a target is a jump to it."""
    match statement:
        case (s.Target() as target) | s.Jump("GoTo", target):
            return Exits(jumps=(target,), on=False)
        case s.Jump(_, target):
            return Exits(calls=(target,))
        case s.OnJump(_, keyword, targets):
            named = tuple(target for target in targets if target is not None)
            return Exits(jumps=named) if keyword == "GoTo" else Exits(calls=named)
        case s.OnCom(_, target):
            return Exits(handlers=((target, True),))
        case s.DefAct(_, _, keyword, target):
            return Exits(handlers=((target, keyword == "GoSub"),))
        case s.If(_, then, otherwise) if then is not None:
            return exits_of(then) | exits_of(otherwise)
        case s.Command(keyword=keyword):
            return _WORDS.get(keyword, ON)
    return ON


def graph_of(
    code: Sequence[object],
    places: Sequence[int],
    blocks: Blocks,
    steps: Mapping[int, int] | None = None,
) -> Graph:
    """The ways through the lines at some places, which follow each other in that order.

    steps: place by step number, for jumps to them.
    """
    labels, known = labels_of(code, places), steps or {}

    def find(target: s.Target) -> int | None:
        place = target.place
        return known.get(place) if isinstance(place, int) else labels.get(place.upper())

    return line_graph.graph_of(places, blocks, lambda at: exits_of(statement_of(code[at])), find)


def targets_in(items: Iterable[object]) -> Iterator[s.Target]:
    """Every jump target of some lines."""
    for item in items:
        if (exits := exits_of(statement_of(item))) is not ON:
            yield from exits.targets


def labels_named(items: Iterable[object]) -> Iterator[str]:
    """The labels that the jumps of some lines name, in upper case."""
    for target in targets_in(items):
        if isinstance(target.place, str):
            yield target.place.upper()


def steps_named(items: Iterable[object]) -> set[int]:
    """The step numbers that the jumps of some lines name."""
    return {target.place for target in targets_in(items) if isinstance(target.place, int)}


def labels_written(items: Iterable[object]) -> Iterator[str]:
    """The labels of some lines as they are written."""
    for item in items:
        if isinstance(item, s.Line) and item.label is not None:
            yield item.label


def labels_of(code: Sequence[object], places: Iterable[int] | None = None) -> dict[str, int]:
    """The labels of the lines at some places, in upper case, with the first place of each."""
    found: dict[str, int] = {}
    for at in range(len(code)) if places is None else places:
        item = code[at]
        if isinstance(item, s.Line) and item.label is not None:
            found.setdefault(item.label.upper(), at)
    return found


def lone_labels(code: Sequence[object]) -> dict[str, int]:
    """The same of lines that are a label and nothing else."""
    alone = (
        at
        for at, item in enumerate(code)
        if isinstance(item, s.Line) and item.statement is None and item.comment is None
    )
    return labels_of(code, alone)


def retargeted(item: I, change: Change) -> I:
    """The line with its jumps changed."""
    statement = statement_of(item)
    if not isinstance(item, s.Line) or not exits_of(statement).targets:
        return item
    changed = _retargeted(statement, change)
    return item if changed == statement else replace(item, statement=changed)


def _retargeted(node: Any, change: Change) -> Any:
    match node:
        case s.Target(place=place):
            return s.Target(change(place))
        case s.Jump(target=target) | s.OnCom(target=target) | s.DefAct(target=target):
            return replace(node, target=_retargeted(target, change))
        case s.OnJump(targets=targets):
            return replace(node, targets=tuple(_retargeted(one, change) for one in targets))
        case s.If(condition, then, otherwise):
            return s.If(condition, _retargeted(then, change), _retargeted(otherwise, change))
    return node


# ---------------------------------------------------------------------------------------- steps


def steps_in(items: Iterable[object]) -> int:
    """How many steps some lines are."""
    return sum(len(i) if isinstance(i, MoveRows) else isinstance(i, s.Line) for i in items)


def numbered(items: Sequence[T], step: int) -> Iterator[T]:
    """The lines with ascending step numbers.

    step: between two of them, smaller where they would not fit otherwise.
    """
    step = max(1, min(step, LAST_STEP // max(steps_in(items), 1)))
    number = step
    for item in items:
        count = steps_in([item])
        yield with_steps(item, number + step * np.arange(count, dtype=np.int64))
        number += step * count


def steps_of(item: object) -> Ints:
    """(n,) step numbers of a line or a table of moves; none of what has none."""
    if isinstance(item, MoveRows):
        return item.steps
    number = item.number if isinstance(item, s.Line) else None
    return np.array([] if number is None else [number], dtype=np.int64)


def with_steps(item: T, steps: Ints) -> T:
    """A line or a table of moves with other step numbers (n,)."""
    if isinstance(item, MoveRows):
        return item if np.array_equal(item.steps, steps) else replace(item, steps=steps)
    if isinstance(item, s.Line) and item.number != int(steps[0]):
        return replace(item, number=int(steps[0]))
    return item


def first_step(item: object) -> int | None:
    """The step number of a line, of the first one of a table of moves."""
    if isinstance(item, MoveRows):
        return int(item.steps[0])
    return item.number if isinstance(item, s.Line) else None


def places_of_steps(code: Iterable[object]) -> dict[int, int]:
    """Step number → place of its line, of a table of moves its own; the first of equal ones."""
    found: dict[int, int] = {}
    for at, item in enumerate(code):
        for number in item.steps.tolist() if isinstance(item, MoveRows) else [first_step(item)]:
            if number is not None:
                found.setdefault(number, at)
    return found


def labelled(items: Sequence[T]) -> tuple[list[T | s.Line], dict[str, int]]:
    """The lines with jumps to labels only, and which labels were made for which steps.

    A number that no line has stays in its jump. A table of moves is cut where a jump leads to.
    """
    wanted = steps_named(items)
    if not wanted:
        return list(items), {}
    taken = set(labels_of(items))
    made: dict[str, int] = {}
    names: dict[str | int, str] = {}
    lines: list[T | s.Line] = []
    for item in _cut(items, wanted):
        number = first_step(item)
        if number in wanted and number not in names:
            if isinstance(item, s.Line) and item.label is not None:
                names[number] = item.label
            else:
                label = names[number] = _free(f"L{number}", taken)
                made[label] = number
                lines.append(s.Line(label=label, span=getattr(item, "span", None)))
        lines.append(item)
    return [retargeted(item, lambda place: names.get(place, place)) for item in lines], made


def _free(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "X"
    taken.add(name)
    return name


def _cut(items: Iterable[T], wanted: set[int]) -> Iterator[T | MoveRows]:
    for item in items:
        edges: list[int] = []
        if isinstance(item, MoveRows):
            edges = np.flatnonzero(np.isin(item.steps, list(wanted))).tolist()
            edges = sorted({0, *edges, len(item)})
        if not isinstance(item, MoveRows) or len(edges) <= 2:
            yield item
            continue
        for low, high in itertools.pairwise(edges):
            yield item.rows(slice(low, high))
