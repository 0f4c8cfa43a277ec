"""What was seen of the ways between the targets of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Ints, Rows
from assistant.base.diagnostics import Diagnostic
from assistant.program.motion import Kind
from assistant.robots import findings as rules
from assistant.robots.arms.arm import CLOSING
from assistant.robots.branches.row_reach import distance_text
from assistant.robots.branches.turns import AxisBetweenTargets
from assistant.robots.motion.run import Run
from assistant.robots.robot import Robot

BETWEEN_TOLERANCE: Final = 1e-3
"""degrees or mm by which an axis may pass its limit between rows: what is printed of them is no
better."""


@dataclass(frozen=True, slots=True)
class MotionBetweenTargets:
    """What the arm does on the way to m rows that are looked at.

    rows: (m,). winding: (m, a) whole turns that an axis makes beyond the shorter way from the
    row before. below, above: (m, a) degrees or mm by which an axis goes below and above where it
    is at the row, at most 0 and at least 0. short: (m,) mm that the way is out of reach. jumps:
    what an arm without named branches cannot do.
    """

    rows: Rows
    winding: Ints
    below: Floats
    above: Floats
    short: Floats
    jumps: tuple[tuple[int, str], ...]

    def of(self, axis: int, count: int) -> AxisBetweenTargets:
        """What one axis does on the way to each of `count` rows."""
        winding = np.zeros(count, dtype=np.int64)
        below, above = np.zeros(count), np.zeros(count)
        winding[self.rows], below[self.rows] = self.winding[:, axis], self.below[:, axis]
        above[self.rows] = self.above[:, axis]
        return AxisBetweenTargets(winding, below, above)

    def faults(self, run: Run, robot: Robot, joints: Floats) -> tuple[Rows, list[Diagnostic]]:
        """Rows to which there is no way with joints (n, a), whole turns included, and why."""
        low, high = robot.limits.T
        here = joints[self.rows]
        # Where a row is beyond a limit itself, that is told of by itself.
        under = np.where(self.below < 0.0, low - (here + self.below), -np.inf)
        over = np.where(self.above > 0.0, here + self.above - high, -np.inf)
        beyond = np.maximum(under, over)
        bad = list(self.jumps)
        for i in np.flatnonzero((self.short >= CLOSING) | (beyond > BETWEEN_TOLERANCE).any(axis=1)):
            row = int(self.rows[i])
            if self.short[i] >= CLOSING:
                bad.append((row, f"is up to {distance_text(self.short[i])} mm out of reach"))
                continue
            axis = int(beyond[i].argmax())
            least = under[i, axis] > over[i, axis]
            angle = here[i, axis] + (self.below if least else self.above)[i, axis]
            limit = (low if least else high)[axis]
            value = f"{angle:.2f} {robot.units[axis]}"
            bad.append((row, f"would have {robot.axes[axis]} at {value}, limit {limit:g}"))
        bad.sort()
        findings = []
        for way, round_ in (("straight line", False), ("arc", True)):
            told = [one for one in bad if bool(run.kinds[one[0]] != Kind.LINEAR) is round_]
            if told:
                findings.append(
                    rules.ON_THE_WAY(
                        about=run.what(np.array([row for row, _ in told], dtype=np.intp)),
                        way=way,
                        robot=robot.title,
                        reason=told[0][1],
                        where=run.label(told[0][0]),
                    )
                )
        return np.array([row for row, _ in bad], dtype=np.intp), findings
