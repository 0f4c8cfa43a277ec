"""Control laws of visual servoing: image-based and position-based.

A law gets a sighting and returns a `ServoTask`: the error, and its change by the twist of the
flange. It does not control the motion of the arm; the loop brings the error to 0.

Image-based: the law moves pixels to their positions for the tool at its goal. Errors are of
tangents (x / z, y / z of the camera), so lens distortion has no effect. Depths come from the
estimated pose; a wrong depth lengthens the path and leaves the goal. The slopes are the mean of
those at the present pose and at the goal (Malis, Improving vision-based control using efficient
second-order minimization techniques, ICRA 2004), which stays well conditioned far away.
Position-based: the law moves the seen pose to the goal's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from typing import Final, Protocol

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths, all_of
from assistant.base.data_classes import dataclass
from assistant.program.geometry import IDENTITY, Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.servoing.interaction import (
    carried_twist,
    cross,
    interaction_matrix,
    turned_by,
)
from assistant.vision.servoing.visual_targets import (
    MeanPose,
    PoseTracker,
    TargetPose,
    VisualTarget,
    pose_difference,
)

_ARM_LENGTH: Final = 100.0
"""mm by which a turn is weighed against a way: one degree as 1.7 mm."""


@dataclass(frozen=True, slots=True, eq=False)
class TargetSighting:
    """Sighting at one moment. seconds: time of the pictures, by the clock of the loop; pictures of
    several cameras have the time of the oldest. number: of the picture.

    target, mark: camera → (n, 2) pixels of the points of the servoing target, and of the mark on
    the tool; NaN for hidden points.
    """

    seconds: float
    number: int
    target: Mapping[str, Floats] = field(default_factory=dict)
    mark: Mapping[str, Floats] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class ServoMoment:
    """A sighting, with the poses of the cameras in the base and of the flange at that moment."""

    cameras: Sequence[Camera]
    sight: TargetSighting
    flange: Pose


@dataclass(frozen=True, slots=True, eq=False)
class ServoTask:
    """error: (m,) what is to become 0. slopes: (m, 6) its change by the twist of the flange, of its
    point in the axes of the base, mm/s and rad/s. rank: how many of the six it tells.

    pixels: of the error, root mean square, NaN for a law that does not go by them. distance, turn:
    mm and degrees that are left, NaN where that is not told.
    """

    error: Floats
    slopes: Floats
    rank: int
    pixels: float = np.nan
    distance: float = np.nan
    turn: float = np.nan

    @property
    def size(self) -> float:
        """Remaining error, in a unit that stays the same for a law: it shows whether the error
        grows.
        """
        if np.isfinite(self.pixels):
            return self.pixels
        turn = 0.0 if np.isnan(self.turn) else np.radians(self.turn)
        return float(self.distance + _ARM_LENGTH * turn)

    @property
    def condition(self) -> float:
        """Condition number of the directions that the task determines.

        Turns are weighted by `_ARM_LENGTH`.
        """
        scaled = self.slopes / np.array([1.0] * 3 + [_ARM_LENGTH] * 3)
        values = np.linalg.svd(scaled, compute_uv=False)
        if len(values) < self.rank or not values[self.rank - 1] > 0.0:
            return float("inf")
        return float(values[0] / values[self.rank - 1])


class ControlLaw(Protocol):
    """Made for one servoing: it may remember what it saw before."""

    def task(self, moment: ServoMoment) -> ServoTask | str:
        """Return the task, or the reason in words why it is unknown: then the target counts as not
        seen.
        """

    def forget(self) -> None:
        """Forget earlier sightings: they are of another time."""


_TOOL_FREEDOMS: Final = 6
"""Directions in which a tool moves; a point in a picture tells two."""
_EDGE_ZONE: Final = 60.0
"""Pixels from the edge of a picture from which on it is looked whether a point will leave it."""
_LEAST_EDGE_DISTANCE: Final = 15.0
"""Pixels from the edge that it must keep."""
_LOOKED_AHEAD_SHARE: Final = 0.4
"""Share of the error over which the path of the points is predicted."""
_SHRUNK_SHARE: Final = 0.8
"""Predicted distance from the middle and size of the seen points, as a factor of the present
ones.
"""
_FEWEST_VISIBLE_POINTS: Final = 4
"""Points of which none may be hidden."""


@dataclass(slots=True)
class ImageInHand:
    """The camera is in the hand and sees the target.

    target: what is seen. goal: the flange in the frame of the target.
    """

    target: VisualTarget
    goal: Pose
    tracked: PoseTracker = field(default_factory=PoseTracker)

    def task(self, moment: ServoMoment) -> ServoTask | str:
        (camera,) = moment.cameras
        if not _enough_points(all_of(np.isfinite(moment.sight.target[camera.name]))):
            return "the target is not seen"
        now = self.tracked.pose_of(moment.cameras, moment.sight.target, self.target.points)
        return now if isinstance(now, str) else _image_task(moment, self.target, self.goal, now)

    def forget(self) -> None:
        self.tracked.forget()


def _image_task(
    moment: ServoMoment, target: VisualTarget, goal: Pose, now: TargetPose | None
) -> ServoTask:
    """Return the task for the error in the picture of a camera in the hand.

    now: pose of the target, None if its few points do not determine its distance: the depths are
    then those at the goal.
    """
    (camera,) = moment.cameras
    pixels = moment.sight.target[camera.name]
    good = all_of(np.isfinite(pixels))
    mount = moment.flange.inverse() @ camera.pose
    wanted = (mount.inverse() @ goal.inverse()).moved(target.points)[good]
    depths, rest = wanted[:, 2], (np.nan, np.nan)
    if now is not None:
        depths = camera.seen_by(now.pose.moved(target.points))[good, 2]
        rest = pose_difference(moment.flange, now.pose @ goal)
    tangents, goals = camera.lens.tangents(pixels[good]), wanted[:, :2] / wanted[:, 2:]
    error, slopes = (tangents - goals).ravel(), _mean_slopes(tangents, depths, goals, wanted[:, 2])
    if not camera.within(pixels[good], _EDGE_ZONE).all():
        slopes, error = _keep_in_picture(camera, tangents, depths, slopes, error)
    slopes = slopes @ carried_twist(camera.pose, moment.flange)
    off = float(np.sqrt(_pixel_squares(camera, tangents, goals).mean()))
    return ServoTask(error, slopes, min(_TOOL_FREEDOMS, 2 * len(goals)), off, *rest)


def _keep_in_picture(
    camera: Camera, tangents: Floats, depths: Floats, mean: Floats, error: Floats
) -> tuple[Floats, Floats]:
    """Slopes and errors that keep points in the picture that are near to its edge.

    The slopes at the goal have a part in bending the way of a point: where that leads out of the
    picture, those here alone lead it in a line, as far as all of them can go in one. Where that
    does not either, all of them go towards the middle of the picture, and shrink.
    """
    here = interaction_matrix(tangents, depths)
    middle = ((1.0 - _SHRUNK_SHARE) * tangents).ravel()
    for slopes, wrong in ((mean, error), (here, error), (here, middle)):
        step = -_LOOKED_AHEAD_SHARE * np.linalg.lstsq(slopes, wrong, rcond=1e-6)[0]
        if camera.within(
            camera.lens.pixels(tangents + (here @ step).reshape(-1, 2)), _LEAST_EDGE_DISTANCE
        ).all():
            return slopes, wrong
    return here, middle


@dataclass(slots=True)
class ImageToHand:
    """Cameras stand still and see a mark that the tool carries.

    mark: what is seen of the tool. mount: the frame of the mark on the flange. goal: the flange in
    the base, or in the frame of the target, which is seen by the same cameras.
    """

    mark: VisualTarget
    mount: Pose
    goal: Pose
    target: VisualTarget | None = None
    tracked: PoseTracker = field(default_factory=PoseTracker)

    def task(self, moment: ServoMoment) -> ServoTask | str:
        goal = self.goal
        if self.target is not None:
            at = self.tracked.pose_of(moment.cameras, moment.sight.target, self.target.points)
            if at is None or isinstance(at, str):
                return at or "the target is not seen"
            goal = at.pose @ self.goal
        points = self.mark.points
        placed, wanted = ((one @ self.mount).moved(points) for one in (moment.flange, goal))
        parts = [
            part
            for camera in moment.cameras
            if (part := self._of(camera, moment, placed, wanted)) is not None
        ]
        if not parts:
            return "the mark on the tool is not seen"
        errors, slopes, squares = zip(*parts, strict=True)
        error, off = np.concatenate(errors), float(np.sqrt(np.concatenate(squares).mean()))
        # One point in any number of cameras tells a place, two tell all but one turn.
        rank = min(len(error), (3, 5)[len(points) - 1] if len(points) < 3 else _TOOL_FREEDOMS)
        return ServoTask(error, np.concatenate(slopes), rank, off)

    def _of(
        self, camera: Camera, moment: ServoMoment, placed: Floats, wanted: Floats
    ) -> tuple[Floats, Floats, Floats] | None:
        pixels = moment.sight.mark.get(camera.name)
        if pixels is None:
            return None
        good = all_of(np.isfinite(pixels))
        if not _enough_points(good):
            return None
        tangents = camera.lens.tangents(pixels[good])
        there, depths = camera.seen_by(wanted)[good], camera.seen_by(placed)[good, 2]
        goals = there[:, :2] / there[:, 2:]
        # What moves are the points: as they have it, the camera moves the other way.
        slopes = -_mean_slopes(tangents, depths, goals, there[:, 2])
        slopes = slopes @ carried_twist(camera.pose, moment.flange)
        return (tangents - goals).ravel(), slopes, _pixel_squares(camera, tangents, goals)

    def forget(self) -> None:
        self.tracked.forget()


def _mean_slopes(tangents: Floats, depths: Floats, goals: Floats, goal_depths: Floats) -> Floats:
    here, there = interaction_matrix(tangents, depths), interaction_matrix(goals, goal_depths)
    return (here + there) / 2.0


def _enough_points(good: Truths) -> bool:
    """True if enough points are seen: all of a few points; of many points, one may be hidden."""
    return bool(good.all()) or (
        len(good) > _FEWEST_VISIBLE_POINTS and int(good.sum()) >= _FEWEST_VISIBLE_POINTS
    )


def _pixel_squares(camera: Camera, tangents: Floats, goals: Floats) -> Floats:
    """(n,) of the pixels between places, by the lens without distortion."""
    off = (tangents - goals) * np.array(camera.lens.focal)
    return np.asarray((off**2).sum(axis=1))


_LEAVING_EDGE: Final = 40.0
"""Pixels from the edge of a picture at which a point is about to leave it."""
_FEWEST_FOR_TURN: Final = 3
"""Points of a thing from which on it tells how it is turned."""


@dataclass(slots=True)
class PoseInHand:
    """Position-based law for a camera in the hand that sees the target.

    The law brings the position of the target in front of the camera, and the turn of the camera, to
    their goals: so the middle of the target moves in a straight line through the picture, and stays
    in it (Chaumette and Hutchinson, Visual servo control part I, 2006, "c* t o"). Its other points
    do not: if one approaches the edge, the law continues as image-based servoing, which moves all
    of them in straight lines. goal: the flange in the frame of the target.
    """

    target: VisualTarget
    goal: Pose
    tracked: PoseTracker = field(default_factory=PoseTracker)

    def task(self, moment: ServoMoment) -> ServoTask | str:
        (camera,) = moment.cameras
        found = self.tracked.pose_of(moment.cameras, moment.sight.target, self.target.points)
        if found is None or isinstance(found, str):
            return found or "the target is not seen"
        if not camera.within(moment.sight.target[camera.name], _LEAVING_EDGE).all():
            return replace(_image_task(moment, self.target, self.goal, found), pixels=np.nan)
        mount = moment.flange.inverse() @ camera.pose
        now, wanted = camera.pose.inverse() @ found.pose, (self.goal @ mount).inverse()
        place = np.array(now.position)
        turn = turned_by(
            rotations.multiply(
                np.array(wanted.quaternion), rotations.conjugate(np.array(now.quaternion))
            )
        )
        moves = np.zeros((6, 6))
        moves[:3, :3], moves[:3, 3:] = -np.eye(3), cross(place)
        moves[3:, 3:] = _ARM_LENGTH * np.eye(3)
        error = np.concatenate([place - np.array(wanted.position), _ARM_LENGTH * turn])
        slopes = moves @ carried_twist(camera.pose, moment.flange)
        return ServoTask(
            error, slopes, 6, np.nan, *pose_difference(moment.flange, found.pose @ self.goal)
        )

    def forget(self) -> None:
        self.tracked.forget()


@dataclass(slots=True)
class PoseToHand:
    """Cameras stand still and see a mark that the tool carries: it is where they see it, whatever
    the arm says. How far from there that is hardly changes: their mean of it is gone by.

    mark: what is seen of the tool. mount: the frame of the mark on the flange. goal: the flange in
    the base, or in the frame of the target, which is seen by the same cameras. tip: of the tool on
    the flange, which goes straight to its goal.
    """

    mark: VisualTarget
    mount: Pose
    goal: Pose
    target: VisualTarget | None = None
    tip: Pose = IDENTITY
    tracked: PoseTracker = field(default_factory=PoseTracker)
    beside: MeanPose = field(default_factory=MeanPose)

    def task(self, moment: ServoMoment) -> ServoTask | str:
        goal = self.goal
        if self.target is not None:
            at = self.tracked.pose_of(moment.cameras, moment.sight.target, self.target.points)
            if at is None or isinstance(at, str):
                return at or "the target is not seen"
            goal = at.pose @ self.goal
        near = moment.flange @ self.mount
        seen = PoseTracker().pose_of(moment.cameras, moment.sight.mark, self.mark.points, near)
        if seen is None or isinstance(seen, str):
            return seen or "the mark on the tool is not seen"
        mark = near @ self.beside.take(near.inverse() @ seen.pose)
        if len(self.mark.points) < _FEWEST_FOR_TURN:
            return self._place_alone(moment.flange, mark, goal)
        return _goal_task(moment.flange, mark @ self.mount.inverse(), goal, self.tip)

    def forget(self) -> None:
        self.tracked.forget()
        self.beside.forget()

    def _place_alone(self, flange: Pose, mark: Pose, goal: Pose) -> ServoTask:
        """The place of the mark's own point; the turn stays what the arm makes of it."""
        at = mark.moved(self.mark.points).mean(axis=0)
        wanted = (goal @ self.mount).moved(self.mark.points).mean(axis=0)
        error = at - wanted
        return ServoTask(error, _point_slopes(at, flange), 3, np.nan, float(np.linalg.norm(error)))


