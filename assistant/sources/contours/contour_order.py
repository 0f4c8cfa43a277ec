"""Order of contours: short travel between them, what lies inside others first, or as drawn.

A tour goes to the nearest contour left, and is then improved, contour by contour, by 2-opt (a
stretch of the tour run backwards), by or-opt (up to three contours moved elsewhere), and by
choosing where closed contours start, as long as there is gain and effort left. Only near
neighbours are tried (along Morton curves in O(n log n), some of them missed for the speed of it),
so the work grows little faster than the number of contours. The result depends on the contours
alone, and is never longer than the order they came in. Travel is mm, or the seconds of a
`TravelMeasure`.

`holders` finds which contours lie inside others, seen along the tool: each contour comes after
those inside it, as a part that is cut out falls. `stated_order` takes the order of drawing, or of
the numbers beside contours.
"""

from __future__ import annotations

import math
import re
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from itertools import groupby, pairwise
from typing import Final, Literal

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, error, warning
from assistant.program.geometry import Vector
from assistant.program.settings_tables import shown
from assistant.sources.contours.chains import Contour
from assistant.sources.contours.curves import (
    Arc,
    FreeCurve,
    Line,
    Points,
    chord_counts,
    chorded,
    cross,
    points_at_parts,
    sample,
)
from assistant.sources.contours.moves import level_x_axis
from assistant.sources.contours.work_words import EdgeKind

_MORTON_BITS: Final = 20
"""Bits of each coordinate in a Morton key; three make 60."""
_MORTON_SHIFTS: Final = (0.0, 0.236, 0.618)
"""Parts of the extent that the curve is moved by, so that no border is one in all of them."""
_CANDIDATES_EACH_WAY: Final = 5
"""Points before and after on the curve that count as candidates."""

_BIT_SPREAD: Final = (
    (32, 0x001F00000000FFFF),
    (16, 0x001F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)
"""Shifts and masks that put two zero bits after each of 21 bits."""


def _near_owners(points: Points, owners: Rows, most: int) -> list[list[int]]:
    """For each owner of points (m, 3) up to `most` others, the nearest first.

    owners: (m,), 0 to n - 1 and each of them there. Candidates are the neighbours along
    Morton curves (G. M. Morton, 1966) through the points.
    """
    pairs = []
    for shift in _MORTON_SHIFTS:
        order = _along_morton_curve(points, shift)
        pairs += [np.stack([order[:-n], order[n:]]) for n in range(1, _CANDIDATES_EACH_WAY + 1)]
    one, two = np.concatenate(pairs, axis=1)
    apart = np.linalg.norm(points[one] - points[two], axis=1)
    a, b = owners[np.r_[one, two]], owners[np.r_[two, one]]
    order = np.lexsort((b, np.r_[apart, apart], a))
    lists: list[list[int]] = [[] for _ in range(int(owners.max(initial=-1)) + 1)]
    for owner, other in zip(a[order].tolist(), b[order].tolist(), strict=True):
        mine = lists[owner]
        if len(mine) < most and owner != other and other not in mine:
            mine.append(other)
    return lists


def _along_morton_curve(points: Points, shift: float = 0.0) -> Rows:
    """The points (m, 3) in the order of a Morton curve."""
    if not len(points):
        return np.empty(0, dtype=np.intp)
    low = points.min(axis=0)
    # All points in one place would divide by zero.
    extent = max(float((points.max(axis=0) - low).max()), 1e-9)
    cells = ((points - low) / extent + shift) / (1.0 + max(_MORTON_SHIFTS)) * (2**_MORTON_BITS - 1)
    bits = cells.astype(np.uint64)
    for by, mask in _BIT_SPREAD:
        bits = (bits | (bits << np.uint64(by))) & np.uint64(mask)
    x, y, z = bits.T
    return np.argsort(x | (y << np.uint64(1)) | (z << np.uint64(2)), kind="stable")


_TRIED_NEIGHBOURS: Final = 8
"""Other contours that a contour is tried beside."""
_LOOKS_PER_CONTOUR: Final = 12
"""Looks at each contour, on the average, while improving a tour."""
_MANY_CONTOURS: Final = 2000
"""Contours over which the effort for all of them grows no further, but one look at each."""
_MOST_STARTS_TRIED: Final = 24
"""Vertices of a closed contour that are tried as its start."""
_LONGEST_MOVED_RUN: Final = 3
_LEAST_GAIN: Final = 1e-6
_FREE_CONTOUR: Final = -1
"""Holder of a contour that none holds."""

TourPoint = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class TravelMeasure:
    """Measure of travel that replaces mm.

    places: points (n, 3) → (n, k), each the arguments of `apart`; None if they are not available.
    apart: from point to point.
    """

    places: Callable[[Points], Floats | None]
    apart: Callable[[TourPoint, TourPoint], float]


_BY_TRAVEL_LENGTH: Final = TravelMeasure(lambda points: points, math.dist)


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
        stops, list(holders) or [_FREE_CONTOUR] * len(given), measure
    )
    made = tuple(tour.stops[c].contour() for c in tour.order)
    # The given order may break the rule of holders: then it is no alternative.
    allowed = all(holder == _FREE_CONTOUR or i < holder for i, holder in enumerate(tour.holders))
    if allowed and before <= after:
        return ContourOrder(given, before, before, timed)
    return ContourOrder(made, before, after, timed)


