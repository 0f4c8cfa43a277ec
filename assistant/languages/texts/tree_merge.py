"""Merge of a changed program into the tree that it was lifted from.

Lifting and building lose layout, order and spelling, so a changed program is built twice: as it was
lifted and as it is now. What differs between the two is changed in the tree: an entry of the old
built tree is looked up in the tree, and what is new is placed beside the same neighbours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from difflib import SequenceMatcher
from typing import Any, TypeVar


@dataclass(frozen=True, slots=True)
class Entry:
    """Something that a program says in one place.

    key: what it says, whatever its number and layout. kind: what entries that may take each
    other's place have in common. setting: the word of a statement that holds for what follows.
    at: index of its item. row: of a table, -1 for others; entries of one line have the same of
    both. part: field of its line, empty for a table as a whole. line: it alone.
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
    """What stands in the place of old entries first … stop: pairs of old and new, None for none."""

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
    """What is done to the entries of a tree.

    place: entry of the built tree → entry here. replaced: entry → what takes its place, None for
    nothing. put: new entries in front of an entry.
    """

    here: Sequence[Entry]
    place: dict[int, int]
    forward: bool
    replaced: dict[int, Entry | None] = field(default_factory=dict)
    put: dict[int, list[Entry]] = field(default_factory=dict)

    def take(self, change: Change) -> bool:
        """Does a change; False if it cannot be told where."""
        last: int | None = None
        for was, now in change.pairs:
            at = None if was is None else self.place.get(was)
            if at is not None:
                self.replaced[at] = now
                last = at
            elif now is not None:
                gap = self._gap(change.first, change.stop) if last is None else last + 1
                if gap is None:
                    return False
                self.put.setdefault(gap, []).append(now)
        return True

    def restore(self, change: Change, old: Sequence[Entry], changed: set[int]) -> None:
        """Says settings again that have changed and are not said where they are to change back.

        changed: entries of the built tree that are not to stay.
        """
        said = {old[at].setting for at in range(change.first, change.stop)}
        said |= {now.setting for _, now in change.pairs if now is not None}
        for setting in said - {None}:
            following = range(change.stop, len(old))
            at = next((k for k in following if old[k].setting == setting), None)
            if at is None or at in changed or at in self.place:
                continue
            gap = self._gap(at, at + 1, forward=True)
            if gap is not None:
                self.put.setdefault(gap, []).append(old[at])

    def _gap(self, first: int, stop: int, forward: bool | None = None) -> int | None:
        """The entry here that stands behind the place of entries first … stop of the built tree."""
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
    """The items of a tree, changed as one built tree was into another, where order says nothing.

    key: of what is declared, None for what is none; that stays. changed: an item here, as it was
    and as it is. place: where a new one goes. None where a changed one is not here.
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
