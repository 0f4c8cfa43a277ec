"""Pallets: grids and arcs of positions (COSIROP: DEF PLT; CR1D 4-189 and 4-190)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.virtual.melfa.circles import circle_through
from assistant.virtual.melfa.stops import Failed, out_of_range
from assistant.virtual.melfa.values import Position, eight

ZIGZAG_PALLET: Final = 1
ARC_PALLET: Final = 3
FIXED_ORIENTATION: Final = 10
"""Added to a direction whose points keep the posture of the start."""
PALLET_KINDS: Final = (1, 2, 3, 11, 12, 13)
MOST_PALLETS: Final = 8
MOST_POINTS: Final = 32767


@dataclass(frozen=True, slots=True)
class Grid:
    """start, first, second: its corner and the ends of the edges there; of an arc its start, a
    place on its way and its end. opposite: the fourth corner, None for a parallelogram.
    counts: points along the first and the second edge. direction: 1 zigzag, 2 same, 3 arc.
    fixed: whether all points have the posture of the start.
    """

    start: Position
    first: Position
    second: Position
    opposite: Position | None
    counts: tuple[int, int]
    direction: int
    fixed: bool

    @property
    def points(self) -> int:
        return self.counts[0] if self.direction == ARC_PALLET else self.counts[0] * self.counts[1]


def pallet_grid(
    number: int,
    corners: tuple[Position | None, ...],
    counts: tuple[int, int],
    direction: int,
    fixed: bool = False,
) -> Grid:
    """A pallet as `Def Plt` defines it; raises Failed.

    fixed: whether directions 1 to 3 keep the posture of the start, too.
    """
    start, first, second, opposite = corners
    if not 1 <= number <= MOST_PALLETS:
        raise out_of_range(f"the pallet {number}")
    if start is None or first is None or second is None:
        raise Failed(3120, "a corner of the pallet is left out")
    if direction not in PALLET_KINDS:
        raise out_of_range(f"a pallet of direction {direction}")
    kind = direction % FIXED_ORIENTATION
    along, rows = counts
    if (
        along < 1
        or (rows < 1 and kind != ARC_PALLET)
        or (kind != ARC_PALLET and along * rows > MOST_POINTS)
    ):
        raise out_of_range(f"a pallet of {along} by {rows} points")
    if kind == ARC_PALLET:
        opposite = None
    given = [c for c in (start, first, second, opposite) if c is not None]
    if any(None in corner.values[:6] for corner in given):
        raise Failed(3750, "a corner of the pallet is not defined")
    return Grid(
        start, first, second, opposite, counts, kind, fixed or direction > FIXED_ORIENTATION
    )


def pallet_point(of: Grid | None, number: int, at: int) -> Position:
    """A point by its number from 1: along the first edge, then the next row."""
    if of is None:
        raise Failed(3850, f"the pallet {number} is not defined")
    if not 1 <= at <= of.points:
        raise out_of_range(f"the point {at} of a pallet of {of.points}")
    if of.direction == ARC_PALLET:
        return _arc_position(of, at)
    along, rows = of.counts
    row, column = divmod(at - 1, along)
    if of.direction == ZIGZAG_PALLET and row % 2:
        column = along - 1 - column
    i = column / (along - 1) if along > 1 else 0.0
    j = row / (rows - 1) if rows > 1 else 0.0
    place = tuple(_grid_mean(of, axis, i, j) for axis in range(3))
    turned = tuple(_grid_mean(of, axis, i, j) for axis in range(3, 6))
    return _pallet_position(of, place, turned)


def _pallet_position(
    of: Grid, place: tuple[float, ...], turned: tuple[float | None, ...]
) -> Position:
    turned = of.start.values[3:6] if of.fixed else turned
    return Position(eight((*place, *turned)), of.start.flags)


def _arc_position(of: Grid, at: int) -> Position:
    """Points at equal angles from the start to the end of the arc.

    Through places on a line they are at equal distances, as `Mvr` goes straight there.
    """
    a, b, c = (np.array(p.values[:3], dtype=np.float64) for p in (of.start, of.first, of.second))
    circle = circle_through(a, b, c)
    share = (at - 1) / (of.counts[0] - 1) if of.counts[0] > 1 else 0.0
    place = a + share * (c - a) if circle is None else circle.at(a, share * circle.angle(a, c))
    ends = [
        (_known_element(of.start, axis), _known_element(of.second, axis)) for axis in range(3, 6)
    ]
    turned = tuple(one + share * (other - one) for one, other in ends)
    return _pallet_position(of, tuple(float(v) for v in place), turned)


def _grid_mean(of: Grid, axis: int, i: float, j: float) -> float:
    start, first, second = (_known_element(c, axis) for c in (of.start, of.first, of.second))
    made = start + i * (first - start) + j * (second - start)
    if of.opposite is None:
        return made
    return made + i * j * (_known_element(of.opposite, axis) - first - second + start)


def _known_element(corner: Position, axis: int) -> float:
    value = corner.values[axis]
    assert value is not None
    return value
