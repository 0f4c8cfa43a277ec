"""Step numbers of lines, and jumps that name them.

A line has its step number in `number` (None without one), a table of lines has those of its rows in
`steps`; other items of a file have neither. Lines are renumbered together with the jumps to them,
and new lines get numbers between those of their neighbours.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from assistant.base.arrays import Ints
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Rule
from assistant.base.source_text import SourceText, finding_in
from assistant.languages.runs.columns import Run, rows_of

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
    """Return the number of steps in some items, if every line is one."""
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
    # Steps shrink where a long program would pass the last number.
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


UNNUMBERED: Final = 0
"""Stands for the number of a line that is to get one."""


@dataclass(frozen=True, slots=True)
class Steps:
    """Step numbers of a language.

    line: type of a single line. last: the highest number. named: numbers that the jumps of some
    items name. retargeted: an item whose jumps name others. falling, past_last, unknown: rules for
    numbers that do not ascend, that are too high, and for a jump to a number that no line has.
    """

    line: type[Any]
    last: int
    named: Callable[[Iterable[Any]], Collection[int]]
    retargeted: Callable[[Any, Change], Any]
    falling: Rule
    past_last: Rule
    unknown: Rule


def renumbered(
    items: Sequence[Any], first: int, step: int, steps: Steps, source: SourceText | None
) -> list[Any]:
    """The lines with the numbers first, first + step …, and the jumps to them.

    source: that the items were read from. Raises Refused where a jump has no destination, where
    numbers do not ascend (which of two lines comes first is open then), or where the last number
    would be too high.
    """
    numbers = [steps_of(item) for item in items]
    old = np.concatenate([np.empty(0, dtype=np.int64), *numbers])
    ends = np.cumsum([len(some) for some in numbers])
    new = first + step * np.arange(len(old), dtype=np.int64)
    known = np.flatnonzero(old != UNNUMBERED)
    wanted = np.array(sorted(steps.named(items)), dtype=np.int64)
    # -1 for a number that no line has.
    at = rows_of(old[known], wanted)
    there = new[known[at[at >= 0]]]
    places: dict[str | int, int] = dict(zip(wanted[at >= 0].tolist(), there.tolist(), strict=True))

    found: list[Diagnostic] = []
    falls = np.flatnonzero(np.diff(old[known], prepend=0) <= 0)
    # One finding for a table, however many of its rows fall.
    owners, once = np.unique(np.searchsorted(ends, known[falls], "right"), return_index=True)
    for owner, fall in zip(owners.tolist(), falls[once].tolist(), strict=True):
        number, before = (int(old[known[k]]) for k in (fall, fall - 1))
        where, told = items[owner].span, {"number": number, "before": before}
        found.append(finding_in(source, steps.falling, where, **told))
    if len(new) and new[-1] > steps.last:
        told = {"count": len(new), "first": first, "step": step, "last": int(new[-1])}
        found.append(finding_in(source, steps.past_last, None, **told, most=steps.last))
    made: list[Any] = []
    for item, some, end in zip(items, numbers, ends.tolist(), strict=True):
        if len(some):
            lost = sorted(set(steps.named([item])) - places.keys())
            found += [finding_in(source, steps.unknown, item.span, name=number) for number in lost]
            item = steps.retargeted(item, lambda to: places.get(to, to))
            item = with_steps(item, new[end - len(some) : end])
        made.append(item)
    if found:
        raise Refused(*found)
    return made


def with_fitted_steps(items: Sequence[Any], step: int, steps: Steps) -> list[Any] | None:
    """New lines with numbers between their neighbours; where there is no room others move on.

    Jumps go with their lines. step: between lines behind all others. None if numbers end before
    the program does.
    """
    # Without a single number the text has none, and gets none.
    if not any(steps_of(item).any() for item in items):
        return list(items)
    made: list[Any] = []
    moved: dict[str | int, int] = {}
    last = 0
    for at, item in enumerate(items):
        old = steps_of(item)
        if len(old):
            # Old numbers stay where they are high enough.
            new = np.maximum(old, last + 1 + np.arange(len(old)))
            item = with_steps(item, new)
            moved |= {a: b for a, b in zip(old.tolist(), new.tolist(), strict=True) if a != b and a}
            last = int(new[-1])
        elif isinstance(item, steps.line):
            last += _room(items, at, last, step, steps)
            item = replace(item, number=last)
        made.append(item)
    if last > steps.last:
        return None
    return [steps.retargeted(i, lambda to: moved.get(to, to)) for i in made] if moved else made


def _room(items: Sequence[Any], at: int, last: int, step: int, steps: Steps) -> int:
    """Return the increment from the number of the previous line to that of a new one."""
    # Several new lines share the room up to the next number.
    count = 1
    for item in islice(items, at, None):
        following = steps_of(item)
        if len(following):
            return max((int(following[0]) - last) // count, 1)
        count += isinstance(item, steps.line)
    return step
