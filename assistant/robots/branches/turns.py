"""Whole turns of one axis along a path.

Inverse kinematics gives an angle up to whole turns. A linear or circular move follows its
axes without a break, so all rows of a chain (a joint move and the linear and circular
moves after it) share one count of turns; a joint move may wind an axis back.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from assistant.base.arrays import Floats, Ints, Rows, Truths


@dataclass(frozen=True, slots=True)
class TurnedAxis:
    """angles: (n,) deg inside the limits where that can be. broken: rows before which the
    axis would have to be wound back although the move does not allow it.
    """

    angles: Floats
    broken: Rows


@dataclass(frozen=True, slots=True)
class AxisBetweenTargets:
    """What one axis does on the way to each of n rows; see `between.Ways`."""

    winding: Ints
    below: Floats
    above: Floats


def add_whole_turns(
    angles: Floats,
    limits: tuple[float, float],
    starts: Rows,
    near: float,
    stated: Ints | None = None,
    way: AxisBetweenTargets | None = None,
) -> TurnedAxis:
    """Adds whole turns to angles (n,) deg, so that chains are unbroken and inside the limits.

    angles: nearest to the middle of the limits; NaN where there is no solution.
    starts: (c,) first rows of the chains, the first being 0. near: deg, where the axis is
    before the path. stated: (n,) turns that a row must have, FREE where it states none.
    way: the turns that the axis makes on its way to a row, and how far it goes there.
    """
    wrapped = _filled_by_chain(angles, starts)
    if not len(wrapped):
        return TurnedAxis(angles.copy(), np.empty(0, np.intp))
    step = _turn_steps(wrapped, way)
    turns = np.cumsum(step)
    whole = _by_chain(angles, wrapped, turns, starts[:1], limits, stated, way)
    first = round((near - wrapped[0]) / 360.0)
    if whole.possible[0] and (whole.clear or len(starts) == 1):
        return TurnedAxis(angles + 360.0 * (whole.follow(first) + turns), np.empty(0, np.intp))
    chains = _by_chain(angles, wrapped, turns, starts, limits, stated, way)
    failing = ~chains.possible
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
    return TurnedAxis(out, broken)


class OpenTurns(NamedTuple):
    """least, most: (c,) turns that a chain may be wound by; the first is more where none are.
    within: (n,) turns of a row beyond those of its chain. of_row: (n,) chain of each row.
    """

    least: Ints
    most: Ints
    within: Ints
    of_row: Rows


def open_turns(
    angles: Floats,
    limits: tuple[float, float],
    starts: Rows,
    stated: Ints | None = None,
    way: AxisBetweenTargets | None = None,
) -> OpenTurns:
    """What there is to choose from; the same as `turn` chooses from."""
    wrapped = _filled_by_chain(angles, starts)
    turns = np.cumsum(_turn_steps(wrapped, way))
    chains = _by_chain(angles, wrapped, turns, starts, limits, stated, way)
    within = turns - turns[starts][chains.of_row]
    return OpenTurns(chains.least, chains.most, within, chains.of_row)


LIMIT_CLEARANCE: Final = 1.0
"""degrees that an axis keeps from its limits where another count of turns can: a controller
reads a target rounded, and near a singularity that turns the wrist."""
LIMIT_ROUNDING: Final = 1e-6
"""degrees by which an angle may pass a limit."""
TURNS_NOT_STATED: Final = np.iinfo(np.int64).min
"""In `stated`: the row says nothing of its turns."""


def filled_forward(angles: Floats) -> Floats:
    """NaN rows take the value of the row before, leading ones that of the first after; else 0."""
    known = np.isfinite(angles)
    if known.all():
        return angles
    if not known.any():
        return np.zeros_like(angles)
    last = np.maximum.accumulate(np.where(known, np.arange(len(angles)), -1))
    return np.asarray(angles[np.where(last < 0, known.argmax(), last)])


def _turn_steps(wrapped: Floats, way: AxisBetweenTargets | None) -> Ints:
    """(n,) by how many turns each row is beyond the one before, going to it the short way."""
    step = np.zeros(len(wrapped), dtype=np.int64)
    step[1:] = -np.round(np.diff(wrapped) / 360.0)
    if way is not None:
        step += way.winding
    return step


def _filled_by_chain(angles: Floats, starts: Rows) -> Floats:
    """NaN rows take the value before them, at the start of a chain the one after them.

    So a chain is counted from its own first angle, not from the last of the chain before.
    """
    known = np.isfinite(angles)
    if known.all() or not known.any():
        return filled_forward(angles)
    row, n = np.arange(len(angles)), len(angles)
    last = np.maximum.accumulate(np.where(known, row, -1))
    following = np.minimum.accumulate(np.where(known, row, n)[::-1])[::-1]
    start = np.repeat(starts, np.diff(np.append(starts, n)))
    own = np.where((last < start) & (following < n), following, last)
    return np.asarray(angles[own])


@dataclass(frozen=True, slots=True)
class _AxisChains:
    """starts: (c,) rows. of_row: (n,) chain of each row. offsets: (c,) turns at the starts.
    least, most: (c,) turns with which every row of the chain is inside, and clear of the limits if
    it is so with any; the first is more where there are none. clear: whether all of them are that.
    lowest, highest: turns with which an angle of half a turn about the middle can be inside.
    """

    starts: Rows
    of_row: Rows
    offsets: Ints
    least: Ints
    most: Ints
    clear: bool
    lowest: int
    highest: int

    @property
    def possible(self) -> Truths:
        return np.asarray(self.least <= self.most)

    def follow(self, first: int) -> Ints:
        """(c,) turns at the start of each chain: unbroken where possible, else the nearest."""
        count = len(self.starts)
        moves = np.diff(self.offsets, prepend=self.offsets[:1])
        # Sections of the chains side by side, each from every count of turns before it, which
        # are the lowest to the highest and, of the first section, `first`.
        sections = max(int(np.sqrt(count)), 1)
        length = -(-count // sections)
        shape, filled = (sections, length), length * sections - count
        steps = np.append(moves, np.zeros(filled, np.int64)).reshape(shape)
        least, most = (
            np.append(np.where(self.possible, each, end), np.full(filled, end)).reshape(shape)
            for each, end in ((self.least, self.lowest), (self.most, self.highest))
        )
        at = np.tile(np.arange(self.lowest, self.highest + 1), (sections, 1))
        at[0] = first
        ways = np.empty((length, *at.shape), dtype=np.int64)
        for t in range(length):
            ways[t] = at = np.clip(at + steps[:, t, None], least[:, t, None], most[:, t, None])
        out = np.empty(shape, dtype=np.int64)
        came = 0
        for section in range(sections):
            out[section] = ways[:, section, came]
            came = int(out[section, -1]) - self.lowest
        return out.ravel()[:count]


def _by_chain(
    angles: Floats,
    wrapped: Floats,
    turns: Ints,
    starts: Rows,
    limits: tuple[float, float],
    stated: Ints | None,
    way: AxisBetweenTargets | None,
) -> _AxisChains:
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
    highest = int(np.floor((high - middle + 180.0) / 360.0))
    fewest, greatest = np.full(len(starts), lowest), np.full(len(starts), highest)
    if stated is not None:
        wanted = np.where(stated == TURNS_NOT_STATED, 0, stated - relative)
        smallest = np.minimum.reduceat(
            np.where(stated == TURNS_NOT_STATED, 1 << 40, wanted), starts
        )
        largest = np.maximum.reduceat(
            np.where(stated == TURNS_NOT_STATED, -(1 << 40), wanted), starts
        )
        # All that a chain states has to be the same.
        fewest, greatest = np.maximum(fewest, largest), np.minimum(greatest, smallest)
    # From the best to what has to do: clear of the limits, inside them, inside at the rows alone.
    least, most = np.ones(len(starts), np.int64), np.zeros(len(starts), np.int64)
    clear = False
    for bottom, top, inside in (
        (least_on_way, most_on_way, LIMIT_CLEARANCE),
        (least_on_way, most_on_way, -LIMIT_ROUNDING),
        (lows, highs, -LIMIT_ROUNDING),
    ):
        # A chain without any solution (NaN) allows everything.
        first = np.fmax(np.ceil((low + inside - bottom) / 360.0), fewest).astype(np.int64)
        last = np.fmin(np.floor((high - inside - top) / 360.0), greatest).astype(np.int64)
        open_ = least > most
        least, most = np.where(open_, first, least), np.where(open_, last, most)
        if inside == LIMIT_CLEARANCE:
            clear = bool((first <= last).all())
    return _AxisChains(starts, of_row, turns[starts], least, most, clear, lowest, highest)
