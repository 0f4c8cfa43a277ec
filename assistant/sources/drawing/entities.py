"""Entities of a drawing as straight pieces, conics and splines: one reader for each entity type.

The primitives are closed under any affine transform: a conic given by two conjugate radii becomes
such a conic again, and a spline the spline of the moved control points. So nested, mirrored and
unevenly scaled inserts need no special cases; only at the end it is known whether a conic is a
circle. Readers answer in the coordinates of the entity's layout.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.sources.contours.curves import (
    Arc,
    Curve,
    FreeCurve,
    Line,
    Points,
    cross_product,
    dot_product,
    vector,
)
from assistant.sources.drawing.transforms import cross, direction, ocs_axes, ocs_matrix, point

if TYPE_CHECKING:
    from ezdxf.entities.dxfgfx import DXFGraphic
    from ezdxf.entities.lwpolyline import LWPolyline
    from ezdxf.entities.polyline import Polyline
    from ezdxf.entities.spline import Spline as SplineEntity


_ROUND_TOLERANCE: Final = 1e-9
"""Relative difference of two conjugate radii, and cosine between them, of a circle."""

_FARTHEST_COORDINATE: Final = 1e7
"""mm; a coordinate beyond 10 km is no work piece but a broken file."""

_FLATTEST_ARC: Final = 1e-4
"""mm; an arc that leaves its chord by less is a line, where its centre is no place."""

_SHORTEST_CURVE: Final = 1e-9
"""mm; what is shorter has no direction."""


class Degenerate(ValueError):
    """A curve without length or without a plane."""


@dataclass(frozen=True, slots=True, eq=False)
class Straight:
    """From start to end, (3,) each."""

    start: Floats
    end: Floats

    def moved(self, matrix: Floats) -> Straight:
        return Straight(point(matrix, self.start), point(matrix, self.end))

    def curve(self, layer: str, handle: str) -> Curve:
        check_coordinates(self.start, self.end)
        if np.linalg.norm(self.end - self.start) <= _SHORTEST_CURVE:
            raise Degenerate("without length")
        return Line(vector(self.start), vector(self.end), layer, handle)


@dataclass(frozen=True, slots=True, eq=False)
class Conic:
    """centre + u·cos t + v·sin t for t from 0 to `sweep` radians, a whole ellipse at 2π."""

    centre: Floats
    u: Floats
    v: Floats
    sweep: float

    @staticmethod
    def part(centre: Floats, u: Floats, v: Floats, first: float, sweep: float) -> Conic:
        """The part that begins at parameter `first` (radians)."""
        c, s = math.cos(first), math.sin(first)
        return Conic(centre, c * u + s * v, c * v - s * u, sweep)

    @property
    def whole(self) -> bool:
        return self.sweep == math.tau

    def moved(self, matrix: Floats) -> Conic:
        u, v = direction(matrix, np.stack([self.u, self.v]))
        return Conic(point(matrix, self.centre), u, v, self.sweep)

    def curve(self, layer: str, handle: str) -> Curve:
        radius = max(math.hypot(*vector(self.u)), math.hypot(*vector(self.v)))
        # A nearly straight arc has a centre far away: as an arc it would be refused.
        if (
            radius >= _FARTHEST_COORDINATE
            and 2.0 * radius * math.sin(self.sweep / 4.0) ** 2 <= _FLATTEST_ARC
        ):
            start, end = self._evaluate(np.array([0.0, 1.0]))
            return Straight(start, end).curve(layer, handle)
        check_coordinates(self.centre, self.u, self.v)
        # Plain numbers: a drawing may have thousands of these, of three numbers each.
        centre, u, v = vector(self.centre), vector(self.u), vector(self.v)
        normal = cross_product(u, v)
        sizes = math.hypot(*u), math.hypot(*v)
        flat = math.hypot(*normal) <= _ROUND_TOLERANCE * max(sizes) ** 2
        # Without area it has no normal: it is a line that is run twice.
        if flat or self.sweep * max(sizes) <= _SHORTEST_CURVE:
            raise Degenerate("without length or area")
        even = abs(sizes[0] - sizes[1]) <= _ROUND_TOLERANCE * max(sizes)
        if even and abs(dot_product(u, v)) <= _ROUND_TOLERANCE * max(sizes) ** 2:
            sweep = 360.0 if self.whole else math.degrees(self.sweep)
            start = (centre[0] + u[0], centre[1] + u[1], centre[2] + u[2])
            return Arc.about(centre, normal, start, sweep, layer, handle)
        return FreeCurve(self._evaluate, self.whole, layer, handle)

    def _evaluate(self, parameters: Floats) -> Points:
        t = (parameters * self.sweep)[:, None]
        return np.asarray(self.centre + np.cos(t) * self.u + np.sin(t) * self.v)


@dataclass(frozen=True, slots=True, eq=False)
class _Spline:
    """A rational B-spline.

    knots (n + degree + 1,) ascending, points (n, 3), weights (n,) positive.
    """

    degree: int
    knots: Floats
    points: Floats
    weights: Floats

    def moved(self, matrix: Floats) -> _Spline:
        return replace(self, points=point(matrix, self.points))

    def curve(self, layer: str, handle: str) -> Curve:
        check_coordinates(self.points)
        if np.linalg.norm(np.ptp(self.points, axis=0)) <= _SHORTEST_CURVE:
            raise Degenerate("without length")
        low, high = self._domain
        inner = np.unique(self.knots[(self.knots > low) & (self.knots < high)])
        # A change of polynomial may be a corner: fitting must not go across it.
        breaks = (0.0, *(float(b) for b in (inner - low) / (high - low)), 1.0)
        ends = self._evaluate(np.array([0.0, 1.0]))
        closed = bool(np.linalg.norm(ends[1] - ends[0]) <= _SHORTEST_CURVE)
        return FreeCurve(self._evaluate, closed, layer, handle, breaks)

    def continuous(self) -> Iterator[_Spline]:
        """The parts between knots at which the curve may jump: those that are there more often
        than its degree. Each part has its own ends.
        """
        p, n = self.degree, len(self.points)
        first = 0
        values, places, counts = np.unique(self.knots, return_index=True, return_counts=True)
        low, high = self._domain
        for value, place, count in zip(values, places.tolist(), counts.tolist(), strict=True):
            if low < value < high and count > p:
                yield self._part(first, place)
                first = place + count - p - 1
        yield self if first == 0 else self._part(first, n)

    def _part(self, first: int, last: int) -> _Spline:
        """The part of a spline from one control point up to another."""
        return replace(
            self,
            knots=self.knots[first : last + self.degree + 1],
            points=self.points[first:last],
            weights=self.weights[first:last],
        )

    @property
    def _domain(self) -> tuple[float, float]:
        return float(self.knots[self.degree]), float(self.knots[len(self.points)])

    def _evaluate(self, parameters: Floats) -> Points:
        """De Boor's algorithm in homogeneous coordinates, all parameters at once."""
        p, n, knots = self.degree, len(self.points), self.knots
        low, high = self._domain
        x = np.clip(low + parameters * (high - low), low, high)
        last = int(np.searchsorted(knots, high, side="left")) - 1  # its span holds the end
        # The last span holds the end of the domain: no span begins there.
        span = np.clip(np.searchsorted(knots, x, side="right") - 1, p, min(last, n - 1))
        homogeneous = np.column_stack([self.points * self.weights[:, None], self.weights])
        d = homogeneous[span[:, None] + np.arange(-p, 1)]
        for r in range(1, p + 1):
            for j in range(p, r - 1, -1):
                i = span - p + j
                width = knots[i + p - r + 1] - knots[i]
                # Repeated knots have spans without width, whose share does not matter.
                share = np.divide(x - knots[i], width, out=np.zeros_like(x), where=width > 0)
                d[:, j] = d[:, j - 1] + share[:, None] * (d[:, j] - d[:, j - 1])
        return np.asarray(d[:, p, :3] / d[:, p, 3:])


