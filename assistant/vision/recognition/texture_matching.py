"""Recognise objects by their textures, anywhere in a picture.

Keypoints are SIFT (Lowe, 2004) as OpenCV has it, their descriptors with square roots of their
parts (Arandjelović and Zisserman, 2012). A face that is learnt is also drawn as seen from aside
(Morel and Yu, ASIFT, 2009). The pose that most keypoints agree on (RANSAC) is refined, and the face
is compared with the picture cell by cell.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.recognition.known_objects import KnownObject, Texture
from assistant.vision.recognition.outline_edges import points_in_ring
from assistant.vision.recognition.photo import Photo
from assistant.vision.recognition.pose_estimation import (
    Plane,
    PoseEstimate,
    fit_pose,
    measure_points,
)

if TYPE_CHECKING:
    from types import ModuleType


_MOST_KEYPOINTS: Final = 4000
"""Largest number of keypoints of a picture in which objects are searched."""
_MOST_LEARNT_KEYPOINTS: Final = 700
"""Keypoints of one look at a face that is learnt."""
_NEAREST_RATIO: Final = 0.82
"""Distance to the nearest descriptor by that to the nearest one of another place, at most."""
_FARTHEST_DESCRIPTOR: Final = 180.0
"""Distance of descriptors that are of one thing: of 512 between those that share nothing."""
_LEARNT_TILTS: Final = ((1.0, 0.0), (1.6, 0.0), (1.6, 45.0), (1.6, 90.0), (1.6, 135.0))
"""Shortening of a face in an oblique view, and the direction of the shortening."""

Grey = NDArray[np.uint8]
Descriptors = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Keypoints:
    """pixels: (n, 2); descriptors: (n, 128); sizes: (n,) pixels across what each one describes."""

    pixels: Floats
    descriptors: Descriptors
    sizes: Floats

    def __len__(self) -> int:
        return len(self.pixels)


def find_keypoints(
    cv: ModuleType, grey: Grey, most: int = _MOST_KEYPOINTS, mask: Grey | None = None
) -> Keypoints:
    """Find the keypoints of a picture (h, w) of grey levels; mask: the searched part."""
    points, found = cv.SIFT_create(
        nfeatures=most, contrastThreshold=0.02, enable_precise_upscale=True
    ).detectAndCompute(grey, mask)
    if not points:
        return Keypoints(np.zeros((0, 2)), np.zeros((0, 128), np.uint8), np.zeros(0))
    rooted = np.sqrt(found / np.maximum(found.sum(axis=1, keepdims=True), 1e-9))
    return Keypoints(
        np.array([p.pt for p in points], dtype=np.float64),
        np.clip(np.rint(512.0 * rooted), 0, 255).astype(np.uint8),
        np.array([p.size for p in points], dtype=np.float64),
    )


def face_keypoints(cv: ModuleType, grey: Grey) -> Keypoints:
    """Find the keypoints of a flat face, including those of oblique views; in pixels of the
    face.
    """
    looks = [
        _to_face_pixels(find_keypoints(cv, one, _MOST_LEARNT_KEYPOINTS, mask), turned)
        for one, mask, turned in _tilted_faces(cv, grey)
    ]
    return Keypoints(
        np.concatenate([one.pixels for one in looks]),
        np.concatenate([one.descriptors for one in looks]),
        np.concatenate([one.sizes for one in looks]),
    )


def _tilted_faces(cv: ModuleType, grey: Grey) -> Iterator[tuple[Grey, Grey | None, Floats]]:
    """The face as it looks from aside, where it is in that picture, and the map (2, 3) to it."""
    height, width = grey.shape
    for tilt, along in _LEARNT_TILTS:
        if tilt == 1.0:
            yield grey, None, np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
            continue
        c, s = np.cos(np.radians(along)), np.sin(np.radians(along))
        turn = np.array([[c, s], [-s, c]])
        map = np.diag([1.0 / tilt, 1.0]) @ turn
        corners = np.array([[0, 0], [width, 0], [width, height], [0, height]]) @ map.T
        low, high = corners.min(axis=0), corners.max(axis=0)
        size = tuple(int(v) for v in np.ceil(high - low))
        whole = np.column_stack([map, -low])
        # What is shortened must not alias.
        sigma = 0.8 * np.sqrt(tilt**2 - 1.0)
        turned = cv.GaussianBlur(grey, (0, 0), sigma / 2.0)
        seen = cv.warpAffine(turned, whole, size, borderMode=cv.BORDER_REPLICATE)
        mask = cv.warpAffine(np.full_like(grey, 255), whole, size)
        yield seen, cv.erode(mask, np.ones((5, 5), np.uint8)), whole


def _to_face_pixels(found: Keypoints, map: Floats) -> Keypoints:
    """Pixels in the face itself."""
    pixels = np.linalg.solve(map[:, :2], (found.pixels - map[:, 2]).T).T
    return Keypoints(np.asarray(pixels, dtype=np.float64), found.descriptors, found.sizes)


def match_keypoints(
    cv: ModuleType, seen: Keypoints, known: Descriptors, owners: Rows, places: Floats
) -> tuple[Rows, Rows]:
    """Rows of `seen` and the rows of `known` that look like them.

    owners: (m,) number of the object of each known descriptor; places: (m, 3) mm where it is on
    it. A look at the same place from elsewhere is no rival: the nearest of another object or of
    another place of the same one is.
    """
    if not len(seen) or len(known) < 2:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    nearest = min(2 * len(_LEARNT_TILTS), len(known))
    matcher = cv.FlannBasedMatcher({"algorithm": 1, "trees": 4}, {"checks": 160})
    cv.setRNGSeed(1)
    found = matcher.knnMatch(seen.descriptors.astype(np.float32), known.astype(np.float32), nearest)
    at = np.array([[m.trainIdx for m in row] + [-1] * (nearest - len(row)) for row in found])
    gap = np.array([[m.distance for m in row] + [np.inf] * (nearest - len(row)) for row in found])
    best = at[:, 0]
    spread = np.array([np.ptp(places[owners == o], axis=0).max() for o in range(owners.max() + 1)])
    away = np.linalg.norm(places[at] - places[best][:, None], axis=2)
    rival = (owners[at] != owners[best][:, None]) | (away > 0.03 * spread[owners[best]][:, None])
    second = np.where(rival, gap, np.inf).min(axis=1)
    second = np.where(np.isfinite(second), second, gap[:, -1] * 1.02)
    good = (gap[:, 0] < _NEAREST_RATIO * second) & (gap[:, 0] < _FARTHEST_DESCRIPTOR)
    return np.nonzero(good)[0], best[good]


_FEWEST_KEYPOINTS: Final = 9
"""Keypoints that agree on a pose."""
_MOST_REPROJECTION_ERROR: Final = 4.0
"""Pixels that a keypoint may be off the pose that others agree on."""
_RANSAC_ROUNDS: Final = 2000
_FACE_CELLS: Final = 6
"""A face is compared with the picture in so many cells along each side."""
_LEAST_CORRELATION: Final = 0.6
"""Correlation of a cell of the face with the picture from which it is the same."""
_PLAIN_CELL_SIGMA: Final = 4.0
"""Grey levels, one sigma, below which a cell has no texture to compare."""
_LEAST_MATCHING_CELLS: Final = 0.45
"""Part of the cells that have to be the same."""
_SURE_KEYPOINTS: Final = 30.0
"""Keypoints that agree on the pose of what is not flat, from which nobody doubts it."""
_MOST_OF_KIND: Final = 6
"""Largest number of objects of one kind searched in a picture."""
_LYING_SIGMAS: Final = 4.0
"""Sigmas that an object on the plane may seem to be off it, beside mm and degrees of
`_LYING_TOLERANCE`."""
_LYING_TOLERANCE: Final = (2.0, 2.0)
_FLIPPED_RATIO: Final = 1.5
"""Factor by which the other pose of a flat face, which looks nearly the same, must fit worse."""


@dataclass(frozen=True, slots=True, eq=False)
class TextureFound:
    """An object where a picture shows its texture. confidence: part of the face that looks like
    it; of what is not flat, by how many keypoints agree. lying: on the plane. doubtful: a pose
    that is tilted the other way fits about as well.
    """

    object: KnownObject
    estimate: PoseEstimate
    confidence: float
    points: Floats
    pixels: Floats
    lying: bool
    doubtful: bool


@dataclass(frozen=True, slots=True, eq=False)
class TextureIndex:
    """The keypoints of all objects with textures, to be looked for together."""

    objects: tuple[KnownObject, ...]
    descriptors: Any
    points: Floats
    owners: Rows

    @staticmethod
    def of(objects: Sequence[KnownObject]) -> TextureIndex | None:
        textured = tuple(one for one in objects if one.texture is not None)
        if not textured:
            return None
        textures = [one.texture for one in textured if one.texture is not None]
        return TextureIndex(
            textured,
            np.concatenate([one.descriptors for one in textures]),
            np.concatenate([one.points for one in textures]),
            np.repeat(np.arange(len(textures)), [len(one.points) for one in textures]),
        )


def find_textures(
    cv: ModuleType, photo: Photo, marks: TextureIndex, plane: Plane | None
) -> list[TextureFound]:
    """Objects whose textures a picture shows; several of one kind one after the other."""
    seen = find_keypoints(cv, cv.cvtColor(photo.picture, cv.COLOR_BGR2GRAY))
    here, there = match_keypoints(cv, seen, marks.descriptors, marks.owners, marks.points)
    found: list[TextureFound] = []
    for number, known in enumerate(marks.objects):
        rows = np.nonzero(marks.owners[there] == number)[0]
        found += _find_object(cv, photo, known, seen, here[rows], marks.points[there[rows]], plane)
    return found


def _find_object(
    cv: ModuleType,
    photo: Photo,
    known: KnownObject,
    seen: Keypoints,
    here: Rows,
    points: Floats,
    plane: Plane | None,
) -> Iterator[TextureFound]:
    left, before = np.ones(len(here), dtype=np.bool_), list[TextureFound]()
    for _ in range(_MOST_OF_KIND):
        if left.sum() < _FEWEST_KEYPOINTS:
            return
        pixels = seen.pixels[here[left]]
        agreed = _consensus_pose(cv, photo.camera, points[left], pixels, known)
        if agreed is None:
            return
        pose, good = agreed
        rows = np.nonzero(left)[0]
        found = _refine_pose(cv, photo, known, pose, points[left][good], pixels[good], plane)
        # Those that nearly agree are of the same thing, and must not make a second one of it.
        near = np.linalg.norm(photo.camera.project(pose.moved(points[left])) - pixels, axis=1)
        left[rows[good]] = False
        left[rows[near < 4.0 * _MOST_REPROJECTION_ERROR]] = False
        if found is not None and not _on_another(photo.camera, found, before):
            before.append(found)
            yield found


def _on_another(camera: Camera, found: TextureFound, before: Sequence[TextureFound]) -> bool:
    """True if its middle is on a better seen object of the same kind: two objects cannot lie at one
    position.
    """
    texture = found.object.texture
    assert texture is not None
    if texture.size is None:
        return False
    x, y = np.array(texture.size) / 2.0
    corners = np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])
    middle = camera.project(np.array([found.estimate.pose.position]))
    rims = (camera.project(one.estimate.pose.moved(corners)) for one in before)
    return any(bool(points_in_ring(rim, middle)[0]) for rim in rims)


def _consensus_pose(
    cv: ModuleType, camera: Camera, points: Floats, pixels: Floats, known: KnownObject
) -> tuple[Pose, Truths] | None:
    """The pose that most keypoints agree on, and which do."""
    assert known.texture is not None
    straight = camera.lens.tangents(pixels)
    good = np.isfinite(straight).all(axis=1)
    if good.sum() < _FEWEST_KEYPOINTS:
        return None
    rows = np.nonzero(good)[0]
    limit = _MOST_REPROJECTION_ERROR / float(np.mean(camera.lens.focal))
    flat = known.texture.flat
    cv.setRNGSeed(1)
    if flat:
        _, mask = cv.findHomography(
            points[rows, :2],
            straight[rows],
            cv.RANSAC,
            limit,
            maxIters=_RANSAC_ROUNDS,
            confidence=0.999,
        )
        inliers = None if mask is None else np.nonzero(mask.ravel())[0]
    else:
        done, _, _, inliers = cv.solvePnPRansac(
            *(points[rows], straight[rows], np.eye(3), None),
            iterationsCount=_RANSAC_ROUNDS,
            reprojectionError=limit,
            flags=cv.SOLVEPNP_EPNP,
        )
        inliers = inliers.ravel() if done and inliers is not None else None
    if (
        inliers is None
        or len(np.unique(points[rows[inliers]].round(3), axis=0)) < _FEWEST_KEYPOINTS
    ):
        return None
    chosen = rows[inliers]
    poses = _perspective_poses(cv, camera, points[chosen], straight[chosen], flat)
    if not poses:
        return None
    mask = np.zeros(len(points), dtype=np.bool_)
    mask[chosen] = True
    return poses[0][0], mask


def _perspective_poses(
    cv: ModuleType, camera: Camera, points: Floats, straight: Floats, flat: bool
) -> list[tuple[Pose, float]]:
    """Poses in the world by perspective, the one that fits best first, with how many tangents it
    is off; a flat face has two.
    """
    method = cv.SOLVEPNP_IPPE if flat else cv.SOLVEPNP_SQPNP
    count, turns, moves, offs = cv.solvePnPGeneric(points, straight, np.eye(3), None, flags=method)
    found = []
    for turn, move, off in zip(turns, moves, np.ravel(offs), strict=False):
        matrix, _ = cv.Rodrigues(turn)
        if not np.isfinite(matrix).all() or move[2, 0] <= 0.0:
            continue
        local = Pose.of(move.ravel(), rotations.from_matrix(matrix))
        found.append((camera.pose @ local, float(off)))
    return sorted(found[:count], key=lambda one: one[1])


def _refine_pose(
    cv: ModuleType,
    photo: Photo,
    known: KnownObject,
    pose: Pose,
    points: Floats,
    pixels: Floats,
    plane: Plane | None,
) -> TextureFound | None:
    """The pose made exact, on the plane if it agrees with that, where the face is really there."""
    texture = known.texture
    assert texture is not None
    measure = measure_points(photo.camera, points, pixels)
    free = fit_pose(pose, [measure])
    doubtful, lying = False, False
    if texture.flat:
        poses = _perspective_poses(
            cv, photo.camera, points, photo.camera.lens.tangents(pixels), True
        )
        others = [fit_pose(one, [measure]) for one, _ in poses[1:]]
        doubtful = any(
            other is not None
            and free is not None
            and other.scatter < _FLIPPED_RATIO * free.scatter
            and _angle_between(other.pose, free.pose) > 3.0
            for other in others
        )
        if plane is not None:
            for start in (free, *others):
                if start is not None and lies_on_plane(start, plane, known.height):
                    laid = fit_pose(start.pose, [measure], plane, known.height)
                    if laid is not None:
                        free, lying, doubtful = laid, True, False
                        break
    if free is None:
        return None
    if texture.flat:
        confidence = _face_similarity(cv, photo, texture, free.pose)
    else:
        confidence = min(1.0, len(points) / _SURE_KEYPOINTS)
    if confidence < _LEAST_MATCHING_CELLS or _seen_from_behind(photo.camera, texture, free.pose):
        return None
    return TextureFound(known, free, confidence, points, pixels, lying, doubtful)


def _angle_between(one: Pose, other: Pose) -> float:
    return float(rotations.angle_between(np.array(one.quaternion), np.array(other.quaternion)))


def _seen_from_behind(camera: Camera, texture: Texture, pose: Pose) -> bool:
    """True if a flat face would be seen through its back."""
    out = rotations.rotate(np.array(pose.quaternion), np.array([0.0, 0.0, 1.0]))
    return texture.flat and float(out @ (np.array(camera.pose.position) - pose.position)) <= 0.0


def lies_on_plane(found: PoseEstimate, plane: Plane, height: float) -> bool:
    """True if a pose that was found without the plane may be one on it."""
    local = plane.pose.inverse() @ found.pose
    up = rotations.rotate(np.array(local.quaternion), np.array([0.0, 0.0, 1.0]))
    tilt = float(np.degrees(np.arccos(np.clip(up[2], -1.0, 1.0))))
    off = abs(local.position[2] - height)
    return (
        off <= _LYING_TOLERANCE[0] + _LYING_SIGMAS * found.sigma_mm
        and tilt <= _LYING_TOLERANCE[1] + _LYING_SIGMAS * found.sigma_deg
    )


def _face_similarity(cv: ModuleType, photo: Photo, texture: Texture, pose: Pose) -> float:
    """Part of a flat face, 0 to 1, that looks in the picture as it was shown.

    The picture is drawn as the face would be seen from straight above; correlations of cells do not
    mind light.
    """
    face = texture.picture
    assert face is not None and texture.size is not None
    height, width = face.shape
    wide, high = texture.size
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    places = np.column_stack([(u.ravel() - 0.5) * wide, (0.5 - v.ravel()) * high, 0.0 * u.ravel()])
    pixels = photo.camera.project(pose.moved(places))
    grey = cv.cvtColor(photo.smooth, cv.COLOR_BGR2GRAY)
    grid = np.nan_to_num(pixels, nan=-10.0).astype(np.float32).reshape(height, width, 2)
    seen = cv.remap(grey, grid[..., 0], grid[..., 1], cv.INTER_LINEAR)
    inside = photo.camera.within(pixels).reshape(height, width)
    # Both as sharp as the less sharp of them: the face is shown larger than it is seen.
    sides = np.linalg.norm(grid[0, -1] - grid[0, 0]), np.linalg.norm(grid[-1, 0] - grid[0, 0])
    coarser = max(width / max(float(sides[0]), 1.0), height / max(float(sides[1]), 1.0), 1.0)
    blurred = cv.GaussianBlur(face.astype(np.float32), (0, 0), 0.8 * coarser)
    same, cells = 0, 0
    for rows in np.array_split(np.arange(height), _FACE_CELLS):
        for columns in np.array_split(np.arange(width), _FACE_CELLS):
            part = np.ix_(rows, columns)
            a, b = blurred[part].ravel(), seen[part].ravel()
            if a.std() < _PLAIN_CELL_SIGMA:
                continue
            cells += 1
            if inside[part].all() and b.std() > 0.25 * _PLAIN_CELL_SIGMA:
                same += float(np.corrcoef(a, b)[0, 1]) > _LEAST_CORRELATION
    return same / cells if cells else 0.0
