"""Signed distances between shapes: in closed form for round shapes and boxes, else by coal.

A sphere is a segment of no length, a capsule a segment, each with a radius around it. A distance
below 0 is the shortest translation that separates the two shapes.

The triangles of a closed mesh alone report a body that is entirely inside it as clear. A body that
does not touch the surface is inside if one of its points is: a ray from there passes the surface an
odd number of times. Three rays vote, as one may run along an edge.

Lengths stay mm: coal's tolerances are absolute, and 1e-9 keeps distances of bodies of metres right
to 1e-7 mm (measured against closed forms in tests/cell/test_distances.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final
from weakref import WeakKeyDictionary

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.cell.findings import NO_LIBRARY
from assistant.cell.scene import Box, Capsule, Convex, Cylinder, Mesh, Shape, Sphere, extent

if TYPE_CHECKING:
    from types import ModuleType


_TINY: Final = 1e-12
_BOX_PAIRS_AT_ONCE: Final = 4096
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


def _dot_products(a: Floats, b: Floats) -> Floats:
    """(...) products of vectors (..., 3)."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def _segments_apart(a0: Floats, a1: Floats, b0: Floats, b1: Floats) -> tuple[Floats, Floats]:
    """The nearest points (..., 3) of segments from a0 to a1 and from b0 to b1 (..., 3).

    After Ericson, Real-Time Collision Detection, 5.1.9.
    """
    d1, d2, r = a1 - a0, b1 - b0, a0 - b0
    a, e, f, c, b = (
        _dot_products(d1, d1),
        _dot_products(d2, d2),
        _dot_products(d2, r),
        _dot_products(d1, r),
        _dot_products(d1, d2),
    )
    point_a, point_b = a <= _TINY, e <= _TINY
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


def _capsule_distances(
    a: tuple[Floats, Floats], b: tuple[Floats, Floats], radii: Floats
) -> NearestPoints:
    """Capsules about segments (k, 3) to (k, 3). radii: (k, 2) of the one and of the other."""
    p, q = _segments_apart(*a, *b)
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
        lost = norms(found) <= 1e-9 * (norms(one) * norms(other) + _TINY)
        found = np.where(lost[:, None], np.cross(vector, smallest), found)
    lost = norms(found) <= _TINY
    found[lost] = (0.0, 0.0, 1.0)
    return found


def _capsule_box_distances(p0: Floats, p1: Floats, half: Floats, radius: Floats) -> NearestPoints:
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
    still = np.abs(way) <= _TINY
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
    flat = size <= 1e-9 * (norms(way)[:, None] + _TINY)
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


