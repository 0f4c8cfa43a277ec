"""The order of contours that keeps the travel between them short.

A tour goes to the nearest contour left, and is then improved, contour by contour, by 2-opt
(a stretch of the tour run backwards), by or-opt (up to three contours moved elsewhere), and
by choosing where closed contours start, as long as there is gain and effort left. Only near
neighbours are tried, so the work grows little faster than the number of contours. The
result depends on the contours alone, and is never longer than the order they came in.

Where contours have holders, each comes before its own, and only changes that keep it so are
made: what lies inside others is done first, as a part that is cut out falls.

Travel is mm between points, or the seconds of a `Measure`.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.sources.contours.chaining import Contour
from assistant.sources.contours.curves import Points
from assistant.sources.contours.neighbours import along_morton_curve, near_owners

TRIED_NEIGHBOURS: Final = 8
"""Other contours that a contour is tried beside."""
LOOKS_PER_CONTOUR: Final = 12
"""Looks at each contour, on the average, while improving a tour."""
MANY_CONTOURS: Final = 2000
"""Contours over which the effort for all of them grows no further, but one look at each."""
MOST_STARTS_TRIED: Final = 24
"""Vertices of a closed contour that are tried as its start."""
LONGEST_MOVED_RUN: Final = 3
LEAST_GAIN: Final = 1e-6
FREE_CONTOUR: Final = -1
"""Holder of a contour that none holds."""

TourPoint = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class TravelMeasure:
    """What travel is measured by instead of mm.

    places: points (n, 3) → (n, k), each what `apart` asks of it; None if that cannot be had.
    apart: from place to place.
    """

    places: Callable[[Points], Floats | None]
    apart: Callable[[TourPoint, TourPoint], float]


BY_TRAVEL_LENGTH: Final = TravelMeasure(lambda points: points, math.dist)


@dataclass(frozen=True, slots=True)
class ContourOrder:
    """contours: as they should be followed. before, after: mm of travel between them, or what it
    was measured by if `measured`.
    """

    contours: tuple[Contour, ...]
    before: float
    after: float
    measured: bool = False


def order_contours(
    contours: Sequence[Contour], holders: Sequence[int] = (), measure: TravelMeasure | None = None
) -> ContourOrder:
    """The contours in an order of short travel: turned, started elsewhere, none left out.

    holders: for each contour the one that it has to come before, or -1; none: no such rule. It
    may make the travel longer than in the order of drawing. measure: of travel, None for mm.
    """
    given = tuple(contours)
    if len(given) < 2:
        return ContourOrder(given, 0.0, 0.0)
    stops = [_Stop.of(c) for c in given]
    before, after, tour, timed = _improved_tour(
        stops, list(holders) or [FREE_CONTOUR] * len(given), measure
    )
    made = tuple(tour.stops[c].contour() for c in tour.order)
    allowed = all(holder == FREE_CONTOUR or i < holder for i, holder in enumerate(tour.holders))
    if allowed and before <= after:
        return ContourOrder(given, before, before, timed)
    return ContourOrder(made, before, after, timed)


@dataclass(frozen=True, slots=True)
class PointOrder:
    """rows: of points, in the order to visit them. before, after: as of `Ordering`."""

    rows: tuple[int, ...]
    before: float
    after: float
    measured: bool


def order_points(points: Points, measure: TravelMeasure) -> PointOrder:
    """Points (n, 3) in an order of short travel."""
    given = tuple(range(len(points)))
    if len(points) < 2:
        return PointOrder(given, 0.0, 0.0, measured=False)
    stops = [_Stop(None, points[i : i + 1], [0]) for i in given]
    before, after, tour, timed = _improved_tour(stops, [FREE_CONTOUR] * len(stops), measure)
    if before <= after:
        return PointOrder(given, before, before, timed)
    return PointOrder(tuple(tour.order), before, after, timed)


def travel_length(contours: Sequence[Contour]) -> float:
    """Mm from the end of each contour to the start of the next."""
    ends = [c.end for c in contours[:-1]]
    starts = [c.start for c in contours[1:]]
    return math.fsum(map(math.dist, ends, starts))


def _improved_tour(
    stops: list[_Stop], holders: list[int], measure: TravelMeasure | None
) -> tuple[float, float, _Tour, bool]:
    """A tour of stops, the travel before and after, and whether the measure could be taken."""
    points = np.concatenate([stop.points for stop in stops])
    places = None if measure is None else measure.places(points)
    used = BY_TRAVEL_LENGTH if measure is None or places is None else measure
    rest = iter(map(tuple, (points if places is None else places).tolist()))
    for stop in stops:
        stop.stand([next(rest) for _ in range(len(stop.points))])
    before = _tour_travel(stops, used)
    tour = _Tour(stops, holders, used)
    tour.improve()
    return before, _tour_travel([stops[i] for i in tour.order], used), tour, used is measure


def _tour_travel(stops: Sequence[_Stop], measure: TravelMeasure) -> float:
    return math.fsum(measure.apart(a.exit, b.entry) for a, b in pairwise(stops))


@dataclass(slots=True)
class _Stop:
    """A contour in the tour, or a point alone: where the tool goes in and out.

    points: (m, 3), of an open contour its ends, of a closed one its possible starts, which are
    those vertices. choices: the places of those.
    """

    given: Contour | None
    points: Points
    vertices: list[int]
    entry: TourPoint = ()
    exit: TourPoint = ()
    choices: list[TourPoint] = field(default_factory=list)
    chosen: int = 0
    backwards: bool = False
    fixed: bool = False

    @staticmethod
    def of(contour: Contour) -> _Stop:
        if not contour.closed:
            ends = np.array([contour.start, contour.end])
            return _Stop(contour, ends, [], fixed=contour.fixed)
        vertices = contour.vertices
        count = len(vertices)
        tried = min(count, MOST_STARTS_TRIED)
        rows = [i * count // tried for i in range(tried)]
        return _Stop(contour, vertices[rows], rows)

    def stand(self, places: list[TourPoint]) -> None:
        """As given, with the places of its points."""
        self.entry, self.exit = places[0], places[0 if self.vertices else -1]
        self.choices = places if self.vertices else []

    def ends(self) -> Points:
        """The points that stand for it when its neighbours are looked for."""
        return self.points[:: max(1, len(self.choices) // 4)]

    def flip(self) -> None:
        self.entry, self.exit = self.exit, self.entry
        self.backwards = not self.backwards

    def enter(self, choice: int) -> None:
        self.chosen = choice
        self.entry = self.exit = self.choices[choice]

    def contour(self) -> Contour:
        assert self.given is not None
        if self.choices:
            return self.given.starting_at(self.vertices[self.chosen])
        return self.given.reversed() if self.backwards else self.given


class _Tour:
    """order: the stop at each place. place: the place of each stop.

    holders: of each stop the one that comes later, or -1. held: the stops that each holds.
    """

    def __init__(self, stops: list[_Stop], holders: list[int], measure: TravelMeasure) -> None:
        self.stops, self.holders, self.apart = stops, holders, measure.apart
        self.held: list[list[int]] = [[] for _ in stops]
        for stop, holder in enumerate(holders):
            if holder != FREE_CONTOUR:
                self.held[holder].append(stop)
        self.free = all(holder == FREE_CONTOUR for holder in holders)
        self.any_fixed = any(stop.fixed for stop in stops)
        ends = [stop.ends() for stop in stops]
        points = np.concatenate(ends)
        owners = np.repeat(np.arange(len(stops)), [len(e) for e in ends])
        self.near = near_owners(points, owners, TRIED_NEIGHBOURS)
        self.order = self._nearest_first(owners[along_morton_curve(points)].tolist())
        self.place = [0] * len(stops)
        for place, stop in enumerate(self.order):
            self.place[stop] = place

    def _nearest_first(self, curve: list[int]) -> list[int]:
        """From the first contour on to the nearest neighbour left.

        Where all the neighbours are done, the next one on the curve follows. A holder waits
        for what it holds, and is the next one then if no neighbour is left.
        """
        done = [False] * len(self.stops)
        waits = [len(held) for held in self.held]
        rest = iter(curve)
        freed: list[int] = []
        order: list[int] = []
        stop: int | None = waits.index(0)
        while stop is not None:
            done[stop] = True
            order.append(stop)
            here = self.stops[stop].exit
            open_ = [s for s in self.near[stop] if not done[s] and not waits[s]]
            if (holder := self.holders[stop]) != FREE_CONTOUR:
                waits[holder] -= 1
                if not waits[holder]:
                    freed.append(holder)
                    open_.append(holder)
            while freed and done[freed[-1]]:
                freed.pop()
            if open_:
                stop = min(open_, key=lambda s: (self._enter_near(s, here), s))
            elif freed:
                stop = freed.pop()
            else:
                stop = next((s for s in rest if not done[s] and not waits[s]), None)
            if stop is not None:
                self._enter_near(stop, here)
        return order

    def _enter_near(self, stop: int, here: TourPoint) -> float:
        """Turns the stop so that it is entered where it is nearest, and says how near."""
        it = self.stops[stop]
        if it.choices:
            it.enter(min(range(len(it.choices)), key=lambda i: self.apart(here, it.choices[i])))
        elif not it.fixed and self.apart(here, it.exit) < self.apart(here, it.entry):
            it.flip()
        return self.apart(here, it.entry)

    def _link(self, one: TourPoint | None, two: TourPoint | None) -> float:
        """Travel between two places of the tour; none before its start and after its end."""
        return 0.0 if one is None or two is None else self.apart(one, two)

    def _nearest(self, one: _Stop, other: _Stop) -> float:
        """Travel between them, whichever way they are turned."""
        return min(
            self.apart(a, b) for a in (one.entry, one.exit) for b in (other.entry, other.exit)
        )

    def improve(self) -> None:
        """Looks at each stop until none gains any more, or the effort is spent."""
        n = len(self.order)
        waiting, queued = deque(self.order), [True] * n
        effort = max(LOOKS_PER_CONTOUR * min(n, MANY_CONTOURS), n)
        while waiting and effort > 0:
            effort -= 1
            stop = waiting.popleft()
            queued[stop] = False
            for touched in self._look(stop):
                if not queued[touched]:
                    queued[touched] = True
                    waiting.append(touched)

    def _look(self, stop: int) -> list[int]:
        """Makes the best change found near a stop; the stops whose links it changed."""
        changed = self._start_elsewhere(stop)
        best = (LEAST_GAIN, 0, 0, -1, False)
        for change in self._changes(stop):
            gain = self._gain(*change)
            if gain > best[0] and self._allowed(*change):
                best = (gain, *change)
        _, low, high, to, backwards = best
        if high == 0:
            return changed
        places = {low - 1, low, high - 1, high}
        if to >= 0:
            places |= {to - 1, to, to + low - high, to + high - low}
        self._apply(low, high, to, backwards)
        last = len(self.order) - 1
        around = {min(max(p + d, 0), last) for p in places for d in (-1, 0, 1)}
        return [self.order[p] for p in sorted(around)]

    def _changes(self, stop: int) -> Iterator[tuple[int, int, int, bool]]:
        """Stretches (low, high) to run backwards (to = -1) or to move before place `to`."""
        n, i = len(self.order), self.place[stop]
        yield 0, i, -1, True
        yield i + 1, n, -1, True
        yield 0, i + 1, -1, True
        yield i, n, -1, True
        it = self.stops[stop]
        longest = max(
            self._link(self._exit(i - 1), it.entry), self._link(it.exit, self._entry(i + 1))
        )
        for other in self.near[stop]:
            if self._nearest(self.stops[other], it) >= longest:
                continue  # no new link to it would be shorter than the stop's own
            j = self.place[other]
            a, b = (i, j) if i < j else (j, i)
            yield a + 1, b + 1, -1, True
            yield a, b, -1, True
            for size in range(1, LONGEST_MOVED_RUN + 1):
                for low in {i, i - size + 1}:
                    high = low + size
                    if low < 0 or high > n or low <= j < high:
                        continue
                    for to in (j, j + 1):
                        if to not in (low, high):
                            yield low, high, to, False
                        yield low, high, to, True

    def _allowed(self, low: int, high: int, to: int, backwards: bool) -> bool:
        if backwards and self.any_fixed and any(self.stops[s].fixed for s in self.order[low:high]):
            return False
        return self.free or self._keeps_holders(low, high, to, backwards)

    def _keeps_holders(self, low: int, high: int, to: int, backwards: bool) -> bool:
        """Whether after a change each stop still comes before its holder."""
        place, holders = self.place, self.holders
        moved = self.order[low:high]
        later = [place[holders[s]] if holders[s] != FREE_CONTOUR else math.inf for s in moved]
        if backwards and any(low <= p < high for p in later):
            return False
        if to > high:
            return not any(high <= p < to for p in later)
        if 0 <= to < low:
            return not any(to <= place[s] < low for stop in moved for s in self.held[stop])
        return True

    def _gain(self, low: int, high: int, to: int, backwards: bool) -> float:
        """By how much a change shortens the tour."""
        if high - low < 1:
            return 0.0
        before, after = self._exit(low - 1), self._entry(high)
        head, tail = self._entry(low), self._exit(high - 1)
        old = self._link(before, head) + self._link(tail, after)
        if to < 0 or to in (low, high):
            return old - self._link(before, tail) - self._link(head, after) if backwards else 0.0
        into, out = (tail, head) if backwards else (head, tail)
        left, right = self._exit(to - 1), self._entry(to)
        new = self._link(left, into) + self._link(out, right) - self._link(left, right)
        return old - self._link(before, after) - new

    def _apply(self, low: int, high: int, to: int, backwards: bool) -> None:
        moved = self.order[low:high]
        if backwards:
            moved.reverse()
            for stop in moved:
                self.stops[stop].flip()
        first, last = low, high
        if to < 0 or to in (low, high):
            self.order[low:high] = moved
        elif to < low:
            self.order[to:high] = moved + self.order[to:low]
            first = to
        else:
            self.order[low:to] = self.order[high:to] + moved
            last = to
        for place in range(first, last):
            self.place[self.order[place]] = place

    def _start_elsewhere(self, stop: int) -> list[int]:
        """Starts a closed contour at the vertex nearest to what is before and after."""
        it, i = self.stops[stop], self.place[stop]
        if not it.choices:
            return []
        before, after = self._exit(i - 1), self._entry(i + 1)
        costs = [self._link(before, p) + self._link(p, after) for p in it.choices]
        best = min(range(len(costs)), key=costs.__getitem__)
        if costs[best] >= costs[it.chosen] - LEAST_GAIN:
            return []
        it.enter(best)
        return self.order[max(i - 1, 0) : i + 2]

    def _entry(self, place: int) -> TourPoint | None:
        return self.stops[self.order[place]].entry if place < len(self.order) else None

    def _exit(self, place: int) -> TourPoint | None:
        return self.stops[self.order[place]].exit if place >= 0 else None
