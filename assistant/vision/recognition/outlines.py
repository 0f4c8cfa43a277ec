"""Objects that are known by their outlines, lying on a plane, in a picture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.recognition.edges import (
    CORNER_CLEARANCE,
    SAMPLE_SPACING,
    OutlineSamples,
    measure_edges,
    sample_outline,
)
from assistant.vision.recognition.estimating import Plane, PoseEstimate, fit_pose
from assistant.vision.recognition.judging import (
    OutlineSupport,
    face_appearance,
    inner_points,
    judge_outline,
    points_in_ring,
)
from assistant.vision.recognition.moments import ContourMoments, contour_moments
from assistant.vision.recognition.objects import KnownObject, Outline
from assistant.vision.recognition.pairs import Contour, PairTable, PlanePose, sample_contour
from assistant.vision.recognition.photo import Photo, signed_area
from assistant.vision.recognition.symmetry import near_symmetry_of, outline_centre

if TYPE_CHECKING:
    from types import ModuleType

LEAST_SUPPORT: Final = 0.45
"""Part of an outline that has to be supported by edges, less twice what speaks against it."""
SUPPORT_TO_TRY_TURNS: Final = 0.4
"""Part of an outline that is supported from which other turns of it are looked at as well."""
MOST_CONTRADICTED: Final = 0.08
"""Part of an outline that a picture may contradict."""
MOST_EMPTY: Final = 0.06
"""Part of the face at which there may be nothing."""
LEAST_INSIDE: Final = 0.5
"""Part of the face that shows one colour."""
LEAST_INSIDE_AT_START: Final = 0.4
"""The same, before an outline is brought onto its edges."""
LEAST_ON_CONTOUR: Final = 0.36
"""Part of an outline that lies on a contour of the picture before it is looked at closer."""
EDGE_REACH: Final = 6.0
"""Pixels from where the contour put an outline in which its edges are looked for."""
LEAST_OWN_EDGES: Final = 0.8
"""Part of the supported edges of an object that no other one has before."""
RIVAL_CONFIDENCE: Final = 0.03
"""Of confidence, within which two ways to lie are not told apart."""
POSES_TRIED: Final = 3
"""Poses of an object in a region that are looked at closely."""
COVERED_EDGE: Final = 0.7
"""Part of a region's edge that lies on faces which are known already, from which it is left out."""
FEWEST_SAMPLES: Final = 24
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
        return confidence_of(self.judged)


