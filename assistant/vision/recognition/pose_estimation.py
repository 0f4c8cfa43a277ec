"""Estimate the pose of an object by least squares over the measurements of cameras.

A pose is changed by mm along the axes of the world and by radians about them, through the object's
origin. Each measurement is a row: its error in pixels, and the change of that by these six.
Outliers get less weight (Tukey's biweight); steps are those of Gauss and Newton. Prior knowledge of
the pose, such as the plane that the object lies on, is rows as well, weighted by its standard
deviation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths
from assistant.base.data_classes import dataclass
from assistant.program.geometry import IDENTITY, Pose
from assistant.vision.cameras.camera import Camera

_FIT_ROUNDS: Final = 12
_CONVERGED_SIGMAS: Final = 0.02
"""Sigmas of a step at which they end."""
_TUKEY_SIGMAS: Final = 4.685
"""Sigmas beyond which a measurement counts nothing: 95 % of the efficiency of least squares for
Gaussian noise (Huber, Robust Statistics, 1981)."""
_LEAST_PIXEL_SIGMA: Final = 0.02
"""Pixels that no measurement is surer than: of rounding to grey levels and to pixels."""
_SCATTER_FLOORS: Final = (2.0, 1.0, 0.5, 0.15)
"""Pixels, one sigma, that measurements are at least taken to scatter by where they are weighted: in
the first steps, and in all after them. Else one edge that agrees with itself drives others out."""
_EDGE_SHIFT_SIGMA: Final = 0.3
"""Pixels, one sigma, that all edges of an outline may lie out of the material."""
_SIDE_SIGMA: Final = 0.008
"""Pixels, one sigma, that a whole side of an outline is off by what no noise is: the grid of
pixels, corners, the lens. It is not less for more samples of that side."""
_SIDES: Final = 6.0
_SURE_ROW_SIGMA: Final = 0.05
"""Pixels, one sigma, that a row counts wholly to which nothing else is unsure."""
_FEWEST_MEASUREMENTS: Final = 6
_LEAST_AGREEING: Final = 0.3
"""Part of all measurements that have to agree with a pose."""
_KEYPOINT_OVERLAP: Final = 1.4
"""Rows of keypoints with the information of one independent row: their surroundings overlap, and
all share the errors of their learnt positions (measured on drawn scenes, tests/vision/recognition).
"""
_ANY_TURN_SIGMA: Final = 104.0
"""Degrees, one sigma, of what may be turned by any angle: 180 / √3."""
_UNKNOWN_HEIGHT_SIGMA: Final = 1e3
"""mm, one sigma, of a plane whose height is left to what is seen."""
_FREE_DIRECTION_SHARE: Final = 1e-9
"""Part of the largest eigenvalue below which measurements tell nothing of a direction."""


@dataclass(frozen=True, slots=True, eq=False)
class PixelErrors:
    """offs: (n,) pixels; slopes: (n, 6). along: they are of edges out of the material, each beside
    the next. alike: how many of them tell as much as one that has nothing in common with others.
    unsure: (n,) pixels, one sigma, that each may be off beside what all are.
    """

    offs: Floats
    slopes: Floats
    along: bool = False
    alike: float = 1.0
    unsure: Floats | None = None


Measure = Callable[[Pose], PixelErrors]
"""Return the pixel errors that a camera measures for a pose of an object."""


@dataclass(frozen=True, slots=True)
class Plane:
    """Plane on which objects lie: its z axis is the normal. sigma: uncertainty in mm. sigma_deg: in
    degrees.
    """

    pose: Pose = IDENTITY
    sigma: float = 0.05
    sigma_deg: float = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class PoseEstimate:
    """A pose with what is known of it.

    pose: in the world. covariance: (6, 6) of mm along and degrees about the axes of the world, at
    the object's origin. scatter: pixels, one sigma, of what agrees. used: (n,) weights, 0 to 1, of
    the measurements in their order.
    """

    pose: Pose
    covariance: Floats
    scatter: float
    used: Floats

    @property
    def sigma_mm(self) -> float:
        """Standard deviation of the position along its least certain axis."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariance[:3, :3])[-1]))

    @property
    def sigma_deg(self) -> float:
        return float(np.sqrt(np.linalg.eigvalsh(self.covariance[3:, 3:])[-1]))


