"""Learn objects from pictures: a flat face, or a solid seen by two cameras.

A face comes from a picture of it alone, or lying on a plane before calibrated cameras, which gives
its outline too; further views add keypoints. A solid comes from one moment of two cameras, which
give its keypoints positions in space.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import ModuleType
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, triangulate
from assistant.vision.recognition.known_objects import KnownObject, Outline, Texture
from assistant.vision.recognition.outline_edges import (
    distances_to_ring,
    points_in_ring,
    symmetry_of,
)
from assistant.vision.recognition.outline_matching import pixels_on_plane
from assistant.vision.recognition.photo import Picture, analyse_picture, signed_area
from assistant.vision.recognition.pose_estimation import Plane
from assistant.vision.recognition.texture_matching import (
    Descriptors,
    Keypoints,
    face_keypoints,
    find_keypoints,
    match_keypoints,
)
from assistant.vision.rules import (
    NO_TEXTURE,
    NOT_TWO_CAMERAS,
    NOTHING_IN_PICTURE,
    REPEATED_VIEWS,
    UNRELATED_VIEW,
)

_LARGEST_FACE: Final = 400
"""Pixels of the longer side of a face that is kept."""
_FEWEST_MARKS: Final = 40
_FEWEST_AGREEING: Final = 15
"""Keypoints of another view that agree with the first one."""
_SAME_PICTURE_LEVELS: Final = 1.0
"""Grey levels that two views differ by, on average, if they are one picture."""
_RIM_SHARE: Final = 0.04
"""Part of the length of a thing from its edge within which marks are of what it lies on, too."""
_MOST_MARKS: Final = 6000


@dataclass(frozen=True, slots=True)
class ObjectView:
    """A picture with the name that messages use. camera: that took it, None of a picture of the
    face alone.
    """

    name: str
    picture: Picture
    camera: Camera | None = None


@dataclass(frozen=True, slots=True)
class LearntObject:
    object: KnownObject
    findings: tuple[Diagnostic, ...]


def learn_face(
    cv: ModuleType, name: str, views: Sequence[ObjectView], width: float, height: float = 0.0
) -> LearntObject:
    """A flat thing by pictures of its face: the first one is filled by it, `width` mm wide.

    Others show it as it may be seen, and add what they show of the same face. Its frame is in the
    middle of the face, x to the right of the first picture and y up. Raises Refused.
    """
    first, path = views[0].picture, views[0].name
    grey = _scaled_face(cv, cv.cvtColor(first, cv.COLOR_BGR2GRAY))
    tall = width * first.shape[0] / first.shape[1]
    marks = face_keypoints(cv, grey)
    if len(marks) < _FEWEST_MARKS:
        raise Refused(NO_TEXTURE(path=path, count=len(marks), least=_FEWEST_MARKS))
    texture = Texture(
        _positions_on_face(marks.pixels, grey, width, tall), marks.descriptors, grey, (width, tall)
    )
    findings = _repeated_views(views)
    for view in views[1:]:
        texture = _with_view(cv, texture, view)
    source = f"shown by {len(views)} view{'s' * (len(views) > 1)}"
    return LearntObject(KnownObject(name, None, texture, height, source=source), findings)


def learn_lying(
    cv: ModuleType, name: str, views: Sequence[ObjectView], plane: Plane, height: float = 0.0
) -> LearntObject:
    """A thing that lies alone on a plane in front of calibrated cameras, its face `height` above.

    Outline and marks come from the first picture, more marks from the others. Its frame is in the
    middle of the smallest rectangle about it, x along the longer side. Raises Refused.
    """
    view = views[0]
    assert view.camera is not None
    photo = analyse_picture(cv, view.camera, view.picture)
    if not photo.regions:
        raise Refused(NOTHING_IN_PICTURE(path=view.name))
    largest = photo.regions[int(np.argmax(photo.areas))]
    rings = [pixels_on_plane(view.camera, ring, plane, height) for ring in largest]
    rings = [ring for ring in rings if np.isfinite(ring).all()]
    if not rings:
        raise Refused(NOTHING_IN_PICTURE(path=view.name))
    if signed_area(rings[0]) < 0.0:
        rings = [ring[::-1] for ring in rings]
    (x, y), (wide, tall), turn = cv.minAreaRect(rings[0].astype(np.float32))
    if tall > wide:
        wide, tall, turn = tall, wide, turn + 90.0
    angle = np.radians(turn)
    back = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    inside = [(ring - [x, y]) @ back.T for ring in rings]
    outline = Outline(
        tuple(_simplified_ring(cv, ring, 0.4 * wide / _LARGEST_FACE) for ring in inside)
    )
    pose = plane.pose @ Pose.of(
        np.array([x, y, height]), rotations.canonical(rotations.about((0.0, 0.0, 1.0), turn))
    )
    grey = _rectified_face(cv, view.camera, view.picture, pose, wide, tall)
    marks = face_keypoints(cv, grey)
    texture = None
    places = _positions_on_face(marks.pixels, grey, wide, tall)
    own = _well_inside(outline, places, _RIM_SHARE * wide)
    if own.sum() >= _FEWEST_MARKS:
        texture = Texture(places[own], marks.descriptors[own], grey, (wide, tall))
        for other in views[1:]:
            texture = _with_view(cv, texture, other)
    known = KnownObject(name, outline, texture, height, symmetry_of(outline))
    source = f"shown by {len(views)} view{'s' * (len(views) > 1)} on the plane"
    return LearntObject(replace(known, source=source), _repeated_views(views))


def _well_inside(outline: Outline, places: Floats, clear: float) -> Truths:
    """(n,) which places are inside of an outline, so far from its edge: marks there are of it."""
    flat = places[:, :2]
    found = np.zeros(len(flat), dtype=np.bool_)
    for ring in outline.rings:
        found ^= points_in_ring(ring, flat)
    away = np.min([distances_to_ring(ring, flat) for ring in outline.rings], axis=0)
    return np.asarray(found & (away > clear))


def _scaled_face(cv: ModuleType, grey: Picture) -> Picture:
    part = _LARGEST_FACE / max(grey.shape)
    if part >= 1.0:
        return grey
    return np.asarray(cv.resize(grey, None, fx=part, fy=part, interpolation=cv.INTER_AREA))


def _positions_on_face(pixels: Floats, grey: Picture, wide: float, tall: float) -> Floats:
    """(n, 3) mm from the middle of a face of pixels (n, 2) of its picture."""
    height, width = grey.shape[:2]
    x = ((pixels[:, 0] + 0.5) / width - 0.5) * wide
    y = (0.5 - (pixels[:, 1] + 0.5) / height) * tall
    return np.column_stack([x, y, np.zeros(len(pixels))])


def _repeated_views(views: Sequence[ObjectView]) -> tuple[Diagnostic, ...]:
    """A warning where all views are one picture."""
    first = views[0].picture.astype(np.int16)
    others = [view.picture for view in views[1:]]
    same = [
        one.shape == first.shape and np.abs(one - first).mean() < _SAME_PICTURE_LEVELS
        for one in others
    ]
    return (REPEATED_VIEWS(path=views[0].name),) if others and all(same) else ()


def _with_view(cv: ModuleType, texture: Texture, view: ObjectView) -> Texture:
    """With the marks of another picture of the same face, through the map between both."""
    seen = find_keypoints(cv, cv.cvtColor(view.picture, cv.COLOR_BGR2GRAY))
    owners = np.zeros(len(texture.points), np.intp)
    here, there = match_keypoints(cv, seen, texture.descriptors, owners, texture.points)
    map, good = None, None
    if len(here) >= _FEWEST_AGREEING:
        cv.setRNGSeed(1)
        map, good = cv.findHomography(
            seen.pixels[here], texture.points[there, :2], cv.RANSAC, _most_keypoint_error(texture)
        )
    agreed = 0 if good is None else int(good.sum())
    if map is None or agreed < _FEWEST_AGREEING:
        raise Refused(UNRELATED_VIEW(path=view.name, count=agreed))
    places = cv.perspectiveTransform(seen.pixels[None], map)[0]
    assert texture.size is not None
    on = (np.abs(places) < np.array(texture.size) / 2.0).all(axis=1) & np.isfinite(places).all(
        axis=1
    )
    more = Keypoints(places[on], seen.descriptors[on], seen.sizes[on])
    points = np.column_stack([more.pixels, np.zeros(len(more))])
    room = max(_MOST_MARKS - len(texture.points), 0)
    return replace(
        texture,
        points=np.concatenate([texture.points, points[:room]]),
        descriptors=np.concatenate([texture.descriptors, more.descriptors[:room]]),
    )


def _most_keypoint_error(texture: Texture) -> float:
    """Mm that a mark may be off: one in a hundred of the face."""
    assert texture.size is not None
    return 0.01 * max(texture.size)


def _simplified_ring(cv: ModuleType, ring: Floats, off: float) -> Floats:
    """The polygon with fewer corners, `off` mm off it at most."""
    made = cv.approxPolyDP(ring.astype(np.float32)[:, None], off, True)
    return np.asarray(made[:, 0], dtype=np.float64)


def _rectified_face(
    cv: ModuleType, camera: Camera, picture: Picture, pose: Pose, wide: float, tall: float
) -> Picture:
    """The face as it is from straight above, in grey levels."""
    step = max(wide, tall) / _LARGEST_FACE
    width, height = max(round(wide / step), 16), max(round(tall / step), 16)
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    pixels = np.column_stack([u.ravel(), v.ravel()]).astype(np.float64)
    places = _positions_on_face(pixels, np.zeros((height, width), np.uint8), wide, tall)
    seen = camera.project(pose.moved(places)).astype(np.float32).reshape(height, width, 2)
    grey = cv.cvtColor(picture, cv.COLOR_BGR2GRAY)
    return np.asarray(cv.remap(grey, seen[..., 0], seen[..., 1], cv.INTER_CUBIC))


_MUTUAL_RATIO: Final = 0.85
"""Distance to the nearest descriptor by that to the next one, at most."""
_MOST_KEYPOINT_RESIDUAL: Final = 1.0
"""Pixels that a mark may leave in both pictures."""
_MOST_POSITION_SIGMA: Final = 1.5
"""mm, one sigma, that the place of a mark may be unsure by."""
_MOST_BELOW_PLANE: Final = 2.0
"""mm that a mark may seem to be below the plane."""


def learn_solid(
    cv: ModuleType, name: str, views: Sequence[ObjectView], plane: Plane
) -> LearntObject:
    """A thing that lies alone on a plane, by pictures of one moment of two cameras.

    Its frame is on the plane, below the middle of its marks, turned as the plane is. Raises Refused
    if the pictures are not of two cameras, or show too few marks that both see.
    """
    one = views[0]
    other = next((v for v in views if v.camera is not None and v.camera != one.camera), None)
    if one.camera is None or other is None or other.camera is None:
        raise Refused(NOT_TWO_CAMERAS(path=one.name), exit_status=2)
    seen = [_foreground_keypoints(cv, view) for view in (one, other)]
    first, second = _mutual_matches(cv, seen[0].descriptors, seen[1].descriptors)
    pixels = [seen[0].pixels[first], seen[1].pixels[second]]
    located = triangulate([one.camera, other.camera], pixels, 0.3)
    local = plane.pose.inverse().moved(np.nan_to_num(located.points))
    with np.errstate(invalid="ignore"):
        good = (located.residuals < _MOST_KEYPOINT_RESIDUAL) & (local[:, 2] > -_MOST_BELOW_PLANE)
        sure = np.linalg.eigvalsh(np.nan_to_num(located.covariances, nan=1e6))[:, -1]
        good &= sure < _MOST_POSITION_SIGMA**2
    if good.sum() < _FEWEST_MARKS:
        raise Refused(NO_TEXTURE(path=one.name, count=int(good.sum()), least=_FEWEST_MARKS))
    middle = np.median(local[good], axis=0)
    points: Floats = local[good] - [middle[0], middle[1], 0.0]
    descriptors = [seen[0].descriptors[first[good]], seen[1].descriptors[second[good]]]
    texture = Texture(np.concatenate([points, points]), np.concatenate(descriptors))
    source = "shown to two cameras as a solid"
    return LearntObject(KnownObject(name, None, texture, 0.0, source=source), ())


def _foreground_keypoints(cv: ModuleType, view: ObjectView) -> Keypoints:
    """Keypoints of what differs from the background."""
    assert view.camera is not None
    photo = analyse_picture(cv, view.camera, view.picture)
    mask = cv.dilate(photo.foreground.astype(np.uint8), np.ones((7, 7), np.uint8)) * 255
    return find_keypoints(cv, cv.cvtColor(view.picture, cv.COLOR_BGR2GRAY), mask=mask)


def _mutual_matches(cv: ModuleType, one: Descriptors, other: Descriptors) -> tuple[Rows, Rows]:
    """Rows of descriptors that are each other's nearest, and clearly so."""
    if len(one) < 2 or len(other) < 2:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    both = one.astype(np.float32), other.astype(np.float32)
    there = cv.BFMatcher().knnMatch(*both, 2)
    back = {m.queryIdx: m.trainIdx for (m,) in cv.BFMatcher().knnMatch(*both[::-1], 1)}
    pairs = [
        (m.queryIdx, m.trainIdx)
        for m, n in there
        if m.distance < _MUTUAL_RATIO * n.distance and back[m.trainIdx] == m.queryIdx
    ]
    rows = np.array(pairs, dtype=np.intp).reshape(-1, 2)
    return rows[:, 0], rows[:, 1]
