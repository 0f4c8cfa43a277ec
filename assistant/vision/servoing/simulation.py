"""Simulated eyes and arm, for servoing without cameras or without a controller.

Points are projected, or bodies are drawn and searched for, where the arm is at that moment: against
a virtual controller its arm moves and the pictures follow. `IdealArm` is at once where it is sent,
in a time that only waiting advances (`SteppedClock`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from types import TracebackType
from typing import Final, Self

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots import Robot
from assistant.vision.cameras.camera import WORLD, Camera
from assistant.vision.cameras.synthetic_pictures import CLEAR, Optics, Picture, VisibleBody, draw
from assistant.vision.servoing.control_laws import TargetSighting
from assistant.vision.servoing.interaction import flange_of
from assistant.vision.servoing.visual_targets import VisualTarget as Sought

_PICTURE_RATE: Final = 30.0
"""Pictures a second."""


@dataclass(slots=True)
class Clock:
    """Seconds that only rise; pace: of them in each real one, as a virtual controller may have."""

    pace: float = 1.0

    def __call__(self) -> float:
        return self.pace * time.monotonic()

    def wait(self, seconds: float) -> None:
        time.sleep(max(0.0, seconds) / self.pace)


@dataclass(frozen=True, slots=True, eq=False)
class ServoWorld:
    """World of a simulation.

    robot, joints: the arm, and a function that returns its present joints (a,). target: with its
    pose in the base. mark: the mark on the tool, with its frame on the flange.
    """

    robot: Robot
    joints: Callable[[], Floats]
    target: tuple[Sought, Pose] | None = None
    mark: tuple[Sought, Pose] | None = None

    def placed(self, cameras: Sequence[Camera]) -> tuple[list[Camera], Pose]:
        """The cameras in the base, and the flange, now."""
        flange = flange_of(self.robot, self.joints())
        return [c if c.parent == WORLD else c.carried(flange) for c in cameras], flange


@dataclass(slots=True, eq=False)
class ProjectedEyes:
    """Exact projections with noise of normal distribution, in pixels; nothing hides anything.

    hidden: number of a picture → whether nothing is seen in it. delay: number → seconds by which
    it comes late.
    """

    cameras: Sequence[Camera]
    world: ServoWorld
    clock: Clock = field(default_factory=Clock)
    noise: float = 0.2
    rate: float = _PICTURE_RATE
    seed: int = 0
    hidden: Callable[[int], bool] = lambda _: False
    delay: Callable[[int], float] = lambda _: 0.0
    _number: int = -1
    _due: float = -np.inf

    def look(self, after: float, patience: float) -> TargetSighting | None:
        taken = _wait_for_picture(self, after)
        placed, flange = self.world.placed(self.cameras)
        self.clock.wait(min(self.delay(self._number), 2.0 * patience))
        return TargetSighting(
            taken,
            self._number,
            self._seen(placed, self.world.target, IDENTITY, 1),
            self._seen(placed, self.world.mark, flange, 2),
        )

    def _seen(
        self, cameras: Sequence[Camera], thing: tuple[Sought, Pose] | None, on: Pose, salt: int
    ) -> Mapping[str, Floats]:
        if thing is None:
            return {}
        sought, pose = thing
        points, found = (on @ pose).moved(sought.points), {}
        for place, camera in enumerate(cameras):
            chance = np.random.default_rng([self.seed, self._number, place, salt])
            pixels = camera.project(points) + chance.normal(0.0, self.noise, (len(points), 2))
            pixels[~camera.within(np.nan_to_num(pixels, nan=-1e6), 2.0)] = np.nan
            found[camera.name] = (
                np.full_like(pixels, np.nan) if self.hidden(self._number) else pixels
            )
        return found


@dataclass(slots=True, eq=False)
class DrawnEyes:
    """Eyes with drawn pictures, in which targets are detected as in those of a real camera.

    still: bodies besides the target. on_target, on_mark: bodies that represent them, in their
    frames. hidden: number of a picture → True if a hand is in front of the lens.
    """

    cameras: Sequence[Camera]
    world: ServoWorld
    on_target: Sequence[VisibleBody] = ()
    on_mark: Sequence[VisibleBody] = ()
    still: Callable[[Floats], Sequence[VisibleBody]] = lambda _: ()
    clock: Clock = field(default_factory=Clock)
    optics: Optics = CLEAR
    rate: float = _PICTURE_RATE
    seed: int = 0
    hidden: Callable[[int], bool] = lambda _: False
    _number: int = -1
    _due: float = -np.inf

    def look(self, after: float, patience: float) -> TargetSighting | None:  # noqa: ARG002 - one always comes
        taken = _wait_for_picture(self, after)
        pictures = self.pictures()
        target, mark = (
            {
                camera.name: thing[0].find(picture, camera)
                for camera, picture in zip(self.cameras, pictures, strict=True)
            }
            if thing is not None
            else {}
            for thing in (self.world.target, self.world.mark)
        )
        return TargetSighting(taken, self._number, target, mark)

    def pictures(self) -> list[Picture]:
        """Return the present picture of each camera."""
        placed, flange = self.world.placed(self.cameras)
        things = list(self.still(self.world.joints()))
        if self.world.target is not None:
            things += [_body_at(self.world.target[1], thing) for thing in self.on_target]
        if self.world.mark is not None:
            things += [_body_at(flange @ self.world.mark[1], thing) for thing in self.on_mark]
        if self.hidden(self._number):
            things = []
        seeds = (self.seed + 1000 * self._number + place for place in range(len(placed)))
        return [
            draw(camera, things, self.optics, seed=max(seed, 0))
            for camera, seed in zip(placed, seeds, strict=True)
        ]


def _wait_for_picture(eyes: ProjectedEyes | DrawnEyes, after: float) -> float:
    """Waits for the next picture that is taken after a time; when it was."""
    now, each = eyes.clock(), 1.0 / eyes.rate
    eyes._due = max(eyes._due + each, now, after + 1e-6)
    eyes.clock.wait(eyes._due - now)
    eyes._number += 1
    return eyes.clock()


def _body_at(pose: Pose, thing: VisibleBody) -> VisibleBody:
    return replace(thing, pose=pose @ thing.pose)


class SteppedClock(Clock):
    """A clock that only waiting moves on."""

    __slots__ = ("now",)

    def __init__(self) -> None:
        super().__init__()
        self.now = 0.0

    def __call__(self) -> float:
        return self.now

    def wait(self, seconds: float) -> None:
        self.now += max(0.0, seconds)


class IdealArm:
    """A `Carrier`. at: (a,) last commanded position. speeds: (a,) limits of steps. clock: by which
    it gets there in the time of a step, None for at once.

    rows: the commanded positions, one after the other. rested: number of calls of `rest`.
    """

    waits = False

    def __init__(
        self, at: Floats, speeds: Floats, period: float = 0.02, clock: Clock | None = None
    ) -> None:
        self.at, self.speeds, self.period = np.array(at, dtype=np.float64), speeds, period
        self.rows: list[Floats] = [self.at]
        self.rested = 0
        self._clock, self._left = clock, self.at
        self._since, self._takes = 0.0, 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Nothing is open."""

    def joints(self) -> Floats:
        if self._clock is None or self._takes <= 0.0:
            return self.at
        share = float(np.clip((self._clock() - self._since) / self._takes, 0.0, 1.0))
        return np.asarray(self._left + share * (self.at - self._left))

    def told(self) -> Floats:
        return self.at

    def move(self, to: Floats, seconds: float) -> None:
        if self._clock is not None:
            self._left, self._since, self._takes = self.joints(), self._clock(), seconds
        self.at = np.array(to)
        self.rows.append(self.at)

    def rest(self) -> None:
        """Stop at the present position."""
        self.at, self._takes = self.joints(), 0.0
        self.rested += 1