def _box_distances(turn: Floats, place: Floats, one: Floats, other: Floats) -> NearestPoints:
    """Boxes of half edges other (k, 3) at places (k, 3), turned by (k, 3, 3), in the frames of
    boxes of half edges one (k, 3), in which the points and the normals are.
    """
    if len(one) > _BOX_PAIRS_AT_ONCE:
        parts = [
            _box_distances(*(x[i : i + _BOX_PAIRS_AT_ONCE] for x in (turn, place, one, other)))
            for i in range(0, len(one), _BOX_PAIRS_AT_ONCE)
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
        normal[out] = way / np.maximum(apart[out], _TINY)[:, None]
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
    e, f = _segments_apart(a[:, :, 0], a[:, :, 1], b[:, :, 0], b[:, :, 1])
    p = np.concatenate([mine, on_one, e], axis=1)
    q = np.concatenate([on_other, theirs, f], axis=1)
    best = _dot_products(q - p, q - p).argmin(axis=1)
    rows = np.arange(len(mine))
    return p[rows, best], q[rows, best]


_COAL_TOLERANCE: Final = 1e-9
"""mm, of the distances of convex shapes."""
_COAL_ITERATIONS: Final = 1000


def coal_library() -> ModuleType:
    """coal; raises Refused, naming the extra, without it."""
    try:
        import coal  # type: ignore[import-untyped]
    except ImportError:
        raise Refused(NO_LIBRARY(what="collisions are", name="coal"), exit_status=2) from None
    return coal  # type: ignore[no-any-return]


def distance_request() -> Any:
    """Return the settings of a distance request to coal."""
    wanted = coal_library().DistanceRequest()
    wanted.gjk_tolerance = _COAL_TOLERANCE
    wanted.gjk_max_iterations = _COAL_ITERATIONS
    return wanted


@dataclass(frozen=True, slots=True, eq=False)
class BoundingBox:
    """A box about a shape: middle (3,) and half edges (3,) in its frame, and the sphere of both."""

    middle: Floats
    half: Floats

    @property
    def radius(self) -> float:
        return float(np.linalg.norm(self.half))


def bounding_box(shape: Shape) -> BoundingBox:
    low, high = extent(shape)
    return BoundingBox((low + high) / 2.0, (high - low) / 2.0)


def coal_geometry(shape: Shape) -> Any:
    """A shape as a geometry of coal."""
    coal = coal_library()
    match shape:
        case Box(size=(x, y, z)):
            return coal.Box(float(x), float(y), float(z))
        case Sphere():
            return coal.Sphere(float(shape.radius))
        case Cylinder():
            return coal.Cylinder(float(shape.radius), float(shape.length))
        case Capsule():
            return coal.Capsule(float(shape.radius), float(shape.length))
        case Convex():
            return _convex(shape.hull)
    return _surface(shape)


def _convex(hull: Mesh) -> Any:
    coal = coal_library()
    return coal.Convex(_points(hull), _triangles(hull))


_BUILT: Final[WeakKeyDictionary[Mesh, Any]] = WeakKeyDictionary()
"""Surfaces of meshes, for as long as these are there: building one takes long."""


def _surface(mesh: Mesh) -> Any:
    if mesh not in _BUILT:
        _BUILT[mesh] = _built_surface(mesh)
    return _BUILT[mesh]


def _built_surface(mesh: Mesh) -> Any:
    coal = coal_library()
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(mesh.triangles), len(mesh.points))
    model.addVertices(np.ascontiguousarray(mesh.points))
    model.addTriangles(np.ascontiguousarray(mesh.triangles.astype(np.int64)))
    model.endModel()
    return model


def _points(mesh: Mesh) -> Any:
    out = coal_library().StdVec_Vec3s()
    out.extend(list(mesh.points.astype(np.float64)))
    return out


def _triangles(mesh: Mesh) -> Any:
    coal = coal_library()
    out = coal.StdVec_Triangle()
    for a, b, c in mesh.triangles.tolist():
        out.append(coal.Triangle(a, b, c))
    return out


_RAYS: Final = (
    (0.5773502691896258, 0.5773502691896257, 0.5773502691896259),
    (-0.2672612419124244, 0.5345224838248488, 0.8017837257372732),
    (0.8728715609439694, -0.2182178902359924, 0.4364357804719847),
)
"""Unit vectors along no axis, which many edges and faces of drawings lie along."""


class _InsideTest:
    """Test whether a shape lies inside another; shapes are given by number."""

    def __init__(self, shapes: Sequence[Shape]) -> None:
        self._shapes = shapes
        self._extents = [extent(shape) for shape in shapes]

    def signed(self, distance: float, one: int, other: int, at_one: Any, at_other: Any) -> float:
        """A distance above 0 of two shapes, made negative if one lies inside the other."""
        for outer, inner, frame, point in (
            (one, other, at_one, at_other),
            (other, one, at_other, at_one),
        ):
            shape = self._shapes[outer]
            if isinstance(shape, Mesh) and shape.solid:
                place = point.getRotation() @ self._some_point(inner) + point.getTranslation()
                local = frame.getRotation().T @ (place - frame.getTranslation())
                low, high = self._extents[outer]
                if ((local > low) & (local < high)).all() and points_inside(shape, local[None])[0]:
                    return -distance
        return distance

    def _some_point(self, number: int) -> Floats:
        """Return a point of a shape, in its frame: a corner if it has corners, otherwise the
        centre.
        """
        shape = self._shapes[number]
        if isinstance(shape, Mesh):
            return np.asarray(shape.points[shape.triangles[0, 0]])
        if isinstance(shape, Convex):  # the middle of the box about it may be outside
            return np.asarray(shape.points[0])
        low, high = self._extents[number]
        return np.asarray((low + high) / 2.0)