def confidence_of(judged: OutlineSupport) -> float:
    """Part of the outline that is seen, less twice what speaks against it."""
    return max(judged.supported - 2.0 * judged.contradicted, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class OutlineShape:
    """What is worked out once of an object with an outline. nearly: in how many ways it looks
    nearly the same. inner: (n, 3) places inside of it.
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
    """What lies on the plane with a known outline, each place of the picture claimed once.

    faces: polygons (n, 2) of pixels in which everything is known already.
    """
    possible: list[OutlineFound] = []
    for rings in photo.regions if shapes else ():
        if any(points_in_ring(face, rings[0]).mean() > COVERED_EDGE for face in faces):
            continue
        by_height: dict[float, PlaneRegion | None] = {}
        for shape in shapes:
            height = shape.object.height
            if height not in by_height:
                by_height[height] = PlaneRegion.of(cv, photo, rings, plane, height)
            region = by_height[height]
            if region is None or region.moments.area < 0.3 * shape.moments.area:
                continue
            possible += _find_shape(cv, photo, shape, region, plane)
    return _without_shared_edges(possible)


@dataclass(frozen=True, slots=True, eq=False)
class PlaneRegion:
    """A region of the picture in the plane of a face. scale: mm a pixel."""

    contour: Contour
    moments: ContourMoments
    scale: float

    @staticmethod
    def of(
        cv: ModuleType, photo: Photo, rings: tuple[Floats, ...], plane: Plane, height: float
    ) -> PlaneRegion | None:
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
        return PlaneRegion(sample_contour(tuple(flat)), found, scale)


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
    cv: ModuleType, photo: Photo, shape: OutlineShape, region: PlaneRegion, plane: Plane
) -> Iterator[OutlineFound]:
    """Poses of one object in one region that the picture agrees with."""
    settled = [shape.pairs.settled(region.contour, one) for one in _poses_by_moments(shape, region)]
    if not any(share > 0.9 for _, share in settled):
        voted = shape.pairs.poses(region.contour)
        settled += [shape.pairs.settled(region.contour, one) for one in voted]
    tried: list[PlanePose] = []
    for pose, share in sorted(settled, key=lambda one: -one[1]):
        if len(tried) >= POSES_TRIED * shape.nearly:
            return
        if share < LEAST_ON_CONTOUR or any(_same_pose(pose, one, shape) for one in tried):
            continue
        first, *others = _turned_ways(shape, pose)
        tried += [first, *others]
        seen = [_fit_outline(cv, photo, shape, first, region, plane)]
        if seen[0] is None or seen[0].judged.supported < SUPPORT_TO_TRY_TURNS:
            continue
        seen += [_fit_outline(cv, photo, shape, one, region, plane) for one in others]
        agreed = (one for one in seen if one is not None and _agrees(one.judged))
        found = sorted(agreed, key=lambda one: -one.confidence)
        if found:
            close = len(found) > 1 and found[1].confidence > found[0].confidence - RIVAL_CONFIDENCE
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


def _poses_by_moments(shape: OutlineShape, region: PlaneRegion) -> list[PlanePose]:
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
    region: PlaneRegion,
    plane: Plane,
) -> OutlineFound | None:
    known = shape.object
    assert known.outline is not None
    turn = rotations.about((0.0, 0.0, 1.0), np.degrees(flat.turn))
    pose = plane.pose @ Pose.of(np.array([flat.x, flat.y, known.height]), rotations.canonical(turn))
    face = face_appearance(photo, shape.inner, pose)
    if face.alike < LEAST_INSIDE_AT_START or face.empty > 3.0 * MOST_EMPTY:
        return None
    samples = sample_outline(
        known.outline, SAMPLE_SPACING * region.scale, CORNER_CLEARANCE * region.scale
    )
    if len(samples) < FEWEST_SAMPLES:
        return None
    estimate = fit_pose(
        pose,
        [measure_edges(cv, photo, samples, EDGE_REACH, known.height)],
        plane,
        known.height,
        any_turn=known.symmetry == 0,
    )
    if estimate is None:
        return None
    judged = judge_outline(cv, photo, shape.inner, samples, estimate.pose)
    return OutlineFound(known, estimate, judged, samples)


def _agrees(judged: OutlineSupport) -> bool:
    """Whether a picture shows enough of an outline, and little that speaks against it."""
    return (
        confidence_of(judged) >= LEAST_SUPPORT
        and judged.contradicted <= MOST_CONTRADICTED
        and judged.empty <= MOST_EMPTY
        and judged.inside >= LEAST_INSIDE
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
            free * one.judged.supported < LEAST_SUPPORT * LEAST_OWN_EDGES
            or free < LEAST_OWN_EDGES - 0.2
        ):
            kept = [replace(k, doubtful=k.doubtful or _rivals(k, one)) for k in kept]
            continue
        kept.append(one)
        taken = np.concatenate([taken, own])
    return kept


def _rivals(kept: OutlineFound, other: OutlineFound) -> bool:
    """Whether another pose of the same object at the same place is about as likely."""
    if kept.object is not other.object or kept.object.symmetry != 1:
        return False
    if other.confidence < kept.confidence - RIVAL_CONFIDENCE:
        return False
    points = kept.samples.points[::8]
    one, two = kept.estimate.pose.moved(points), other.estimate.pose.moved(points)
    away = np.linalg.norm(one - two, axis=1)
    size = float(np.ptp(points, axis=0).max())
    return bool(away.max() > 0.03 * size and np.linalg.norm((one - two).mean(axis=0)) < 0.3 * size)


def _exact_confidence(one: OutlineFound) -> float:
    return one.confidence * float(one.judged.held.sum())
