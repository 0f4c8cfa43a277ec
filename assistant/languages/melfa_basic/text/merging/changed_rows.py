"""Tables of which some rows changed: the others keep their bytes, no object a row."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from assistant.languages.melfa_basic.tree.columnar import (
    MoveRows,
    PositionRows,
    move_text,
    places_of,
    position_text,
)
from assistant.program.arrays import Ints, Truths

SEGMENTS = 1 << 16
"""Pieces of text that are put together at a time."""


@dataclass(frozen=True, slots=True)
class Lines:
    """The text of a table and where its lines begin and end, offsets (n,)."""

    text: bytes
    starts: Ints
    ends: Ints

    @classmethod
    def of(cls, text: str) -> Lines:
        data = text.encode("ascii")
        ends = np.flatnonzero(np.frombuffer(data, dtype=np.uint8) == ord("\n")) + 1
        return cls(data, np.concatenate([[0], ends[:-1]]).astype(np.int64), ends.astype(np.int64))

    def digits(self) -> Ints:
        """The offsets behind the step number that each line begins with."""
        letters = np.frombuffer(self.text, dtype=np.uint8)
        other = np.flatnonzero((letters < ord("0")) | (letters > ord("9")))
        found: Ints = other[np.searchsorted(other, self.starts)]
        return found


def positions(new: PositionRows, olds: Iterable[tuple[PositionRows, str]], newline: str) -> str:
    """The lines of a table made from others, which were read from the texts beside them."""
    width = new.values.shape[1]
    known = [(o, t) for o, t in olds if o.stem == new.stem and o.values.shape[1] == width]
    places = places_of(new.values)
    if not known:
        return position_text(new, newline.encode("ascii"), places)
    numbers, values, flags = (
        np.concatenate([getattr(o, name) for o, _ in known])
        for name in ("numbers", "values", "flags")
    )
    lines = Lines.of("".join(text for _, text in known))
    at = _places(numbers, new.numbers)
    kept = (at >= 0) & (values[at] == new.values).all(axis=1) & (flags[at] == new.flags).all(axis=1)

    def fresh(rows: Truths) -> str:
        table = PositionRows(new.stem, new.numbers[rows], new.values[rows], new.flags[rows])
        return position_text(table, newline.encode("ascii"), places)

    return _assembled(lines, at, kept, fresh)


def moves(new: MoveRows, old: MoveRows, text: str, newline: str, upper: bool, indent: int) -> str:
    """The lines of a run of moves made from another, which was read from the text.

    indent: blanks more behind the step of a new line.
    """
    lines = Lines.of(text)
    n = len(new)
    at = np.arange(n) if len(old) == n else _places(old.steps, new.steps)
    same = (at >= 0) & (new.stem == old.stem)
    for name in ("kinds", "start", "via", "end"):
        same &= getattr(old, name)[at] == getattr(new, name)
    kept = same & (old.steps[at] == new.steps)

    def fresh(rows: Truths) -> str:
        columns = (getattr(new, name)[rows] for name in ("steps", "kinds", "start", "via", "end"))
        return move_text(MoveRows(new.stem, *columns), newline.encode("ascii"), upper, indent)

    moved = same & ~kept
    if not moved.any():
        return _assembled(lines, at, kept, fresh)
    # a number of its own before the rest of the line as it stood
    printed = Lines.of(fresh(~kept))
    starts, ends = np.zeros((2, n, 2), dtype=np.int64)
    base = len(lines.text)
    rest = lines.digits()
    starts[kept, 0], ends[kept, 0] = lines.starts[at[kept]], lines.ends[at[kept]]
    starts[~kept, 0], ends[~kept, 0] = printed.starts + base, printed.ends + base
    ends[moved, 0] = (printed.digits() + base)[moved[~kept]]
    starts[moved, 1], ends[moved, 1] = rest[at[moved]], lines.ends[at[moved]]
    return _gathered(lines.text + printed.text, starts.ravel(), ends.ravel())


def _places(known: Ints, wanted: Ints) -> Ints:
    """Where each number stands among others, -1 for one that does not."""
    if not len(known):
        return np.full(len(wanted), -1, dtype=np.int64)
    order = np.argsort(known, kind="stable")
    found = np.minimum(np.searchsorted(known, wanted, sorter=order), len(known) - 1)
    places: Ints = order[found]
    return np.where(known[places] == wanted, places, -1)


def _assembled(lines: Lines, at: Ints, kept: Truths, fresh: Callable[[Truths], str]) -> str:
    """Old lines where they are kept, new ones elsewhere."""
    starts, ends = np.empty((2, len(kept)), dtype=np.int64)
    starts[kept], ends[kept] = lines.starts[at[kept]], lines.ends[at[kept]]
    text = lines.text
    if not kept.all():
        printed = Lines.of(fresh(~kept))
        starts[~kept], ends[~kept] = printed.starts + len(text), printed.ends + len(text)
        text += printed.text
    return _gathered(text, starts, ends)


def _gathered(text: bytes, starts: Ints, ends: Ints) -> str:
    """Pieces of a text one behind the other."""
    letters = np.frombuffer(text, dtype=np.uint8)
    parts = []
    for first in range(0, len(starts), SEGMENTS):
        begins, lengths = (
            starts[first : first + SEGMENTS],
            (ends - starts)[first : first + SEGMENTS],
        )
        shifts = begins - np.cumsum(lengths) + lengths
        index = np.repeat(shifts, lengths) + np.arange(lengths.sum())
        parts.append(letters[index].tobytes())
    return b"".join(parts).decode("ascii")
