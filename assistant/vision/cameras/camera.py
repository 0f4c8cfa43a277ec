"""A camera: its lens, its pose, and the points that several cameras see.

The frame of a camera has z along its view, x to the right of the picture and y down. Pixels (u, v)
count from the middle of the upper left one. Points are mm.

Lens: pinhole with the distortion of Brown and Conrady in the form and order of OpenCV,
(k1, k2, p1, p2, k3); source: its documentation of calib3d, "Detailed Description".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths, rows_of
from assistant.base.data_classes import dataclass
from assistant.program.geometry import IDENTITY, Pose, Vector

WORLD: Final = "world"
"""The parent of a camera that stands still."""
LEAST_DEPTH: Final = 1.0
"""mm in front of the camera; closer points, and points at its back, are not seen."""
_UNDISTORTION_ROUNDS: Final = 20
"""Steps of Newton's method at most, from a pixel to its ray."""
_TANGENT_SAMPLES: Final = np.linspace(0.0, 3.0, 601)
"""Tangents of angles from the axis at which it is looked how far the lens is one to one."""


@dataclass(frozen=True, slots=True)
class Lens:
    """Projection of directions by a camera.

    size: width and height in pixels. focal: pixels along u and v. centre: pixel of the axis.
    distortion: k1, k2, p1, p2, k3.
    """

    size: tuple[int, int]
    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    @staticmethod
    def ideal(size: tuple[int, int], focal: float) -> Lens:
        """Square pixels, the axis in the middle, no distortion."""
        return Lens(size, (focal, focal), ((size[0] - 1) / 2.0, (size[1] - 1) / 2.0))

    @property
    def matrix(self) -> Floats:
        """(3, 3), as OpenCV takes it."""
        (fx, fy), (cx, cy) = self.focal, self.centre
        return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])

    @property
    def widest(self) -> float:
        """Tangent of the angle from the axis up to which what is farther out is seen so."""
        k1, k2, _, _, k3 = self.distortion
        r2 = _TANGENT_SAMPLES**2
        rising = 1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3)) > 0.0
        return float(_TANGENT_SAMPLES[-1] if rising.all() else _TANGENT_SAMPLES[np.argmin(rising)])

    @property
    def whole(self) -> bool:
        """True if all of the ellipse that fills the picture is seen, each direction once."""
        ring = np.linspace(0.0, 2.0 * np.pi, 33)
        circle = np.column_stack([np.cos(ring), np.sin(ring)])
        part = np.linspace(0.05, 1.0, 20)[:, None, None]
        size = np.array(self.size, dtype=np.float64)
        seen = self.tangents(((size - 1.0) / 2.0 + part * circle * size / 2.0).reshape(-1, 2))
        with np.errstate(all="ignore"):
            turning = np.linalg.det(self._slope(np.nan_to_num(seen)))
        return bool(np.isfinite(seen).all() and (turning > 0.0).all())

    def pixels(self, tangents: Floats) -> Floats:
        """(n, 2) x / z and y / z → (n, 2) pixels; NaN beyond `widest`."""
        found = self._distorted(tangents) * self.focal + np.array(self.centre)
        found[(tangents**2).sum(axis=1) > self.widest**2] = np.nan
        return np.asarray(found)

    def tangents(self, pixels: Floats) -> Floats:
        """(n, 2) pixels → (n, 2) x / z and y / z; NaN for pixels that the lens does not reach."""
        wanted: Floats = np.asarray((pixels - np.array(self.centre)) / np.array(self.focal))
        if not any(self.distortion):
            return wanted
        found = wanted.copy()
        with np.errstate(over="ignore", invalid="ignore"):
            return self._undistorted(found, wanted)

    def _undistorted(self, found: Floats, wanted: Floats) -> Floats:
        """By Newton's method from `found` on, in place."""
        for _ in range(_UNDISTORTION_ROUNDS):
            off = self._distorted(found) - wanted
            step = _solve_2x2(self._slope(found), off)
            found -= np.clip(step, -0.3, 0.3)
            if not (np.abs(step) > 1e-13).any():
                break
        off = np.abs(self._distorted(found) - wanted).max(axis=1)
        found[~((off < 1e-9) & ((found**2).sum(axis=1) <= self.widest**2))] = np.nan
        return found

    def slopes(self, tangents: Floats) -> Floats:
        """(n, 2) tangents → (n, 2, 2) change of the pixel by them."""
        return np.asarray(self._slope(tangents) * np.array(self.focal)[:, None])

    def _distorted(self, t: Floats) -> Floats:
        k1, k2, p1, p2, k3 = self.distortion
        x, y = t[:, 0], t[:, 1]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        return np.stack(
            [
                x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
            ],
            axis=1,
        )

    def _slope(self, t: Floats) -> Floats:
        k1, k2, p1, p2, k3 = self.distortion
        x, y = t[:, 0], t[:, 1]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        grows = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3))
        across = x * y * grows + 2.0 * p1 * x + 2.0 * p2 * y
        rows = [
            [radial + x * x * grows + 2.0 * p1 * y + 6.0 * p2 * x, across],
            [across, radial + y * y * grows + 6.0 * p1 * y + 2.0 * p2 * x],
        ]
        return np.moveaxis(np.array(rows), 2, 0)


def _solve_2x2(matrices: Floats, right: Floats) -> Floats:
    """(n, 2, 2) and (n, 2) → (n, 2), many times faster than by a factorisation of each."""
    (a, b), (c, d) = matrices[:, 0].T, matrices[:, 1].T
    x, y = right.T
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(
            np.stack([d * x - b * y, a * y - c * x], axis=1) / (a * d - b * c)[:, None]
        )