Primitive = Straight | Conic | _Spline


def check_coordinates(*places: Floats) -> None:
    """Raises ValueError for a coordinate that is not finite, or is no place for a robot."""
    if not (np.abs(np.concatenate(places)) < _FARTHEST_COORDINATE).all():  # NaN fails as well
        raise ValueError(f"a coordinate is not finite or beyond {_FARTHEST_COORDINATE:g} mm")


_FEWEST_FIT_POINTS: Final = 2


def primitives(entity: DXFGraphic) -> list[Primitive]:
    """Return the primitives of an entity, in world or block coordinates.

    The entity's type has to be one of `_PRIMITIVE_READERS`. Raises Degenerate for one without any
    length, ValueError or ezdxf's errors for one with invalid data.
    """
    check_stated(entity)
    return _PRIMITIVE_READERS[entity.dxftype()](entity)


def check_stated(entity: DXFGraphic) -> None:
    """Raises ValueError if an entity lacks what ezdxf would put a default in place of."""
    missing = [a for a in _STATED_ATTRIBUTES.get(entity.dxftype(), ()) if not entity.dxf.hasattr(a)]
    if missing:
        raise ValueError(f"it does not state its {' and '.join(missing)}")


def is_followed(entity: DXFGraphic) -> bool:
    """True if an entity is a curve that can be followed; a mesh, though a POLYLINE, is not."""
    kind = entity.dxftype()
    if kind == "POLYLINE":
        polyline = cast("Polyline", entity)
        return polyline.is_2d_polyline or polyline.is_3d_polyline
    return kind in _PRIMITIVE_READERS


