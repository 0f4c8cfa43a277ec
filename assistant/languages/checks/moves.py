"""Moves of a program in columns, from single lines and from tables."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from math import nan
from typing import Final, Generic, TypeVar

import numpy as np

from assistant.base.arrays import Floats, Ints, Rows, Truths
from assistant.base.data_classes import dataclass

N = TypeVar("N")

UNKNOWN: Final = -1
"""A posture that is not known."""


Point = tuple[float | None, ...]
"""Coordinates in mm; None, or a missing one, means unknown."""
_NOWHERE: Final = (nan, nan, nan)


@dataclass(frozen=True, slots=True)
class Moves(Generic[N]):
    """A sequence of n moves in columns.

    items: lines or tables that contain them. item: (n,) index of the item of each move. row: (n,)
    row in that item. kinds: (n,) in the numbering of the language, -1 for others. follows: (n,)
    True if the robot is certainly at the end of the previous move, in the same frame. ends, vias,
    starts: (n, 3) mm, NaN where unknown; starts only where a move names one. postures: (n,) of the
    arm at the end. turning: (n,) True if the move may change the posture on its path.
    """

    items: tuple[N, ...]
    item: Rows
    row: Rows
    kinds: Ints
    follows: Truths
    ends: Floats
    vias: Floats
    starts: Floats
    postures: Ints
    turning: Truths

    def __len__(self) -> int:
        return len(self.kinds)

    @property
    def before(self) -> Floats:
        """(n, 3) mm, the robot's position before each move; NaN where that is not certain."""
        ends = np.concatenate([np.full((1, 3), np.nan), self.ends[:-1]])
        return np.where(self.follows[:, None], ends, np.nan)

    def where(self, chosen: Truths) -> Iterator[tuple[N, int]]:
        """The item of each of some moves, and the row in it."""
        for at in np.flatnonzero(chosen).tolist():
            yield self.items[self.item[at]], int(self.row[at])


class Follower(Generic[N]):
    """Gathers moves one behind the other, of lines and of tables."""

    def __init__(self) -> None:
        self._parts: list[Moves[N]] = []
        self._lines: list[tuple[N, int, bool, tuple[float, ...], int, bool]] = []

    def line(
        self,
        item: N,
        kind: int,
        *,
        follows: bool,
        end: Point = (),
        via: Point = (),
        start: Point = (),
        posture: int = UNKNOWN,
        turning: bool = False,
    ) -> None:
        """One move."""
        points = (*_known(end), *_known(via), *_known(start))
        self._lines.append((item, kind, follows, points, posture, turning))

    def table(
        self,
        item: N,
        kinds: Ints,
        ends: Floats,
        *,
        follows: bool,
        vias: Floats,
        starts: Floats | None = None,
        postures: Ints | None = None,
        apart: Truths | None = None,
    ) -> None:
        """Moves that follow each other. follows: of the first. apart: (n,) in another frame than
        the one before.
        """
        n = len(ends)
        following = np.ones(n, bool) if apart is None else ~apart
        following[0] = follows
        self._close()
        self._parts.append(
            Moves(
                (item,),
                np.zeros(n, np.intp),
                np.arange(n),
                kinds,
                following,
                ends,
                vias,
                np.full((n, 3), np.nan) if starts is None else starts,
                np.full(n, UNKNOWN) if postures is None else postures,
                np.zeros(n, bool),
            )
        )

    def _close(self) -> None:
        """Turns the lines since the last table into columns."""
        if self._lines:
            items, kinds, follows, points, postures, turning = zip(*self._lines, strict=True)
            # (n, 3, 3): end, via and start of each move, three coordinates each.
            n, at = len(items), np.array(points).reshape(-1, 3, 3)
            self._parts.append(
                Moves(
                    items,
                    np.arange(n),
                    np.zeros(n, np.intp),
                    np.array(kinds),
                    np.array(follows),
                    at[:, 0],
                    at[:, 1],
                    at[:, 2],
                    np.array(postures),
                    np.array(turning),
                )
            )
            self._lines.clear()

    def moves(self) -> Moves[N] | None:
        """Return all moves in columns; None if there are no moves."""
        self._close()
        if not self._parts:
            return None
        columns = {
            column.name: np.concatenate([getattr(part, column.name) for part in self._parts])
            for column in fields(Moves)[2:]
        }
        # Rows of items count on from one part to the next.
        begins = np.cumsum([0, *(len(part.items) for part in self._parts[:-1])])
        return Moves(
            tuple(item for part in self._parts for item in part.items),
            np.concatenate([part.item + at for part, at in zip(self._parts, begins, strict=True)]),
            **columns,
        )


def _known(point: Point) -> tuple[float, ...]:
    """Three numbers, NaN for what is not known."""
    return tuple(nan if value is None else value for value in (*point, *_NOWHERE)[:3])