@dataclass(slots=True)
class JointsToGoal:
    """No camera: the arm is where its joints say. goal: the flange in the base."""

    goal: Pose
    tip: Pose = IDENTITY

    def task(self, moment: ServoMoment) -> ServoTask:
        return _goal_task(moment.flange, moment.flange, self.goal, self.tip)

    def forget(self) -> None:
        """Nothing is remembered."""


def _goal_task(flange: Pose, seen: Pose, goal: Pose, tip: Pose) -> ServoTask:
    """The way of a tip in the base, and its turn.

    flange: by the joints of the arm. seen: where it is, goal: where it should be.
    """
    now, wanted = seen @ tip, goal @ tip
    at = np.array(now.position)
    turn = turned_by(
        rotations.multiply(
            np.array(now.quaternion), rotations.conjugate(np.array(wanted.quaternion))
        )
    )
    slopes = np.zeros((6, 6))
    slopes[:3] = _point_slopes(np.array((flange @ tip).position), flange)
    slopes[3:, 3:] = _ARM_LENGTH * np.eye(3)
    error = np.concatenate([at - np.array(wanted.position), _ARM_LENGTH * turn])
    return ServoTask(error, slopes, 6, np.nan, *pose_difference(now, wanted))


def _point_slopes(point: Floats, flange: Pose) -> Floats:
    """(3, 6) change of a point of the flange by its twist."""
    return np.concatenate([np.eye(3), -cross(point - np.array(flange.position))], axis=1)
