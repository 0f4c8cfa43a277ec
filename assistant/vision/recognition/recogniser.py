"""Recognise known objects in pictures of one moment: their poses, and how sure these are.

Objects are matched by outline and texture in each picture; what several cameras see of one object
gets one pose. Findings report what a program must not act on: cameras that disagree, two poses that
fit alike, a size that contradicts the plane.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import ModuleType
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.recognition.known_objects import KnownObject
from assistant.vision.recognition.object_library import Library
from assistant.vision.recognition.outline_edges import measure_edges, outline_centre
from assistant.vision.recognition.outline_matching import (
    OutlineFound,
    OutlineShape,
    find_outlines,
    pixels_on_plane,
)
from assistant.vision.recognition.photo import Photo, Picture, analyse_picture, signed_area
from assistant.vision.recognition.pose_estimation import (
    Measure,
    PixelErrors,
    Plane,
    PoseEstimate,
    SizeFit,
    fit_by_size,
    fit_pose,
    measure_points,
)
from assistant.vision.recognition.texture_matching import TextureIndex, find_textures, lies_on_plane
from assistant.vision.rules import (
    AMBIGUOUS_TILT,
    AMBIGUOUS_TURN,
    CONTRADICTED_SIZE,
    NOT_ON_PLANE,
    PLANE_NOT_SEEN,
    POSES_DISAGREE,
    UNKNOWN_OBJECT,
)

_LEVEL_PLANE: Final = Plane()
"""x and y of the world."""
_SAME_OBJECT_SHARE: Final = 0.5
"""Part of the shorter side of an object: what two cameras put nearer together is one, as two of a
kind would lie in each other."""
_SAME_OBJECT_SIGMAS: Final = 4.0
"""Added to that, of how sure both are."""
_DISAGREEING_SIGMAS: Final = 6.0
"""Sigmas, and mm below, from which cameras disagree."""
_DISAGREEING_MM: Final = 0.5
_SURE_CONFIDENCE: Final = 0.6
"""Part of an object that is seen, and agrees, from which nobody doubts that it is this one."""
_COVERED_SHARE: Final = 0.3
"""Part of a thing that known objects cover from which it is not unknown."""
_CONTRADICTING_SIZE: Final = (4.0, 0.5)
"""Sigmas, and percent of its size, by which an object on the plane looks larger or smaller than it
is: from there on its pose is wrong, or it is another object."""
_LEAST_UNKNOWN_AREA: Final = 0.1
"""Part of the area of the smallest known object below which a thing is not worth a word."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundObject:
    """An object that was found. name: NAME, NAME_2 … where several are there. estimate: its pose in
    the world with what is known of it. confidence: 0 to 1, that it is this object. cameras: that
    see it. rim: (n, 2) pixels about it in the picture of the first of them. larger: percent by
    which it looks larger than it is, if that contradicts the plane.
    """

    name: str
    object: KnownObject
    estimate: PoseEstimate
    confidence: float
    cameras: tuple[str, ...]
    rim: Floats
    larger: float | None = None

    @property
    def pose(self) -> Pose:
        return self.estimate.pose


@dataclass(frozen=True, slots=True)
class UnknownThing:
    """A thing that is not a known object: its middle on the plane, and its size in mm."""

    x: float
    y: float
    size: float


@dataclass(frozen=True, slots=True)
class Recognition:
    """Result of recognition in pictures. findings: errors concern results that must not be used."""

    found: tuple[FoundObject, ...]
    unknown: tuple[UnknownThing, ...]
    findings: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _CameraObject:
    """An object as one camera sees it."""

    object: KnownObject
    estimate: PoseEstimate
    confidence: float
    camera: str
    measure: Measure
    plane: Plane | None
    lying: bool
    doubtful: bool = False