def fit_pose(
    pose: Pose,
    measures: Sequence[Measure],
    plane: Plane | None = None,
    height: float = 0.0,
    *,
    any_turn: bool = False,
) -> PoseEstimate | None:
    """The pose near to one that fits best; None where the measurements do not tell one.

    plane: what the object lies on with its face `height` mm above. any_turn: it looks the same
    however it is turned in its face, so that nothing tells how it is.
    """
    wide = _any_turn_information(pose) if any_turn else np.zeros((6, 6))
    weights, scatter = np.zeros(0), _LEAST_PIXEL_SIGMA
    for number in range(_FIT_ROUNDS):
        coarse = _SCATTER_FLOORS[min(number, len(_SCATTER_FLOORS) - 1)]
        found = _fit_step(pose, measures, plane, height, coarse, wide)
        if found is None:
            return None
        step, matrix, scatter, weights = found
        if number == len(_SCATTER_FLOORS) and float((weights > 0.0).mean()) < _LEAST_AGREEING:
            return None
        pose = moved_pose(pose, step)
        small = float(step @ matrix @ step) < _CONVERGED_SIGMAS**2
        if small and number >= len(_SCATTER_FLOORS):
            break
    units = np.array([1.0, 1.0, 1.0, *[180.0 / np.pi] * 3])
    covariance = np.asarray(np.linalg.inv(matrix) * np.outer(units, units), dtype=np.float64)
    return PoseEstimate(pose, covariance, scatter, weights)


@dataclass(frozen=True, slots=True, eq=False)
class SizeFit:
    """An object on a plane, located by its seen size instead of the height of the plane.

    above: mm that this is above the plane. sigma: mm, one sigma of that and of the plane. shift:
    (6,) mm and degrees from the pose on the plane.
    """

    above: float
    sigma: float
    shift: Floats

    @property
    def sigmas(self) -> float:
        """By how many sigmas the size contradicts the plane."""
        return abs(self.above) / self.sigma


def fit_by_size(
    on_plane: PoseEstimate,
    measures: Sequence[Measure],
    plane: Plane,
    height: float = 0.0,
    *,
    any_turn: bool = False,
) -> SizeFit | None:
    """Locate an object that lies on a plane again with the height of the plane unknown.

    None where the measurements do not determine its size.
    """
    unknown = replace(plane, sigma=_UNKNOWN_HEIGHT_SIGMA)
    found = fit_pose(on_plane.pose, measures, unknown, height, any_turn=any_turn)
    if found is None:
        return None
    normal = rotations.rotate(np.array(plane.pose.quaternion), np.array([0.0, 0.0, 1.0]))
    above = float(normal @ (np.array(found.pose.position) - plane.pose.position)) - height
    variance = float(normal @ found.covariance[:3, :3] @ normal) + plane.sigma**2
    moved_by = np.subtract(found.pose.position, on_plane.pose.position)
    turned = _turn_between(on_plane.pose, found.pose)
    return SizeFit(above, float(np.sqrt(variance)), np.concatenate([moved_by, turned]))


def _turn_between(one: Pose, other: Pose) -> Floats:
    """(3,) degrees about the axes of the world from one pose to a near one."""
    turn = rotations.multiply(
        np.array(other.quaternion), rotations.conjugate(np.array(one.quaternion))
    )
    w, *axis = np.ravel(rotations.canonical(turn))
    return np.asarray(np.degrees(2.0 * np.array(axis))) if w > 0.0 else np.zeros(3)


