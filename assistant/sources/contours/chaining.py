"""Contours: curves of one layer chained end to end.

Ends that meet exactly are one node of a graph; loose ends that remain are joined to the
nearest other loose end within the tolerance. Exact meetings go first, so that a contour of
segments that are shorter than the tolerance keeps all of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Rows
from assistant.base.diagnostics import Diagnostic, Rule, error, info, warning
from assistant.program.geometry import Vector
from assistant.sources.contours.curves import Arc, Curve, FreeCurve, Points, chorded, sample
from assistant.sources.contours.flat import started_at
from assistant.sources.contours.proximity import Indices, clusters, pairs_within

EXACT_MEETING: Final = 1e-4
"""mm within which two ends are one point, and below which a curve has no length."""

CHORD_PART: Final = 0.1
"""Part of a distance that chords may be off where curves are compared with it."""

FARTHEST: Final = 1e7
"""mm from the origin; a coordinate beyond 10 km is no work piece but a broken file."""

LONGEST_SPUR: Final = 0.4
"""Tolerances that a curve is long at most to be left out where it sticks out of a contour."""

CIRCLE_QUADRANTS: Final = (0.0, 0.25, 0.5, 0.75)

NOT_A_PLACE = error(
    "CT101",
    "a curve on layer {layer!r} has a coordinate that is no number, or is beyond 10 km",
    "delete or redraw it near the origin",
)
NO_LENGTH = info(
    "CT102",
    "{count} curves without length on layer {layer!r} are left out",
    "delete them in the drawing",
)
DUPLICATE = warning(
    "CT103",
    "{count} curves on layer {layer!r} are drawn again over others and are followed once only",
    "delete the copies (OVERKILL in most CAD programs); move one that is meant to be run twice",
)
JUNCTION = info(
    "CT104",
    "more than two curves on layer {layer!r} meet at {count} points; contours are split there",
    "move the branches to a layer of their own if one contour should run through",
)
GAP = info(
    "CT105",
    "{count} gaps of up to {largest:.4f} mm on layer {layer!r} are closed",
    "draw with object snap, or give a smaller `tolerance` to keep the ends apart",
)


WIDE_GAP = warning(
    "CT107",
    "{count} gaps on layer {layer!r} of {smallest:.4f} to {largest:.4f} mm are wider than the"
    " tolerance of {tolerance:g} mm: the contours are open there",
    "close them in the drawing, or give a larger `tolerance` in the process file",
)

WIDEST_GAP: Final = 10.0
"""Tolerances of a gap at most that is hardly meant."""


@dataclass(frozen=True, slots=True)
class Contour:
    """Curves of one layer, each beginning where the one before it ends.

    starts: (curve, part of it) where a closed one may start, its own start first; none: at any
    joint. Such curves are lines and arcs. fixed: an open one that is not to be run backwards.
    number: to know it by.
    """

    curves: tuple[Curve, ...]
    closed: bool
    layer: str = ""
    starts: tuple[tuple[int, float], ...] = ()
    fixed: bool = False
    number: int = 0

    @property
    def start(self) -> Vector:
        return self.curves[0].start

    @property
    def end(self) -> Vector:
        """Where it ends; the start again for a closed one, gaps left aside."""
        return self.start if self.closed else self.curves[-1].end

    @property
    def length(self) -> float:
        return math.fsum(c.length for c in self.curves)

    @property
    def vertices(self) -> Points:
        """Where a closed contour may start, (m, 3): its joints, the quadrants of a circle."""
        if self.starts:
            return np.concatenate([self.curves[i].at([part]) for i, part in self.starts])
        only = self.curves[0]
        if len(self.curves) == 1 and isinstance(only, Arc):
            return only.at(CIRCLE_QUADRANTS)
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
        return replace(self, curves=tuple(c.reversed() for c in reversed(self.curves)))


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
        *(column.tolist() for column in pairs_within(ends, WIDEST_GAP * tolerance)), strict=True
    )
    for a, b, gap in pairs:
        long = min(lengths[a // 2], lengths[b // 2]) > 4.0 * gap
        if long and gap > tolerance and not used & {a, b}:
            used |= {a, b}
            found.append(gap)
    if not found:
        return []
    sizes: dict[str, Any] = {"smallest": min(found), "largest": max(found)}
    return [WIDE_GAP(layer=open_[0].layer, count=len(found), tolerance=tolerance, **sizes)]


COMPARED_PARTS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)


def _chain_layer(curves: list[Curve], tolerance: float) -> tuple[list[Contour], list[Diagnostic]]:
    layer, findings = curves[0].layer, []
    with np.errstate(invalid="ignore", over="ignore"):
        points = sample(curves, COMPARED_PARTS)  # what is no number comes out as none
    placed = np.all(np.abs(points) < FARTHEST, axis=(1, 2)).astype(bool)
    lengths = np.array([c.length if ok else 0.0 for c, ok in zip(curves, placed, strict=True)])
    placed &= np.isfinite(lengths)
    findings += [
        NOT_A_PLACE(layer=layer, place=_curve_position(curves[i])) for i in np.flatnonzero(~placed)
    ]
    long = lengths > EXACT_MEETING
    kept = np.flatnonzero(placed & long)
    again = kept[_duplicates([curves[i] for i in kept], points[kept], lengths[kept], tolerance)]
    if again.size:
        findings.append(_count_finding(DUPLICATE, layer, [curves[i] for i in again]))
    kept = np.setdiff1d(kept, again)
    spurs = kept[_spurs([curves[i] for i in kept], points[kept], lengths[kept], tolerance)]
    empty = np.concatenate([np.flatnonzero(placed & ~long), spurs])
    if empty.size:
        findings.append(_count_finding(NO_LENGTH, layer, [curves[i] for i in empty]))
    kept = np.setdiff1d(kept, spurs)
    if not kept.size:
        return [], findings
    graph = _Graph.of([curves[i] for i in kept], points[kept], lengths[kept], tolerance)
    if graph.gaps:
        findings.append(GAP(layer=layer, count=len(graph.gaps), largest=max(graph.gaps)))
    if graph.junctions:
        findings.append(JUNCTION(layer=layer, count=graph.junctions))
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
        one, two, _ = pairs_within(compared[chosen, 2], radius)
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
    a, b = (chorded(curve, CHORD_PART * near) for curve in (one, two))
    return min(_farthest(a, b), _farthest(a, b[::-1])) <= near


def _farthest(one: Points, two: Points) -> float:
    """The largest distance of two polylines at the same parts of their lengths."""
    marks = []
    for points in (one, two):
        sums = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
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
    short = np.flatnonzero(lengths < LONGEST_SPUR * tolerance)
    if not short.size:
        return short
    nodes = _nodes(curves, points, tolerance)
    degrees = np.sort(_degrees(nodes)[nodes[short]], axis=1)
    return np.asarray(short[(degrees[:, 0] == 1) & (degrees[:, 1] > 2)])


def _nodes(curves: list[Curve], points: Points, tolerance: float) -> Rows:
    """Return the nodes (n, 2) where curves start and end: ends that meet exactly share one."""
    ends = points[:, [0, -1]].reshape(-1, 3)
    one, two, _ = pairs_within(ends, min(EXACT_MEETING, tolerance))
    nodes = clusters(len(ends), one, two).reshape(-1, 2)
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
            after = walk(i, b)
            before = [(edge, not back) for edge, back in reversed(walk(i, a))]
            way = [*before, (i, False), *after]
            first = nodes[way[0][0]][1 if way[0][1] else 0]
            last = nodes[way[-1][0]][0 if way[-1][1] else 1]
            ordered = (self.curves[e].reversed() if back else self.curves[e] for e, back in way)
            yield Contour(tuple(ordered), first == last, layer)


def _degrees(nodes: Rows) -> Rows:
    """How many ends of open curves each node has."""
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
    one, two, apart = pairs_within(ends[loose], tolerance)
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
    return clusters(nodes.size, low, high)[nodes], gaps


class _Chains:
    """Which curves hang together, and how long the whole is."""

    def __init__(self, nodes: Rows, lengths: Points) -> None:
        root = clusters(nodes.size, nodes[:, 0], nodes[:, 1])
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
