"""Runs of which some rows changed: the others keep their bytes, no object a row."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeVar

import numpy as np

from assistant.base.arrays import Ints, Rows
from assistant.languages.runs.columns import Run
from assistant.languages.runs.reading import after_digits

R = TypeVar("R", bound=Run)

SEGMENTS: Final = 1 << 16
"""Pieces of text that are put together at a time."""


@dataclass(frozen=True, slots=True)
class _RunLines:
    """The text of a run and where its lines begin and end, offsets (n,)."""

    text: bytes
    starts: Rows
    ends: Rows

    @classmethod
    def of(cls, text: str) -> _RunLines:
        data = text.encode("ascii")
        ends = np.flatnonzero(np.frombuffer(data, dtype=np.uint8) == ord("\n")) + 1
        return cls(data, np.concatenate([[0], ends])[:-1].astype(np.intp), ends)

    def digits(self) -> Rows:
        """The offsets behind the number that each line begins with."""
        return after_digits(np.frombuffer(self.text, dtype=np.uint8), self.starts)


def merged_run_text(
    new: R, old: R, text: str, at: Rows, fresh: Callable[[R], str], number: str | None = None
) -> str:
    """The lines of a run made from another, which was read from a text.

    at: (n,) row of the old run that each row may be, -1 for none. fresh: the lines of rows that
    are new. number: column of the numbers that lines begin with; a line of which only that changed
    keeps what stands behind it.
    """
    lines = _RunLines.of(text)
    kept = old.equal(at, new)
    moved = ~kept & old.equal(at, new, {number}) if number is not None else np.zeros_like(kept)
    if kept.all():
        return _gather_pieces(lines.text, lines.starts[at], lines.ends[at])
    printed = _RunLines.of(fresh(new.rows(~kept)))
    base = len(lines.text)
    starts, ends = np.zeros((2, len(new), 2 if moved.any() else 1), dtype=np.int64)
    starts[kept, 0], ends[kept, 0] = lines.starts[at[kept]], lines.ends[at[kept]]
    starts[~kept, 0], ends[~kept, 0] = printed.starts + base, printed.ends + base
    if moved.any():
        ends[moved, 0] = printed.digits()[moved[~kept]] + base
        starts[moved, 1], ends[moved, 1] = lines.digits()[at[moved]], lines.ends[at[moved]]
    return _gather_pieces(lines.text + printed.text, starts.ravel(), ends.ravel())


def _gather_pieces(text: bytes, starts: Ints, ends: Ints) -> str:
    """Pieces of a text one behind the other."""
    letters = np.frombuffer(text, dtype=np.uint8)
    parts = []
    for first in range(0, len(starts), SEGMENTS):
        part = slice(first, first + SEGMENTS)
        lengths = ends[part] - starts[part]
        shifts = starts[part] - np.cumsum(lengths) + lengths
        index = np.repeat(shifts, lengths) + np.arange(lengths.sum())
        parts.append(letters[index].tobytes())
    return b"".join(parts).decode("ascii")
