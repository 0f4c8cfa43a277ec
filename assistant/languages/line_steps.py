"""Step numbers of lines.

A line has its step number in `number`, None for none, a table of lines has those of its rows in
`steps`; other items of a file have neither.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from assistant.base.arrays import Ints
from assistant.languages.runs.columns import Run

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T", bound="DataclassInstance")
Change = Callable[[str | int], str | int]
"""Gives a jump another label or step number."""


def steps_of(item: object) -> Ints:
    """(n,) step numbers of a line or a table; none of what has none."""
    steps: Ints | None = getattr(item, "steps", None)
    if steps is not None:
        return steps
    number: int | None = getattr(item, "number", None)
    return np.array([] if number is None else [number], dtype=np.int64)


def first_step(item: object) -> int | None:
    """The step number of a line, of the first one of a table."""
    steps: Ints | None = getattr(item, "steps", None)
    number: int | None = getattr(item, "number", None) if steps is None else int(steps[0])
    return number


def steps_in(items: Iterable[object]) -> int:
    """How many steps some items are, if every line is one."""
    return sum(len(i.steps) if hasattr(i, "steps") else hasattr(i, "number") for i in items)


def with_steps(item: T, steps: Ints) -> T:
    """A line or a table with other step numbers (n,)."""
    if np.array_equal(steps_of(item), steps):
        return item
    if hasattr(item, "steps"):
        return replace(item, steps=steps)
    return replace(item, number=int(steps[0]))


def with_ascending_steps(items: Sequence[T], step: int, last: int) -> Iterator[T]:
    """The lines with ascending step numbers.

    step: between two of them, smaller where they would not fit otherwise. last: highest number.
    """
    step = max(1, min(step, last // max(steps_in(items), 1)))
    number = step
    for item in items:
        count = steps_in([item])
        yield with_steps(item, number + step * np.arange(count, dtype=np.int64)) if count else item
        number += step * count


def places_of_steps(items: Iterable[object]) -> dict[int, int]:
    """Step number → place of its line, of a table its own; the first of equal ones."""
    found: dict[int, int] = {}
    for at, item in enumerate(items):
        steps: Ints | None = getattr(item, "steps", None)
        for number in [first_step(item)] if steps is None else steps.tolist():
            if number is not None:
                found.setdefault(number, at)
    return found


def cut_at(items: Iterable[T], wanted: Collection[int]) -> Iterator[T]:
    """The items, tables cut so that each step of some numbers begins one."""
    for item in items:
        steps: Ints | None = getattr(item, "steps", None)
        edges = [] if steps is None else np.flatnonzero(np.isin(steps, list(wanted))).tolist()
        edges = sorted({0, *edges, 0 if steps is None else len(steps)})
        if len(edges) <= 2 or not isinstance(item, Run):
            yield item
        else:
            for low, high in itertools.pairwise(edges):
                yield item.rows(slice(low, high))
