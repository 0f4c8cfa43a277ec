"""Position-based servoing: the pose that is seen is brought to the goal's."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.geometry import IDENTITY, Pose
from assistant.vision.servoing.image_based import image_task
from assistant.vision.servoing.interaction import carried_twist, cross, turned_by
from assistant.vision.servoing.law import ARM_LENGTH, ServoMoment, ServoTask
from assistant.vision.servoing.things import VisualTarget
from assistant.vision.servoing.tracked import MeanPose, PoseTracker, pose_difference

LEAVING_EDGE: Final = 40.0
"""Pixels from the edge of a picture at which a point is about to leave it."""
FEWEST_FOR_TURN: Final = 3
"""Points of a thing from which on it tells how it is turned."""


@dataclass(slots=True)
class PoseInHand:
    """The camera is in the hand and sees the target.

    What is brought to its goal is the place of the target before the camera, and the turn of the
    camera: so the middle of the target goes in a straight line through the picture, and stays in it
    (Chaumette and Hutchinson, Visual servo control part I, 2006, "c* t o"). Its other points do
    not: where one comes near to the edge, it goes on as image-based servoing does, which leads all
    of them in lines. goal: the flange in the frame of the target.
    """

    target: VisualTarget
    goal: Pose
    tracked: PoseTracker = field(default_factory=PoseTracker)

    def task(self, moment: ServoMoment) -> ServoTask | str:
        (camera,) = moment.cameras
        found = self.tracked.pose_of(moment.cameras, moment.sight.target, self.target.points)
        if found is None or isinstance(found, str):
            return found or "the target is not seen"
        if not camera.within(moment.sight.target[camera.name], LEAVING_EDGE).all():
            return replace(image_task(moment, self.target, self.goal, found), pixels=np.nan)
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
        moves[3:, 3:] = ARM_LENGTH * np.eye(3)
        error = np.concatenate([place - np.array(wanted.position), ARM_LENGTH * turn])
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
        if len(self.mark.points) < FEWEST_FOR_TURN:
            return self._place_alone(moment.flange, mark, goal)
        return goal_task(moment.flange, mark @ self.mount.inverse(), goal, self.tip)

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
        return goal_task(moment.flange, moment.flange, self.goal, self.tip)

    def forget(self) -> None:
        """Nothing is remembered."""


def goal_task(flange: Pose, seen: Pose, goal: Pose, tip: Pose) -> ServoTask:
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
    slopes[3:, 3:] = ARM_LENGTH * np.eye(3)
    error = np.concatenate([at - np.array(wanted.position), ARM_LENGTH * turn])
    return ServoTask(error, slopes, 6, np.nan, *pose_difference(now, wanted))


def _point_slopes(point: Floats, flange: Pose) -> Floats:
    """(3, 6) change of a point of the flange by its twist."""
    return np.concatenate([np.eye(3), -cross(point - np.array(flange.position))], axis=1)
