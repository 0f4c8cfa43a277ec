"""Sources: constants, motions of programs, paths over time, pose to pose."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats, finite_columns, finite_row, number_within, row_of
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams import Block, Port
from assistant.blocks.library.ports import joints_port, pose_port, pose_signal
from assistant.blocks.rules import BAD_TIMES
from assistant.program.se3 import AnyPose, pose_of
from assistant.robots.robot import Robot


class Constant(Block):
    """The same numbers at all times; NaN for a value that is not known."""

    def __init__(self, name: str, value: ArrayLike, unit: str = "") -> None:
        self.value = row_of(value, f"value of `{name}`")
        super().__init__(name, (), [Port("value", len(self.value), unit)])

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del now, given
        return [self.value]


class Table(Block):
    """Rows (n, k) at increasing times (n,), interpolated linearly and constant before and after.

    Takes the columns of a recording, a simulation or the user's computation without a copy. Raises
    Refused for an invalid table.
    """

    def __init__(
        self, name: str, seconds: ArrayLike, rows: ArrayLike, *, port: Port | None = None
    ) -> None:
        self.seconds = finite_row(seconds, f"seconds of `{name}`")
        self.rows = finite_columns(rows, f"rows of `{name}`", port.size if port else None)
        if len(self.seconds) != len(self.rows):
            reason = f"are {len(self.seconds)}, and it has {len(self.rows)} rows"
            raise Refused(BAD_TIMES(block=name, reason=reason))
        if not (np.diff(self.seconds) > 0.0).all():
            row = int(np.argmin(np.diff(self.seconds) > 0.0)) + 2
            raise Refused(BAD_TIMES(block=name, reason=f"do not rise at row {row}"))
        width = self.rows.shape[1]
        super().__init__(name, (), [port or Port("value", width), Port("over")])

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del given
        row = int(np.clip(np.searchsorted(self.seconds, now), 1, max(len(self.seconds) - 1, 1)))
        over = float(now >= self.seconds[-1])
        if len(self.seconds) == 1:
            return [self.rows[0], [over]]
        start, end = self.seconds[row - 1], self.seconds[row]
        part = np.clip((now - start) / (end - start), 0.0, 1.0)
        return [self.rows[row - 1] + part * (self.rows[row] - self.rows[row - 1]), [over]]


def joint_table(name: str, robot: Robot, seconds: ArrayLike, joints: ArrayLike) -> Table:
    """Joints (n, a) of an arm over time: what `assistant.simulate(…).simulation.samples` holds."""
    return Table(name, seconds, joints, port=joints_port(robot))


class PoseToPose(Block):
    """From one pose to another on a line in so many seconds, at rest at both ends.

    The speed rises and falls as a trapezoid, with a third of the time for each part; the turn is
    about one axis.
    """

    def __init__(self, name: str, start: AnyPose, end: AnyPose, seconds: float) -> None:
        self.seconds = number_within(seconds, f"seconds of `{name}`", above=0.0)
        super().__init__(name, (), [pose_port(), Port("over")])
        self._ends = pose_of(start, what="start"), pose_of(end, what="end")

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        del given
        part = trapezoid(now / self.seconds)
        first, last = (np.array(one.position) for one in self._ends)
        turns = [np.array([one.quaternion]) for one in self._ends]
        turn = rotations.between(turns[0], turns[1], [part])[0]
        return [pose_signal(first + part * (last - first), turn), [float(now >= self.seconds)]]


def trapezoid(part: float) -> float:
    """Return the position, 0 to 1, at a part of the time: speed rises, holds, falls in thirds."""
    t = min(max(part, 0.0), 1.0)
    if t < 1.0 / 3.0:
        return 2.25 * t * t
    if t > 2.0 / 3.0:
        return 1.0 - 2.25 * (1.0 - t) ** 2
    return 1.5 * t - 0.25
