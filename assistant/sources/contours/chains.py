"""Contours: curves of one layer chained end to end.

Ends that meet exactly are one node of a graph; loose ends that remain are joined to the nearest
other loose end within the tolerance. Exact meetings go first, so that a contour of segments that
are shorter than the tolerance keeps all of them.

`without_overlaps` cuts curves that lie in part on others, so that each stretch is followed once.
`_pairs_within` finds near points with a grid in O(n log n), without looking at pairs in Python.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Rows
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, error, info, warning
from assistant.program.geometry import Vector
from assistant.sources.contours.curves import (
    Arc,
    Curve,
    FreeCurve,
    Line,
    Points,
    chord_counts,
    chorded,
    points_at_parts,
    sample,
    started_at,
    vector,
)

Indices = NDArray[np.intp]

_MOST_CELL_NEIGHBOURS: Final = 64
"""Neighbours a point is compared with in one grid cell; keeps crowds of points linear."""

_CELL_KEY_PRIMES: Final = np.array([73856093, 19349663, 83492791], dtype=np.int64)
"""Weights of a cell's three indices in its key; a collision only costs a comparison."""

_HALF_NEIGHBOURS: Final = np.array(
    [
        *[(0, 0, 1), (0, 1, -1), (0, 1, 0), (0, 1, 1)],
        *[(1, y, z) for y in (-1, 0, 1) for z in (-1, 0, 1)],
    ],
    dtype=np.int64,
)
"""One of each pair of opposite neighbours of a cell."""


def _pairs_within(points: Points, distance: float) -> tuple[Indices, Indices, Points]:
    """Pairs i < j of points (n, 3) at most `distance` apart, and how far apart they are.

    Sorted by distance, then i, then j. Of more than `_MOST_CELL_NEIGHBOURS` points in one cube of
    that size not all pairs come, yet enough to reach each of the points from any other.
    """
    # Cells as wide as the distance: near points are in one cell or in neighbouring ones.
    cells = np.floor(points / distance).astype(np.int64)
    keys = (cells * _CELL_KEY_PRIMES).sum(axis=1)
    order = np.argsort(keys, kind="stable")
    ranked = keys[order]
    here = np.arange(len(points))
    found = [_expand(order, order, here + 1, np.searchsorted(ranked, ranked, "right"))]
    for offset in (_HALF_NEIGHBOURS * _CELL_KEY_PRIMES).sum(axis=1):
        # The key is linear in the indices of a cell, so a neighbour's key is a sum.
        wanted = ranked + offset
        first, last = (np.searchsorted(ranked, wanted, side) for side in ("left", "right"))
        found.append(_expand(order, order, first, last))
    one, two = (np.concatenate(column) for column in zip(*found, strict=True))
    apart = np.linalg.norm(points[one] - points[two], axis=1)
    near = (apart <= distance) & (one != two)
    low, high, apart = np.minimum(one, two)[near], np.maximum(one, two)[near], apart[near]
    ranks = np.lexsort((high, low, apart))
    return low[ranks], high[ranks], apart[ranks]


def _clusters(count: int, one: Indices, two: Indices) -> Indices:
    """For each of `count` things the smallest one that pairs (one, two) connect it to."""
    root = list(range(count))

    def top(i: int) -> int:
        while root[i] != i:
            # Path halving keeps the trees flat.
            root[i] = root[root[i]]
            i = root[i]
        return i

    for a, b in zip(one.tolist(), two.tolist(), strict=True):
        low, high = sorted((top(a), top(b)))
        root[high] = low
    return np.array([top(i) for i in range(count)], dtype=np.intp)


def _expand(
    order: Indices, candidates: Indices, first: Indices, last: Indices
) -> tuple[Indices, Indices]:
    """Pairs of order[k] with each of candidates[first[k] : last[k]], the count bounded."""
    counts = np.clip(last - first, 0, _MOST_CELL_NEIGHBOURS)
    starts = np.repeat(np.cumsum(counts) - counts, counts)
    within = np.arange(counts.sum()) - starts + np.repeat(first, counts)
    return np.repeat(order, counts), candidates[within]


