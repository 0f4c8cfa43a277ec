"""Moves of a program in columns, whether they stand in lines or in tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Final, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from assistant.languages.checks.name_sets import places
from assistant.program.arrays import Floats, Ints, Rows, Truths

N = TypeVar("N")

UNKNOWN: Final = -1
"""A posture that is not known."""


@dataclass(frozen=True, slots=True)
class Moves(Generic[N]):
    """n moves in their order.

    items: lines or tables that they stand in. item: (n,) rows of items. row: (n,) which one of it.
    kinds: (n,) as the language counts them, -1 for others. follows: (n,) whether the robot is
    surely where the move before it ends, in the same frame. ends, vias, starts: (n, 3) mm, NaN
    where not known; starts only where a move names one. postures: (n,) of the arm at the end.
    turning: (n,) whether the move may change the posture on its way.
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

    @staticmethod
    def of(
        item: N,
        kinds: ArrayLike,
        ends: Floats,
        *,
        follows: bool,
        vias: Floats | None = None,
        starts: Floats | None = None,
        postures: ArrayLike = UNKNOWN,
        turning: bool = False,
    ) -> Moves[N]:
        """The moves of one item, each of which follows the one before. follows: of the first."""
        n = len(ends)
        nowhere = np.full((n, 3), np.nan)
        return Moves(
            (item,),
            np.zeros(n, np.intp),
            np.arange(n),
            np.broadcast_to(np.asarray(kinds, np.int64), n),
            np.concatenate([[follows], np.ones(n - 1, bool)]),
            ends,
            nowhere if vias is None else vias,
            nowhere if starts is None else starts,
            np.broadcast_to(np.asarray(postures, np.int64), n),
            np.full(n, turning),
        )

    @staticmethod
    def joined(parts: Sequence[Moves[N]]) -> Moves[N] | None:
        """One behind the other, each of one item; None if there is none."""
        if not parts:
            return None
        columns = {
            column.name: np.concatenate([getattr(part, column.name) for part in parts])
            for column in fields(Moves)[2:]
        }
        return Moves(
            tuple(part.items[0] for part in parts),
            places(parts)[0],
            **columns,
        )

    @property
    def before(self) -> Floats:
        """(n, 3) mm where the robot stands in front of each move; NaN where that is not sure."""
        ends = np.concatenate([np.full((1, 3), np.nan), self.ends[:-1]])
        return np.where(self.follows[:, None], ends, np.nan)

    def where(self, chosen: Truths) -> Iterator[tuple[N, int]]:
        """The item of each of some moves, and the row in it."""
        for at in np.flatnonzero(chosen).tolist():
            yield self.items[self.item[at]], int(self.row[at])
