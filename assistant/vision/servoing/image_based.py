"""Image-based servoing: pixels are brought to where they are when the tool is at its goal.

The errors are of tangents (x / z, y / z of the camera), so that lenses bend nothing. Depths come
from where the thing is estimated to be; a wrong one makes the way longer, not the goal another one.
The slopes are the mean of those here and at the goal (Malis, Improving vision-based control using
efficient second-order minimization techniques, ICRA 2004), which stays well conditioned far away.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Truths, all_of
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.servoing.estimating import TargetPose
from assistant.vision.servoing.interaction import carried_twist, interaction_matrix
from assistant.vision.servoing.law import ServoMoment, ServoTask
from assistant.vision.servoing.things import VisualTarget
from assistant.vision.servoing.tracked import PoseTracker, pose_difference

TOOL_FREEDOMS: Final = 6
"""Directions in which a tool moves; a point in a picture tells two."""
EDGE_ZONE: Final = 60.0
"""Pixels from the edge of a picture from which on it is looked whether a point will leave it."""
LEAST_EDGE_DISTANCE: Final = 15.0
"""Pixels from the edge that it must keep."""
LOOKED_AHEAD_SHARE: Final = 0.4
"""Part of the error of whose way that is looked at."""
SHRUNK_SHARE: Final = 0.8
"""How far what is seen is from the middle, and how large, once it has gone towards that."""
FEWEST_VISIBLE_POINTS: Final = 4
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
        return now if isinstance(now, str) else image_task(moment, self.target, self.goal, now)

    def forget(self) -> None:
        self.tracked.forget()


def image_task(
    moment: ServoMoment, target: VisualTarget, goal: Pose, now: TargetPose | None
) -> ServoTask:
    """What is wrong in the picture of a camera in the hand.

    now: where the target is, None where its few points do not tell how far it is: about as far as
    at the goal.
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
    if not camera.within(pixels[good], EDGE_ZONE).all():
        slopes, error = _keep_in_picture(camera, tangents, depths, slopes, error)
    slopes = slopes @ carried_twist(camera.pose, moment.flange)
    off = float(np.sqrt(_pixel_squares(camera, tangents, goals).mean()))
    return ServoTask(error, slopes, min(TOOL_FREEDOMS, 2 * len(goals)), off, *rest)


def _keep_in_picture(
    camera: Camera, tangents: Floats, depths: Floats, mean: Floats, error: Floats
) -> tuple[Floats, Floats]:
    """Slopes and errors that keep points in the picture that are near to its edge.

    The slopes at the goal have a part in bending the way of a point: where that leads out of the
    picture, those here alone lead it in a line, as far as all of them can go in one. Where that
    does not either, all of them go towards the middle of the picture, and shrink.
    """
    here = interaction_matrix(tangents, depths)
    middle = ((1.0 - SHRUNK_SHARE) * tangents).ravel()
    for slopes, wrong in ((mean, error), (here, error), (here, middle)):
        step = -LOOKED_AHEAD_SHARE * np.linalg.lstsq(slopes, wrong, rcond=1e-6)[0]
        if camera.within(
            camera.lens.pixels(tangents + (here @ step).reshape(-1, 2)), LEAST_EDGE_DISTANCE
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
        rank = min(len(error), (3, 5)[len(points) - 1] if len(points) < 3 else TOOL_FREEDOMS)
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
    """Of a few points all must be seen; of many, one may be hidden."""
    return bool(good.all()) or (
        len(good) > FEWEST_VISIBLE_POINTS and int(good.sum()) >= FEWEST_VISIBLE_POINTS
    )


def _pixel_squares(camera: Camera, tangents: Floats, goals: Floats) -> Floats:
    """(n,) of the pixels between places, by the lens without distortion."""
    off = (tangents - goals) * np.array(camera.lens.focal)
    return np.asarray((off**2).sum(axis=1))