class Recogniser:
    """A library made ready for looking; `see` may be asked for many pictures."""

    def __init__(self, cv: ModuleType, library: Library) -> None:
        self.cv: Final = cv
        objects = tuple(library.objects.values())
        self.shapes: Final = tuple(
            OutlineShape.of(cv, one)
            for one in objects
            if one.outline is not None and one.texture is None
        )
        self.marks: Final = TextureIndex.of(objects)

    def see(
        self,
        pictures: Mapping[str, Picture],
        cameras: Mapping[str, Camera],
        plane: Plane = _LEVEL_PLANE,
    ) -> Recognition:
        """Recognise objects in one picture of each of some cameras in the world.

        Objects with outlines lie on the plane; those with textures may be anywhere. Raises Refused
        if a camera does not see the plane.
        """
        photos = {
            name: analyse_picture(self.cv, cameras[name], picture)
            for name, picture in pictures.items()
        }
        for name in photos:
            _check_plane_seen(cameras[name], plane)
        ones = [one for photo in photos.values() for one in self._in_photo(photo, plane)]
        groups = _group_by_object(ones)
        findings: list[Diagnostic] = []
        joined = [_join_cameras(group, findings) for group in groups]
        kept = sorted((one for one in joined if one is not None), key=lambda f: -f[1].confidence)
        found = _numbered_objects(kept, photos)
        for one, (_, group) in zip(found, kept, strict=True):
            findings += _doubt_findings(one, group.one, plane)
        unknown = self._unknown(photos, found, plane)
        findings += [UNKNOWN_OBJECT(x=one.x, y=one.y, size=one.size) for one in unknown]
        return Recognition(tuple(found), tuple(unknown), tuple(findings))

    def _in_photo(self, photo: Photo, plane: Plane) -> list[_CameraObject]:
        cv, name = self.cv, photo.camera.name
        found: list[_CameraObject] = []
        faces: list[Floats] = []
        textures = [] if self.marks is None else find_textures(cv, photo, self.marks, plane)
        for texture in textures:
            measure = measure_points(photo.camera, texture.points, texture.pixels)
            found.append(
                _CameraObject(
                    *(texture.object, texture.estimate, texture.confidence, name, measure),
                    plane if texture.lying else None,
                    texture.lying,
                    texture.doubtful,
                )
            )
            face = photo.camera.project(texture.estimate.pose.moved(object_rim(texture.object)))
            faces += [face] if np.isfinite(face).all() else []
        for outline in find_outlines(cv, photo, self.shapes, plane, faces):
            measure = _outline_measure(cv, photo, outline)
            found.append(
                _CameraObject(
                    *(outline.object, outline.estimate, outline.confidence, name, measure),
                    plane,
                    lying=True,
                    doubtful=outline.doubtful,
                )
            )
        return found

    def _unknown(
        self, photos: Mapping[str, Photo], found: Sequence[FoundObject], plane: Plane
    ) -> list[UnknownThing]:
        """Things of the first picture that known objects do not cover."""
        photo = next(iter(photos.values()))
        height, width = photo.foreground.shape
        covered = np.zeros((height, width), np.uint8)
        for one in found:
            rim = photo.camera.project(one.pose.moved(object_rim(one.object)))
            if np.isfinite(rim).all():
                self.cv.fillPoly(covered, [np.rint(rim).astype(np.int32)], 1)
        sizes = [s.moments.area for s in self.shapes] + [
            float(np.prod(o.texture.size))
            for o in (self.marks.objects if self.marks else ())
            if o.texture is not None and o.texture.size is not None
        ]
        least = _LEAST_UNKNOWN_AREA * min(sizes, default=100.0)
        things: list[UnknownThing] = []
        pieces = self.cv.connectedComponents(photo.foreground.astype(np.uint8))[1]
        for rings in photo.regions[: photo.pieces]:
            u, v = np.rint(rings[0][0]).astype(int)
            near = pieces[max(v - 2, 0) : v + 3, max(u - 2, 0) : u + 3]
            number = int(near.max())
            if number == 0:
                continue
            mask = pieces == number
            if covered[mask].mean() > _COVERED_SHARE:
                continue
            flat = pixels_on_plane(photo.camera, rings[0], plane, 0.0)
            if not np.isfinite(flat).all() or abs(signed_area(flat)) < least:
                continue
            x, y = (flat.min(axis=0) + flat.max(axis=0)) / 2.0
            things.append(UnknownThing(float(x), float(y), float(np.ptp(flat, axis=0).max())))
        return things