def points_inside(mesh: Mesh, points: Floats) -> Any:
    """(n,) whether points (n, 3) lie inside a closed mesh, in its frame."""
    if mesh.within is not None:
        return mesh.within(points)
    votes = sum(
        (_ray_crossings(mesh, points, np.array(ray)) % 2 for ray in _RAYS), np.zeros(len(points))
    )
    return votes >= 2


def _ray_crossings(mesh: Mesh, points: Floats, ray: Floats) -> Any:
    """(n,) how many triangles a ray (3,) from points (n, 3) passes (Möller and Trumbore, 1997)."""
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    e1, e2 = b - a, c - a
    p = np.cross(ray, e2)
    det = np.einsum("ij,ij->i", e1, p)
    flat = np.abs(det) < 1e-15
    inv = np.where(flat, 0.0, 1.0 / np.where(flat, 1.0, det))
    out = np.zeros(len(points), dtype=np.intp)
    for n, point in enumerate(points):
        s = point - a
        u = np.einsum("ij,ij->i", s, p) * inv
        q = np.cross(s, e1)
        v = q @ ray * inv
        t = np.einsum("ij,ij->i", e2, q) * inv
        out[n] = (~flat & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0)).sum()
    return out


WorldPoses = tuple[Floats, Floats]
"""Places (k, 3) mm and turns (k, 3, 3) of k shapes in the world."""


