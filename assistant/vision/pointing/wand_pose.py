"""Where a device with several marks is: its pose by least squares over all pictures of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths
from assistant.vision.cameras.camera import LEAST_DEPTH, Camera
from assistant.vision.cameras.triangulating import triangulate

POSE_ROUNDS: Final = 12
CONVERGED_STEP: Final = 1e-7
"""mm and radians of a step at which the search ends."""
UNDETERMINED_SHARE: Final = 1e-7
"""Part of the strongest direction below which the pixels do not tell a direction."""
ALONG_X_COSINE: Final = np.cos(np.radians(20.0))


@dataclass(frozen=True, slots=True, eq=False)
class DevicePoses:
    """n poses of a device: positions (n, 3) mm, quaternions (n, 4), NaN where they are not told.

    covariances: (n, 6, 6) of the position in mm and of the turn about the axes of the world in
    radians, for the noise that was given; 0 for a turn that the marks do not tell. residuals: (n,)
    pixels, root mean square over u and v of all marks and cameras.
    """

    positions: Floats
    quaternions: Floats
    covariances: Floats
    residuals: Floats


def fit_device_poses(
    cameras: Sequence[Camera], pixels: Floats, marks: Floats, noise: float = 0.2
) -> DevicePoses:
    """pixels: (c, n, b, 2) of b marks in n moments, NaN where one is not seen; marks: (b, 3) mm.

    Every mark must be seen by two cameras. The begin is the rigid motion onto the triangulated
    marks (Kabsch 1976, by singular values), then Gauss and Newton on the pixels.
    """
    count, b = pixels.shape[1], len(marks)
    flat = [one.reshape(-1, 2) for one in pixels]
    located = triangulate(cameras, flat, noise).points.reshape(count, b, 3)
    good = np.isfinite(located).all(axis=(1, 2))
    positions = np.full((count, 3), np.nan)
    quaternions = np.full((count, 4), np.nan)
    covariances = np.full((count, 6, 6), np.nan)
    residuals = np.full(count, np.nan)
    if good.any():
        p, turn = _rigid_motions(located[good], marks)
        p, turn, normal, squares, there = _refine_poses(cameras, pixels[:, good], marks, p, turn)
        if b > 1 and _in_line(marks):
            turn = _without_free_turn(turn, marks)
        positions[good], quaternions[good] = p, rotations.from_matrix(turn)
        covariances[good] = noise**2 * np.linalg.pinv(
            normal, rcond=UNDETERMINED_SHARE, hermitian=True
        )
        residuals[good] = np.sqrt(squares / np.maximum(2 * there, 1))
    return DevicePoses(positions, quaternions, covariances, residuals)


def _in_line(marks: Floats) -> bool:
    return bool(np.linalg.matrix_rank(marks - marks.mean(axis=0), tol=1.0) < 2)


def _rigid_motions(points: Floats, marks: Floats) -> tuple[Floats, Floats]:
    """Positions (n, 3) and rotations (n, 3, 3) that bring marks (b, 3) nearest to (n, b, 3)."""
    middle, centre = points.mean(axis=1), marks.mean(axis=0)
    u, _, vt = np.linalg.svd(np.einsum("nbi,bj->nij", points - middle[:, None], marks - centre))
    flip = np.tile(np.eye(3), (len(points), 1, 1))
    flip[:, 2, 2] = np.linalg.det(u @ vt)
    turn = u @ flip @ vt
    return middle - np.einsum("nij,j->ni", turn, centre), turn


def _refine_poses(
    cameras: Sequence[Camera], pixels: Floats, marks: Floats, p: Floats, turn: Floats
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """The poses, the normal matrices (n, 6, 6), the squares in pixels (n,) and marks seen (n,)."""
    n, b = len(p), len(marks)
    there = np.asarray(np.isfinite(pixels).all(axis=3))
    normal, squares = np.zeros((n, 6, 6)), np.zeros(n)
    for _ in range(POSE_ROUNDS):
        arms = np.einsum("nij,bj->nbi", turn, marks)
        points = (p[:, None] + arms).reshape(-1, 3)
        normal, vector, squares = np.zeros((n, 6, 6)), np.zeros((n, 6)), np.zeros(n)
        for i, camera in enumerate(cameras):
            seen = pixels[i]
            known = there[i] & _in_front(camera, points).reshape(n, b)
            off = np.where(known[..., None], camera.project(points).reshape(n, b, 2) - seen, 0.0)
            by_point = camera.slopes(points).reshape(n, b, 2, 3)
            by_turn = -np.einsum("nbki,nbij->nbkj", by_point, _cross_matrices(arms))
            slope = np.concatenate([by_point, by_turn], axis=3)
            slope = np.where(known[..., None, None], slope, 0.0)
            normal += np.einsum("nbki,nbkj->nij", slope, slope)
            vector += np.einsum("nbki,nbk->ni", slope, off)
            squares += (off**2).sum(axis=(1, 2))
        back = np.linalg.pinv(normal, rcond=UNDETERMINED_SHARE, hermitian=True)
        step = -np.einsum("nij,nj->ni", back, vector)
        p = p + step[:, :3]
        turn = _rotate_by(turn, step[:, 3:])
        if not (np.abs(step) > CONVERGED_STEP).any():
            break
    return p, turn, normal, squares, there.sum(axis=(0, 2)).astype(np.float64)


def _in_front(camera: Camera, points: Floats) -> Truths:
    return np.asarray(camera.seen_by(points)[:, 2] > LEAST_DEPTH)


def _cross_matrices(arms: Floats) -> Floats:
    """(..., 3, 3) matrices of the cross product with vectors (..., 3)."""
    x, y, z = np.moveaxis(arms, -1, 0)
    none = np.zeros_like(x)
    rows = np.array([[none, -z, y], [z, none, -x], [-y, x, none]])
    return np.moveaxis(rows, (0, 1), (-2, -1))


def _rotate_by(turn: Floats, by: Floats) -> Floats:
    """Rotations (n, 3, 3) turned about axes of the world by vectors (n, 3) in radians."""
    angle = np.linalg.norm(by, axis=1)
    axis = by / np.maximum(angle, 1e-300)[:, None]
    return np.asarray(rotations.to_matrix(rotations.about(axis, np.degrees(angle))) @ turn)


def _without_free_turn(turn: Floats, marks: Floats) -> Floats:
    """Turned about the line of the marks, so that x follows the rule of `Device`.

    The line is the z of the device, or its frame is left as the fit gave it.
    """
    away = marks - marks.mean(axis=0)
    if np.abs(away[:, :2]).max() > 1e-6:
        return turn
    z = turn[:, :, 2]
    wished = np.where(np.abs(z[:, :1]) > ALONG_X_COSINE, (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    y = np.cross(z, wished)
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    return np.stack([np.cross(y, z), y, z], axis=2)
