"""Pallets: grids of positions (COSIROP: DEF PLT)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from assistant.virtual.melfa.stops import Failed, Unknown, out_of_range
from assistant.virtual.melfa.values import Position, eight

ZIGZAG: Final = 1
SAME: Final = 2
MOST: Final = 8
MOST_POINTS: Final = 32767


@dataclass(frozen=True, slots=True)
class Grid:
    """start, first, second: its corner and the ends of the edges there. opposite: the fourth
    corner, None for a parallelogram. counts: points along the first and the second edge.
    """

    start: Position
    first: Position
    second: Position
    opposite: Position | None
    counts: tuple[int, int]
    direction: int


def grid(
    number: int, corners: tuple[Position | None, ...], counts: tuple[int, int], direction: int
) -> Grid:
    """A pallet as `Def Plt` defines it; raises Failed and Unknown."""
    start, first, second, opposite = corners
    if not 1 <= number <= MOST:
        raise out_of_range(f"the pallet {number}")
    if start is None or first is None or second is None:
        raise Failed(3120, "a corner of the pallet is left out")
    if direction not in (ZIGZAG, SAME):
        raise Unknown(f"a pallet of direction {direction}")
    if min(counts) < 1 or counts[0] * counts[1] > MOST_POINTS:
        raise out_of_range(f"a pallet of {counts[0]} by {counts[1]} points")
    given = [c for c in corners if c is not None]
    if any(None in corner.values[:6] for corner in given):
        raise Failed(3750, "a corner of the pallet is not defined")
    if any(corner.values[3:6] != start.values[3:6] for corner in given):
        raise Unknown("a pallet whose corners are turned differently")
    return Grid(start, first, second, opposite, counts, direction)


def point(of: Grid | None, number: int, at: int) -> Position:
    """A point by its number from 1: along the first edge, then the next row."""
    if of is None:
        raise Failed(3850, f"the pallet {number} is not defined")
    along, rows = of.counts
    if not 1 <= at <= along * rows:
        raise out_of_range(f"the point {at} of a pallet of {along * rows}")
    row, column = divmod(at - 1, along)
    if of.direction == ZIGZAG and row % 2:
        column = along - 1 - column
    i = column / (along - 1) if along > 1 else 0.0
    j = row / (rows - 1) if rows > 1 else 0.0
    place = tuple(_mean(of, axis, i, j) for axis in range(3))
    return Position(eight((*place, *of.start.values[3:6])), of.start.flags)


def _mean(of: Grid, axis: int, i: float, j: float) -> float:
    start, first, second = (_known(c, axis) for c in (of.start, of.first, of.second))
    made = start + i * (first - start) + j * (second - start)
    if of.opposite is None:
        return made
    return made + i * j * (_known(of.opposite, axis) - first - second + start)


def _known(corner: Position, axis: int) -> float:
    value = corner.values[axis]
    assert value is not None
    return value
