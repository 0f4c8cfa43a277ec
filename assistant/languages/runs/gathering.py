"""Neighbours that are alike as one run, however they came about."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import groupby
from operator import itemgetter
from typing import TypeVar

from assistant.languages.runs.columns import Run

T = TypeVar("T")


def gathered(
    items: Iterable[T],
    kinds: Iterable[object],
    run: Callable[[T], Run | None],
    fewest: int,
    join: Callable[[Sequence[T]], T],
) -> Iterator[Sequence[T]]:
    """Neighbours of one kind, as one item if they have enough rows.

    kinds: of each item, None for one that is joined with none. run: of an item that has one
    already; others are a row. fewest: rows that make a run. What is less comes as it is, all that
    are alike together.
    """
    for kind, pairs in groupby(zip(items, kinds, strict=True), itemgetter(1)):
        stretch = [item for item, _ in pairs]
        runs = (run(item) for item in stretch)
        if kind is None or sum(1 if one is None else len(one) for one in runs) < fewest:
            yield stretch
        else:
            yield stretch if len(stretch) == 1 else [join(stretch)]
