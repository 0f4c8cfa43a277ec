"""The arm of a virtual CR controller: its motions take their time, slowed by the override."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from assistant.robots import Robot
from assistant.virtual.events import Moved, Switched
from assistant.virtual.kernel import Task
from assistant.virtual.motion import Timed

FULL_OVERRIDE: Final = 100.0


class CrArm(Timed):
    """override: percent of the operating panel (OVRD=), which holds for motions that begin."""

    def __init__(self, robot: Robot, joints: Sequence[float]) -> None:
        super().__init__(robot, joints=joints)
        self.override = FULL_OVERRIDE

    def go(self, task: Task, moved: Moved, changes: Sequence[Switched] = ()) -> None:
        super().go(task, scaled_speed(moved, self.override / FULL_OVERRIDE), changes)

    def halt(self) -> None:
        """Ends all motions where the arm is."""
        if self.kernel is not None:
            self.hold(self.kernel)
            self.lead(self.kernel, self.where()[1])


def scaled_speed(moved: Moved, share: float) -> Moved:
    """A motion at a share of its speed."""
    if share >= 1.0:
        return moved
    how = replace(moved.how, rotation=moved.how.rotation * share)
    if moved.speed is not None:
        return replace(moved, speed=moved.speed * share, how=how)
    percent = FULL_OVERRIDE if moved.percent is None else moved.percent
    return replace(moved, percent=percent * share, how=how)
