"""Merge of a changed program into the tree that it was lifted from.

Lifting and building lose layout, order and spelling, so a changed program is built twice: as it was
lifted and as it is now. What differs between the two is changed in the tree: an entry of the old
built tree is looked up in the tree, and what is new is placed beside the same neighbours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import field
from difflib import SequenceMatcher
from typing import Any, TypeVar

from assistant.base.data_classes import dataclass


@dataclass(frozen=True, slots=True)
class Entry:
    """An item of content at one position of a program.

    key: its content, independent of number and layout. kind: common property of entries that may
    replace each other. setting: the word of a statement that applies to the lines after it. at:
    index of its item. row: of a table, -1 for others; entries of one line have the same values of
    both. part: field of its line, empty for a complete table. line: the entry alone.
    """

    key: str
    kind: object
    setting: str | None
    at: int
    row: int
    part: str
    line: Any


T = TypeVar("T")


def matched_entries(old: Sequence[Entry], new: Sequence[Entry]) -> dict[int, int]:
    """Index of the new entry that each old one is, as far as they say the same; both rise."""
    pairs: dict[int, int] = {}
    for block in _matcher(old, new).get_matching_blocks():
        pairs |= {block.a + k: block.b + k for k in range(block.size)}
    return pairs


@dataclass(frozen=True, slots=True)
class Change:
    """Replacement of old entries first … stop: pairs of old and new, None for a missing one."""

    first: int
    stop: int
    pairs: tuple[tuple[int | None, Entry | None], ...]


def changes(old: Sequence[Entry], new: Sequence[Entry]) -> list[Change]:
    """The changes that lead from one program to another, in order."""
    found = []
    for step, i1, i2, j1, j2 in _matcher(old, new).get_opcodes():
        if step != "equal":
            found.append(Change(i1, i2, tuple(_paired_entries(old, i1, i2, new[j1:j2]))))
    return found


def _paired_entries(
    old: Sequence[Entry], first: int, stop: int, new: Sequence[Entry]
) -> Iterator[tuple[int | None, Entry | None]]:
    """Entries of one kind take each other's place, in order."""
    at = first
    for entry in new:
        partner = next((k for k in range(at, stop) if old[k].kind == entry.kind), None)
        if partner is None:
            yield None, entry
            continue
        yield from ((k, None) for k in range(at, partner))
        yield partner, entry
        at = partner + 1
    yield from ((k, None) for k in range(at, stop))


def _matcher(old: Sequence[Entry], new: Sequence[Entry]) -> SequenceMatcher[str]:
    return SequenceMatcher(None, [e.key for e in old], [e.key for e in new], autojunk=False)


@dataclass
class Edits:
    """Edits of the entries of a tree.

    place: entry of the built tree → entry here. replaced: entry → its replacement, None for
    removal. put: new entries in front of an entry.
    """

    here: Sequence[Entry]
    place: dict[int, int]
    forward: bool
    replaced: dict[int, Entry | None] = field(default_factory=dict)
    put: dict[int, list[Entry]] = field(default_factory=dict)

    def take(self, change: Change) -> bool:
        """Apply a change; False if its position is unknown."""
        last: int | None = None
        for was, now in change.pairs:
            at = None if was is None else self.place.get(was)
            if at is not None:
                self.replaced[at] = now
                last = at
            # Behind what was replaced last, so that the new entries keep their order.
            elif now is not None:
                gap = self._gap(change.first, change.stop) if last is None else last + 1
                if gap is None:
                    return False
                self.put.setdefault(gap, []).append(now)
        return True

    def restore(self, change: Change, old: Sequence[Entry], changed: set[int]) -> None:
        """Repeat changed settings that are not stated at the point where they must change back.

        changed: entries of the built tree that will not stay.
        """
        said = {old[at].setting for at in range(change.first, change.stop)}
        said |= {now.setting for _, now in change.pairs if now is not None}
        for setting in said - {None}:
            following = range(change.stop, len(old))
            at = next((k for k in following if old[k].setting == setting), None)
            # The setting is stated here, or the change itself states it again.
            if at is None or at in changed or at in self.place:
                continue
            gap = self._gap(at, at + 1, forward=True)
            if gap is not None:
                self.put.setdefault(gap, []).append(old[at])

    def _gap(self, first: int, stop: int, forward: bool | None = None) -> int | None:
        """Return the entry here after the position of entries first … stop of the built tree."""
        above = max((k for k in self.place if k < first), default=None)
        below = min((k for k in self.place if k >= stop), default=None)
        if (self.forward if forward is None else forward) and below is not None:
            return self._begin(self.place[below])
        if above is not None:
            return self.place[above] + 1
        return None if below is None else self._begin(self.place[below])

    def _begin(self, entry: int) -> int:
        """The first entry of the same line."""
        while entry and self._together(entry - 1, entry):
            entry -= 1
        return entry

    def _together(self, one: int, other: int) -> bool:
        a, b = self.here[one], self.here[other]
        return (a.at, a.row) == (b.at, b.row)


def merged_by_key(
    items: Sequence[T],
    old: Iterable[T],
    new: Iterable[T],
    key: Callable[[T], object],
    changed: Callable[[T, T, T], T],
    place: Callable[[Sequence[T], T], int],
) -> list[T] | None:
    """Return a tree's items, changed as one built tree was into another, if order has no meaning.

    key: of the declared item, None for an item that declares nothing; that stays. changed: returns
    an item here with the change from the old to the new one. place: index for a new item. None if a
    changed item is not here.
    """
    was, now, here = ({key(item): item for item in listed} for listed in (old, new, items))
    differ = {k for k, item in now.items() if k is not None and k in was and was[k] != item}
    gone = was.keys() - now.keys() - {None}
    if not (differ | gone) <= here.keys():
        return None
    kept: list[T] = []
    for item in items:
        if (k := key(item)) in differ:
            kept.append(changed(item, was[k], now[k]))
        elif k not in gone:
            kept.append(item)
    for k, item in now.items():
        if k is not None and k not in was:
            kept.insert(place(kept, item), item)
    return kept
