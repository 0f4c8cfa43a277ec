"""Recognise objects that lie on a plane by their outlines.

Candidate poses come from contour moments of regions and from pairs of contour points: two points
with normals have three numbers that no motion changes, their distance and the angle of each normal
to the line between them. A table holds which pairs of a known outline have about these numbers, and
every seen pair votes for positions of its first point on the outline, which survives hidden parts
(Drost, Ulrich, Navab and Ilic, Model globally, match locally, 2010, here in two dimensions). Each
candidate is fitted to the edges of the picture and judged by them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Ints, evenly_spaced
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.recognition.known_objects import KnownObject, Outline
from assistant.vision.recognition.outline_edges import (
    CORNER_CLEARANCE,
    SAMPLE_SPACING,
    OutlineSamples,
    OutlineSupport,
    face_appearance,
    inner_points,
    judge_outline,
    measure_edges,
    near_symmetry_of,
    outline_centre,
    points_in_ring,
    sample_outline,
)
from assistant.vision.recognition.photo import Photo, signed_area
from assistant.vision.recognition.pose_estimation import Plane, PoseEstimate, fit_pose

if TYPE_CHECKING:
    from types import ModuleType


_PAIRED_POINTS: Final = 96
"""Points of an outline that form pairs."""
_VOTING_POINTS: Final = 28
"""Points of a seen contour that vote."""
_PARTNER_POINTS: Final = 120
"""Points of a seen contour that they are paired with."""
_DISTANCE_STEPS: Final = 24
"""Steps of distances up to the largest of an outline."""
_ANGLE_STEPS: Final = 24
"""Steps of a full turn."""
_MOST_CANDIDATES: Final = 4
"""Poses of an outline in a contour that are examined closely."""
_CONTOUR_FIT_ROUNDS: Final = 10
_LEAST_NEAR_CONTOUR: Final = 0.3
"""Part of an outline that lies near to a contour where a pose that is voted for is worth more."""


@dataclass(frozen=True, slots=True)
class PlanePose:
    """A pose in a plane: a turn in radians about its normal, then a move in mm."""

    turn: float
    x: float
    y: float

    def moved(self, points: Floats) -> Floats:
        """Points (n, 2)."""
        return np.asarray(points @ self.matrix.T + [self.x, self.y])

    @property
    def matrix(self) -> Floats:
        c, s = np.cos(self.turn), np.sin(self.turn)
        return np.array([[c, -s], [s, c]])


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """A seen contour: points (n, 2) mm in a plane, normals (n, 2) out of what it is about."""

    points: Floats
    normals: Floats


def _sample_contour(rings: tuple[Floats, ...], count: int = _PARTNER_POINTS) -> Contour:
    """Points evenly spaced on closed rings (n, 2), material to their left."""
    lengths = [np.linalg.norm(np.roll(r, -1, axis=0) - r, axis=1) for r in rings]
    total = sum(float(one.sum()) for one in lengths)
    points, normals = list[Floats](), list[Floats]()
    for ring, sides in zip(rings, lengths, strict=True):
        ends = np.concatenate([[0.0], np.cumsum(sides)])
        here = max(6, round(count * ends[-1] / total))
        at = np.arange(here) * ends[-1] / here
        closed = np.vstack([ring, ring[:1]])
        reach = ends[-1] / here
        place = _points_along(closed, ends, at)
        ahead = _points_along(closed, ends, at + reach) - _points_along(closed, ends, at - reach)
        ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-12)
        points.append(place)
        normals.append(np.column_stack([ahead[:, 1], -ahead[:, 0]]))
    return Contour(np.concatenate(points), np.concatenate(normals))


def _points_along(closed: Floats, ends: Floats, at: Floats) -> Floats:
    at = np.mod(at, ends[-1])
    return np.column_stack([np.interp(at, ends, closed[:, 0]), np.interp(at, ends, closed[:, 1])])


@dataclass(frozen=True, slots=True, eq=False)
class PairTable:
    """The table of an outline. firsts: of each cell in turn the first points of its pairs, from
    starts[cell] on, counts[cell] of them.
    """

    contour: Contour
    largest: float
    firsts: Ints
    starts: Ints
    counts: Ints

    @staticmethod
    def of(outline: Outline) -> PairTable:
        perimeter = sum(
            float(np.linalg.norm(np.roll(r, -1, axis=0) - r, axis=1).sum()) for r in outline.rings
        )
        samples = sample_outline(outline, perimeter / _PAIRED_POINTS)
        contour = Contour(samples.points[:, :2], samples.normals[:, :2])
        count = len(contour.points)
        gaps = np.linalg.norm(contour.points[:, None] - contour.points[None], axis=2)
        largest = float(gaps.max()) * 1.0001
        first, second = np.nonzero(gaps > 0.04 * largest)
        cells, _ = _table_cells(contour, contour, first, second, largest)
        order = np.argsort(cells, kind="stable")
        counts = np.bincount(cells, minlength=_DISTANCE_STEPS * _ANGLE_STEPS * _ANGLE_STEPS)
        assert count
        starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        return PairTable(contour, largest, first[order], starts, counts)

    def poses(self, seen: Contour, kept: int = _MOST_CANDIDATES) -> list[PlanePose]:
        """Poses that the most pairs of a seen contour vote for, the best first."""
        count = len(seen.points)
        firsts = evenly_spaced(count, _VOTING_POINTS)
        one, other = (a.ravel() for a in np.meshgrid(firsts, np.arange(count), indexing="ij"))
        gap = np.linalg.norm(seen.points[one] - seen.points[other], axis=1)
        near = (gap > 0.04 * self.largest) & (gap < self.largest)
        one, other = one[near], other[near]
        if not len(one):
            return []
        cells, inside = _table_cells(seen, seen, one, other, self.largest)
        cells, one = cells[inside], one[inside]
        many = self.counts[cells]
        rows = np.repeat(np.arange(len(cells)), many)
        within = np.arange(len(rows)) - np.repeat(np.cumsum(many) - many, many)
        voted = self.firsts[self.starts[cells][rows] + within]
        model = len(self.contour.points)
        votes = np.bincount(one[rows] * model + voted, minlength=count * model)
        return self._best(seen, votes.reshape(count, model), kept)

    def _best(self, seen: Contour, votes: Ints, kept: int) -> list[PlanePose]:
        """The poses with most votes, those that are nearly the same counted together."""
        flat = votes.ravel()
        most = np.argpartition(flat, -min(12 * kept, len(flat)))[-12 * kept :]
        most = most[np.argsort(flat[most])[::-1]]
        at, on = np.unravel_index(most, votes.shape)
        weight = votes.ravel()[most].astype(np.float64)
        angles = np.arctan2(*seen.normals[at].T[::-1]) - np.arctan2(
            *self.contour.normals[on].T[::-1]
        )
        c, s = np.cos(angles), np.sin(angles)
        p = self.contour.points[on]
        place = seen.points[at] - np.column_stack(
            [c * p[:, 0] - s * p[:, 1], s * p[:, 0] + c * p[:, 1]]
        )
        middle = self.contour.points.mean(axis=0)
        centre = place + np.column_stack(
            [c * middle[0] - s * middle[1], s * middle[0] + c * middle[1]]
        )
        found: list[tuple[float, PlanePose]] = []
        left = weight > 0.0
        while left.any() and len(found) < kept:
            best = int(np.argmax(np.where(left, weight, -1.0)))
            turn = np.abs(np.angle(np.exp(1j * (angles - angles[best]))))
            gap = np.linalg.norm(centre - centre[best], axis=1)
            same = left & (turn < 0.25) & (gap < 0.08 * self.largest)
            total = float(weight[same].sum())
            found.append((total, PlanePose(float(angles[best]), *map(float, place[best]))))
            left &= ~same
        return [pose for _, pose in sorted(found, key=lambda one: -one[0])]

    def settled(self, seen: Contour, pose: PlanePose) -> tuple[PlanePose, float]:
        """A pose brought onto the seen contour, and the part of the outline that lies on it.

        Nearest points whose normals agree, those farther than a shrinking gap left out
        (iterated closest points, trimmed).
        """
        gap, share = 0.1 * self.largest, 0.0
        middle = self.contour.points.mean(axis=0)
        squares = (seen.points**2).sum(axis=1)
        for number in range(_CONTOUR_FIT_ROUNDS):
            some = slice(None, None, 1 if number >= _CONTOUR_FIT_ROUNDS - 3 else 3)
            points = pose.moved(self.contour.points[some])
            normals = self.contour.normals[some] @ pose.matrix.T
            away = squares - 2.0 * points @ seen.points.T + (points**2).sum(axis=1)[:, None]
            away[normals @ seen.normals.T < 0.8] = np.inf
            near = away.argmin(axis=1)
            good = away[np.arange(len(near)), near] < gap**2
            share = float(good.mean())
            if good.sum() < 8 or (share < _LEAST_NEAR_CONTOUR and number == 0):
                return pose, 0.0
            # Distances along the normals of what is seen: points slide along edges freely.
            across = seen.normals[near[good]]
            arm = points[good] - pose.moved(middle[None])[0]
            off = ((points[good] - seen.points[near[good]]) * across).sum(axis=1)
            by_turn = across[:, 1] * arm[:, 0] - across[:, 0] * arm[:, 1]
            rows = np.column_stack([across, by_turn])
            damped = rows.T @ rows + np.diag([1e-6, 1e-6, 1e-6 * self.largest**2]) * len(rows)
            step = -np.linalg.solve(damped, rows.T @ off)
            pose = _turned_pose(pose, middle, step)
            gap = max(gap * 0.75, 0.02 * self.largest)
        return pose, share


def _turned_pose(pose: PlanePose, middle: Floats, step: Floats) -> PlanePose:
    """Turned about where the middle is, and moved."""
    centre = pose.moved(middle[None])[0] + step[:2]
    turned = PlanePose(pose.turn + float(step[2]), 0.0, 0.0)
    x, y = centre - turned.moved(middle[None])[0]
    return PlanePose(turned.turn, float(x), float(y))


def _table_cells(
    one: Contour, other: Contour, first: Ints, second: Ints, largest: float
) -> tuple[Ints, Floats]:
    """Cells of pairs, and which of them lie within the table."""
    line = other.points[second] - one.points[first]
    gap = np.linalg.norm(line, axis=1)
    heading = np.arctan2(line[:, 1], line[:, 0])
    step = (gap / largest * _DISTANCE_STEPS).astype(np.int64)
    cells = step
    for normals in (one.normals[first], other.normals[second]):
        angle = np.arctan2(normals[:, 1], normals[:, 0]) - heading
        part = np.mod(np.rint(angle / (2.0 * np.pi) * _ANGLE_STEPS), _ANGLE_STEPS).astype(np.int64)
        cells = cells * _ANGLE_STEPS + part
    return np.where(step < _DISTANCE_STEPS, cells, 0), step < _DISTANCE_STEPS


_ROUND_DIFFERENCE: Final = 0.03
"""Difference of the two radii of gyration, as a part of the larger, below which they determine no
direction.
"""


@dataclass(frozen=True, slots=True, eq=False)
class ContourMoments:
    """Moments of a shape in a plane. area: mm²; middle: (2,) mm; radii: of gyration along both main
    axes, the longer one first; turn: radians of that axis, in [0, π); hu: the seven invariants of
    Hu (1962), which do not change with position, turn and size.
    """

    area: float
    middle: Floats
    radii: tuple[float, float]
    turn: float
    hu: Floats

    @property
    def round(self) -> bool:
        return self.radii[0] - self.radii[1] < _ROUND_DIFFERENCE * self.radii[0]

    def like(self, other: ContourMoments, part: float = 0.06) -> bool:
        """True if size and stretch differ by at most that part."""
        if abs(self.area - other.area) > 2.0 * part * other.area:
            return False
        pairs = zip(self.radii, other.radii, strict=True)
        return all(abs(one - two) <= part * two for one, two in pairs)


def contour_moments(cv: ModuleType, rings: tuple[Floats, ...]) -> ContourMoments | None:
    """Return the moments of closed polygons (n, 2), the first about the shape, the others about its
    holes.

    Computed by Green's formula over the polygons; None for a shape without area.
    """
    total: dict[str, float] = {}
    origin = rings[0].mean(axis=0)
    for number, ring in enumerate(rings):
        sign = -1.0 if number else 1.0
        for key, value in cv.moments((ring - origin).astype(np.float32)[:, None]).items():
            if key.startswith("m"):
                # OpenCV gives a polygon's area without the sign of its direction.
                total[key] = total.get(key, 0.0) + sign * value
    area = total["m00"]
    if area <= 0.0:
        return None
    x, y = total["m10"] / area, total["m01"] / area
    xx = total["m20"] / area - x * x
    yy = total["m02"] / area - y * y
    xy = total["m11"] / area - x * y
    (low, high), axes = np.linalg.eigh(np.array([[xx, xy], [xy, yy]]))
    turn = float(np.arctan2(axes[1, 1], axes[0, 1]) % np.pi)
    radii = (float(np.sqrt(max(high, 0.0))), float(np.sqrt(max(low, 0.0))))
    central = _central_moments(total, x, y)
    hu = np.asarray(cv.HuMoments({**total, **central})).ravel()
    return ContourMoments(area, origin + np.array([x, y]), radii, turn, hu)


def _central_moments(m: dict[str, float], x: float, y: float) -> dict[str, float]:
    """Central and normalised moments up to the third order, as OpenCV names them."""
    mu = {
        "mu20": m["m20"] - x * m["m10"],
        "mu11": m["m11"] - x * m["m01"],
        "mu02": m["m02"] - y * m["m01"],
        "mu30": m["m30"] - 3 * x * m["m20"] + 2 * x * x * m["m10"],
        "mu21": m["m21"] - 2 * x * m["m11"] - y * m["m20"] + 2 * x * x * m["m01"],
        "mu12": m["m12"] - 2 * y * m["m11"] - x * m["m02"] + 2 * y * y * m["m10"],
        "mu03": m["m03"] - 3 * y * m["m02"] + 2 * y * y * m["m01"],
    }
    nu = {
        "n" + key[1:]: value / m["m00"] ** (1.0 + (int(key[2]) + int(key[3])) / 2.0)
        for key, value in mu.items()
    }
    return {**mu, **nu}


_LEAST_SUPPORT: Final = 0.45
"""Part of an outline that has to be supported by edges, less twice what speaks against it."""
_SUPPORT_TO_TRY_TURNS: Final = 0.4
"""Supported part of an outline from which on other turns of it are tried as well."""
_MOST_CONTRADICTED: Final = 0.08
"""Part of an outline that a picture may contradict."""
_MOST_EMPTY: Final = 0.06
"""Part of the face at which there may be nothing."""
_LEAST_INSIDE: Final = 0.5
"""Part of the face that shows one colour."""
_LEAST_INSIDE_AT_START: Final = 0.4
"""The same, before an outline is brought onto its edges."""
_LEAST_ON_CONTOUR: Final = 0.36
"""Least part of an outline on a contour of the picture for a closer examination."""
_EDGE_REACH: Final = 6.0
"""Pixels from the outline placed by the contour within which its edges are searched."""
_LEAST_OWN_EDGES: Final = 0.8
"""Part of the supported edges of an object that no other one has before."""
_RIVAL_CONFIDENCE: Final = 0.03
"""Difference of confidence within which two poses are ambiguous."""
_POSES_TRIED: Final = 3
"""Poses of an object in a region that are examined closely."""
_COVERED_EDGE: Final = 0.7
"""Part of a region's edge that lies on faces which are known already, from which it is left out."""
_FEWEST_SAMPLES: Final = 24
"""Samples of an outline below which it is too small in a picture to be known by it."""


