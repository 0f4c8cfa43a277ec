"""An arm that is not there: a robot whose tool synthetic cameras see, for learning without one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, rows_of
from assistant.base.diagnostics import Refused
from assistant.learning.maps.extended_map import MapTask
from assistant.learning.maps.rules import NO_AXIS, NO_LENGTH
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.robots.arms.closed_form import FiveAxis, Lengths, SixAxis
from assistant.vision.cameras.camera import Camera, Lens, looking_at

LENGTH_NAMES: Final = ("d1", "a1", "a2", "a3", "d4", "d6")


@dataclass(frozen=True, eq=False)
class ObservedArm:
    """Called with joints (n, a) of `moves` it answers pixels (n, d), as `trials.Arm`.

    robot: in whose base the cameras stand. moves: names of the joints that move; the others stay at
    `rest`, (robot's a,), by default its home. points: (k, 3) mm of the tool in the frame of the
    flange. noise: pixels, one sigma, drawn by `seed`. free: the orientation of the tool is free, so
    that fewer points than the joints need are enough: only their places are learnt.
    """

    robot: Robot
    cameras: tuple[Camera, ...]
    points: Floats
    moves: tuple[str, ...]
    rest: Floats
    noise: float = 0.0
    seed: int = 0
    free: bool = False
    _draw: np.random.Generator = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_draw", np.random.default_rng(self.seed))

    def __call__(self, joints: Floats) -> Floats:
        return self.seen(self.tool(joints)[0])

    def tool(self, joints: Floats) -> tuple[Floats, Floats]:
        """Joints (n, a) → the points of the tool (n, k, 3) mm and its rotation (n, 4); the truth,
        which the map never sees.
        """
        whole = np.tile(self.rest, (len(joints), 1))
        whole[:, self.columns] = joints
        positions, turns = self.robot.fk(whole)
        return positions[:, None] + rotations.rotate(turns[:, None], self.points), turns

    def seen(self, points: Floats) -> Floats:
        """Points (n, k, 3) of a tool → pixels (n, d), with noise; NaN outside of a picture."""
        out = np.empty((*points.shape[:2], len(self.cameras), 2))
        flat = points.reshape(-1, 3)
        for i, camera in enumerate(self.cameras):
            pixels = camera.project(flat)
            pixels[~camera.within(pixels)] = np.nan
            out[:, :, i] = pixels.reshape(*points.shape[:2], 2)
        if self.noise:
            out += self._draw.normal(0.0, self.noise, out.shape)
        return out.reshape(len(points), -1)

    @cached_property
    def columns(self) -> list[int]:
        return [self.robot.axes.index(name) for name in self.moves]

    @property
    def task(self) -> MapTask:
        names = tuple(camera.name for camera in self.cameras)
        return MapTask(self.robot.name, self.moves, names, len(self.points))

    def noisy(self, noise: float, seed: int = 0) -> ObservedArm:
        return replace(self, noise=noise, seed=seed)

    def bent(self, points: Floats) -> ObservedArm:
        """With another tool."""
        return replace(self, points=points)

    def watched(self, cameras: Sequence[Camera]) -> ObservedArm:
        """By other cameras, or by the same ones that have been moved."""
        return replace(self, cameras=tuple(cameras))

    def longer(self, name: str, factor: float) -> ObservedArm:
        """With another length of a link, by its name in `Lengths`; raises Refused for none."""
        return replace(self, robot=with_length(self.robot, name, factor))


def observed_arm(
    robot: Robot,
    cameras: Sequence[Camera],
    points: Sequence[Sequence[float]],
    moves: Sequence[str] = (),
    rest: Floats | None = None,
) -> ObservedArm:
    """moves: by default all joints. Raises Refused for a joint that the robot has not."""
    known = tuple(moves) or robot.axes
    for name in known:
        if name not in robot.axes:
            finding = NO_AXIS(robot=robot.title, axis=name, known=", ".join(robot.axes))
            raise Refused(finding, exit_status=2)
    still = robot.home if rest is None else np.asarray(rest, dtype=np.float64)
    tool = rows_of(points, 3, "points")
    return ObservedArm(robot, tuple(cameras), tool, known, still)


def with_length(robot: Robot, name: str, factor: float) -> Robot:
    """The robot with one length times a factor; raises Refused for a length that it has not."""
    lengths = getattr(robot.arm, "lengths", None)
    known = [one for one in LENGTH_NAMES if getattr(lengths, one, 0.0)]
    if not isinstance(robot.arm, SixAxis | FiveAxis) or name not in known:
        finding = NO_LENGTH(robot=robot.title, name=name, known=", ".join(known) or "none")
        raise Refused(finding, exit_status=2)
    values = {one: getattr(lengths, one) for one in LENGTH_NAMES}
    values[name] *= factor
    return replace(robot, arm=replace(robot.arm, lengths=Lengths(**values)))


PAIR_LENS: Final = Lens.ideal((640, 480), 800.0)
PAIR_MARGIN: Final = 30.0
"""Pixels that are kept free at the edges by `pair_for`."""
PAIR_ASIDE: Final = 0.3
"""Of the distance by which each of the two cameras stands aside."""
PAIR_HEIGHT: Final = 0.35
"""Of the distance by which they stand higher than what they look at."""


def pair_for(points: Floats, lens: Lens = PAIR_LENS) -> tuple[Camera, Camera]:
    """Two cameras in front of a robot that see points (n, 3) mm of its base, as near as can be."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    distance = max(float(np.linalg.norm(np.ptp(points, axis=0))), 1.0)
    while True:
        cameras = tuple(
            Camera(name, lens, _pose_of_pair(middle, distance, side * PAIR_ASIDE))
            for name, side in (("left", -1.0), ("right", 1.0))
        )
        if all(one.within(one.project(points), PAIR_MARGIN).all() for one in cameras):
            return cameras[0], cameras[1]
        distance *= 1.05


def _pose_of_pair(middle: Floats, distance: float, aside: float) -> Pose:
    ahead = np.array([1.0, aside, PAIR_HEIGHT])
    eye = middle + distance * ahead / np.linalg.norm(ahead)
    return looking_at(eye, middle)