EXACT_MEETING: Final = 1e-4
"""mm within which two ends are one point, and below which a curve has no length."""

_CHORD_PART: Final = 0.1
"""Part of a distance that chords may be off where curves are compared with it."""

_FARTHEST: Final = 1e7
"""mm from the origin; a coordinate beyond 10 km is no work piece but a broken file."""

_LONGEST_SPUR: Final = 0.4
"""Tolerances that a curve is long at most to be left out where it sticks out of a contour."""

_CIRCLE_QUADRANTS: Final = (0.0, 0.25, 0.5, 0.75)

_NOT_A_PLACE = error(
    "CT101",
    "a curve on layer {layer!r} has a coordinate that is no number, or is beyond 10 km",
    "delete or redraw it near the origin",
)
_NO_LENGTH = info(
    "CT102",
    "{count} curves without length on layer {layer!r} are left out",
    "delete them in the drawing",
)
_DUPLICATE = warning(
    "CT103",
    "{count} curves on layer {layer!r} are drawn again over others and are followed once only",
    "delete the copies (OVERKILL in most CAD programs); move one that is meant to be run twice",
)
_JUNCTION = info(
    "CT104",
    "more than two curves on layer {layer!r} meet at {count} points; contours are split there",
    "move the branches to a layer of their own if one contour should run through",
)
_GAP = info(
    "CT105",
    "{count} gaps of up to {largest:.4f} mm on layer {layer!r} are closed",
    "draw with object snap, or give a smaller `tolerance` to keep the ends apart",
)


_WIDE_GAP = warning(
    "CT107",
    "{count} gaps on layer {layer!r} of {smallest:.4f} to {largest:.4f} mm are wider than the"
    " tolerance of {tolerance:g} mm: the contours are open there",
    "close them in the drawing, or give a larger `tolerance` in the process file",
)

_WIDEST_GAP: Final = 10.0
"""Tolerances of a gap at most that is hardly meant."""


@dataclass(frozen=True, slots=True)
class Contour:
    """Curves of one layer, each beginning where the one before it ends.

    starts: (curve, part of it) where a closed one may start, its own start first; none: at any
    joint. Such curves are lines and arcs. fixed: an open one that is not to be run backwards.
    backwards: an open one that is run against the way in which it is drawn. number: to know it by.
    """

    curves: tuple[Curve, ...]
    closed: bool
    layer: str = ""
    starts: tuple[tuple[int, float], ...] = ()
    fixed: bool = False
    backwards: bool = False
    number: int = 0

    @property
    def start(self) -> Vector:
        return self.curves[0].start

    @property
    def end(self) -> Vector:
        """Return its end; the start again for a closed one, regardless of gaps."""
        return self.start if self.closed else self.curves[-1].end

    @property
    def length(self) -> float:
        return math.fsum(c.length for c in self.curves)

    @property
    def vertices(self) -> Points:
        """Return the points at which a closed contour may start, (m, 3): its joints, the quadrants
        of a circle.
        """
        if self.starts:
            return np.concatenate([self.curves[i].at([part]) for i, part in self.starts])
        only = self.curves[0]
        if len(self.curves) == 1 and isinstance(only, Arc):
            return only.at(_CIRCLE_QUADRANTS)
        return np.array([c.start for c in self.curves])

    def starting_at(self, vertex: int) -> Contour:
        """The same closed contour, from that row of `vertices`."""
        only = self.curves[0]
        if vertex == 0:
            return self
        if self.starts:
            pieces = [c for c in self.curves if not isinstance(c, FreeCurve)]
            return replace(self, curves=started_at(pieces, *self.starts[vertex]), starts=())
        if len(self.curves) == 1 and isinstance(only, Arc):
            start = self.vertices[vertex]
            turned = Arc.about(only.centre, only.normal, start, only.sweep, only.layer, only.handle)
            return replace(self, curves=(turned,))
        return replace(self, curves=self.curves[vertex:] + self.curves[:vertex])

    def reversed(self) -> Contour:
        curves = tuple(c.reversed() for c in reversed(self.curves))
        return replace(self, curves=curves, backwards=not self.backwards)