def _check_plane_seen(camera: Camera, plane: Plane) -> None:
    """Raises Refused where the plane is behind a camera, or seen from below."""
    width, height = camera.lens.size
    grid = np.array([[u, v] for u in (0.25, 0.5, 0.75) for v in (0.25, 0.5, 0.75)])
    seen = pixels_on_plane(camera, grid * [width, height], plane, 0.0)
    above = plane.pose.inverse().moved(np.array([camera.pose.position]))[0, 2]
    if not np.isfinite(seen).all(axis=1).any() or above <= 0.0:
        raise Refused(PLANE_NOT_SEEN(camera=camera.name), exit_status=2)


def object_rim(known: KnownObject) -> Floats:
    """(n, 3) points about an object in its frame."""
    if known.outline is not None:
        ring = known.outline.rings[0]
        return np.column_stack([ring, np.zeros(len(ring))])
    assert known.texture is not None
    if known.texture.size is not None:
        x, y = np.array(known.texture.size) / 2.0
        return np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])
    low, high = known.texture.points.min(axis=0), known.texture.points.max(axis=0)
    (a, b, _), (c, e, top) = low, high
    return np.array([[a, b, top], [c, b, top], [c, e, top], [a, e, top]])


def face_centre(known: KnownObject) -> Floats:
    """(3,) the middle of its face, in its frame."""
    if known.outline is not None:
        return np.array([*outline_centre(known.outline), 0.0])
    return np.asarray(object_rim(known).mean(axis=0))


def _outline_measure(cv: ModuleType, photo: Photo, found: OutlineFound) -> Measure:
    """The edges near to where they were found, for whoever fits them with others."""

    def rows(pose: Pose) -> PixelErrors:
        return measure_edges(cv, photo, found.samples, 2.0, found.object.height)(pose)

    return rows


def _group_by_object(ones: Sequence[_CameraObject]) -> list[list[_CameraObject]]:
    """Group the sightings of one object by several cameras; one camera sees an object once."""
    groups: list[list[_CameraObject]] = []
    for one in sorted(ones, key=lambda one: -one.confidence):
        for group in groups:
            first = group[0]
            if first.object is not one.object:
                continue
            away = np.linalg.norm(_object_position(one) - _object_position(first))
            sure = np.hypot(one.estimate.sigma_mm, first.estimate.sigma_mm)
            size = float(np.ptp(object_rim(one.object)[:, :2], axis=0).min())
            if away < _SAME_OBJECT_SHARE * size + _SAME_OBJECT_SIGMAS * sure:
                if all(other.camera != one.camera for other in group):
                    group.append(one)
                break
        else:
            groups.append([one])
    return groups


def _object_position(one: _CameraObject) -> Floats:
    return np.asarray(one.estimate.pose.moved(face_centre(one.object)[None])[0])


@dataclass(frozen=True, slots=True, eq=False)
class _JoinedObject:
    one: _CameraObject
    cameras: tuple[str, ...]
    confidence: float
    size: SizeFit | None


def _join_cameras(
    group: Sequence[_CameraObject], findings: list[Diagnostic]
) -> tuple[PoseEstimate, _JoinedObject] | None:
    """One pose of what several cameras see; with a finding where they do not agree."""
    best = group[0]
    estimate, cameras = best.estimate, tuple(one.camera for one in group)
    confidence = 1.0 - float(np.prod([1.0 - min(one.confidence, 1.0) for one in group]))
    plane = best.plane if all(one.lying for one in group) else None
    measures, height = [one.measure for one in group], best.object.height
    any_turn = best.object.symmetry == 0
    if len(group) > 1:
        together = fit_pose(estimate.pose, measures, plane, height, any_turn=any_turn)
        if together is not None:
            estimate = together
        for one in group[1:]:
            off = _object_position(one) - _object_position(best)
            covariance = (one.estimate.covariance + best.estimate.covariance)[:3, :3]
            sigmas = float(np.sqrt(off @ np.linalg.solve(covariance, off)))
            mm = float(np.linalg.norm(off))
            if sigmas > _DISAGREEING_SIGMAS and mm > _DISAGREEING_MM:
                findings.append(POSES_DISAGREE(name=best.object.name, mm=mm, sigmas=sigmas))
        best = replace(best, doubtful=False)
    size = None
    if plane is not None:
        size = fit_by_size(estimate, measures, plane, height, any_turn=any_turn)
    return estimate, _JoinedObject(best, cameras, confidence, size)


