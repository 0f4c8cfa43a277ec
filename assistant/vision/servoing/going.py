"""Leading the tool to a place that is known already, with or without cameras that watch it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

from assistant.controllers.setpoint_streams import Carrier
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera
from assistant.vision.servoing.bounds import Guard
from assistant.vision.servoing.law import TargetSighting
from assistant.vision.servoing.loop import Eyes, ServoResult, ServoSettings, servo
from assistant.vision.servoing.pose_based import JointsToGoal, PoseToHand
from assistant.vision.servoing.synthetic import Clock
from assistant.vision.servoing.things import VisualTarget

JOINT_PERIOD: Final = 1.0 / 30.0
"""Seconds from look to look at the joints."""
JOINT_SETTINGS: Final = ServoSettings(distance=0.1, turn=0.1, gain=4.0, share=0.6)
"""For joints, which have no noise to speak of."""


def lead_to(
    goal: Pose,
    carrier: Carrier,
    guard: Guard,
    settings: ServoSettings | None = None,
    *,
    eyes: Eyes | None = None,
    mark: tuple[VisualTarget, Pose] | None = None,
    clock: Clock | None = None,
    progress: Callable[[float], None] | None = None,
) -> ServoResult:
    """Leads the tip of the guard to a pose in the base; joints and pose that it reached.

    The way is a straight line, if nothing bars it; nobody looks whether something stands there.
    carrier: is entered. eyes, mark: cameras that stand and see what the tool carries, with its
    frame on the flange: then the tool is where they see it. None to believe the arm. An arm of five
    axes comes as near as it can turn: allow it the turn by `Settings(turn=inf)`.
    Raises Broken and Refused; the arm is brought to rest by then.
    """
    clock = clock or Clock()
    flange = goal @ guard.tip.inverse()
    if eyes is None or mark is None:
        eyes, law = NoCameras(clock), JointsToGoal(flange, guard.tip)
        return servo(
            eyes, law, carrier, guard, settings or JOINT_SETTINGS, clock=clock, progress=progress
        )
    seen = PoseToHand(mark[0], mark[1], flange, tip=guard.tip)
    return servo(eyes, seen, carrier, guard, settings, clock=clock, progress=progress)


@dataclass(slots=True)
class NoCameras:
    """Eyes that see nothing, at moments in which the joints are looked at."""

    clock: Clock = field(default_factory=Clock)
    cameras: Sequence[Camera] = ()
    _number: int = -1

    def look(self, after: float, patience: float) -> TargetSighting:  # noqa: ARG002 - one always comes
        self.clock.wait(max(after + JOINT_PERIOD - self.clock(), 0.0))
        self._number += 1
        return TargetSighting(self.clock(), self._number)