def chain_curves(
    curves: Sequence[Curve], tolerance: float, *, path: str | None = None
) -> tuple[tuple[Contour, ...], tuple[Diagnostic, ...]]:
    """Contours of the curves, layer by layer in order of first appearance.

    tolerance: mm, positive, over which ends are joined. path: the file that findings name.
    Layer names are compared without case. Within a layer contours come in the order of
    their first curves, which keep their direction. Raises ValueError for a bad tolerance.
    """
    if not (math.isfinite(tolerance) and tolerance > 0.0):
        raise ValueError(f"a tolerance of {tolerance} mm")
    layers: dict[str, list[Curve]] = {}
    for curve in curves:
        layers.setdefault(curve.layer.casefold(), []).append(curve)
    contours: list[Contour] = []
    findings: list[Diagnostic] = []
    for group in layers.values():
        made, found = _chain_layer(group, tolerance)
        contours += made
        findings += (f.within(path) for f in found)
    return tuple(contours), tuple(findings)


def wide_gaps(contours: Sequence[Contour], tolerance: float) -> list[Diagnostic]:
    """A finding if ends of contours of one layer are a little farther apart than the tolerance."""
    open_ = [contour for contour in contours if not contour.closed]
    if not open_:
        return []
    ends = np.array([[contour.start, contour.end] for contour in open_]).reshape(-1, 3)
    lengths = [contour.length for contour in open_]
    used: set[int] = set()
    found: list[float] = []
    pairs = zip(
        *(column.tolist() for column in _pairs_within(ends, _WIDEST_GAP * tolerance)), strict=True
    )
    for a, b, gap in pairs:
        # The ends of a curve that is hardly longer than the gap are near each other anyway.
        long = min(lengths[a // 2], lengths[b // 2]) > 4.0 * gap
        if long and gap > tolerance and not used & {a, b}:
            used |= {a, b}
            found.append(gap)
    if not found:
        return []
    sizes: dict[str, Any] = {"smallest": min(found), "largest": max(found)}
    return [_WIDE_GAP(layer=open_[0].layer, count=len(found), tolerance=tolerance, **sizes)]


_COMPARED_PARTS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)


def _chain_layer(curves: list[Curve], tolerance: float) -> tuple[list[Contour], list[Diagnostic]]:
    layer, findings = curves[0].layer, []
    with np.errstate(invalid="ignore", over="ignore"):
        points = sample(curves, _COMPARED_PARTS)  # what is no number comes out as none
    placed = np.all(np.abs(points) < _FARTHEST, axis=(1, 2)).astype(bool)
    lengths = np.array([c.length if ok else 0.0 for c, ok in zip(curves, placed, strict=True)])
    placed &= np.isfinite(lengths)
    findings += [
        _NOT_A_PLACE(layer=layer, place=_curve_position(curves[i])) for i in np.flatnonzero(~placed)
    ]
    long = lengths > EXACT_MEETING
    kept = np.flatnonzero(placed & long)
    again = kept[_duplicates([curves[i] for i in kept], points[kept], lengths[kept], tolerance)]
    if again.size:
        findings.append(_count_finding(_DUPLICATE, layer, [curves[i] for i in again]))
    kept = np.setdiff1d(kept, again)
    spurs = kept[_spurs([curves[i] for i in kept], points[kept], lengths[kept], tolerance)]
    empty = np.concatenate([np.flatnonzero(placed & ~long), spurs])
    if empty.size:
        findings.append(_count_finding(_NO_LENGTH, layer, [curves[i] for i in empty]))
    kept = np.setdiff1d(kept, spurs)
    if not kept.size:
        return [], findings
    graph = _Graph.of([curves[i] for i in kept], points[kept], lengths[kept], tolerance)
    if graph.gaps:
        findings.append(_GAP(layer=layer, count=len(graph.gaps), largest=max(graph.gaps)))
    if graph.junctions:
        findings.append(_JUNCTION(layer=layer, count=graph.junctions))
    return list(graph.contours(layer)), findings


def _curve_position(curve: Curve) -> str | None:
    return f"entity {curve.handle}" if curve.handle else None


def _count_finding(rule: Rule, layer: str, curves: list[Curve]) -> Diagnostic:
    handles = list(dict.fromkeys(c.handle for c in curves if c.handle))
    shown = ", ".join(handles[:3]) + (" …" if len(handles) > 3 else "")
    return rule(layer=layer, count=len(curves), place=f"entity {shown}" if shown else None)


def _duplicates(curves: list[Curve], points: Points, lengths: Points, tolerance: float) -> Indices:
    """Indices of curves that lie on an earlier one, in either direction.

    Near is within the tolerance, and a tenth of the length, lest short neighbours be
    taken for copies.
    """
    compared = points.copy()
    circles = [i for i, c in enumerate(curves) if c.closed and isinstance(c, Arc)]
    if circles:
        compared[circles] = _five_of_circles([c for c in curves if c.closed and isinstance(c, Arc)])
    near = np.minimum(tolerance, lengths / 10.0)
    copies: list[tuple[int, int]] = []
    # Short curves are compared at a finer radius: many of them stand within the tolerance.
    for chosen, radius in (
        (np.flatnonzero(near >= tolerance), tolerance),
        (np.flatnonzero(near < tolerance), min(EXACT_MEETING, tolerance)),
    ):
        one, two, _ = _pairs_within(compared[chosen, 2], radius)
        one, two = chosen[one], chosen[two]
        apart = np.minimum(
            np.linalg.norm(compared[one] - compared[two], axis=2).max(axis=1, initial=0.0),
            np.linalg.norm(compared[one] - compared[two, ::-1], axis=2).max(axis=1, initial=0.0),
        )
        within = np.minimum(near[one], near[two])
        same = apart <= within
        found = zip(*(column[same].tolist() for column in (two, one, within)), strict=True)
        copies += ((a, b) for a, b, off in found if _run_alike(curves[a], curves[b], off))
    again: set[int] = set()
    for copy, original in sorted(copies):
        # A copy of a copy is a copy of the original as well, and counts once.
        if original not in again:
            again.add(copy)
    return np.array(sorted(again), dtype=np.intp)


def _run_alike(one: Curve, two: Curve, near: float) -> bool:
    """True if two curves that agree at five points do so all along, in either direction.

    Lines and arcs are known by them. Chords of others are compared at the same parts of their
    lengths: between two of their corners the distance of lines is nowhere larger.
    """
    if not isinstance(one, FreeCurve) and not isinstance(two, FreeCurve):
        return True
    a, b = (chorded(curve, _CHORD_PART * near) for curve in (one, two))
    return min(_farthest(a, b), _farthest(a, b[::-1])) <= near


def _farthest(one: Points, two: Points) -> float:
    """The largest distance of two polylines at the same parts of their lengths."""
    marks = []
    for points in (one, two):
        sums = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
        # A polyline without length must not divide by zero.
        marks.append(sums / max(sums[-1], 1e-300))
    parts = np.union1d(*marks)
    here, there = (
        np.stack([np.interp(parts, at, points[:, i]) for i in range(3)], axis=1)
        for at, points in zip(marks, (one, two), strict=True)
    )
    return float(np.linalg.norm(here - there, axis=1).max())


def _five_of_circles(circles: list[Arc]) -> Points:
    """Five points of circles that do not depend on where they start or which way they run."""
    normal = np.array([c.normal for c in circles])
    # Normals that differ by rounding alone must choose the same axes.
    sizes = np.abs(np.round(normal, 6))
    row = np.arange(len(circles))
    normal = normal * np.sign(normal[row, sizes.argmax(axis=1)])[:, None]
    right = np.cross(normal, np.eye(3)[sizes.argmin(axis=1)])
    right *= (np.array([c.radius for c in circles]) / np.linalg.norm(right, axis=1))[:, None]
    ahead = np.cross(normal, right)
    around = np.stack([right, ahead, -right, -ahead, right], axis=1)
    return np.asarray(np.array([c.centre for c in circles])[:, None] + around)


def _spurs(curves: list[Curve], points: Points, lengths: Points, tolerance: float) -> Indices:
    """Indices of curves that are next to nothing and stick out of where others meet."""
    short = np.flatnonzero(lengths < _LONGEST_SPUR * tolerance)
    if not short.size:
        return short
    nodes = _nodes(curves, points, tolerance)
    degrees = np.sort(_degrees(nodes)[nodes[short]], axis=1)
    return np.asarray(short[(degrees[:, 0] == 1) & (degrees[:, 1] > 2)])


def _nodes(curves: list[Curve], points: Points, tolerance: float) -> Rows:
    """Return the nodes (n, 2) where curves start and end: ends that meet exactly share one."""
    ends = points[:, [0, -1]].reshape(-1, 3)
    one, two, _ = _pairs_within(ends, min(EXACT_MEETING, tolerance))
    nodes = _clusters(len(ends), one, two).reshape(-1, 2)
    # A closed curve is a loop at one node, even if its ends do not meet exactly.
    for i, curve in enumerate(curves):
        if curve.closed:
            nodes[i, 1] = nodes[i, 0]
    return nodes


@dataclass(frozen=True, slots=True)
class _Graph:
    """curves: the edges. nodes: (n, 2), what each starts and ends at. degrees: by node."""

    curves: list[Curve]
    nodes: Rows
    degrees: Rows
    gaps: list[float]

    @staticmethod
    def of(curves: list[Curve], points: Points, lengths: Points, tolerance: float) -> _Graph:
        ends = points[:, [0, -1]].reshape(-1, 3)
        nodes = _nodes(curves, points, tolerance)
        nodes, gaps = _join_loose_ends(nodes, ends, lengths, tolerance)
        return _Graph(curves, nodes, _degrees(nodes), gaps)

    @property
    def junctions(self) -> int:
        return int((self.degrees > 2).sum())

    def contours(self, layer: str) -> Iterator[Contour]:
        """Each curve in one contour, in the order of their first curves."""
        at_node: dict[int, list[int]] = {}
        nodes = self.nodes.tolist()
        for i, (a, b) in enumerate(nodes):
            if a != b:
                at_node.setdefault(a, []).append(i)
                at_node.setdefault(b, []).append(i)
        used = [False] * len(nodes)

        def walk(edge: int, node: int) -> list[tuple[int, bool]]:
            """Edges after `edge`, which leads to `node`, each with whether it is reversed."""
            way: list[tuple[int, bool]] = []
            while len(at_node[node]) == 2:
                # Two curves meet here: the sum of both without this one is the other.
                edge = at_node[node][0] + at_node[node][1] - edge
                if used[edge]:
                    break
                used[edge] = True
                back = nodes[edge][1] == node
                way.append((edge, back))
                node = nodes[edge][0 if back else 1]
            return way

        for i, (a, b) in enumerate(nodes):
            if used[i]:
                continue
            used[i] = True
            if a == b:
                yield Contour((self.curves[i],), True, layer)
                continue
            # From the first curve in both directions, so that it keeps its own.
            after = walk(i, b)
            before = [(edge, not back) for edge, back in reversed(walk(i, a))]
            way = [*before, (i, False), *after]
            first = nodes[way[0][0]][1 if way[0][1] else 0]
            last = nodes[way[-1][0]][0 if way[-1][1] else 1]
            ordered = (self.curves[e].reversed() if back else self.curves[e] for e, back in way)
            yield Contour(tuple(ordered), first == last, layer)


def _degrees(nodes: Rows) -> Rows:
    """Return the number of ends of open curves at each node."""
    open_ = nodes[nodes[:, 0] != nodes[:, 1]]
    return np.bincount(open_.ravel(), minlength=nodes.size).astype(np.intp)


def _join_loose_ends(
    nodes: Rows, ends: Points, lengths: Points, tolerance: float
) -> tuple[Rows, list[float]]:
    """Nodes with only one end joined to each other, nearest first; and the gaps closed.

    The two ends of one chain are joined only if it is long enough to be a loop. A third end
    joins a pair only if the curves are long against the tolerance: the ends of short ones
    are near each other anyway.
    """
    loose = np.flatnonzero(_degrees(nodes) == 1)
    one, two, apart = _pairs_within(ends[loose], tolerance)
    chains = _Chains(nodes, lengths)
    long = (lengths > 2.0 * tolerance).tolist()
    used: set[int] = set()
    joined: list[tuple[int, int]] = []
    gaps: list[float] = []
    for a, b, gap in zip(loose[one].tolist(), loose[two].tolist(), apart.tolist(), strict=True):
        third = a in used or b in used
        if third and (used.issuperset((a, b)) or not (long[a // 2] and long[b // 2])):
            continue
        if chains.join(a, b, math.inf if third else 4.0 * tolerance):
            used |= {a, b}
            joined.append((a, b))
            gaps.append(gap)
    low, high = np.array(joined, dtype=np.intp).reshape(-1, 2).T
    return _clusters(nodes.size, low, high)[nodes], gaps


class _Chains:
    """Which curves hang together, and how long the whole is."""

    def __init__(self, nodes: Rows, lengths: Points) -> None:
        root = _clusters(nodes.size, nodes[:, 0], nodes[:, 1])
        self._root = root.tolist()
        self._length = np.bincount(root[nodes[:, 0]], lengths, nodes.size).tolist()

    def join(self, a: int, b: int, shortest: float) -> bool:
        """Joins two nodes, unless that would close a loop shorter than `shortest`."""
        low, high = sorted((self._top(a), self._top(b)))
        if low == high:
            return bool(self._length[low] > shortest)
        self._root[high] = low
        self._length[low] += self._length[high]
        return True

    def _top(self, i: int) -> int:
        while self._root[i] != i:
            self._root[i] = self._root[self._root[i]]
            i = self._root[i]
        return i


_SHORTEST_PART: Final = 1e-4
_LEAST_OVERLAP: Final = 2.0
"""Tolerances of a stretch that counts as an overlap: ends that run a little over are no more."""

_OVERLAP = warning(
    "CT106",
    "{count} curves on layer {layer!r} lie in part on others, over {length:.2f} mm, which is"
    " followed once only",
    "trim them in the drawing; move one that is meant to be run twice to a layer of its own",
)
_MOST_NEIGHBOURS: Final = 64
"""Largest mean number of neighbours of a curve that are examined: crowds of them are not an
outline.
"""
_OVERLAP_BATCH: Final = 256
"""Curves whose neighbours are searched together."""

_LineOrArc = Line | Arc
_CoveredStretch = tuple[float, float, Vector, Vector]
"""From and to which part of a curve another one covers it, and the points there."""


def without_overlaps(
    curves: Sequence[Curve], tolerance: float
) -> tuple[list[Curve], list[Diagnostic]]:
    """The curves of a layer, of which shorter ones lose what lies within the tolerance on longer
    ones, and a finding about it. A copy of a whole curve stays.
    """
    near = _near_pairs(curves, tolerance)
    if not near:
        return [*curves], []
    covers: dict[int, list[_CoveredStretch]] = {}
    lengths = [curve.length for curve in curves]
    for one, two in near:
        if abs(lengths[one] - lengths[two]) <= tolerance and _are_copies(
            curves[one], curves[two], tolerance
        ):
            continue
        longer, shorter = (one, two) if lengths[one] >= lengths[two] else (two, one)
        covers.setdefault(shorter, []).extend(
            _covered_stretches(curves[shorter], curves[longer], tolerance)  # type: ignore[arg-type]
        )
    made: list[Curve] = []
    count, length = 0, 0.0
    for i, curve in enumerate(curves):
        stretches = covers.get(i, [])
        if not stretches:
            made.append(curve)
            continue
        parts = _uncovered_parts(curve, stretches, tolerance)  # type: ignore[arg-type]
        count += 1
        length += lengths[i] - math.fsum(part.length for part in parts)
        made += parts
    if not count:
        return made, []
    return made, [_OVERLAP(layer=curves[0].layer, count=count, length=length)]


def _are_copies(one: Curve, two: Curve, tolerance: float) -> bool:
    """True if two curves share both ends."""
    ends = one.start, one.end
    there = max(math.dist(ends[0], two.start), math.dist(ends[1], two.end))
    return min(there, max(math.dist(ends[0], two.end), math.dist(ends[1], two.start))) <= tolerance


def _near_pairs(curves: Sequence[Curve], tolerance: float) -> list[tuple[int, int]]:
    """Pairs of lines, and of arcs of one circle, that may lie on each other."""
    rows = [i for i, curve in enumerate(curves) if _is_measurable(curve)]
    if len(rows) < 2:
        return []
    import shapely

    pieces: list[_LineOrArc] = [curves[i] for i in rows]  # type: ignore[misc]
    # With both ends, as each piece becomes a line of its own.
    counts = chord_counts(pieces, 0.5 * tolerance) + 1
    owner = np.repeat(np.arange(len(rows)), counts)
    begins = np.cumsum(counts) - counts
    parts = (np.arange(len(owner)) - begins[owner]) / (counts[owner] - 1)
    points = points_at_parts(pieces, owner, parts)
    axes = np.sort(np.argsort(np.ptp(points, axis=0))[1:])  # seen along the axis of least extent
    lines = shapely.linestrings(points[:, axes], indices=owner)
    tree = shapely.STRtree(lines)
    found, seen = [np.empty((2, 0), dtype=np.intp)], 0
    # In batches: a crowd of curves is given up before all pairs are in memory.
    for first in range(0, len(lines), _OVERLAP_BATCH):
        some = lines[first : first + _OVERLAP_BATCH]
        near = tree.query(some, predicate="dwithin", distance=tolerance)
        near[0] += first
        found.append(near[:, near[0] < near[1]])
        seen += near.shape[1]
        if seen > _MOST_NEIGHBOURS * len(lines):
            break
    one, two = np.concatenate(found, axis=1)
    arcs = np.array([isinstance(curves[i], Arc) for i in rows])
    straight = ~arcs[one] & ~arcs[two]
    ends = np.array([[curves[i].start, curves[i].end] for i in rows])
    straight[straight] = _lie_along(ends[one[straight]], ends[two[straight]], tolerance)
    alike = straight | (arcs[one] & arcs[two])
    pairs = zip(one[alike].tolist(), two[alike].tolist(), strict=True)
    return [(rows[a], rows[b]) for a, b in pairs]


def _is_measurable(curve: Curve) -> bool:
    """True if it is a line or an arc of a believable size."""
    if not isinstance(curve, Line | Arc):
        return False
    size = max(map(abs, (*curve.start, *curve.end)))
    return size < _FARTHEST and curve.length > _SHORTEST_PART


def _lie_along(one: Points, two: Points, tolerance: float) -> NDArray[np.bool_]:
    """True for the lines (n, 2, 3) that share a stretch within the tolerance with others."""
    way = one[:, 1] - one[:, 0]
    length = np.linalg.norm(way, axis=1)
    along = way / length[:, None]
    arms = two - one[:, :1]
    places = np.einsum("nkc,nc->nk", arms, along)
    # An other line that is square to this one has one position along it: any divisor but 0 will do.
    low, high = np.sort(np.clip(places, 0.0, length[:, None]), axis=1).T
    share = (np.stack([low, high], axis=1) - places[:, :1]) / np.where(
        np.abs(places[:, 1:] - places[:, :1]) > 1e-12, places[:, 1:] - places[:, :1], 1e-12
    )
    across = arms - places[..., None] * along[:, None]
    off = across[:, :1] + share[..., None] * (across[:, 1:] - across[:, :1])
    beside = np.linalg.norm(off, axis=2).max(axis=1) <= tolerance
    return np.asarray(beside & (high - low > _LEAST_OVERLAP * tolerance))


def _covered_stretches(
    piece: _LineOrArc, other: _LineOrArc, tolerance: float
) -> list[_CoveredStretch]:
    """Return the stretches of a piece that lie on another one of its kind."""
    if isinstance(piece, Line):
        way = np.subtract(piece.end, piece.start)
        size = float(way @ way)
        marks = [(float(np.subtract(p, piece.start) @ way) / size, p) for p in _piece_ends(other)]
        (low, first), (high, last) = sorted(marks)
        return _covered_stretch(low, high, first, last, piece, tolerance)
    assert isinstance(other, Arc)
    if not _are_on_one_circle(piece, other, tolerance):
        return []
    if other.closed:
        return [(0.0, 1.0, piece.start, piece.end)]
    forward = float(np.dot(piece.normal, other.normal)) > 0.0
    first, last = _piece_ends(other) if forward else reversed(_piece_ends(other))
    begin, sweep = _degrees_to(piece, first), piece.sweep
    found: list[_CoveredStretch] = []
    # The other arc may begin before the start of the piece, across the 0 of its angles.
    for low in (begin, begin - 360.0):
        found += _covered_stretch(
            low / sweep, (low + other.sweep) / sweep, first, last, piece, tolerance
        )
    return found


def _covered_stretch(
    low: float, high: float, first: Vector, last: Vector, piece: _LineOrArc, tolerance: float
) -> list[_CoveredStretch]:
    if low <= 0.0:
        low, first = 0.0, piece.start
    if high >= 1.0:
        high, last = 1.0, piece.end
    if (high - low) * piece.length <= _LEAST_OVERLAP * tolerance:
        return []
    return [(low, high, first, last)]


def _piece_ends(piece: _LineOrArc) -> tuple[Vector, Vector]:
    return piece.start, piece.end


def _are_on_one_circle(a: Arc, b: Arc, tolerance: float) -> bool:
    apart = math.dist(a.centre, b.centre) + abs(a.radius - b.radius)
    return apart <= tolerance and abs(float(np.dot(a.normal, b.normal))) > 1.0 - 1e-6


def _degrees_to(arc: Arc, point: Vector) -> float:
    """Degrees about the normal from the start of an arc to a point of its circle, below 360."""
    u, v = np.subtract(arc.start, arc.centre), np.subtract(point, arc.centre)
    sine: Any = np.dot(np.cross(u, v), arc.normal)
    return math.degrees(math.atan2(float(sine), float(u @ v))) % 360.0


def _uncovered_parts(
    piece: _LineOrArc, stretches: Sequence[_CoveredStretch], tolerance: float
) -> list[_LineOrArc]:
    """Return the parts of a piece between stretches that are longer than the tolerance."""
    made: list[_LineOrArc] = []
    at, point = 0.0, piece.start
    for low, high, first, last in [*sorted(stretches), (1.0, 1.0, piece.end, piece.end)]:
        if (low - at) * piece.length > tolerance:
            made.append(_piece_part(piece, (at, low), (point, first)))
        if high > at:
            at, point = high, last
    return made


def _piece_part(
    piece: _LineOrArc, parts: tuple[float, float], ends: tuple[Vector, Vector]
) -> _LineOrArc:
    start, end = ends
    if isinstance(piece, Line):
        return replace(piece, start=start, end=end)
    via = vector(piece.at([0.5 * (parts[0] + parts[1])])[0])
    # A piece that is too short has no circle through its points.
    arc = Arc.through(start, via, end, piece.layer, piece.handle)
    return arc or Line(start, end, piece.layer, piece.handle)
