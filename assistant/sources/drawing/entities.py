"""Entities to primitives: one reader an entity type, in the coordinates of its layout."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assistant.base.arrays import Floats
from assistant.sources.drawing.primitives import Conic, Degenerate, Primitive, Spline, Straight
from assistant.sources.drawing.transforms import cross, direction, ocs_axes, ocs_matrix, point

if TYPE_CHECKING:
    from ezdxf.entities.dxfgfx import DXFGraphic
    from ezdxf.entities.lwpolyline import LWPolyline
    from ezdxf.entities.polyline import Polyline
    from ezdxf.entities.spline import Spline as SplineEntity

FEWEST_FIT_POINTS: Final = 2


def primitives(entity: DXFGraphic) -> list[Primitive]:
    """What an entity is made of, in world or block coordinates.

    The entity's type has to be one of `READERS`. Raises Degenerate for one without any
    length, ValueError or ezdxf's errors for one that says nothing sensible.
    """
    check_stated(entity)
    return PRIMITIVE_READERS[entity.dxftype()](entity)


def check_stated(entity: DXFGraphic) -> None:
    """Raises ValueError if an entity lacks what ezdxf would put a default in place of."""
    missing = [a for a in STATED_ATTRIBUTES.get(entity.dxftype(), ()) if not entity.dxf.hasattr(a)]
    if missing:
        raise ValueError(f"it does not state its {' and '.join(missing)}")


def is_followed(entity: DXFGraphic) -> bool:
    """Whether an entity is a curve that can be followed; a mesh, though a POLYLINE, is not."""
    kind = entity.dxftype()
    if kind == "POLYLINE":
        polyline = cast("Polyline", entity)
        return polyline.is_2d_polyline or polyline.is_3d_polyline
    return kind in PRIMITIVE_READERS


def ignored_properties(entity: DXFGraphic) -> list[str]:
    """What an entity says beyond its curve: thickness, width."""
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
    sweep = (last - first) % 360.0 or 360.0
    return [_circular_arc(entity, math.radians(first % 360.0), math.radians(sweep))]


def _circular_arc(entity: Any, start: float, sweep: float) -> Conic:
    """A circular arc of `sweep` radians."""
    axes = ocs_axes(_xyz(entity.dxf.extrusion))
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
    if math.isclose(sweep, 0.0, abs_tol=1e-9) or math.isclose(sweep, math.tau, abs_tol=1e-9):
        sweep = math.tau
    return [Conic.part(_xyz(entity.dxf.center), major, minor, first, sweep)]


def _lwpolyline(entity: LWPolyline) -> list[Primitive]:
    corners = [(x, y, bulge) for x, y, bulge in entity.get_points("xyb")]
    return _flat_polyline(corners, entity.closed, float(entity.dxf.elevation), entity.dxf.extrusion)


def _polyline(entity: Polyline) -> list[Primitive]:
    # Of a polyline smoothed by a spline only the smooth vertices lie on it.
    vertices = [v for v in entity.vertices if not v.dxf.flags & FRAME_CONTROL_POINT]
    if entity.is_3d_polyline:
        places = [_xyz(v.dxf.location) for v in vertices]
        return _require_pieces(_straights(places, entity.is_closed))
    elevation = _xyz(entity.dxf.elevation)[2]
    corners = [(v.dxf.location.x, v.dxf.location.y, v.dxf.get("bulge", 0.0)) for v in vertices]
    return _flat_polyline(corners, entity.is_closed, float(elevation), entity.dxf.extrusion)


FRAME_CONTROL_POINT: Final = 16
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
    largest = float(np.abs(bulges).max(initial=0.0))
    if largest > LARGEST_BULGE:
        raise ValueError(f"the bulge {largest:g} is a full circle through one point")
    chord = end - start
    sweep = 4.0 * np.arctan(np.abs(bulges))
    bent = sweep * np.linalg.norm(chord, axis=1) >= FLATTEST_BULGE
    b = np.where(bent, bulges, 1.0)
    centre = (start + end) / 2.0 + _turned_left(chord) * ((1.0 - b * b) / (4.0 * b))[:, None]
    u = start - centre
    return bent, centre, u, _turned_left(u) * np.sign(b)[:, None], sweep


def _turned_left(v: Floats) -> Floats:
    """Vectors (n, 3) turned to the left about z by a quarter."""
    return np.column_stack([-v[:, 1], v[:, 0], np.zeros(len(v))])


LARGEST_BULGE: Final = 1e6
"""Beyond it start and end of the arc cannot be told apart."""

FLATTEST_BULGE: Final = 1e-9
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
    if len(fit) and entity.closed and not (fit[0] == fit[-1]).all():
        fit = np.vstack([fit, fit[:1]])
    if len(fit) < FEWEST_FIT_POINTS:
        raise ValueError("it has neither control points nor fit points")
    if not np.isfinite(fit).all():
        raise ValueError("a fit point is not finite")
    if len(fit) == FEWEST_FIT_POINTS and not entity.dxf.hasattr("start_tangent"):
        return [Straight(fit[0], fit[1])]
    return [_fitted(entity, fit)]


def _fitted(entity: SplineEntity, fit: Floats) -> Spline:
    """Through the fit points, as CAD systems draw it: cubic, with the end tangents if given."""
    from ezdxf.math import Vec3, fit_points_to_cad_cv

    tangents = None
    if entity.dxf.hasattr("start_tangent") and entity.dxf.hasattr("end_tangent"):
        pair = [Vec3(entity.dxf.start_tangent), Vec3(entity.dxf.end_tangent)]
        if all(t.magnitude > 0 for t in pair):
            tangents = pair
    curve = fit_points_to_cad_cv([Vec3(p) for p in fit], tangents)
    points = _points(curve.control_points)
    points[0], points[-1] = fit[0], fit[-1]  # where they are but for rounding
    return _nurbs(curve.degree, curve.knots(), points, ())


def _nurbs(degree: int, knots: Sequence[float], points: Floats, weights: Sequence[float]) -> Spline:
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
    return Spline(int(degree), knot, points, weight)


def _require_pieces(pieces: list[Primitive]) -> list[Primitive]:
    if not pieces:
        raise Degenerate("without length")
    return pieces


def _xyz(v: Any) -> Floats:
    from ezdxf.math import Vec3

    return np.array(Vec3(v).xyz)


def _points(vectors: Iterable[ArrayLike]) -> Floats:
    return np.array([tuple(v) for v in vectors], dtype=np.float64).reshape(-1, 3)  # type: ignore[arg-type]


STATED_ATTRIBUTES: Final[dict[str, tuple[str, ...]]] = {
    "LINE": ("start", "end"),
    "ARC": ("center", "radius", "start_angle", "end_angle"),
    "CIRCLE": ("center", "radius"),
    "ELLIPSE": ("center", "major_axis", "ratio", "start_param", "end_param"),
    "POINT": ("location",),
    "INSERT": ("name", "insert"),
}
"""What an entity has to state itself: with a default instead, a robot would go elsewhere."""

PRIMITIVE_READERS: Final[dict[str, Callable[[Any], list[Primitive]]]] = {
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