@dataclass(frozen=True, slots=True)
class Camera:
    """pose: of the camera in its parent: `WORLD`, or a link of a robot (`arm.flange`)."""

    name: str
    lens: Lens
    pose: Pose = IDENTITY
    parent: str = WORLD

    def carried(self, parent: Pose) -> Camera:
        """The same camera in the world, while its parent has a pose there."""
        return replace(self, pose=parent @ self.pose, parent=WORLD)

    def seen_by(self, points: Floats) -> Floats:
        """Points (n, 3) of the parent's frame, in the frame of the camera."""
        return self.pose.inverse().moved(rows_of(points, 3, "points"))

    def project(self, points: Floats) -> Floats:
        """Points (n, 3) of the parent's frame → pixels (n, 2), perhaps outside of the picture.

        NaN for points behind the camera, and for those beyond what its lens maps.
        """
        local = self.seen_by(points)
        with np.errstate(divide="ignore", invalid="ignore"):
            tangents = local[:, :2] / local[:, 2:]
        tangents[~(local[:, 2] > LEAST_DEPTH)] = np.nan
        return self.lens.pixels(tangents)

    def slopes(self, points: Floats) -> Floats:
        """(n, 2, 3) change of the pixels by points (n, 3) of the parent's frame, a mm.

        NaN for points behind the camera.
        """
        local = self.seen_by(points)
        local[~(local[:, 2] > LEAST_DEPTH)] = np.nan
        x, y, z = local.T
        none = np.zeros_like(z)
        with np.errstate(divide="ignore", invalid="ignore"):
            by_point = np.array([[1.0 / z, none, -x / z**2], [none, 1.0 / z, -y / z**2]])
            tangents = local[:, :2] / local[:, 2:]
        turn = rotations.to_matrix(np.array(self.pose.quaternion)).T
        return np.asarray(self.lens.slopes(tangents) @ np.moveaxis(by_point, 2, 0) @ turn)

    def directions(self, pixels: Floats) -> Floats:
        """Pixels (n, 2) → unit vectors (n, 3) in the parent's frame from `pose.position` on."""
        tangents = self.lens.tangents(rows_of(pixels, 2, "pixels"))
        local = np.column_stack([tangents, np.ones(len(tangents))])
        local /= np.linalg.norm(local, axis=1, keepdims=True)
        return np.asarray(rotations.rotate(np.array(self.pose.quaternion), local))

    def within(self, pixels: Floats, margin: float = 0.0) -> Truths:
        """(n,) which pixels (n, 2) are in the picture, so many pixels from its edge."""
        width, height = self.lens.size
        u, v = rows_of(pixels, 2, "pixels").T
        low = margin - 0.5
        inside = (u >= low) & (v >= low) & (u <= width - 1 - low) & (v <= height - 1 - low)
        return np.asarray(inside)


def looking_at(eye: ArrayLike, target: ArrayLike, up: Vector = (0.0, 0.0, 1.0)) -> Pose:
    """The pose of a camera at a place that looks at another one, the picture's top towards `up`."""
    ahead = np.asarray(target, dtype=np.float64) - np.asarray(eye, dtype=np.float64)
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, up)
    if np.linalg.norm(right) < 1e-9:
        right = np.cross(ahead, (0.0, 1.0, 0.0))
    right /= np.linalg.norm(right)
    turn = np.column_stack([right, np.cross(ahead, right), ahead])
    return Pose.of(np.asarray(eye, dtype=np.float64), rotations.from_matrix(turn))


_TRIANGULATION_ROUNDS: Final = 15
"""Steps of Gauss and Newton at most; three are usual."""
_CONVERGED_STEP: Final = 1e-9
"""mm between two of them at which they end."""
_LONGEST_LAST_STEP: Final = 0.01
"""mm that the last of them may be long; others go nowhere, for pixels of different things."""
_LEAST_EIGENVALUE: Final = 1e-10
"""Part of the largest eigenvalue below which the least one tells nothing."""
_FARTHEST_PIXEL: Final = 1e6
"""Pixels from the middle that no camera has; they are as good as none."""
_LEAST_RAY_ANGLE: Final = 0.5
"""Degrees between two rays below which they tell no depth."""


@dataclass(frozen=True, slots=True, eq=False)
class TriangulatedPoints:
    """Triangulated points. points: (n, 3) mm in the world, NaN for an undetermined point: seen by
    fewer than two cameras, by nearly parallel rays, or behind a camera. covariances: (n, 3, 3) mm²
    for the given noise. residuals: (n,) pixels, root mean square over u and v of all cameras that
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
    inside = [np.all(np.abs(one) < _FARTHEST_PIXEL, axis=1, keepdims=True) for one in seen]
    seen = [np.where(good, one, np.nan) for good, one in zip(inside, seen, strict=True)]
    rays = np.stack([c.directions(p) for c, p in zip(cameras, seen, strict=True)])
    there: Truths = np.asarray(np.isfinite(rays).all(axis=2))
    points = _nearest_to_rays(cameras, rays, there)
    told = (there.sum(axis=0) >= 2) & np.isfinite(points).all(axis=1)
    normal = np.tile(np.eye(3), (len(points), 1, 1))
    off = np.zeros((len(cameras), len(points), 2))
    for _ in range(_TRIANGULATION_ROUNDS):
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
        if not (np.abs(step) > _CONVERGED_STEP).any():
            break
    told &= np.abs(step).max(axis=1) <= _LONGEST_LAST_STEP
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
    return np.asarray(values[:, 0] > _LEAST_EIGENVALUE * values[:, -1])


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
    return np.asarray(~(least > 2.0 * np.sin(np.radians(_LEAST_RAY_ANGLE) / 2.0) ** 2))


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
