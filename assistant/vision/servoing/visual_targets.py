"""Targets of visual servoing: points with known positions, and their pose from picture to picture.

A target is an ArUco marker, a pointing device, or points that something else finds. Its pose is a
least-squares fit to the pixels of one or several cameras, a start from OpenCV (IPPE, SQPNP) or from
triangulated points (Kabsch, 1976). A pose whose residual is large, or that a second one fits nearly
as well, is doubtful.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any, Final, Protocol

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths, all_of
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera, triangulate
from assistant.vision.cameras.synthetic_pictures import Picture
from assistant.vision.opencv import opencv
from assistant.vision.pointing.devices import Device
from assistant.vision.pointing.mark_detection import find_spots
from assistant.vision.servoing.interaction import cross

_EDGE_MARGIN: Final = 2.0
"""Pixels from the edge of a picture within which a corner is not measured as it is."""
_MARKER_BORDER: Final = 6
"""Part of its edge, 1 in so many, that a marker has white around it."""
_LEAST_SQUARE_DISTANCE: Final = 0.05
"""Least distance of two squares, as a part of the outline: with a larger value, the edge of the
paper around a small marker counts as the marker.
"""
_RIVAL_CONFIDENCE: Final = 0.9
"""Part of the confidence of the surest spot that another one must not have."""


class VisualTarget(Protocol):
    """points: (n, 3) mm in its own frame."""

    @property
    def points(self) -> Floats: ...

    def find(self, picture: Picture, camera: Camera) -> Floats:
        """(n, 2) pixels, NaN for a point that is not seen, or not for sure."""


@dataclass(frozen=True, slots=True)
class Marker:
    """An ArUco marker. size: mm, the edge of its black square.

    Its frame has its origin in the middle, x to the right of the marker, y up and z out of it.
    dictionary: of OpenCV, without `DICT_`.
    """

    number: int
    size: float
    dictionary: str = "4X4_50"

    @property
    def points(self) -> Floats:
        """Positions of its corners, from the upper left one on clockwise, as OpenCV finds them."""
        signs = np.array([[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, -1.0, 0.0]])
        return np.asarray(signs * self.size / 2.0)

    def find(self, picture: Picture, camera: Camera) -> Floats:
        cv = opencv()
        settings = cv.aruco.DetectorParameters()
        settings.cornerRefinementMethod = cv.aruco.CORNER_REFINE_SUBPIX
        settings.minMarkerDistanceRate = _LEAST_SQUARE_DISTANCE
        detector = cv.aruco.ArucoDetector(self._dictionary(cv), settings)
        corners, numbers, _ = detector.detectMarkers(cv.cvtColor(picture, cv.COLOR_BGR2GRAY))
        none = np.full((4, 2), np.nan)
        found = np.flatnonzero(np.ravel([] if numbers is None else numbers) == self.number)
        if len(found) != 1:  # two of one number are one of them and something else
            return none
        pixels = np.asarray(corners[int(found[0])], dtype=np.float64).reshape(4, 2)
        return pixels if camera.within(pixels, _EDGE_MARGIN).all() else none

    @property
    def edge(self) -> float:
        """Edge length of `picture`, in mm."""
        return self.size * (1.0 + 2.0 / _MARKER_BORDER)

    def picture(self, dots: int = 240) -> Picture:
        """The marker with a white border of a sixth of its edge, to print or to draw."""
        cv = opencv()
        inner = np.asarray(cv.aruco.generateImageMarker(self._dictionary(cv), self.number, dots))
        return np.repeat(
            np.pad(inner, dots // _MARKER_BORDER, constant_values=255)[..., None], 3, axis=2
        )

    def _dictionary(self, cv: Any) -> Any:
        return cv.aruco.getPredefinedDictionary(getattr(cv.aruco, f"DICT_{self.dictionary}"))


@dataclass(frozen=True, slots=True)
class DeviceMarks:
    """Coloured balls or lights of a pointing device."""

    device: Device

    @property
    def points(self) -> Floats:
        return self.device.positions

    def find(self, picture: Picture, camera: Camera) -> Floats:
        pixels = np.full((len(self.device.marks), 2), np.nan)
        for row, found in enumerate(find_spots(picture, camera, self.device.marks)):
            sure = [
                spot for spot in found if spot.confidence >= _RIVAL_CONFIDENCE * found[0].confidence
            ]
            if len(sure) == 1 and not sure[0].at_edge:
                pixels[row] = sure[0].place
        return pixels


@dataclass(frozen=True, slots=True, eq=False)
class GivenPoints:
    """Points that something else finds, as a synthetic camera does that projects them."""

    points: Floats

    def find(self, picture: Picture, camera: Camera) -> Floats:  # noqa: ARG002
        return np.full((len(self.points), 2), np.nan)


_POSE_ROUNDS: Final = 12
_CONVERGED_STEP: Final = 1e-7
"""mm (and mm at the size of the thing) of a step from which on it is found."""
_FLATNESS: Final = 1e-6
"""Part of its size by which a thing may be uneven and still be flat."""
_FEWEST_FOR_POSE: Final = 3
"""Fewest points that tell a pose; fewer ones tell a place."""
_FEWEST_FOR_ONE_CAMERA: Final = 4
"""Fewest points by which one camera alone tells a pose."""
_LEAST_RANK_SHARE: Final = 1e-4
"""Part of the best determined direction from which on another one counts as determined."""


@dataclass(frozen=True, slots=True, eq=False)
class TargetPose:
    """Pose of a target. pose: in the base. residual: pixels, root mean square. other: a second pose
    that a flat thing in front of one camera fits nearly as well, with its residual; None if it is
    missing.
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
    if told * 2 < (3 if len(points) < _FEWEST_FOR_POSE else 6):
        return None
    return _least_squares(seen, points, guess)


