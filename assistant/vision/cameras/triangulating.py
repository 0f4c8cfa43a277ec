"""Points that several cameras see: the places whose pixels come nearest to the seen ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.program.arrays import Floats, Truths
from assistant.vision.cameras.camera import NEAR, Camera

ROUNDS: Final = 10
"""Steps of Gauss and Newton at most; three are usual."""
CLOSE: Final = 1e-9
"""mm between two of them at which they end."""
PARALLEL: Final = 0.5
"""Degrees between two rays below which they tell no depth."""


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """points: (n, 3) mm in the world, NaN where they cannot be told: seen by less than two
    cameras, by rays that hardly cross, or behind a camera. covariances: (n, 3, 3) mm² for the
    noise that was given. residuals: (n,) pixels, root mean square over u and v of all cameras that
    see the point; two pictures that show different things have large ones.
    """

    points: Floats
    covariances: Floats
    residuals: Floats


def triangulate(cameras: Sequence[Camera], pixels: Sequence[Floats], noise: float = 0.2) -> Located:
    """pixels: of each camera (n, 2), NaN where it does not see a point. noise: pixels, one sigma.

    Begins at the point nearest to the rays, then minimises the squares in pixels (Hartley and
    Sturm, Triangulation, 1997, for Gaussian noise; here by Gauss and Newton for any number of
    cameras). Raises ValueError for cameras and pixels that do not belong together.
    """
    seen = [np.asarray(one, dtype=np.float64).reshape(-1, 2) for one in pixels]
    if len(seen) != len(cameras) or len({len(one) for one in seen}) != 1:
        raise ValueError("pixels (n, 2) are wanted for each of the cameras")
    there = np.stack([np.isfinite(one).all(axis=1) for one in seen])
    rays = np.stack([c.directions(p) for c, p in zip(cameras, seen, strict=True)])
    there &= np.isfinite(rays).all(axis=2)
    points = _nearest(cameras, rays, there)
    told = there.sum(axis=0) >= 2
    told &= np.isfinite(points).all(axis=1)
    normal = np.tile(np.eye(3), (len(points), 1, 1))
    off = np.zeros((len(cameras), len(points), 2))
    for _ in range(ROUNDS):
        matrix, vector = np.zeros((len(points), 3, 3)), np.zeros((len(points), 3))
        for i, camera in enumerate(cameras):
            rows = there[i] & told
            slope = camera.slopes(points[rows])
            off[i, rows] = camera.project(points[rows]) - seen[i][rows]
            matrix[rows] += np.einsum("nki,nkj->nij", slope, slope)
            vector[rows] += np.einsum("nki,nk->ni", slope, off[i, rows])
        told &= np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(vector).all(axis=1)
        normal[told] = matrix[told]
        step = np.linalg.solve(normal[told], vector[told][..., None])[..., 0]
        points[told] -= step
        if not (np.abs(step) > CLOSE).any():
            break
    for i, camera in enumerate(cameras):
        behind = ~(camera.seen_by(points)[:, 2] > NEAR)
        told &= ~(there[i] & behind)
    points[~told] = np.nan
    covariances = np.full((len(points), 3, 3), np.nan)
    covariances[told] = noise**2 * np.linalg.inv(normal[told])
    squares = np.where(there[..., None], off**2, 0.0).sum(axis=(0, 2))
    residuals = np.sqrt(squares / np.maximum(2 * there.sum(axis=0), 1))
    residuals[~told] = np.nan
    return Located(points, covariances, residuals)


def _nearest(cameras: Sequence[Camera], rays: Floats, there: Truths) -> Floats:
    """(n, 3) points with the least squares of distances to their rays, NaN for parallel ones."""
    eyes = np.array([camera.pose.position for camera in cameras])
    across = np.eye(3) - np.einsum("cni,cnj->cnij", rays, rays)
    across[~there] = 0.0
    matrix = across.sum(axis=0)
    vector = np.einsum("cnij,cj->ni", across, eyes)
    # The least eigenvalue of two rays is 2 sin²(half the angle between them).
    least = np.linalg.eigvalsh(matrix)[:, 0] if len(matrix) else np.zeros(0)
    flat = ~(least > 2.0 * np.sin(np.radians(PARALLEL) / 2.0) ** 2)
    matrix[flat] = np.eye(3)
    points = np.linalg.solve(matrix, vector[..., None])[..., 0]
    points[flat] = np.nan
    return np.asarray(points)
