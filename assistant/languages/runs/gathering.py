"""Neighbours that are alike as one run, however they came about."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import groupby
from typing import Any, TypeVar

from assistant.languages.runs.columns import Run, joined_runs

T = TypeVar("T")
Row = tuple[object, Any]
"""What an item may be joined with others as: what those have in common, and the item's run or, of
a single row, what it says.
"""


def gather_runs(
    items: Sequence[T],
    rows: Iterable[Row | None],
    run: Callable[[list[Any]], Run],
    node: Callable[[Sequence[T], Any], T],
    fewest: int,
) -> Iterator[T]:
    """The items, neighbours that are alike as one item if they have enough rows.

    rows: of each item, None for one that is joined with none. run: of single rows. node: the item
    of several, with their run. fewest: rows that make a run; what is less comes as it is.
    """
    for _, pairs in groupby(zip(items, rows, strict=True), lambda pair: pair[1] and pair[1][0]):
        stretch = list(pairs)
        said = [row[1] for _, row in stretch if row is not None]
        if len(said) < 2 or sum(len(x) if isinstance(x, Run) else 1 for x in said) < fewest:
            yield from (item for item, _ in stretch)
            continue
        parts: list[Run] = []
        for is_run, alike in groupby(said, lambda one: isinstance(one, Run)):
            these = list(alike)
            parts += these if is_run else [run(these)]
        yield node([item for item, _ in stretch], joined_runs(parts))