_SeenPoints = Sequence[tuple[Camera, Floats, Truths]]


def _least_squares(seen: _SeenPoints, points: Floats, start: Pose) -> TargetPose | None:
    """Gauss and Newton from a start; turns are scaled by the size of the thing."""
    pose, size = start, _target_size(points)
    residuals = np.zeros(0)
    for _ in range(_POSE_ROUNDS):
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
        step = np.linalg.lstsq(np.concatenate(rows), residuals, rcond=_LEAST_RANK_SHARE)[0]
        turn = step[3:] / size
        angle = float(np.linalg.norm(turn))
        by = rotations.about(turn / angle if angle > 0.0 else (1.0, 0.0, 0.0), np.degrees(angle))
        quaternion = rotations.multiply(by, np.array(pose.quaternion))
        pose = Pose.of(np.array(pose.position) + step[:3], quaternion)
        if float(np.abs(step).max()) < _CONVERGED_STEP:
            break
    return TargetPose(pose, float(np.sqrt((residuals**2).mean() * 2.0)))


def _target_size(points: Floats) -> float:
    away = float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())
    return away if away > 0.0 else 1.0


def _start_poses(seen: _SeenPoints, points: Floats) -> list[Pose]:
    both = [one for one in seen if one[2].all()]
    if len(both) > 1:
        return [_triangulated_pose([c for c, _, _ in both], [p for _, p, _ in both], points)]
    if len(both) == 1 and len(points) >= _FEWEST_FOR_ONE_CAMERA:
        return _poses_of_one_camera(both[0][0], both[0][1], points)
    return []


def _triangulated_pose(cameras: Sequence[Camera], pixels: Sequence[Floats], points: Floats) -> Pose:
    """Each point by all cameras, then the turn that fits them best (Kabsch, 1976)."""
    placed = triangulate(cameras, pixels, 1.0).points
    middle, away = placed.mean(axis=0), points.mean(axis=0)
    if len(points) < _FEWEST_FOR_POSE:
        return Pose.of(middle - away, np.array([1.0, 0.0, 0.0, 0.0]))
    left, _, right = np.linalg.svd((placed - middle).T @ (points - away))
    sign = np.diag([1.0, 1.0, np.linalg.det(left @ right)])
    turn = left @ sign @ right
    return Pose.of(middle - turn @ away, rotations.from_matrix(turn))