def _numbered_objects(
    kept: Sequence[tuple[PoseEstimate, _JoinedObject]], photos: Mapping[str, Photo]
) -> list[FoundObject]:
    counts: dict[str, int] = {}
    found = []
    for estimate, joined in kept:
        known = joined.one.object
        counts[known.name] = counts.get(known.name, 0) + 1
        number = counts[known.name]
        name = known.name if number == 1 else f"{known.name}_{number}"
        settled = replace(estimate, pose=_with_least_turn(estimate.pose, known))
        photo = photos[joined.cameras[0]]
        rim = photo.camera.project(settled.pose.moved(object_rim(known)))
        confidence, larger = min(joined.confidence / _SURE_CONFIDENCE, 1.0), None
        if joined.size is not None:
            larger = _percent_larger(joined.size, settled.pose, photo.camera)
        if joined.size is not None and larger is not None:
            # Either the plane is elsewhere or the object has another size: both are possible.
            shift = joined.size.shift
            wider = settled.covariance + np.outer(shift, shift)
            settled = replace(settled, covariance=wider)
            confidence *= _CONTRADICTING_SIZE[0] / joined.size.sigmas
        found.append(FoundObject(name, known, settled, confidence, joined.cameras, rim, larger))
    return found


def _percent_larger(size: SizeFit, pose: Pose, camera: Camera) -> float | None:
    """Percent by which an object looks larger than on the plane; None where that may be noise."""
    away = float(np.linalg.norm(np.subtract(camera.pose.position, pose.position)))
    nearer = float(np.linalg.norm(camera.pose.position - (pose.position + size.shift[:3])))
    percent = 100.0 * (away / nearer - 1.0)
    wrong = size.sigmas > _CONTRADICTING_SIZE[0] and abs(percent) > _CONTRADICTING_SIZE[1]
    return percent if wrong else None


def _with_least_turn(pose: Pose, known: KnownObject) -> Pose:
    """Return the pose with the least turn among those in which the object looks the same."""
    if known.symmetry == 1 or known.outline is None:
        return pose
    middle = np.array([*outline_centre(known.outline), 0.0])
    ahead = rotations.rotate(np.array(pose.quaternion), np.array([1.0, 0.0, 0.0]))
    turn = float(np.degrees(np.arctan2(ahead[1], ahead[0])))
    if known.symmetry == 0:
        by = -turn
    else:
        step = 360.0 / known.symmetry
        by = -step * round(turn / step)
    about = rotations.canonical(rotations.about((0.0, 0.0, 1.0), by))
    turned = Pose.of(np.zeros(3), about)
    moved = middle - turned.moved(middle[None])[0]
    return pose @ Pose.of(moved, about)


def _doubt_findings(found: FoundObject, one: _CameraObject, plane: Plane) -> list[Diagnostic]:
    if found.larger is not None:
        mm, percent = found.estimate.sigma_mm, abs(found.larger)
        how = "larger" if found.larger > 0.0 else "smaller"
        return [CONTRADICTED_SIZE(name=found.name, percent=percent, how=how, mm=mm)]
    if one.doubtful:
        return [(AMBIGUOUS_TURN if one.object.texture is None else AMBIGUOUS_TILT)(name=found.name)]
    if one.lying or lies_on_plane(found.estimate, plane, found.object.height):
        return []
    local = plane.pose.inverse() @ found.pose
    up = rotations.rotate(np.array(local.quaternion), np.array([0.0, 0.0, 1.0]))
    tilt = float(np.degrees(np.arccos(np.clip(up[2], -1.0, 1.0))))
    above = local.position[2] - found.object.height
    return [NOT_ON_PLANE(name=found.name, mm=above, degrees=tilt)]