def moved_pose(pose: Pose, step: Floats) -> Pose:
    """The pose after a change, mm along and radians about the axes of the world."""
    angle = float(np.linalg.norm(step[3:]))
    axis = step[3:] / angle if angle > 1e-15 else np.array([0.0, 0.0, 1.0])
    turn = rotations.multiply(rotations.about(axis, np.degrees(angle)), np.array(pose.quaternion))
    return Pose.of(np.array(pose.position) + step[:3], rotations.canonical(turn))


def pixels_and_slopes(camera: Camera, pose: Pose, points: Floats) -> tuple[Floats, Floats]:
    """Pixels (n, 2) of points (n, 3) of an object, and their change (n, 2, 6) by its pose."""
    there = pose.moved(points)
    by_point = camera.slopes(there)
    arms = there - np.array(pose.position)
    # δp = δt + ω × arm, so that ∂p/∂ω = -[arm]×.
    x, y, z = arms.T
    none = np.zeros_like(x)
    cross = np.array([[none, z, -y], [-z, none, x], [y, -x, none]])
    by_turn = by_point @ np.moveaxis(cross, 2, 0)
    return camera.project(there), np.concatenate([by_point, by_turn], axis=2)


def measure_points(camera: Camera, points: Floats, pixels: Floats) -> Measure:
    """Points (n, 3) of an object that were seen at pixels (n, 2); rows u and v of each in turn."""

    def rows(pose: Pose) -> PixelErrors:
        at, slopes = pixels_and_slopes(camera, pose, points)
        return PixelErrors(
            (at - pixels).reshape(-1), slopes.reshape(-1, 6), alike=_KEYPOINT_OVERLAP
        )

    return rows


def _fit_step(
    pose: Pose,
    measures: Sequence[Measure],
    plane: Plane | None,
    height: float,
    coarse: float,
    known: Floats,
) -> tuple[Floats, Floats, float, Floats] | None:
    """The change to the pose, what is known of it, the scatter and the weights of all rows."""
    matrix, vector = known, np.zeros(6)
    weights, squares, total = list[Floats](), 0.0, 0.0
    for measure in measures:
        told = _normal_equations(measure(pose), coarse)
        matrix, vector = matrix + told.matrix, vector + told.vector
        weights.append(told.weights)
        squares += told.variance * told.weights.sum()
        total += told.weights.sum()
    if plane is not None:
        by_plane, off = _plane_rows(pose, plane, height)
        matrix, vector = matrix + by_plane.T @ by_plane, vector + by_plane.T @ off
    if not weights or total == 0.0 or not np.isfinite(matrix).all():
        return None
    # Millimetres and radians differ by the size of what is looked at.
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values = np.linalg.eigvalsh(matrix * np.outer(scale, scale))
    if values[0] < _FREE_DIRECTION_SHARE * values[-1]:
        return None
    step = np.asarray(-np.linalg.solve(matrix, vector), dtype=np.float64)
    return step, matrix, float(np.sqrt(squares / total)), np.concatenate(weights)


@dataclass(frozen=True, slots=True, eq=False)
class _NormalEquations:
    """Normal equations of rows for a change of the pose, and the variance of a row in pixels²."""

    matrix: Floats
    vector: Floats
    weights: Floats
    variance: float


