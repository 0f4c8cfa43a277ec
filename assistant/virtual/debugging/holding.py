"""Where a run is held: break points, steps and pauses."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache
from typing import Literal

from assistant.virtual.kernel import Task

Stride = Literal["in", "over", "out"]
Reason = Literal["breakpoint", "step", "pause", "entry"]


@cache
def same_file(path: str) -> str:
    """One spelling of a file's name, however it is said."""
    return os.path.normcase(os.path.realpath(path))


@dataclass(slots=True)
class Step:
    """A step of a task. depth: how many calls run where it begins."""

    task: Task
    stride: Stride
    depth: int

    def is_done(self, task: Task) -> bool:
        if task is not self.task:
            return False
        if self.stride == "in":
            return True
        depth = len(task.levels())
        return depth < self.depth if self.stride == "out" else depth <= self.depth


@dataclass(slots=True)
class Holding:
    """points: lines with a break point by the file's name. step: the one that is being made."""

    points: dict[str, frozenset[int]] = field(default_factory=dict)
    step: Step | None = None
    pause: Reason | None = None

    def set_points(self, path: str, lines: Iterable[int]) -> None:
        """The break points of a file, instead of those that it had."""
        self.points[same_file(path)] = frozenset(lines)

    def reason(self, task: Task) -> Reason | None:
        """Why a task is held before its next statement, None if it is not."""
        if self.pause is not None:
            return self.pause
        if self.step is not None and self.step.is_done(task):
            return "step"
        if any(self.points.values()):
            place = task.where()
            if place is not None and place[1] in self.points.get(same_file(place[0]), ()):
                return "breakpoint"
        return None

    def go(self, step: Step | None = None) -> None:
        """The run goes on, to the end of a step or to whatever holds it."""
        self.step, self.pause = step, None