def _poses_of_one_camera(camera: Camera, pixels: Floats, points: Floats) -> list[Pose]:
    """Both poses of a flat thing, or the one of another, by OpenCV (IPPE and SQPNP)."""
    cv = opencv()
    flat = (
        np.linalg.matrix_rank(points - points.mean(axis=0), tol=_FLATNESS * _target_size(points))
        < 3
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


_MOST_RESIDUAL: Final = 2.0
"""Pixels, root mean square, that points may be beside where those of the thing would be."""
_AMBIGUOUS_ANGLE: Final = 10.0
"""Degrees between two poses from which on it matters which one is true."""
_BETTER_FIT_RATIO: Final = 1.5
_BETTER_FIT_PIXELS: Final = 0.15
"""Ratio, and pixels, by which the second pose must fit worse for the first to be taken."""


_LEAST_NEW_SHARE: Final = 0.2
"""Part of what is seen anew that counts, once so many pictures were seen that their mean is no
better: what stands still is known the better the longer it is seen.
"""


@dataclass(slots=True)
class MeanPose:
    """A pose that hardly changes, as many pictures tell it. pose: None before the first one."""

    pose: Pose | None = None
    seen: int = 0

    def take(self, pose: Pose) -> Pose:
        """The mean with one more."""
        self.seen += 1
        part = max(_LEAST_NEW_SHARE, 1.0 / self.seen)
        self.pose = pose if self.pose is None else _interpolated_pose(self.pose, pose, part)
        return self.pose

    def forget(self) -> None:
        self.pose, self.seen = None, 0


@dataclass(slots=True)
class PoseTracker:
    """mean: of the thing in the base, which stands still."""

    mean: MeanPose = field(default_factory=MeanPose)

    def pose_of(
        self,
        cameras: Sequence[Camera],
        pixels: Mapping[str, Floats],
        points: Floats,
        guess: Pose | None = None,
    ) -> TargetPose | str | None:
        """Return its present pose; in words the reason why that is doubtful; None if its points do
        not determine it.

        guess: expected pose, None for the last one.
        """
        found = None
        if (near := guess or self.mean.pose) is not None:
            found = estimate_pose(cameras, pixels, points, near)
        if found is None or not found.residual <= _MOST_RESIDUAL:
            found = estimate_pose(cameras, pixels, points)
        if found is None:
            return None
        if not found.residual <= _MOST_RESIDUAL:
            self.forget()
            return f"what is seen is {found.residual:.1f} pixels beside what it should be"
        if (angle := _ambiguous_angle(found)) is not None:
            return f"two poses fit what is seen, {angle:.0f} degrees apart"
        return TargetPose(self.mean.take(found.pose), found.residual)

    def forget(self) -> None:
        self.mean.forget()


def _interpolated_pose(one: Pose, other: Pose, part: float) -> Pose:
    first, last = np.array(one.position), np.array(other.position)
    turns = np.array(one.quaternion), np.array(other.quaternion)
    turn = rotations.between(*turns, np.array(part)).reshape(-1)
    return Pose.of(first + part * (last - first), turn)


def pose_difference(now: Pose, goal: Pose) -> tuple[float, float]:
    """Mm and degrees between two poses."""
    away = np.array(now.position) - np.array(goal.position)
    turn = rotations.angle_between(np.array(now.quaternion), np.array(goal.quaternion))
    return float(np.linalg.norm(away)), float(turn)


def _ambiguous_angle(found: TargetPose) -> float | None:
    """Degrees between the two poses that fit, None if it is clear which one is true."""
    if found.other is None:
        return None
    pose, residual = found.other
    if residual > _BETTER_FIT_RATIO * found.residual + _BETTER_FIT_PIXELS:
        return None
    _, angle = pose_difference(found.pose, pose)
    return angle if angle > _AMBIGUOUS_ANGLE else None