class Distances:
    """Distances of shapes by their numbers. Pairs that are not `closed` need the library coal."""

    def __init__(self, shapes: Sequence[Shape]) -> None:
        self.shapes = tuple(shapes)
        round_ = [isinstance(shape, Sphere | Capsule) for shape in self.shapes]
        self._round: Truths = np.array(round_, dtype=bool)
        self._boxed: Truths = np.array([isinstance(s, Box) for s in self.shapes], dtype=bool)
        self._radii: Floats = np.array([float(getattr(s, "radius", 0.0)) for s in self.shapes])
        sizes = [s.size if isinstance(s, Box) else (0.0, 0.0, 0.0) for s in self.shapes]
        self._halves: Floats = np.array(sizes, dtype=np.float64).reshape(-1, 3) / 2.0
        lengths = [s.length / 2.0 if isinstance(s, Capsule) else 0.0 for s in self.shapes]
        self._lengths: Floats = np.array(lengths)

    def closed(self, one: Rows, other: Rows) -> Truths:
        """(k,) whether the distances of shapes one (k,) and other (k,) have a closed form."""
        form = self._round | self._boxed
        return form[one] & form[other]

    def signed(self, one: Rows, other: Rows, at_one: WorldPoses, at_other: WorldPoses) -> Floats:
        """(k,) mm between shapes one (k,) and other (k,), below 0 the depth of the contact."""
        out = np.empty(len(one))
        for some, found in self._closed_forms(one, other, at_one, at_other):
            out[some] = found.distance
        rest = np.flatnonzero(~self.closed(one, other))
        if len(rest):
            out[rest] = self._by_library(
                one[rest], other[rest], _of(at_one, rest), _of(at_other, rest)
            )
        return out

    def nearest(
        self, one: int, other: int, at_one: WorldPoses, at_other: WorldPoses
    ) -> NearestPoints:
        """Distance of one pair, with its points and its normal in the world."""
        i, o = np.array([one]), np.array([other])
        for _, found in self._closed_forms(i, o, at_one, at_other):
            return found
        frames = [self._frame(at[0][0], at[1][0]) for at in (at_one, at_other)]
        distance = self._distance(one, other, *frames)
        points = self._result.getNearestPoint1(), self._result.getNearestPoint2()
        normal = np.array([self._result.normal])
        return NearestPoints(
            np.array([distance]), np.array([points[0]]), np.array([points[1]]), normal
        )

    # ------------------------------------------------------------------------- closed forms

    def _closed_forms(
        self, one: Rows, other: Rows, at_one: WorldPoses, at_other: WorldPoses
    ) -> Iterator[tuple[Rows, NearestPoints]]:
        """Which of k pairs (m,), and their distances, points and normals in the world."""
        round_one, round_other = self._round[one], self._round[other]
        box_one, box_other = self._boxed[one], self._boxed[other]
        some = np.flatnonzero(round_one & round_other)
        if len(some):
            i, o = one[some], other[some]
            radii = np.stack([self._radii[i], self._radii[o]], axis=1)
            segments = self._segment(i, _of(at_one, some)), self._segment(o, _of(at_other, some))
            yield some, _capsule_distances(*segments, radii)
        some = np.flatnonzero(round_one & box_other)
        if len(some):
            yield some, self._of_box(one[some], other[some], _of(at_one, some), _of(at_other, some))
        some = np.flatnonzero(box_one & round_other)
        if len(some):
            back = self._of_box(other[some], one[some], _of(at_other, some), _of(at_one, some))
            yield some, NearestPoints(back.distance, back.other, back.one, -back.normal)
        some = np.flatnonzero(box_one & box_other)
        if len(some):
            (p, turn), (p_other, turn_other) = _of(at_one, some), _of(at_other, some)
            relative = np.einsum("kji,kjl->kil", turn, turn_other)
            place = np.einsum("kji,kj->ki", turn, p_other - p)
            found = _box_distances(
                relative, place, self._halves[one[some]], self._halves[other[some]]
            )
            yield some, _transforms(found, p, turn)

    def _segment(self, shape: Rows, at: WorldPoses) -> tuple[Floats, Floats]:
        along = at[1][:, :, 2] * self._lengths[shape][:, None]
        return at[0] - along, at[0] + along

    def _of_box(
        self, capsule: Rows, box: Rows, at_capsule: WorldPoses, at_box: WorldPoses
    ) -> NearestPoints:
        place, turn = at_box
        ends = self._segment(capsule, at_capsule)
        p0, p1 = (np.einsum("kji,kj->ki", turn, end - place) for end in ends)
        found = _capsule_box_distances(p0, p1, self._halves[box], self._radii[capsule])
        return _transforms(found, place, turn)

    # ----------------------------------------------------------------------------- by coal

    @cached_property
    def _result(self) -> Any:
        return coal_library().DistanceResult()

    @cached_property
    def _request(self) -> Any:
        return distance_request()

    @cached_property
    def _geometries(self) -> dict[int, Any]:
        return {}

    def _geometry(self, shape: int) -> Any:
        if shape not in self._geometries:
            self._geometries[shape] = coal_geometry(self.shapes[shape])
        return self._geometries[shape]

    @cached_property
    def _inside(self) -> _InsideTest | None:
        """None without closed meshes: their triangles are a surface, with nothing inside."""
        solid = any(isinstance(shape, Mesh) and shape.solid for shape in self.shapes)
        return _InsideTest(self.shapes) if solid else None

    @staticmethod
    def _frame(place: Floats, turn: Floats) -> Any:
        return coal_library().Transform3s(turn, place)

    def _by_library(
        self, one: Rows, other: Rows, at_one: WorldPoses, at_other: WorldPoses
    ) -> Floats:
        make = coal_library().Transform3s
        frames = [
            [make(turn, place) for place, turn in zip(*at, strict=True)]
            for at in (at_one, at_other)
        ]
        pairs = zip(one.tolist(), other.tolist(), *frames, strict=True)
        return np.array([self._distance(*pair) for pair in pairs])

    def _distance(self, one: int, other: int, at_one: Any, at_other: Any) -> float:
        self._result.clear()  # or an older, smaller distance of a mesh stays
        found = coal_library().distance(
            *(self._geometry(one), at_one, self._geometry(other), at_other),
            *(self._request, self._result),
        )
        if found > 0.0 and self._inside is not None:
            found = self._inside.signed(found, one, other, at_one, at_other)
        return float(found)


def _of(at: WorldPoses, some: Rows) -> WorldPoses:
    return at[0][some], at[1][some]


def _transforms(found: NearestPoints, place: Floats, turn: Floats) -> NearestPoints:
    """Transform from frames with origins (k, 3) and rotations (k, 3, 3) to the world."""
    one, other = (np.einsum("kij,kj->ki", turn, p) + place for p in (found.one, found.other))
    return NearestPoints(found.distance, one, other, np.einsum("kij,kj->ki", turn, found.normal))
