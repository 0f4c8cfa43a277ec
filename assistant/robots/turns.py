"""Whole turns of one axis along a path.

Inverse kinematics gives an angle up to whole turns. A linear or circular move follows its
axes without a break, so all rows of a chain (a joint move and the linear and circular
moves after it) share one count of turns; a joint move may wind an axis back.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Turned:
    """angles: (n,) deg inside the limits where that can be. broken: rows before which the
    axis would have to be wound back although the move does not allow it.
    """

    angles: Floats
    broken: Rows


@dataclass(frozen=True, slots=True)
class OnTheWay:
    """What one axis does on the way to each of n rows; see `between.Ways`."""

    winding: NDArray[np.int64]
    below: Floats
    above: Floats


def turn(
    angles: Floats,
    limits: tuple[float, float],
    starts: Rows,
    near: float,
    stated: NDArray[np.int64] | None = None,
    way: OnTheWay | None = None,
) -> Turned:
    """Adds whole turns to angles (n,) deg, so that chains are unbroken and inside the limits.

    angles: nearest to the middle of the limits; NaN where there is no solution.
    starts: (c,) first rows of the chains, the first being 0. near: deg, where the axis is
    before the path. stated: (n,) turns that a row must have, FREE where it states none.
    way: the turns that the axis makes on its way to a row, and how far it goes there.
    """
    wrapped = _filled_by_chain(angles, starts)
    if not len(wrapped):
        return Turned(angles.copy(), np.empty(0, np.intp))
    step = np.zeros(len(wrapped), dtype=np.int64)
    step[1:] = -np.round(np.diff(wrapped) / 360.0)
    if way is not None:
        step += way.winding
    turns = np.cumsum(step)
    whole = _by_chain(angles, wrapped, turns, starts[:1], limits, stated, way)
    first = round((near - wrapped[0]) / 360.0)
    if whole.patterns[0] and (whole.clear or len(starts) == 1):
        return Turned(angles + 360.0 * (whole.follow(first) + turns), np.empty(0, np.intp))
    chains = _by_chain(angles, wrapped, turns, starts, limits, stated, way)
    failing = chains.patterns == 0
    broken = np.empty(0, np.intp)
    if failing.any():
        inside = np.repeat(failing, np.diff(np.append(starts, len(wrapped))))
        inside[starts] = True
        chains = _by_chain(angles, wrapped, turns, np.flatnonzero(inside), limits, stated, way)
    chosen = chains.follow(first)
    count = chosen[chains.of_row] + turns - turns[chains.starts][chains.of_row]
    out = angles + 360.0 * count
    if failing.any():
        unmet = np.flatnonzero(np.diff(count, prepend=count[0]) != step)
        broken = np.setdiff1d(unmet, starts)
    return Turned(out, broken)


CLEARANCE: Final = 1.0
"""degrees that an axis keeps from its limits where another count of turns can: a controller
reads a target rounded, and near a singularity that turns the wrist."""
FREE: Final = np.iinfo(np.int64).min
"""In `stated`: the row says nothing of its turns."""


def filled(angles: Floats) -> Floats:
    """NaN rows take the value of the row before, leading ones that of the first after; else 0."""
    known = np.isfinite(angles)
    if known.all():
        return angles
    if not known.any():
        return np.zeros_like(angles)
    last = np.maximum.accumulate(np.where(known, np.arange(len(angles)), -1))
    return np.asarray(angles[np.where(last < 0, known.argmax(), last)])


def _filled_by_chain(angles: Floats, starts: Rows) -> Floats:
    """NaN rows take the value before them, at the start of a chain the one after them.

    So a chain is counted from its own first angle, not from the last of the chain before.
    """
    known = np.isfinite(angles)
    if known.all() or not known.any():
        return filled(angles)
    row, n = np.arange(len(angles)), len(angles)
    last = np.maximum.accumulate(np.where(known, row, -1))
    following = np.minimum.accumulate(np.where(known, row, n)[::-1])[::-1]
    start = np.repeat(starts, np.diff(np.append(starts, n)))
    own = np.where((last < start) & (following < n), following, last)
    return np.asarray(angles[own])


@dataclass(frozen=True, slots=True)
class _Chains:
    """starts: (c,) rows. of_row: (n,) chain of each row. offsets: (c,) turns at the starts.
    patterns: (c,) bit k set if every row of the chain is inside with lowest + k turns, and clear
    of the limits if it is so with any. clear: whether all of them are that.
    """

    starts: Rows
    of_row: Rows
    offsets: NDArray[np.int64]
    patterns: NDArray[np.int64]
    clear: bool
    lowest: int
    width: int

    def follow(self, first: int) -> NDArray[np.int64]:
        """(c,) turns at the start of each chain: unbroken where possible, else the nearest."""
        count, margin = len(self.starts), self.width + 1
        table = np.array(
            [
                [self._nearest(pattern, t) for t in range(-margin, self.width + margin)]
                for pattern in range(1 << self.width)
            ]
        )
        moves = np.diff(self.offsets, prepend=self.offsets[:1])
        top = self.width + 2 * margin - 1
        start = min(max(first - self.lowest, -margin), self.width + margin - 1)
        # Sections of the chains side by side, each from every count of turns before it, which
        # are 0 to the width and, of the first section, `start`.
        sections = max(int(np.sqrt(count)), 1)
        length = -(-count // sections)
        filled = length * sections - count
        patterns = np.append(self.patterns, np.ones(filled, np.int64)).reshape(sections, length)
        steps = np.append(moves, np.zeros(filled, np.int64)).reshape(sections, length)
        at = np.tile(np.arange(self.width), (sections, 1))
        at[0] = start
        ways = np.empty((length, *at.shape), dtype=np.int64)
        for t in range(length):
            wanted = np.clip(at + steps[:, t, None] + margin, 0, top)
            ways[t] = at = table[patterns[:, t, None], wanted]
        out = np.empty((sections, length), dtype=np.int64)
        came = 0
        for section in range(sections):
            out[section] = ways[:, section, came]
            came = int(out[section, -1])
        return out.ravel()[:count] + self.lowest

    def _nearest(self, pattern: int, wanted: int) -> int:
        there = [k for k in range(self.width) if pattern >> k & 1] or list(range(self.width))
        return min(there, key=lambda k: (abs(k - wanted), abs(k + self.lowest)))


def _by_chain(
    angles: Floats,
    wrapped: Floats,
    turns: NDArray[np.int64],
    starts: Rows,
    limits: tuple[float, float],
    stated: NDArray[np.int64] | None,
    way: OnTheWay | None,
) -> _Chains:
    low, high = limits
    n, middle = len(wrapped), (low + high) / 2.0
    of_row = np.zeros(n, dtype=np.intp)
    of_row[starts[1:]] = 1
    of_row = np.cumsum(of_row)
    relative = turns - turns[starts][of_row]
    unwound = angles + 360.0 * relative
    lows, highs = np.fmin.reduceat(unwound, starts), np.fmax.reduceat(unwound, starts)
    least_on_way, most_on_way = lows, highs
    if way is not None:
        inner = np.ones(n, dtype=bool)
        inner[starts] = False  # what leads to a chain is no part of it
        least_on_way = np.fmin.reduceat(unwound + np.where(inner, way.below, 0.0), starts)
        most_on_way = np.fmax.reduceat(unwound + np.where(inner, way.above, 0.0), starts)
    lowest = int(np.ceil((low - middle - 180.0) / 360.0))
    width = int(np.floor((high - middle + 180.0) / 360.0)) - lowest + 1
    patterns, passing, clear = (np.zeros(len(starts), dtype=np.int64) for _ in range(3))
    if stated is not None:
        wanted = np.where(stated == FREE, 0, stated - relative)
        least = np.minimum.reduceat(np.where(stated == FREE, 1 << 40, wanted), starts)
        most = np.maximum.reduceat(np.where(stated == FREE, -(1 << 40), wanted), starts)
    for k in range(width):
        shift = 360.0 * (lowest + k)
        # `not outside` rather than `inside`: a chain without any solution allows everything.
        fits = ~((lows + shift < low - 1e-6) | (highs + shift > high + 1e-6))
        over = (least_on_way + shift < low - 1e-6) | (most_on_way + shift > high + 1e-6)
        close = (least_on_way + shift < low + CLEARANCE) | (most_on_way + shift > high - CLEARANCE)
        if stated is not None:
            fits &= (least >= lowest + k) & (most <= lowest + k)
        patterns |= fits.astype(np.int64) << k
        passing |= (fits & ~over).astype(np.int64) << k
        clear |= (fits & ~close).astype(np.int64) << k
    patterns = np.where(clear, clear, np.where(passing, passing, patterns))
    return _Chains(starts, of_row, turns[starts], patterns, bool(clear.all()), lowest, width)
