"""Step numbers: taken away, jumps to them made jumps to labels, and given anew."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Sequence
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from assistant.languages.melfa_basic.tables.dialects import LAST_STEP
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.program.rewriting import records, rewrite

T = TypeVar("T")


def targets(items: Sequence[s.Item]) -> Iterator[s.Target]:
    """Every jump target in the lines of a program."""
    for item in items:
        if isinstance(item, s.Line):
            yield from (r for r in records(item.statement) if isinstance(r, s.Target))


def retargeted(node: T, places: dict[str | int, str | int]) -> T:
    """The node with jump targets exchanged by a table: step numbers, labels in upper case."""

    def changed(record: Any) -> Any:
        if not isinstance(record, s.Target):
            return record
        place = record.place
        key = place.upper() if isinstance(place, str) else place
        return s.Target(places[key]) if key in places else record

    return rewrite(node, changed)


def labels_of(items: Sequence[s.Item]) -> set[str]:
    """Labels in upper case."""
    return {i.label.upper() for i in items if isinstance(i, s.Line) and i.label is not None}


def labelled(items: Sequence[s.Item]) -> tuple[list[s.Item], dict[str, int]]:
    """The lines with jumps to labels only, and which labels were made for which steps.

    A number that no line has stays in its jump.
    """
    wanted = {t.place for t in targets(items) if isinstance(t.place, int)}
    if not wanted:
        return list(items), {}
    taken, made, names = labels_of(items), dict[str, int](), dict[str | int, str | int]()
    lines: list[s.Item] = []
    for item in _split(items, wanted):
        number = _first_step(item)
        if number in wanted and number not in names:
            if isinstance(item, s.Line) and item.label is not None:
                names[number] = item.label
            else:
                label = f"L{number}"
                while label in taken:
                    label += "X"
                taken.add(label)
                made[label] = number
                names[number] = label
                lines.append(s.Line(label=label))
        lines.append(item)
    return [retargeted(i, names) if isinstance(i, s.Line) else i for i in lines], made


def _split(items: Sequence[s.Item], wanted: Collection[int]) -> Iterator[s.Item]:
    """Rows of moves cut where a jump goes to one of them."""
    for item in items:
        if not isinstance(item, MoveRows):
            yield item
            continue
        cuts = np.flatnonzero(np.isin(item.steps, np.fromiter(wanted, np.int64)))
        edges = [0, *(c for c in cuts.tolist() if c), len(item)]
        for low, high in itertools.pairwise(edges):
            yield _rows(item, low, high) if len(edges) > 2 else item


def _rows(rows: MoveRows, low: int, high: int) -> MoveRows:
    columns = {
        f.name: getattr(rows, f.name)[low:high]
        for f in fields(rows)
        if f.name not in ("stem", "span")
    }
    return replace(rows, **columns, span=None)


def _first_step(item: s.Item) -> int | None:
    if isinstance(item, MoveRows):
        return int(item.steps[0])
    return item.number if isinstance(item, s.Line) else None


def bare(items: Sequence[s.Item]) -> list[s.Item]:
    """The lines without step numbers."""
    return [replace(i, number=None) if isinstance(i, s.Line) else i for i in items]


def numbered(
    items: Sequence[s.Item], step: int, as_steps: Collection[str] = ()
) -> list[s.Item] | None:
    """The lines with ascending step numbers; None if there are more than a program may have.

    step: between numbers, made smaller if they would not fit. as_steps: labels (upper case)
    that go again, with jumps to the number of the line below them.
    """
    kept, dropped = _without(items, as_steps)
    count = sum(len(i) if isinstance(i, MoveRows) else isinstance(i, s.Line) for i in kept)
    if count > LAST_STEP:
        return None
    step = max(1, min(step, LAST_STEP // max(count, 1)))
    number = 0
    lines: list[s.Item] = []
    first: list[int] = []
    for item in kept:
        first.append(number + step)
        if isinstance(item, MoveRows):
            steps = number + step * np.arange(1, len(item) + 1, dtype=np.int64)
            lines.append(replace(item, steps=steps))
            number = int(steps[-1])
        elif isinstance(item, s.Line):
            number += step
            lines.append(replace(item, number=number))
        else:
            lines.append(item)
    if not dropped:
        return lines
    places: dict[str | int, str | int] = {name: first[at] for name, at in dropped.items()}
    return [retargeted(i, places) if isinstance(i, s.Line) else i for i in lines]


def _without(
    items: Sequence[s.Item], as_steps: Collection[str]
) -> tuple[list[s.Item], dict[str, int]]:
    """The items without such labels, and the place of the item that each of them stood above."""
    kept: list[s.Item] = []
    dropped: dict[str, int] = {}
    for at, item in enumerate(items):
        below = items[at + 1] if at + 1 < len(items) else None
        if (
            isinstance(item, s.Line)
            and item.label is not None
            and item.label.upper() in as_steps
            and item.statement is None
            and item.comment is None
            and isinstance(below, s.Line | MoveRows)
        ):
            dropped[item.label.upper()] = len(kept)
        else:
            kept.append(item)
    return kept, dropped


def apart(items: Sequence[s.Item]) -> list[s.Item]:
    """The lines with each label on a line of its own."""
    made: list[s.Item] = []
    for item in items:
        if isinstance(item, s.Line) and item.label is not None and item.statement is not None:
            made += [s.Line(label=item.label, span=item.span), replace(item, label=None)]
        else:
            made.append(item)
    return made
