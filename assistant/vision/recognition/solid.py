"""A thing that is not flat, as two cameras show it: marks with their places in space."""

from __future__ import annotations

from collections.abc import Sequence
from types import ModuleType
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import Refused
from assistant.vision.cameras.triangulating import triangulate
from assistant.vision.recognition.estimating import Plane
from assistant.vision.recognition.keypoints import Descriptors, Keypoints, find_keypoints
from assistant.vision.recognition.objects import KnownObject, Texture
from assistant.vision.recognition.photo import analyse_picture
from assistant.vision.recognition.rules import NO_TEXTURE, NOT_TWO_CAMERAS
from assistant.vision.recognition.shown import FEWEST_MARKS, LearntObject, ObjectView

MUTUAL_RATIO: Final = 0.85
"""Distance to the nearest descriptor by that to the next one, at most."""
MOST_KEYPOINT_RESIDUAL: Final = 1.0
"""Pixels that a mark may leave in both pictures."""
MOST_POSITION_SIGMA: Final = 1.5
"""mm, one sigma, that the place of a mark may be unsure by."""
MOST_BELOW_PLANE: Final = 2.0
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
        good = (located.residuals < MOST_KEYPOINT_RESIDUAL) & (local[:, 2] > -MOST_BELOW_PLANE)
        sure = np.linalg.eigvalsh(np.nan_to_num(located.covariances, nan=1e6))[:, -1]
        good &= sure < MOST_POSITION_SIGMA**2
    if good.sum() < FEWEST_MARKS:
        raise Refused(NO_TEXTURE(path=one.name, count=int(good.sum()), least=FEWEST_MARKS))
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
        if m.distance < MUTUAL_RATIO * n.distance and back[m.trainIdx] == m.queryIdx
    ]
    rows = np.array(pairs, dtype=np.intp).reshape(-1, 2)
    return rows[:, 0], rows[:, 1]
