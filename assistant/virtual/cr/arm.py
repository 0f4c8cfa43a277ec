"""The arm of a virtual CR controller: its motions take their time, slowed by the override."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.robots import Robot
from assistant.virtual.events import Moved, Switched
from assistant.virtual.kernel import Task
from assistant.virtual.motion import Timed
from assistant.virtual.motion.flight import Flight, Start

FULL: Final = 100.0


class CrArm(Timed):
    """override: percent of the operating panel (OVRD=), which holds for motions that begin."""

    def __init__(self, robot: Robot, joints: Sequence[float]) -> None:
        super().__init__(robot, joints=joints)
        self.override = FULL

    def go(self, task: Task, moved: Moved, changes: Sequence[Switched] = ()) -> None:
        super().go(task, slowed(moved, self.override / FULL), changes)

    def halt(self) -> None:
        """Ends all motions where the arm is."""
        if self.kernel is not None:
            self.hold(self.kernel)
            self.stand_at(self._flight.start.joints.tolist())

    def stand_at(self, joints: Sequence[float]) -> None:
        """The arm is put where it stands from now on, (a,) degrees; nothing moves it there."""
        clock = 0.0 if self.kernel is None else self.kernel.clock
        self._flight = Flight(self.model, Start(np.array(joints, dtype=np.float64), clock))
        self._flying = self._braking = None
        self._held = self.behind = False
        self.legs.clear()


def slowed(moved: Moved, share: float) -> Moved:
    """A motion at a share of its speed."""
    if share >= 1.0:
        return moved
    how = replace(moved.how, rotation=moved.how.rotation * share)
    if moved.speed is not None:
        return replace(moved, speed=moved.speed * share, how=how)
    percent = FULL if moved.percent is None else moved.percent
    return replace(moved, percent=percent * share, how=how)