def _normal_equations(rows: PixelErrors, coarse: float) -> _NormalEquations:
    good = np.isfinite(rows.offs) & np.isfinite(rows.slopes).all(axis=1)
    if good.sum() < _FEWEST_MEASUREMENTS:
        return _NormalEquations(np.zeros((6, 6)), np.zeros(6), np.zeros(len(good)), 0.0)
    offs, slopes = np.where(good, rows.offs, 0.0), np.where(good[:, None], rows.slopes, 0.0)
    middle = float(np.median(offs[good])) if rows.along else 0.0
    centred = np.where(good, offs - middle, 0.0)
    typical = max(1.4826 * float(np.median(np.abs(centred[good]))), coarse)
    weight = np.where(
        good, np.maximum(1.0 - (centred / (_TUKEY_SIGMAS * typical)) ** 2, 0.0) ** 2, 0.0
    )
    if rows.unsure is not None:
        weight = weight / (1.0 + (rows.unsure / _SURE_ROW_SIGMA) ** 2)
    count = float((weight > 0.0).sum())
    if count < _FEWEST_MEASUREMENTS:
        return _NormalEquations(np.zeros((6, 6)), np.zeros(6), np.zeros(len(good)), 0.0)
    if rows.along:
        centred = np.where(good, offs - float((weight * offs).sum() / weight.sum()), 0.0)
    variance = float((weight * centred**2).sum() / weight.sum()) / _TUKEY_SHRINKAGE
    variance = max(variance * count / max(count - 6.0, 1.0), _LEAST_PIXEL_SIGMA**2)
    scatter = variance
    variance *= rows.alike
    if rows.along:
        variance *= _correlation_factor(centred, weight > 0.0)
        variance += _SIDE_SIGMA**2 * count / _SIDES
    matrix = (slopes * weight[:, None]).T @ slopes / variance
    vector = (slopes * weight[:, None]).T @ offs / variance
    if rows.along:
        # All edges may lie a little out of the material or in it, as light and lens have it: an
        # unknown shift, of which `_EDGE_SHIFT_SIGMA` is known before, is taken out of both.
        shift = slopes.T @ weight / variance
        sure = float(weight.sum()) / variance + 1.0 / _EDGE_SHIFT_SIGMA**2
        matrix -= np.outer(shift, shift) / sure
        vector -= shift * float(weight @ offs) / variance / sure
    return _NormalEquations(matrix, vector, weight, scatter)


_TUKEY_SHRINKAGE: Final = 0.828
"""∫ w(x) x² φ / ∫ w(x) φ of Tukey's weights at `_TUKEY_SIGMAS` sigmas."""
_MOST_CORRELATED_NEIGHBOURS: Final = 8


def _correlation_factor(offs: Floats, used: Truths) -> float:
    """Return the factor by which the mean of correlated rows is less certain than it seems: one
    plus twice the sum of their correlations, up to the first that is not above 0.05.
    """
    values = np.where(used, offs, 0.0)
    power = float((values**2).sum())
    if power <= 0.0:
        return 1.0
    more = 1.0
    for lag in range(1, min(_MOST_CORRELATED_NEIGHBOURS, len(values) - 1) + 1):
        part = float((values[lag:] * values[:-lag]).sum()) / power
        if part <= 0.05:
            break
        more += 2.0 * part
    return more


def _any_turn_information(pose: Pose) -> Floats:
    """(6, 6): a turn about the normal of the face is known to `_ANY_TURN_SIGMA` degrees only."""
    axis = rotations.rotate(np.array(pose.quaternion), np.array([0.0, 0.0, 1.0]))
    known = np.zeros((6, 6))
    known[3:, 3:] = np.outer(axis, axis) / np.radians(_ANY_TURN_SIGMA) ** 2
    return known


def _plane_rows(pose: Pose, plane: Plane, height: float) -> tuple[Floats, Floats]:
    """Rows (3, 6) of the height and of both tilts, in sigmas, and how many they are off."""
    x, y, z = rotations.to_matrix(np.array(plane.pose.quaternion)).T
    up = rotations.rotate(np.array(pose.quaternion), np.array([0.0, 0.0, 1.0]))
    above = float(z @ (np.array(pose.position) - plane.pose.position)) - height
    sure, level = 1.0 / plane.sigma, 1.0 / np.radians(plane.sigma_deg)
    rows = np.zeros((3, 6))
    rows[0, :3] = z * sure
    # The axis turns by ω × up.
    rows[1, 3:], rows[2, 3:] = np.cross(up, x) * level, np.cross(up, y) * level
    return rows, np.array([above * sure, float(up @ x) * level, float(up @ y) * level])
