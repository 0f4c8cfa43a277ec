"""Points that several cameras see: the places whose pixels come nearest to the seen ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Truths, rows_of
from assistant.vision.cameras.camera import LEAST_DEPTH, Camera

TRIANGULATION_ROUNDS: Final = 15
"""Steps of Gauss and Newton at most; three are usual."""
CONVERGED_STEP: Final = 1e-9
"""mm between two of them at which they end."""
LONGEST_LAST_STEP: Final = 0.01
"""mm that the last of them may be long; others go nowhere, for pixels of different things."""
LEAST_EIGENVALUE: Final = 1e-10
"""Part of the largest eigenvalue below which the least one tells nothing."""
FARTHEST_PIXEL: Final = 1e6
"""Pixels from the middle that no camera has; they are as good as none."""
LEAST_RAY_ANGLE: Final = 0.5
"""Degrees between two rays below which they tell no depth."""


@dataclass(frozen=True, slots=True, eq=False)
class TriangulatedPoints:
    """points: (n, 3) mm in the world, NaN where they cannot be told: seen by less than two
    cameras, by rays that hardly cross, or behind a camera. covariances: (n, 3, 3) mm² for the
    noise that was given. residuals: (n,) pixels, root mean square over u and v of all cameras that
    see the point; two pictures that show different things have large ones.
    """

    points: Floats
    covariances: Floats
    residuals: Floats


def triangulate(
    cameras: Sequence[Camera], pixels: Sequence[Floats], noise: float = 0.2
) -> TriangulatedPoints:
    """pixels: of each camera (n, 2), NaN where it does not see a point. noise: pixels, one sigma.

    Pixels that are far outside of any picture count as not seen. Begins at the point nearest to the
    rays, then minimises the squares in pixels (Hartley and Sturm, Triangulation, 1997, for Gaussian
    noise; here by Gauss and Newton for any number of cameras). Raises ValueError for cameras and
    pixels that do not belong together.
    """
    seen = [rows_of(one, 2, "pixels") for one in pixels]
    if len(seen) != len(cameras) or len({len(one) for one in seen}) != 1:
        raise ValueError("pixels (n, 2) are wanted for each of the cameras")
    inside = [np.all(np.abs(one) < FARTHEST_PIXEL, axis=1, keepdims=True) for one in seen]
    seen = [np.where(good, one, np.nan) for good, one in zip(inside, seen, strict=True)]
    rays = np.stack([c.directions(p) for c, p in zip(cameras, seen, strict=True)])
    there: Truths = np.asarray(np.isfinite(rays).all(axis=2))
    points = _nearest_to_rays(cameras, rays, there)
    told = (there.sum(axis=0) >= 2) & np.isfinite(points).all(axis=1)
    normal = np.tile(np.eye(3), (len(points), 1, 1))
    off = np.zeros((len(cameras), len(points), 2))
    for _ in range(TRIANGULATION_ROUNDS):
        matrix, vector = np.zeros((len(points), 3, 3)), np.zeros((len(points), 3))
        for i, camera in enumerate(cameras):
            rows = there[i] & told
            slope = camera.slopes(points[rows])
            off[i, rows] = camera.project(points[rows]) - seen[i][rows]
            matrix[rows] += np.einsum("nki,nkj->nij", slope, slope)
            vector[rows] += np.einsum("nki,nk->ni", slope, off[i, rows])
        told &= np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(vector).all(axis=1)
        told[told] = _well_conditioned(matrix[told])
        normal[told] = matrix[told]
        step = np.zeros_like(points)
        step[told] = np.linalg.solve(normal[told], vector[told][..., None])[..., 0]
        points -= step
        if not (np.abs(step) > CONVERGED_STEP).any():
            break
    told &= np.abs(step).max(axis=1) <= LONGEST_LAST_STEP
    told &= _in_front_and_crossing(cameras, points, there)
    points[~told] = np.nan
    covariances = np.full((len(points), 3, 3), np.nan)
    covariances[told] = noise**2 * np.linalg.inv(normal[told])
    squares = np.where(there[..., None], off**2, 0.0).sum(axis=(0, 2))
    residuals = np.sqrt(squares / np.maximum(2 * there.sum(axis=0), 1))
    residuals[~told] = np.nan
    return TriangulatedPoints(points, covariances, residuals)


def _well_conditioned(matrices: Floats) -> Truths:
    values = np.linalg.eigvalsh(matrices)
    return np.asarray(values[:, 0] > LEAST_EIGENVALUE * values[:, -1])


def _in_front_and_crossing(cameras: Sequence[Camera], points: Floats, there: Truths) -> Truths:
    """(n,) which points are before the cameras that see them, and not in one line with them."""
    good = np.isfinite(points).all(axis=1)
    eyes = np.array([camera.pose.position for camera in cameras])
    rays = points - eyes[:, None]
    with np.errstate(invalid="ignore"):
        rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    for i, camera in enumerate(cameras):
        good &= ~there[i] | (camera.seen_by(points)[:, 2] > LEAST_DEPTH)
    rays[:, ~good] = 0.0
    return np.asarray(good & ~_nearly_parallel(_across_rays(rays, there)))


def _across_rays(rays: Floats, there: Truths) -> Floats:
    """(c, n, 3, 3) what of a vector is across to each ray, of those that are there."""
    across = np.eye(3) - np.einsum("cni,cnj->cnij", rays, rays)
    across[~there] = 0.0
    return np.asarray(across)


def _nearly_parallel(across: Floats) -> Truths:
    """(n,) whether rays hardly cross.

    The least eigenvalue of the sum is 2 sin²(half the angle between them) for two rays.
    """
    matrix = across.sum(axis=0)
    least = np.linalg.eigvalsh(matrix)[:, 0] if len(matrix) else np.zeros(0)
    return np.asarray(~(least > 2.0 * np.sin(np.radians(LEAST_RAY_ANGLE) / 2.0) ** 2))


def _nearest_to_rays(cameras: Sequence[Camera], rays: Floats, there: Truths) -> Floats:
    """(n, 3) points with the least squares of distances to their rays, NaN for parallel ones."""
    eyes = np.array([camera.pose.position for camera in cameras])
    across = _across_rays(np.where(there[..., None], rays, 0.0), there)
    matrix = across.sum(axis=0)
    vector = np.einsum("cnij,cj->ni", across, eyes)
    flat = _nearly_parallel(across)
    matrix[flat] = np.eye(3)
    points = np.linalg.solve(matrix, vector[..., None])[..., 0]
    points[flat] = np.nan
    return np.asarray(points)