@dataclass(frozen=True, slots=True)
class PointOrder:
    """rows: of points, in the order to visit them. before, after: as of `ContourOrder`."""

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
    before, after, tour, timed = _improved_tour(stops, [_FREE_CONTOUR] * len(stops), measure)
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
    used = _BY_TRAVEL_LENGTH if measure is None or places is None else measure
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
        tried = min(count, _MOST_STARTS_TRIED)
        rows = [i * count // tried for i in range(tried)]
        return _Stop(contour, vertices[rows], rows)

    def stand(self, places: list[TourPoint]) -> None:
        """Set the entry, the exit and the choices from the tour points of its points, in the given
        order.
        """
        self.entry, self.exit = places[0], places[0 if self.vertices else -1]
        self.choices = places if self.vertices else []

    def ends(self) -> Points:
        """Return the points that represent it in the search for its neighbours."""
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
            if holder != _FREE_CONTOUR:
                self.held[holder].append(stop)
        self.free = all(holder == _FREE_CONTOUR for holder in holders)
        self.any_fixed = any(stop.fixed for stop in stops)
        ends = [stop.ends() for stop in stops]
        points = np.concatenate(ends)
        owners = np.repeat(np.arange(len(stops)), [len(e) for e in ends])
        self.near = _near_owners(points, owners, _TRIED_NEIGHBOURS)
        self.order = self._nearest_first(owners[_along_morton_curve(points)].tolist())
        self.place = [0] * len(stops)
        for place, stop in enumerate(self.order):
            self.place[stop] = place

    def _nearest_first(self, curve: list[int]) -> list[int]:
        """Order the contours from the first to the nearest neighbour left.

        If all the neighbours are done, the next one on the curve follows. A holder waits for the
        contours that it holds, and is the next one then if no neighbour is left.
        """
        done = [False] * len(self.stops)
        waits = [len(held) for held in self.held]
        rest = iter(curve)
        freed: list[int] = []
        order: list[int] = []
        # A contour that holds none always exists: holders form no circle.
        stop: int | None = waits.index(0)
        while stop is not None:
            done[stop] = True
            order.append(stop)
            here = self.stops[stop].exit
            open_ = [s for s in self.near[stop] if not done[s] and not waits[s]]
            if (holder := self.holders[stop]) != _FREE_CONTOUR:
                waits[holder] -= 1
                if not waits[holder]:
                    freed.append(holder)
                    open_.append(holder)
            # Holders that were taken as a neighbour are done.
            while freed and done[freed[-1]]:
                freed.pop()
            if open_:
                stop = min(open_, key=lambda s: (self._enter_near(s, here), s))
            elif freed:
                stop = freed.pop()
            else:
                stop = next((s for s in rest if not done[s] and not waits[s]), None)
            if stop is not None:
                # Candidates turn as they are compared; a stop from the other branches has not been
                # turned yet.
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
        effort = max(_LOOKS_PER_CONTOUR * min(n, _MANY_CONTOURS), n)
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
        best = (_LEAST_GAIN, 0, 0, -1, False)
        for change in self._changes(stop):
            gain = self._gain(*change)
            if gain > best[0] and self._allowed(*change):
                best = (gain, *change)
        _, low, high, to, backwards = best
        if high == 0:
            return changed
        # The stops next to the changed links may gain anew.
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
        # Stretches up to an end of the tour change one link only.
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
            for size in range(1, _LONGEST_MOVED_RUN + 1):
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
        """True if after a change each stop still comes before its holder."""
        place, holders = self.place, self.holders
        moved = self.order[low:high]
        later = [place[holders[s]] if holders[s] != _FREE_CONTOUR else math.inf for s in moved]
        # Run backwards, a stop would come after a holder in the same stretch.
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
        # A stretch that stays in its place can only be turned.
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
        # Only the places between both ends of the change have moved.
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
        if costs[best] >= costs[it.chosen] - _LEAST_GAIN:
            return []
        it.enter(best)
        return self.order[max(i - 1, 0) : i + 2]

    def _entry(self, place: int) -> TourPoint | None:
        return self.stops[self.order[place]].entry if place < len(self.order) else None

    def _exit(self, place: int) -> TourPoint | None:
        return self.stops[self.order[place]].exit if place >= 0 else None


NO_HOLDER: Final = -1
_HOLDER_BATCH: Final = 256
"""Contours whose holders are searched together; bounds memory."""
_PROBED_PARTS: Final = (0.17, 0.5, 0.83)
"""Parts of a contour's way that have to be inside, most of them: ends may touch the outline."""


def holders(contours: Sequence[Contour], direction: Vector, tolerance: float) -> list[int]:
    """For each contour the smallest closed one that it lies inside, or -1.

    direction: of the tool, along which it is seen. tolerance: mm that an arc may leave its
    chords. A contour that crosses another one is inside it if most of it is.
    """
    return _holders_in_groups([contours], direction, tolerance)[0]


def _holders_in_groups(
    groups: Sequence[Sequence[Contour]], direction: Vector, tolerance: float
) -> tuple[list[int], list[int]]:
    """The holders of the contours of all groups, one after the other: among all of them, and among
    those of the same group.
    """
    contours = [contour for group in groups for contour in group]
    among_all, in_group = (np.full(len(contours), NO_HOLDER, dtype=np.intp) for _ in range(2))
    if not any(c.closed for c in contours):
        return among_all.tolist(), in_group.tolist()
    import shapely

    group_of = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    across = view_axes(direction)
    outlines = [polygon_outline(c, tolerance) @ across.T for c in contours]
    low, high = (np.array([f(o, axis=0) for o in outlines]) for f in (np.min, np.max))
    areas = np.zeros(len(contours))
    closed = [i for i, c in enumerate(contours) if c.closed and len(outlines[i]) > 2]
    polygons = np.array([shapely.Polygon(outlines[i]) for i in closed], dtype=object)
    areas[closed] = shapely.area(polygons)
    parts = len(_PROBED_PARTS)
    probes = shapely.points(np.concatenate([_probe_points(o) for o in outlines]))
    tree = shapely.STRtree(probes)
    order = np.argsort(areas[closed], kind="stable")[::-1]  # the smallest holder is set last
    for first in range(0, len(order), _HOLDER_BATCH):
        some = order[first : first + _HOLDER_BATCH]
        outer, probe = tree.query(polygons[some], predicate="contains")
        # One number for each pair of contours: how many probes of the inner are inside the outer.
        pairs, inside = np.unique(outer * len(contours) + probe // parts, return_counts=True)
        pairs = pairs[inside > parts / 2]
        holder, inner = np.array(closed)[some][pairs // len(contours)], pairs % len(contours)
        # A contour that leaves the box of an outline is not inside it; twins have equal areas.
        boxed = (low[holder] <= low[inner] + tolerance) & (high[holder] >= high[inner] - tolerance)
        held = boxed.all(axis=1) & (areas[holder] > areas[inner] + tolerance**2)
        among_all[inner[held]] = holder[held]
        own = held & (group_of[holder] == group_of[inner])
        in_group[inner[own]] = holder[own]
    return among_all.tolist(), in_group.tolist()


@dataclass(frozen=True, slots=True)
class GroupNesting:
    """Nesting of the contours of one group.

    holders: see `holders`, among the contours of the group. inside: True for a contour that
    material is around, False for an outline, None for one that may be no edge of the part. holds:
    True for those that others of any group lie inside. around: for each other group whose contours
    lie inside contours of this one, how many of them do.
    """

    holders: list[int]
    inside: list[bool | None]
    holds: list[bool]
    around: Mapping[int, int]


def group_nestings(
    groups: Sequence[tuple[Vector, EdgeKind, Sequence[Contour]]], tolerance: float
) -> list[GroupNesting]:
    """Return the nesting of each group of contours, among all groups seen in the same direction.

    groups: direction of the tool, what the contours are, and the contours.
    """
    found: dict[int, GroupNesting] = {}
    for direction in dict.fromkeys(direction for direction, *_ in groups):
        rows = [row for row, (seen, *_) in enumerate(groups) if seen == direction]
        members = [groups[row][2] for row in rows]
        around, in_group = _holders_in_groups(members, direction, tolerance)
        held = set(around)
        group_of = [k for k, some in enumerate(members) for _ in some]
        inside = _inside(around, in_group, group_of, [groups[row][1] for row in rows])
        inner = _inner_groups(around, group_of)
        first = 0
        for at, (row, contours) in enumerate(zip(rows, members, strict=True)):
            part = range(first, first + len(contours))
            own = [NO_HOLDER if (to := in_group[k]) == NO_HOLDER else to - first for k in part]
            found[row] = GroupNesting(
                own,
                [inside[k] for k in part],
                [k in held for k in part],
                {rows[other]: count for other, count in inner[at].items()},
            )
            first += len(contours)
    return [found[row] for row in range(len(groups))]


@dataclass(frozen=True, slots=True)
class _Enclosure:
    """The contours around one, without those on surfaces. outermost: group of the first of them,
    None without any. edges: number of those in groups of edges. all: number of all of them.
    covered: True if a contour on a surface is around all of them: material is there.
    """

    outermost: int | None = None
    edges: int = 0
    all: int = 0
    covered: bool = False


_NOT_ENCLOSED: Final = _Enclosure()


def _inside(
    around: Sequence[int],
    in_group: Sequence[int],
    group_of: Sequence[int],
    kinds: Sequence[EdgeKind],
) -> list[bool | None]:
    """See `GroupNesting.inside`. kinds: what the contours of each group are.

    A line on a surface, such as a bead around a hole, encloses nothing. A line that may be one does
    not either where the outermost contour is an edge, or of the same group as the contour: the
    edges alone then tell what is a hole. A line on a surface around the outermost edge does count:
    it lies on material.
    """
    own_depths = nesting_depths(in_group)
    enclosures = dict[int, _Enclosure]()
    for at in range(len(around)):
        chain, row = list[int](), at
        while row not in enclosures:
            chain.append(row)
            row = around[row]
            if row == NO_HOLDER:
                break
        for one in reversed(chain):
            holder = around[one]
            if holder == NO_HOLDER:
                enclosures[one] = _NOT_ENCLOSED
                continue
            outer, group = enclosures[holder], group_of[holder]
            if kinds[group] == "surface":
                covered = outer.covered or outer.outermost is None
                enclosures[one] = replace(outer, covered=covered)
                continue
            outermost = group if outer.outermost is None else outer.outermost
            edges = outer.edges + (kinds[group] == "edge")
            enclosures[one] = _Enclosure(outermost, edges, outer.all + 1, outer.covered)
    found = list[bool | None]()
    for row, group in enumerate(group_of):
        kind, outer = kinds[group], enclosures[row]
        first = outer.outermost
        outlined = first == group or (first is None and not outer.covered)
        if kind == "surface" or (kind == "unknown" and not outlined):
            found.append(None)
            continue
        sure = outer.edges + (0 if kind == "edge" else own_depths[row])
        known = first is None or first == group or kinds[first] == "edge"
        found.append(((sure if known else outer.all) + outer.covered) % 2 == 1)
    return found


def _inner_groups(around: Sequence[int], group_of: Sequence[int]) -> defaultdict[int, Counter[int]]:
    """For each group how many contours of each other group lie inside contours of it.

    around: `holders` of the contours. group_of: the group of each.
    """
    outer: list[frozenset[int] | None] = [None] * len(around)
    inner = defaultdict[int, Counter[int]](Counter)
    for row in range(len(around)):
        chain, at = list[int](), row
        while at != NO_HOLDER and outer[at] is None:
            chain.append(at)
            at = around[at]
        for one in reversed(chain):
            holder = around[one]
            known = frozenset[int]() if holder == NO_HOLDER else outer[holder] or frozenset()
            more = frozenset() if holder == NO_HOLDER else frozenset({group_of[holder]})
            # Most contours share the set of the one around them.
            outer[one] = known if more <= known else known | more
    for row, groups in enumerate(outer):
        for group in groups or ():
            if group != group_of[row]:
                inner[group][group_of[row]] += 1
    return inner


def nesting_depths(around: Sequence[int]) -> list[int]:
    """Return the number of contours around each contour. around: `holders` of them."""
    depths: list[int | None] = [None] * len(around)
    for row in range(len(around)):
        chain = []
        while row != NO_HOLDER and depths[row] is None:
            chain.append(row)
            row = around[row]
        depth = -1 if row == NO_HOLDER else depths[row] or 0
        for inner in reversed(chain):
            depth += 1
            depths[inner] = depth
    return [depth or 0 for depth in depths]


def view_axes(direction: Vector) -> Points:
    """The two axes (2, 3) of the plane that the tool looks onto."""
    x = level_x_axis(direction)
    return np.stack([x, cross(np.asarray(direction, dtype=np.float64), x)])


def polygon_outline(contour: Contour, tolerance: float) -> Points:
    """Corners (n, 3) of a polygon along the contour, its end left out if it is closed."""
    parts = []
    for is_free, group in groupby(contour.curves, key=lambda curve: isinstance(curve, FreeCurve)):
        if is_free:
            parts += [chorded(curve, tolerance)[:-1] for curve in group]
            continue
        pieces: list[Line | Arc] = list(group)  # type: ignore[arg-type]
        counts = chord_counts(pieces, tolerance)
        rows = np.repeat(np.arange(len(pieces)), counts)
        first = np.cumsum(counts) - counts
        parts.append(
            points_at_parts(pieces, rows, (np.arange(len(rows)) - first[rows]) / counts[rows])
        )
    return np.concatenate(parts if contour.closed else [*parts, [contour.end]])


def _probe_points(outline: Points) -> Points:
    """Points (k, 2) between corners of an outline."""
    place = np.array(_PROBED_PARTS) * (len(outline) - 1)
    row = np.minimum(place.astype(np.intp), max(len(outline) - 2, 0))
    after = np.minimum(row + 1, len(outline) - 1)
    part = (place - row)[:, None]
    return np.asarray((1.0 - part) * outline[row] + part * outline[after])


_HOLDER_FIRST = warning(
    "CT224",
    "{count} contours of layer {layer!r} come before others that lie inside them; what is cut out"
    " falls before its holes are done",
    "number or draw the inner ones first, or say inside_first = false",
)
_NO_NUMBER = warning(
    "CT225",
    "{count} of {all} contours of layer {layer!r} have no number beside them and come last, in the"
    " order of drawing",
    "write a text with a whole number beside each, on that layer",
)
_TWO_NUMBERS = error(
    "CT226",
    "the numbers {one} and {other} on layer {layer!r} stand beside the same contour",
    "move each text to its own contour: the nearest one to its insertion point",
)
_SAME_NUMBER = error(
    "CT227",
    "the number {one} stands beside two contours of layer {layer!r}",
    "give each contour a number of its own",
)
_NUMBER_BETWEEN_CONTOURS = error(
    "CT228",
    "the number {one} on layer {layer!r} stands as near to one contour as to another",
    "move it nearer to its own one",
)

_NUMBER_TEXT: Final = re.compile(r"[#(\s]*(\d{1,9})[.):\s]*")
"""A text that numbers a contour: `3`, `3.`, `(3)`, `#3`."""
_LEAST_DISTANCE_GAP: Final = 0.1
"""mm by which the nearest contour has to be nearer than the next one."""
_OUTLINE_CHORDS: Final = 64
"""Chords of each curve that is not a line, to which a text's distance is measured."""


@dataclass(frozen=True, slots=True)
class LayerText:
    """A text on a drawing's layer. at: its insertion point, mm in the drawing's world."""

    text: str
    at: Vector
    layer: str
    handle: str = ""

    @property
    def number(self) -> int | None:
        """Number that the text gives to a contour, None for a text that is not a number."""
        found = _NUMBER_TEXT.fullmatch(self.text)
        return None if found is None else int(found[1])


OrderFindings = tuple[Diagnostic, ...]


def stated_order(
    contours: Sequence[Contour],
    drawn: Sequence[Contour],
    holders: Sequence[int],
    order: Literal["drawing", "text"],
    texts: Sequence[LayerText] = (),
) -> tuple[ContourOrder, OrderFindings]:
    """The contours as the drawing has them: none is turned, or started elsewhere.

    drawn: what each of them was, beside which the texts stand.
    holders: for each contour the one that it lies in, or -1; none: nobody minds. texts: those of
    the layer.
    """
    rows, findings = list(range(len(contours))), list[Diagnostic]()
    if order == "text":
        numbers, findings = _numbers_of_contours(drawn, texts)
        rows.sort(key=lambda i: (numbers.get(i, math.inf), i))
    place = {row: at for at, row in enumerate(rows)}
    early = {h for i, h in enumerate(holders) if h != _FREE_CONTOUR and place[h] < place[i]}
    if early:
        findings.append(_HOLDER_FIRST(count=len(early), layer=shown(contours[0].layer)))
    made = tuple(contours[row] for row in rows)
    return ContourOrder(made, travel_length(contours), travel_length(made)), tuple(findings)


def _numbers_of_contours(
    contours: Sequence[Contour], texts: Sequence[LayerText]
) -> tuple[dict[int, int], list[Diagnostic]]:
    """The number of each contour that has one, and what is wrong."""
    findings: list[Diagnostic] = []
    layer = shown(contours[0].layer)
    numbers: dict[int, int] = {}
    outlines = [_sampled_outline(contour) for contour in contours]
    for one in texts:
        if (number := one.number) is None:
            continue
        place = f"entity {one.handle}" if one.handle else None
        apart = np.array([distance_to_outline(one.at, outline) for outline in outlines])
        nearest = int(apart.argmin())
        if (
            np.partition(apart, 1)[1] - apart[nearest] < _LEAST_DISTANCE_GAP
            if len(apart) > 1
            else False
        ):
            findings.append(_NUMBER_BETWEEN_CONTOURS(place=place, layer=layer, one=number))
        elif nearest in numbers:
            findings.append(
                _TWO_NUMBERS(place=place, layer=layer, one=numbers[nearest], other=number)
            )
        elif number in numbers.values():
            findings.append(_SAME_NUMBER(place=place, layer=layer, one=number))
        else:
            numbers[nearest] = number
    if without := len(contours) - len(numbers):
        findings.append(_NO_NUMBER(layer=layer, count=without, all=len(contours)))
    return numbers, findings


def _sampled_outline(contour: Contour) -> Floats:
    """Points (n, 3) of a line along it."""
    points = []
    for curve in contour.curves:
        count = 2 if isinstance(curve, Line) else _OUTLINE_CHORDS + 1
        points.append(sample([curve], np.linspace(0.0, 1.0, count))[0])
    return np.concatenate(points)


def distance_to_outline(at: Sequence[float], outline: Floats) -> float:
    """Mm from a point to a line through points (n, 3), or both in a plane."""
    first, step = outline[:-1], np.diff(outline, axis=0)
    size = (step**2).sum(axis=1)
    to = np.asarray(at) - first
    part = np.clip((to * step).sum(axis=1) / np.where(size > 0.0, size, 1.0), 0.0, 1.0)
    return float(np.linalg.norm(to - part[:, None] * step, axis=1).min())