def ignored_properties(entity: DXFGraphic) -> list[str]:
    """Return the properties of an entity beyond its curve: thickness, width."""
    found = []
    if entity.dxf.is_supported("thickness") and entity.dxf.get("thickness", 0):
        found.append("thickness")
    kind = entity.dxftype()
    if kind == "LWPOLYLINE":
        polyline = cast("LWPolyline", entity)
        if polyline.has_width or polyline.dxf.get("const_width", 0):
            found.append("width")
    elif kind == "POLYLINE" and cast("Polyline", entity).has_width:
        found.append("width")
    return found


def _line(entity: Any) -> list[Primitive]:
    return [Straight(_xyz(entity.dxf.start), _xyz(entity.dxf.end))]


def _circle(entity: Any) -> list[Primitive]:
    return [_circular_arc(entity, 0.0, math.tau)]


def _arc(entity: Any) -> list[Primitive]:
    first, last = float(entity.dxf.start_angle), float(entity.dxf.end_angle)
    if not (math.isfinite(first) and math.isfinite(last)):
        raise ValueError("an angle is not finite")
    if first == last:
        raise Degenerate("without length")
    # A circle from an angle to itself plus 360 is complete, not empty.
    sweep = (last - first) % 360.0 or 360.0
    return [_circular_arc(entity, math.radians(first % 360.0), math.radians(sweep))]


def _circular_arc(entity: Any, start: float, sweep: float) -> Conic:
    """A circular arc of `sweep` radians."""
    axes = ocs_axes(_xyz(entity.dxf.extrusion))
    # Some writers mirror an arc by a negative radius.
    radius = abs(float(entity.dxf.radius))
    if radius == 0.0:
        raise Degenerate("without radius")
    u, v = radius * axes[:, 0], radius * axes[:, 1]
    return Conic.part(axes @ _xyz(entity.dxf.center), u, v, start, sweep)


def _ellipse(entity: Any) -> list[Primitive]:
    major = _xyz(entity.dxf.major_axis)
    normal = ocs_axes(_xyz(entity.dxf.extrusion))[:, 2]
    minor = cross(normal, major) * float(entity.dxf.ratio)
    first, last = float(entity.dxf.start_param), float(entity.dxf.end_param)
    if not (math.isfinite(first) and math.isfinite(last)):
        raise ValueError("a parameter is not finite")
    if first == last:
        raise Degenerate("without length")
    sweep = (last - first) % math.tau
    # Writers round the end parameter: a full ellipse is nearly 2π or nearly 0.
    if math.isclose(sweep, 0.0, abs_tol=1e-9) or math.isclose(sweep, math.tau, abs_tol=1e-9):
        sweep = math.tau
    return [Conic.part(_xyz(entity.dxf.center), major, minor, first, sweep)]


def _lwpolyline(entity: LWPolyline) -> list[Primitive]:
    corners = [(x, y, bulge) for x, y, bulge in entity.get_points("xyb")]
    return _flat_polyline(corners, entity.closed, float(entity.dxf.elevation), entity.dxf.extrusion)


