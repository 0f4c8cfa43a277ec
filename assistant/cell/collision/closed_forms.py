"""Signed distances of spheres, capsules and boxes in closed form, many pairs at once.

A sphere is a segment of no length, a capsule a segment, each with a radius around it. A distance
below 0 is the shortest translation that separates the two shapes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, norms

TINY: Final = 1e-12
BOX_PAIRS_AT_ONCE: Final = 4096
"""Pairs of boxes that are computed together: 144 pairs of edges each."""


@dataclass(frozen=True, slots=True, eq=False)
class NearestPoints:
    """Distances (k,) mm of k pairs, their nearest points (k, 3) and unit normals (k, 3) from the
    one to the other.
    """

    distance: Floats
    one: Floats
    other: Floats
    normal: Floats


def dot_products(a: Floats, b: Floats) -> Floats:
    """(...) products of vectors (..., 3)."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def segments_apart(a0: Floats, a1: Floats, b0: Floats, b1: Floats) -> tuple[Floats, Floats]:
    """The nearest points (..., 3) of segments from a0 to a1 and from b0 to b1 (..., 3).

    After Ericson, Real-Time Collision Detection, 5.1.9.
    """
    d1, d2, r = a1 - a0, b1 - b0, a0 - b0
    a, e, f, c, b = (
        dot_products(d1, d1),
        dot_products(d2, d2),
        dot_products(d2, r),
        dot_products(d1, r),
        dot_products(d1, d2),
    )
    point_a, point_b = a <= TINY, e <= TINY
    safe_a, safe_e = np.where(point_a, 1.0, a), np.where(point_b, 1.0, e)
    denominator = a * e - b * b
    parallel = denominator <= 1e-12 * safe_a * safe_e
    s = np.where(parallel, 0.0, (b * f - c * e) / np.where(parallel, 1.0, denominator))
    s = np.clip(s, 0.0, 1.0)
    t = (b * s + f) / safe_e
    low, high = (t < 0.0) | point_b, (t > 1.0) & ~point_b
    s = np.where(low, np.clip(-c / safe_a, 0.0, 1.0), s)
    s = np.where(high, np.clip((b - c) / safe_a, 0.0, 1.0), s)
    t = np.where(point_b, 0.0, np.clip(t, 0.0, 1.0))
    s = np.where(point_a, 0.0, s)
    t = np.where(point_a & ~point_b, np.clip(f / safe_e, 0.0, 1.0), t)
    return a0 + s[..., None] * d1, b0 + t[..., None] * d2


def capsule_distances(
    a: tuple[Floats, Floats], b: tuple[Floats, Floats], radii: Floats
) -> NearestPoints:
    """Capsules about segments (k, 3) to (k, 3). radii: (k, 2) of the one and of the other."""
    p, q = segments_apart(*a, *b)
    way = q - p
    apart = norms(way)
    crossing = apart <= 1e-9
    normal = np.where(crossing[:, None], _across(a[1] - a[0], b[1] - b[0]), way)
    normal /= norms(normal)[:, None]
    return NearestPoints(
        apart - radii.sum(axis=1), p + radii[:, :1] * normal, q - radii[:, 1:] * normal, normal
    )


def _across(one: Floats, other: Floats) -> Floats:
    """(k, 3) perpendicular to both vectors (k, 3), whatever these are."""
    found = np.cross(one, other)
    for vector in (one, other):
        smallest = np.eye(3)[np.abs(vector).argmin(axis=1)]
        lost = norms(found) <= 1e-9 * (norms(one) * norms(other) + TINY)
        found = np.where(lost[:, None], np.cross(vector, smallest), found)
    lost = norms(found) <= TINY
    found[lost] = (0.0, 0.0, 1.0)
    return found


