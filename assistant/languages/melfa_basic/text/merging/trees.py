"""Changes of a program made in the text that it was lifted from.

Lifting and building lose layout, order and spelling, so a changed program is built twice, as it
was lifted and as it is now. What differs between the two is changed in the tree as well. Where
that can go is tried out, and a try counts only if the outcome says what the built tree says.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from assistant.languages.melfa_basic.tables.dialects import DIALECTS, LAST_STEP
from assistant.languages.melfa_basic.text.merging.data import merged_data
from assistant.languages.melfa_basic.text.merging.entries import Entry, entries
from assistant.languages.melfa_basic.text.merging.names import named_as
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.targets import retargeted
from assistant.languages.texts import merging

HEADER_END = "' robot-assistant: end"
HEADER = "' robot-assistant: melfa-basic"


def merge(tree: s.File, before: s.File, after: s.File, says: Callable[[s.File], bool]) -> s.File:
    """The tree with everything changed that differs between two built trees, else `after`.

    says: whether a tree says what `after` does.
    """
    old, new = (named_as(file, tree) for file in (before, after))
    for forward, restored in product((False, True), (False, True)):
        merged = _merged(tree, old, new, forward, restored)
        if merged is not None and says(merged):
            return merged
    return after


def _merged(
    tree: s.File, before: s.File, after: s.File, forward: bool, restored: bool
) -> s.File | None:
    """One try. forward: what is new stands before what follows it rather than behind the rest.

    restored: settings that the tree states once are stated again behind a changed one.
    """
    here, old, new = entries(tree.items), entries(before.items), entries(after.items)
    if not any(e.key.startswith(HEADER) for e in here):
        old, new = _headless(old), _headless(new)
    place = merging.matched(old, here)
    edits = _Edits(here, place, forward)
    found = merging.changes(old, new)
    if not all(edits.take(change) for change in found):
        return None
    if restored:
        changed = {at for change in found for at in range(change.first, change.stop)}
        for change in found:
            edits.restore(change, old, changed)
    items = merged_data(edits.items(tree.items), before.items, after.items)
    numbered = None if items is None else _numbered(items, tree.dialect)
    return None if numbered is None else replace(tree, items=numbered)


def _headless(listed: list[Entry]) -> list[Entry]:
    """Without the comments at the beginning that keep what the language cannot say."""
    end = next((at for at, e in enumerate(listed) if e.key == HEADER_END), -1)
    return listed[end + 1 :]


class _Edits(merging.Edits[Entry]):
    """What is done to the entries of the tree."""

    def items(self, items: Sequence[s.Item]) -> list[s.Item]:
        """The items with all edits done; tables that nothing happened to stay one."""
        touched = {self.here[at].at for at in self.replaced}
        for gap in self.put:
            if 0 < gap < len(self.here) and self.here[gap - 1].at == self.here[gap].at:
                touched.add(self.here[gap].at)
        of: dict[int, list[int]] = {}
        for index, entry in enumerate(self.here):
            of.setdefault(entry.at, []).append(index)
        made: list[s.Item] = []
        last = -1
        for at, item in enumerate(items):
            mine = of.get(at, [])
            if mine:
                last = mine[-1]
                made += self._new(mine[0])
            if at not in touched:
                made.append(item)
            elif isinstance(item, MoveRows) and self.here[mine[0]].part != "table":
                made += self._rows(item, mine)
            else:
                made += self._line(item, mine)
            if mine and last == len(self.here) - 1:
                made += self._new(len(self.here))
        return made

    def _new(self, before: int) -> list[s.Line | MoveRows]:
        """New lines in front of an entry."""
        return [entry.line for entry in self.put.get(before, [])]

    def _line(self, item: s.Item, mine: Sequence[int]) -> Iterator[s.Item]:
        """A line with its parts changed; lines that are put between them go in front."""
        for index in mine[1:]:
            yield from self._new(index)
        changed = item
        for index in mine:
            if index not in self.replaced:
                continue
            now, part = self.replaced[index], self.here[index].part
            if part == "table":
                if now is not None and isinstance(now.line, MoveRows):
                    assert isinstance(item, MoveRows)
                    same = len(item) == len(now.line)
                    yield replace(now.line, steps=item.steps) if same else now.line
                return
            value = None if now is None else getattr(now.line, part)
            assert isinstance(changed, s.Line)
            changed = replace(changed, **{part: value})
        if isinstance(changed, s.Line) and (changed.label or changed.statement or changed.comment):
            yield changed

    def _rows(self, rows: MoveRows, mine: Sequence[int]) -> Iterator[s.Item]:
        """The rows of a table around the lines that are new or changed."""
        start = 0
        for index in mine:
            row = self.here[index].row
            put = self._new(index) if index != mine[0] else []
            if not put and index not in self.replaced:
                continue
            yield from _some(rows, start, row)
            yield from put
            start = row
            if index in self.replaced:
                now = self.replaced[index]
                if now is not None and isinstance(now.line, s.Line):
                    yield replace(now.line, number=int(rows.steps[row]))
                start = row + 1
        yield from _some(rows, start, len(rows))


def _some(rows: MoveRows, start: int, stop: int) -> Iterator[MoveRows]:
    if start < stop:
        yield rows.rows(slice(start, stop))


# Step numbers


def _numbered(items: Sequence[s.Item], dialect: str) -> tuple[s.Item, ...] | None:
    """New lines with numbers between their neighbours; where there is no room others move on.

    Jumps go with their lines. None if numbers end before the program does.
    """
    if not any(isinstance(i, s.Line) and i.number is not None for i in items) and not any(
        isinstance(i, MoveRows) and i.steps.any() for i in items
    ):
        return tuple(items)
    made: list[s.Item] = []
    moved: dict[str | int, int] = {}
    last = 0
    for at, item in enumerate(items):
        if isinstance(item, MoveRows):
            fresh = item.span is None and not item.steps.all()
            steps = np.maximum(item.steps, last + 1 + np.arange(len(item)))
            if not fresh:
                moved |= dict(zip(item.steps.tolist(), steps.tolist(), strict=True))
            changed = not np.array_equal(steps, item.steps)
            made.append(replace(item, steps=steps) if changed else item)
            last = int(steps[-1])
        elif isinstance(item, s.Line):
            if item.number is None:
                number = last + _room(items, at, last, DIALECTS[dialect].step)
            else:
                number = max(item.number, last + 1)
                moved[item.number] = number
            made.append(item if number == item.number else replace(item, number=number))
            last = number
        else:
            made.append(item)
    if last > LAST_STEP:
        return None
    if any(old != new for old, new in moved.items()):
        made = [retargeted(item, lambda to: moved.get(to, to)) for item in made]
    return tuple(made)


def _room(items: Sequence[s.Item], at: int, last: int, step: int) -> int:
    """What the number of a new line is more than the one before it."""
    count = 1
    for item in items[at:]:
        if isinstance(item, s.Line) and item.number is None:
            count += 1
            continue
        following = None
        if isinstance(item, s.Line):
            following = item.number
        elif isinstance(item, MoveRows):
            following = int(item.steps[0])
        if following is not None:
            return max((following - last) // count, 1)
    return step