def _polyline(entity: Polyline) -> list[Primitive]:
    # Of a polyline smoothed by a spline only the smooth vertices lie on it.
    vertices = [v for v in entity.vertices if not v.dxf.flags & _FRAME_CONTROL_POINT]
    if entity.is_3d_polyline:
        places = [_xyz(v.dxf.location) for v in vertices]
        return _require_pieces(_straights(places, entity.is_closed))
    elevation = _xyz(entity.dxf.elevation)[2]
    corners = [(v.dxf.location.x, v.dxf.location.y, v.dxf.get("bulge", 0.0)) for v in vertices]
    return _flat_polyline(corners, entity.is_closed, float(elevation), entity.dxf.extrusion)


_FRAME_CONTROL_POINT: Final = 16
"""Flag of a vertex that a spline-fit polyline is drawn from, but does not go through."""


def _flat_polyline(
    corners: Sequence[tuple[float, float, float]], closed: bool, elevation: float, extrusion: Any
) -> list[Primitive]:
    """A polyline in its own plane: straight pieces, and arcs where there is a bulge."""
    matrix = ocs_matrix(_xyz(extrusion))
    rows = np.array(corners, dtype=np.float64).reshape(-1, 3)
    if not (np.isfinite(rows).all() and math.isfinite(elevation)):
        raise ValueError("a vertex is not finite")
    follows = np.roll(rows, -1, axis=0)
    # A closed polyline of one vertex has no piece.
    if not (closed and len(rows) > 1):
        rows, follows = rows[:-1], follows[:-1]
    kept = (rows[:, :2] != follows[:, :2]).any(axis=1)  # doubled vertices are usual
    rows, follows, height = rows[kept], follows[kept], np.full(int(kept.sum()), elevation)
    start, end = (np.column_stack([one[:, :2], height]) for one in (rows, follows))
    bent, centre, u, v, sweep = _bulged(start, end, rows[:, 2])
    start, end, centre = (point(matrix, one) for one in (start, end, centre))
    u, v = direction(matrix, u), direction(matrix, v)
    pieces: list[Primitive] = [
        Conic(centre[i], u[i], v[i], turn) if round_ else Straight(start[i], end[i])
        for i, (round_, turn) in enumerate(zip(bent.tolist(), sweep.tolist(), strict=True))
    ]
    return _require_pieces(pieces)


def _bulged(
    start: Floats, end: Floats, bulges: Floats
) -> tuple[NDArray[np.bool_], Floats, Floats, Floats, Floats]:
    """Truths (n,) for pieces that are arcs; centres, conjugate radii (n, 3), sweeps in radians.

    A bulge is the tangent of a quarter of an arc's angle, positive to the left. With the chord d
    from start to end the centre is (1 - b²) / 4b · d turned left from the middle of the chord.
    """
    # At this bulge start and end of the arc are one point, and its radius is lost.
    largest = float(np.abs(bulges).max(initial=0.0))
    if largest > _LARGEST_BULGE:
        raise ValueError(f"the bulge {largest:g} is a full circle through one point")
    chord = end - start
    sweep = 4.0 * np.arctan(np.abs(bulges))
    bent = sweep * np.linalg.norm(chord, axis=1) >= _FLATTEST_BULGE
    # Any bulge will do for straight pieces, which the result leaves out.
    b = np.where(bent, bulges, 1.0)
    centre = (start + end) / 2.0 + _turned_left(chord) * ((1.0 - b * b) / (4.0 * b))[:, None]
    u = start - centre
    return bent, centre, u, _turned_left(u) * np.sign(b)[:, None], sweep


def _turned_left(v: Floats) -> Floats:
    """Vectors (n, 3) turned to the left about z by a quarter."""
    return np.column_stack([-v[:, 1], v[:, 0], np.zeros(len(v))])


_LARGEST_BULGE: Final = 1e6
"""Largest bulge; beyond it start and end of the arc cannot be distinguished."""

_FLATTEST_BULGE: Final = 1e-9
"""Angle times chord of a bulge below which the arc is straight to any printed decimal."""


def _straights(places: Sequence[Floats], closed: bool) -> list[Primitive]:
    ends = list(itertools.pairwise(places))
    if closed and len(places) > 1:
        ends.append((places[-1], places[0]))
    return [Straight(a, b) for a, b in ends if not (a == b).all()]