def capsule_box_distances(p0: Floats, p1: Floats, half: Floats, radius: Floats) -> NearestPoints:
    """Capsules about segments p0 to p1 (k, 3), from boxes of half edges (k, 3) about the origin.

    The points and the normals are in the frames of the boxes; the capsule is the one.
    """
    way = p1 - p0
    point = p0 + _nearest_to_box(p0, way, half)[:, None] * way
    on_box = np.clip(point, -half, half)
    apart = norms(on_box - point)
    deep, out = _segment_in_box(p0, way, half)
    inside = apart <= 1e-9
    normal = np.where(inside[:, None], -out, on_box - point)
    normal /= norms(normal)[:, None]
    core = np.where(inside, -deep, apart)
    on_capsule = point + radius[:, None] * normal
    return NearestPoints(
        core - radius, on_capsule, on_capsule + (core - radius)[:, None] * normal, normal
    )


def _nearest_to_box(p0: Floats, way: Floats, half: Floats) -> Floats:
    """(k,) parts of segments at which they are nearest to boxes about the origin.

    The square of the distance is convex along the segment, and its slope linear between the parts
    at which the segment passes a plane of the box.
    """
    still = np.abs(way) <= TINY
    safe = np.where(still, 1.0, way)
    cuts = [np.where(still, 0.0, (side * half - p0) / safe) for side in (-1.0, 1.0)]
    k = len(p0)
    t = np.concatenate([np.zeros((k, 1)), *cuts, np.ones((k, 1))], axis=1)
    t = np.sort(np.clip(t, 0.0, 1.0), axis=1)
    place = p0[:, None] + t[..., None] * way[:, None]
    off = place - np.clip(place, -half[:, None], half[:, None])
    slope = np.einsum("ksi,ki->ks", off, way)
    rising = slope >= 0.0
    last = np.where(rising.any(axis=1), rising.argmax(axis=1), t.shape[1] - 1)
    first, at = np.maximum(last - 1, 0), np.arange(k)
    s0, s1 = slope[at, first], slope[at, last]
    step = s1 - s0
    part = np.clip(np.where(step > 0.0, -s0 / np.where(step > 0.0, step, 1.0), 1.0), 0.0, 1.0)
    return np.asarray(t[at, first] + part * (t[at, last] - t[at, first]))


def _segment_in_box(p0: Floats, way: Floats, half: Floats) -> tuple[Floats, Floats]:
    """(k,) mm by which segments have to be moved to leave boxes about the origin, and (k, 3) where
    to, as unit vectors: along a face, or across the segment and an edge.
    """
    across = np.cross(way[:, None], np.eye(3)[None])
    size = norms(across.reshape(-1, 3)).reshape(-1, 3)
    flat = size <= 1e-9 * (norms(way)[:, None] + TINY)
    across = np.where(flat[..., None], 0.0, across / np.where(flat, 1.0, size)[..., None])
    axes = np.concatenate([np.broadcast_to(np.eye(3), across.shape), across], axis=1)
    reach = np.einsum("ksi,ki->ks", np.abs(axes), half)
    ends = np.stack([np.einsum("ksi,ki->ks", axes, p) for p in (p0, p0 + way)])
    up, down = reach - ends.min(axis=0), reach + ends.max(axis=0)
    deep = np.minimum(up, down)
    deep[:, 3:][flat] = np.inf
    best, at = deep.argmin(axis=1), np.arange(len(p0))
    sign = np.where(up[at, best] <= down[at, best], 1.0, -1.0)
    return deep[at, best], axes[at, best] * sign[:, None]


_SIDES: Final = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
_EDGES: Final = np.array(
    [
        (i, k)
        for i in range(8)
        for k in range(i + 1, 8)
        if np.abs(_SIDES[i] - _SIDES[k]).sum() == 2.0
    ]
)