@dataclass(frozen=True, slots=True, eq=False)
class OutlineFound:
    """An object where a picture shows its outline. doubtful: turned another way, it fits about as
    well.
    """

    object: KnownObject
    estimate: PoseEstimate
    judged: OutlineSupport
    samples: OutlineSamples
    doubtful: bool = False

    @property
    def confidence(self) -> float:
        return _confidence_of(self.judged)


def _confidence_of(judged: OutlineSupport) -> float:
    """Part of the outline that is seen, less twice what speaks against it."""
    return max(judged.supported - 2.0 * judged.contradicted, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class OutlineShape:
    """Data of an object with an outline that are computed once. nearly: number of turns after which
    it looks nearly the same. inner: (n, 3) positions inside it.
    """

    object: KnownObject
    outline: Outline
    pairs: PairTable
    moments: ContourMoments
    nearly: int
    inner: Floats

    @staticmethod
    def of(cv: ModuleType, known: KnownObject) -> OutlineShape:
        assert known.outline is not None
        found = contour_moments(cv, known.outline.rings)
        assert found is not None  # outlines without area are refused when they are read
        nearly = near_symmetry_of(known.outline)
        if known.symmetry == nearly:
            nearly = 1
        pairs, inner = PairTable.of(known.outline), inner_points(known.outline)
        return OutlineShape(known, known.outline, pairs, found, max(nearly, 1), inner)


def find_outlines(
    cv: ModuleType,
    photo: Photo,
    shapes: Sequence[OutlineShape],
    plane: Plane,
    faces: Sequence[Floats] = (),
) -> list[OutlineFound]:
    """Find known outlines on the plane; each part of the picture is assigned once.

    faces: polygons (n, 2) of pixels with known objects.
    """
    possible: list[OutlineFound] = []
    for rings in photo.regions if shapes else ():
        if any(points_in_ring(face, rings[0]).mean() > _COVERED_EDGE for face in faces):
            continue
        by_height: dict[float, _PlaneRegion | None] = {}
        for shape in shapes:
            height = shape.object.height
            if height not in by_height:
                by_height[height] = _PlaneRegion.of(cv, photo, rings, plane, height)
            region = by_height[height]
            if region is None or region.moments.area < 0.3 * shape.moments.area:
                continue
            possible += _find_shape(cv, photo, shape, region, plane)
    return _without_shared_edges(possible)


@dataclass(frozen=True, slots=True, eq=False)
class _PlaneRegion:
    """A region of the picture in the plane of a face. scale: mm a pixel."""

    contour: Contour
    moments: ContourMoments
    scale: float

    @staticmethod
    def of(
        cv: ModuleType, photo: Photo, rings: tuple[Floats, ...], plane: Plane, height: float
    ) -> _PlaneRegion | None:
        """None where the picture does not show the plane."""
        flat = [pixels_on_plane(photo.camera, ring, plane, height) for ring in rings]
        if not flat or not np.isfinite(flat[0]).all():
            return None
        flat = [ring for ring in flat if np.isfinite(ring).all()]
        if signed_area(flat[0]) < 0.0:
            flat = [ring[::-1] for ring in flat]
        found = contour_moments(cv, tuple(flat))
        if found is None:
            return None
        pixels = abs(signed_area(rings[0]))
        scale = float(np.sqrt(abs(signed_area(flat[0])) / max(pixels, 1.0)))
        return _PlaneRegion(_sample_contour(tuple(flat)), found, scale)


def pixels_on_plane(camera: Camera, pixels: Floats, plane: Plane, height: float) -> Floats:
    """(n, 2) mm in the plane, `height` above it, that pixels (n, 2) show; NaN where they do not."""
    back = plane.pose.inverse()
    eye = back.moved(np.array([camera.pose.position]))[0]
    rays = rotations.rotate(np.array(back.quaternion), camera.directions(pixels))
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (height - eye[2]) / rays[:, 2]
        found = eye[:2] + far[:, None] * rays[:, :2]
    found[~(far > 0.0)] = np.nan
    return np.asarray(found)


def _find_shape(
    cv: ModuleType, photo: Photo, shape: OutlineShape, region: _PlaneRegion, plane: Plane
) -> Iterator[OutlineFound]:
    """Poses of one object in one region that the picture agrees with."""
    settled = [shape.pairs.settled(region.contour, one) for one in _poses_by_moments(shape, region)]
    if not any(share > 0.9 for _, share in settled):
        voted = shape.pairs.poses(region.contour)
        settled += [shape.pairs.settled(region.contour, one) for one in voted]
    tried: list[PlanePose] = []
    for pose, share in sorted(settled, key=lambda one: -one[1]):
        if len(tried) >= _POSES_TRIED * shape.nearly:
            return
        if share < _LEAST_ON_CONTOUR or any(_same_pose(pose, one, shape) for one in tried):
            continue
        first, *others = _turned_ways(shape, pose)
        tried += [first, *others]
        seen = [_fit_outline(cv, photo, shape, first, region, plane)]
        if seen[0] is None or seen[0].judged.supported < _SUPPORT_TO_TRY_TURNS:
            continue
        seen += [_fit_outline(cv, photo, shape, one, region, plane) for one in others]
        agreed = (one for one in seen if one is not None and _agrees(one.judged))
        found = sorted(agreed, key=lambda one: -one.confidence)
        if found:
            close = len(found) > 1 and found[1].confidence > found[0].confidence - _RIVAL_CONFIDENCE
            yield replace(found[0], doubtful=close)


def _turned_ways(shape: OutlineShape, pose: PlanePose) -> list[PlanePose]:
    """A pose, and those in which the shape looks nearly the same."""
    ways = [pose]
    middle = outline_centre(shape.outline)
    for number in range(1, shape.nearly):
        turn = pose.turn + 2.0 * np.pi * number / shape.nearly
        x, y = pose.moved(middle[None])[0] - PlanePose(turn, 0.0, 0.0).moved(middle[None])[0]
        ways.append(PlanePose(turn, float(x), float(y)))
    return ways


def _poses_by_moments(shape: OutlineShape, region: _PlaneRegion) -> list[PlanePose]:
    """Poses of a shape that is seen whole: its main axis along that of the region, either way."""
    if not region.moments.like(shape.moments):
        return []
    if shape.moments.round:
        turns = np.arange(4) * np.pi / 2.0
    else:
        turns = region.moments.turn - shape.moments.turn + np.array([0.0, np.pi])
    found = []
    for turn in turns:
        x, y = (
            region.moments.middle
            - PlanePose(float(turn), 0.0, 0.0).moved(shape.moments.middle[None])[0]
        )
        found.append(PlanePose(float(turn), float(x), float(y)))
    return found


def _same_pose(one: PlanePose, other: PlanePose, shape: OutlineShape) -> bool:
    points = shape.pairs.contour.points[::8]
    away = np.linalg.norm(one.moved(points) - other.moved(points), axis=1)
    return bool(away.max() < 0.03 * shape.pairs.largest)


def _fit_outline(
    cv: ModuleType,
    photo: Photo,
    shape: OutlineShape,
    flat: PlanePose,
    region: _PlaneRegion,
    plane: Plane,
) -> OutlineFound | None:
    known = shape.object
    assert known.outline is not None
    turn = rotations.about((0.0, 0.0, 1.0), np.degrees(flat.turn))
    pose = plane.pose @ Pose.of(np.array([flat.x, flat.y, known.height]), rotations.canonical(turn))
    face = face_appearance(photo, shape.inner, pose)
    if face.alike < _LEAST_INSIDE_AT_START or face.empty > 3.0 * _MOST_EMPTY:
        return None
    samples = sample_outline(
        known.outline, SAMPLE_SPACING * region.scale, CORNER_CLEARANCE * region.scale
    )
    if len(samples) < _FEWEST_SAMPLES:
        return None
    estimate = fit_pose(
        pose,
        [measure_edges(cv, photo, samples, _EDGE_REACH, known.height)],
        plane,
        known.height,
        any_turn=known.symmetry == 0,
    )
    if estimate is None:
        return None
    judged = judge_outline(cv, photo, shape.inner, samples, estimate.pose)
    return OutlineFound(known, estimate, judged, samples)


def _agrees(judged: OutlineSupport) -> bool:
    """True if a picture shows enough of an outline, and little that contradicts it."""
    return (
        _confidence_of(judged) >= _LEAST_SUPPORT
        and judged.contradicted <= _MOST_CONTRADICTED
        and judged.empty <= _MOST_EMPTY
        and judged.inside >= _LEAST_INSIDE
    )


def _without_shared_edges(possible: list[OutlineFound]) -> list[OutlineFound]:
    """Those that see most of themselves first; edges that one has are no edges of another."""
    kept: list[OutlineFound] = []
    taken = np.zeros((0, 2))
    for one in sorted(possible, key=lambda one: -_exact_confidence(one)):
        own = one.judged.edges.pixels[one.judged.held]
        away = np.full(len(own), np.inf)
        if len(taken):
            away = np.sqrt(((own[:, None] - taken[None]) ** 2).sum(axis=2).min(axis=1))
        free = float((away > 2.0).mean())
        if (
            free * one.judged.supported < _LEAST_SUPPORT * _LEAST_OWN_EDGES
            or free < _LEAST_OWN_EDGES - 0.2
        ):
            kept = [replace(k, doubtful=k.doubtful or _rivals(k, one)) for k in kept]
            continue
        kept.append(one)
        taken = np.concatenate([taken, own])
    return kept


def _rivals(kept: OutlineFound, other: OutlineFound) -> bool:
    """True if another pose of the same object at the same position is about as likely."""
    if kept.object is not other.object or kept.object.symmetry != 1:
        return False
    if other.confidence < kept.confidence - _RIVAL_CONFIDENCE:
        return False
    points = kept.samples.points[::8]
    one, two = kept.estimate.pose.moved(points), other.estimate.pose.moved(points)
    away = np.linalg.norm(one - two, axis=1)
    size = float(np.ptp(points, axis=0).max())
    return bool(away.max() > 0.03 * size and np.linalg.norm((one - two).mean(axis=0)) < 0.3 * size)


def _exact_confidence(one: OutlineFound) -> float:
    return one.confidence * float(one.judged.held.sum())
