"""Where a thing is, from the pixels of its points in one or several cameras."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths, all_of
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.triangulating import triangulate
from assistant.vision.opencv import opencv
from assistant.vision.servoing.interaction import cross

POSE_ROUNDS: Final = 12
CONVERGED_STEP: Final = 1e-7
"""mm (and mm at the size of the thing) of a step from which on it is found."""
FLATNESS: Final = 1e-6
"""Part of its size by which a thing may be uneven and still be flat."""
FEWEST_FOR_POSE: Final = 3
"""Fewest points that tell a pose; fewer ones tell a place."""
FEWEST_FOR_ONE_CAMERA: Final = 4
"""Fewest points by which one camera alone tells a pose."""
LEAST_RANK_SHARE: Final = 1e-4
"""Part of the best told direction from which on another one is told at all."""


@dataclass(frozen=True, slots=True, eq=False)
class TargetPose:
    """pose: of the thing in the base. residual: pixels, root mean square. other: a second pose that
    a flat thing before one camera fits nearly as well, with its residual; None if there is none.
    """

    pose: Pose
    residual: float
    other: tuple[Pose, float] | None = None


def estimate_pose(
    cameras: Sequence[Camera],
    pixels: Mapping[str, Floats],
    points: Floats,
    guess: Pose | None = None,
) -> TargetPose | None:
    """The pose of a thing in the base, in which the cameras stand; None if it is not told.

    pixels: camera → (n, 2), NaN for points that it does not see. guess: where it was before; its
    turn is kept as far as the points do not tell it. The squares of the pixels are the least.
    """
    seen = [(c, pixels[c.name], all_of(np.isfinite(pixels[c.name]))) for c in cameras]
    seen = [one for one in seen if one[2].any()]
    other = None
    if guess is None:
        starts = _start_poses(seen, points)
        if not starts:
            return None
        found = [
            one for start in starts if (one := _least_squares(seen, points, start)) is not None
        ]
        found.sort(key=lambda one: one.residual)
        if len(found) > 1:
            other = (found[1].pose, found[1].residual)
        return TargetPose(found[0].pose, found[0].residual, other) if found else None
    told = sum(int(good.sum()) for _, _, good in seen)
    if told * 2 < (3 if len(points) < FEWEST_FOR_POSE else 6):
        return None
    return _least_squares(seen, points, guess)


SeenPoints = Sequence[tuple[Camera, Floats, Truths]]


def _least_squares(seen: SeenPoints, points: Floats, start: Pose) -> TargetPose | None:
    """Gauss and Newton from a start; turns are scaled by the size of the thing."""
    pose, size = start, _target_size(points)
    residuals = np.zeros(0)
    for _ in range(POSE_ROUNDS):
        placed = pose.moved(points)
        around = placed - np.array(pose.position)
        rows, offs = [], []
        for camera, pixels, good in seen:
            slopes = camera.slopes(placed[good])
            turning = np.stack([-cross(a) for a in around[good]]) / size
            rows.append(np.concatenate([slopes, slopes @ turning], axis=2).reshape(-1, 6))
            offs.append((pixels[good] - camera.project(placed[good])).ravel())
        residuals = np.concatenate(offs)
        if not np.isfinite(residuals).all():
            return None
        step = np.linalg.lstsq(np.concatenate(rows), residuals, rcond=LEAST_RANK_SHARE)[0]
        turn = step[3:] / size
        angle = float(np.linalg.norm(turn))
        by = rotations.about(turn / angle if angle > 0.0 else (1.0, 0.0, 0.0), np.degrees(angle))
        quaternion = rotations.multiply(by, np.array(pose.quaternion))
        pose = Pose.of(np.array(pose.position) + step[:3], quaternion)
        if float(np.abs(step).max()) < CONVERGED_STEP:
            break
    return TargetPose(pose, float(np.sqrt((residuals**2).mean() * 2.0)))


def _target_size(points: Floats) -> float:
    away = float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())
    return away if away > 0.0 else 1.0


def _start_poses(seen: SeenPoints, points: Floats) -> list[Pose]:
    both = [one for one in seen if one[2].all()]
    if len(both) > 1:
        return [_triangulated_pose([c for c, _, _ in both], [p for _, p, _ in both], points)]
    if len(both) == 1 and len(points) >= FEWEST_FOR_ONE_CAMERA:
        return _poses_of_one_camera(both[0][0], both[0][1], points)
    return []


def _triangulated_pose(cameras: Sequence[Camera], pixels: Sequence[Floats], points: Floats) -> Pose:
    """Each point by all cameras, then the turn that fits them best (Kabsch, 1976)."""
    placed = triangulate(cameras, pixels, 1.0).points
    middle, away = placed.mean(axis=0), points.mean(axis=0)
    if len(points) < FEWEST_FOR_POSE:
        return Pose.of(middle - away, np.array([1.0, 0.0, 0.0, 0.0]))
    left, _, right = np.linalg.svd((placed - middle).T @ (points - away))
    sign = np.diag([1.0, 1.0, np.linalg.det(left @ right)])
    turn = left @ sign @ right
    return Pose.of(middle - turn @ away, rotations.from_matrix(turn))


def _poses_of_one_camera(camera: Camera, pixels: Floats, points: Floats) -> list[Pose]:
    """Both poses of a flat thing, or the one of another, by OpenCV (IPPE and SQPNP)."""
    cv = opencv()
    flat = (
        np.linalg.matrix_rank(points - points.mean(axis=0), tol=FLATNESS * _target_size(points)) < 3
    )
    method = cv.SOLVEPNP_IPPE if flat else cv.SOLVEPNP_SQPNP
    tangents = camera.lens.tangents(pixels)
    try:
        found = cv.solvePnPGeneric(points, tangents, np.eye(3), None, flags=method)
    except cv.error:
        return []
    return [
        camera.pose @ _pose_of_opencv(cv, r, t) for r, t in zip(found[1], found[2], strict=True)
    ]


def _pose_of_opencv(cv: Any, turn: Any, place: Any) -> Pose:
    matrix, _ = cv.Rodrigues(turn)
    return Pose.of(np.ravel(place), rotations.from_matrix(np.asarray(matrix)))