def box_distances(turn: Floats, place: Floats, one: Floats, other: Floats) -> NearestPoints:
    """Boxes of half edges other (k, 3) at places (k, 3), turned by (k, 3, 3), in the frames of
    boxes of half edges one (k, 3), in which the points and the normals are.
    """
    if len(one) > BOX_PAIRS_AT_ONCE:
        parts = [
            box_distances(*(x[i : i + BOX_PAIRS_AT_ONCE] for x in (turn, place, one, other)))
            for i in range(0, len(one), BOX_PAIRS_AT_ONCE)
        ]
        columns = ("distance", "one", "other", "normal")
        return NearestPoints(*(np.concatenate([getattr(p, c) for p in parts]) for c in columns))
    gap, normal = _separation(turn, place, one, other)
    corners = _SIDES * one[:, None]
    others = place[:, None] + np.einsum("kij,ksj->ksi", turn, _SIDES * other[:, None])
    supports = (
        np.einsum("ksi,ki->ks", corners, normal).argmax(axis=1),
        np.einsum("ksi,ki->ks", others, normal).argmin(axis=1),
    )
    at = np.arange(len(one))
    p, q = corners[at, supports[0]], others[at, supports[1]]
    apart = gap.copy()
    out = np.flatnonzero(gap > 0.0)
    if len(out):
        p[out], q[out] = _apart(*(x[out] for x in (turn, place, one, other, corners, others)))
        way = q[out] - p[out]
        apart[out] = norms(way)
        normal[out] = way / np.maximum(apart[out], TINY)[:, None]
    return NearestPoints(apart, p, q, normal)


def _separation(turn: Floats, place: Floats, one: Floats, other: Floats) -> tuple[Floats, Floats]:
    """(k,) the largest gap of two boxes along the normals of faces and across two edges, below 0
    the least overlap, and (k, 3) its direction.
    """
    columns = np.swapaxes(turn, 1, 2)
    across = np.cross(np.eye(3)[None, :, None], columns[:, None]).reshape(len(one), 9, 3)
    size = norms(across.reshape(-1, 3)).reshape(-1, 9)
    flat = size <= 1e-9
    across = np.where(flat[..., None], 0.0, across / np.where(flat, 1.0, size)[..., None])
    faces = np.broadcast_to(np.eye(3), (len(one), 3, 3))
    axes = np.concatenate([faces, columns, across], axis=1)
    along = np.einsum("ksi,ki->ks", axes, place)
    reach = np.einsum("ksi,ki->ks", np.abs(axes), one)
    reach += np.einsum("ksj,kj->ks", np.abs(np.einsum("ksi,kij->ksj", axes, turn)), other)
    gap = np.abs(along) - reach
    gap[:, 6:][flat] = -np.inf
    best, at = gap.argmax(axis=1), np.arange(len(one))
    sign = np.where(along[at, best] < 0.0, -1.0, 1.0)
    return gap[at, best], axes[at, best] * sign[:, None]


def _apart(
    turn: Floats, place: Floats, one: Floats, other: Floats, mine: Floats, theirs: Floats
) -> tuple[Floats, Floats]:
    """The nearest points of boxes that do not touch: of corners and boxes, or of two edges.

    mine, theirs: (k, 8, 3) their corners.
    """
    local = np.einsum("kji,ksj->ksi", turn, mine - place[:, None])
    on_other = np.clip(local, -other[:, None], other[:, None])
    on_other = place[:, None] + np.einsum("kij,ksj->ksi", turn, on_other)
    on_one = np.clip(theirs, -one[:, None], one[:, None])
    edges = np.indices((12, 12)).reshape(2, -1)
    a, b = mine[:, _EDGES[edges[0]]], theirs[:, _EDGES[edges[1]]]
    e, f = segments_apart(a[:, :, 0], a[:, :, 1], b[:, :, 0], b[:, :, 1])
    p = np.concatenate([mine, on_one, e], axis=1)
    q = np.concatenate([on_other, theirs, f], axis=1)
    best = dot_products(q - p, q - p).argmin(axis=1)
    rows = np.arange(len(mine))
    return p[rows, best], q[rows, best]