def _spline(entity: SplineEntity) -> list[Primitive]:
    points = _points(entity.control_points)
    if len(points):
        whole = _nurbs(entity.dxf.degree, entity.knots, points, entity.weights)
        return [*whole.continuous()]
    fit = _points(entity.fit_points)
    # Fit points of a closed spline do not repeat the first.
    if len(fit) and entity.closed and not (fit[0] == fit[-1]).all():
        fit = np.vstack([fit, fit[:1]])
    if len(fit) < _FEWEST_FIT_POINTS:
        raise ValueError("it has neither control points nor fit points")
    if not np.isfinite(fit).all():
        raise ValueError("a fit point is not finite")
    # Two fit points without tangents are a line.
    if len(fit) == _FEWEST_FIT_POINTS and not entity.dxf.hasattr("start_tangent"):
        return [Straight(fit[0], fit[1])]
    return [_fitted(entity, fit)]


def _fitted(entity: SplineEntity, fit: Floats) -> _Spline:
    """Through the fit points, as CAD systems draw it: cubic, with the end tangents if given."""
    from ezdxf.math import Vec3, fit_points_to_cad_cv

    tangents = None
    if entity.dxf.hasattr("start_tangent") and entity.dxf.hasattr("end_tangent"):
        pair = [Vec3(entity.dxf.start_tangent), Vec3(entity.dxf.end_tangent)]
        # A zero vector states no tangent.
        if all(t.magnitude > 0 for t in pair):
            tangents = pair
    curve = fit_points_to_cad_cv([Vec3(p) for p in fit], tangents)
    points = _points(curve.control_points)
    points[0], points[-1] = fit[0], fit[-1]  # where they are but for rounding
    return _nurbs(curve.degree, curve.knots(), points, ())


def _nurbs(
    degree: int, knots: Sequence[float], points: Floats, weights: Sequence[float]
) -> _Spline:
    knot = np.asarray(knots, dtype=np.float64)
    weight = np.asarray(weights if len(weights) else np.ones(len(points)), dtype=np.float64)
    if degree < 1 or len(points) <= degree:
        raise ValueError(f"{len(points)} control points are too few for degree {degree}")
    if len(knot) != len(points) + degree + 1:
        raise ValueError(f"it has {len(knot)} knots, but needs {len(points) + degree + 1}")
    if len(weight) != len(points):
        raise ValueError(f"it has {len(weight)} weights for {len(points)} control points")
    if not (np.isfinite(knot).all() and (np.diff(knot) >= 0).all()):
        raise ValueError("its knots do not ascend")
    if not knot[degree] < knot[len(points)]:
        raise ValueError("its knots leave no range")
    if not (np.isfinite(weight).all() and (weight > 0).all()):
        raise ValueError("a weight is not positive")
    return _Spline(int(degree), knot, points, weight)


def _require_pieces(pieces: list[Primitive]) -> list[Primitive]:
    if not pieces:
        raise Degenerate("without length")
    return pieces


def _xyz(v: Any) -> Floats:
    from ezdxf.math import Vec3

    return np.array(Vec3(v).xyz)


def _points(vectors: Iterable[ArrayLike]) -> Floats:
    return np.array([tuple(v) for v in vectors], dtype=np.float64).reshape(-1, 3)  # type: ignore[arg-type]


_STATED_ATTRIBUTES: Final[dict[str, tuple[str, ...]]] = {
    "LINE": ("start", "end"),
    "ARC": ("center", "radius", "start_angle", "end_angle"),
    "CIRCLE": ("center", "radius"),
    "ELLIPSE": ("center", "major_axis", "ratio", "start_param", "end_param"),
    "POINT": ("location",),
    "INSERT": ("name", "insert"),
}
"""Attributes that an entity has to state: with a default instead, a robot would move elsewhere."""

_PRIMITIVE_READERS: Final[dict[str, Callable[[Any], list[Primitive]]]] = {
    "LINE": _line,
    "ARC": _arc,
    "CIRCLE": _circle,
    "ELLIPSE": _ellipse,
    "LWPOLYLINE": _lwpolyline,
    "POLYLINE": _polyline,
    "SPLINE": _spline,
    "HELIX": _spline,
}
"""Entity type → its reader. One line adds one."""
