"""A program's motion as a table in time, and how it is played: paused, faster, from the begin."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.robots.timing.simulation import samples_of

if TYPE_CHECKING:
    from assistant.robots.timing import Samples, Simulation


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Rows of a motion, one each period and the last one at its end.

    table: (n, a + 8) joints, position in mm and quaternion of the tool, its speed in mm/s.
    """

    table: Floats
    period: float
    seconds: float

    @staticmethod
    def of(simulation: Simulation) -> Motion:
        """The samples of a simulation at its period, and where it ends."""
        seconds, period = simulation.seconds, simulation.period
        table = _motion_rows(simulation.samples)
        if seconds > 0.0:
            ends = (simulation.history, seconds, seconds, simulation.robot, simulation.start)
            # A sample at the end itself, or so near to it that nothing is between, gives way.
            kept = math.ceil(seconds / period - 1e-6)
            table = np.concatenate([table[:kept], _motion_rows(samples_of(*ends))[-1:]])
        return Motion(table, period, seconds)

    def at(self, time: float) -> Floats:
        """(a + 8,) between two rows: in lines, and the tool on the shorter turn."""
        row = min(math.floor(time / self.period), len(self.table) - 2)
        start = row * self.period
        end = self.seconds if row == len(self.table) - 2 else (row + 1) * self.period
        part = max(0.0, min(1.0, (time - start) / (end - start)))
        one, two = self.table[row], self.table[row + 1]
        out = one + part * (two - one)
        turn = slice(len(out) - 5, len(out) - 1)
        out[turn] = rotations.between(one[turn], two[turn], part)
        return np.asarray(out)


@dataclass(slots=True)
class Playback:
    """A motion that is played. repeat: again from the begin at the end.

    time: how far it is, in seconds of the program. ends: how often it came to its end.
    """

    motion: Motion
    repeat: bool = False
    time: float = 0.0
    ends: int = 0
    _before: bool = field(default=False, repr=False)
    _lost: float = field(default=0.0, repr=False)

    def step(
        self, seconds: float, *, play: bool = True, restart: bool = False, factor: float = 1.0
    ) -> Floats:
        """The row (a + 8,) after a step.

        play: whether it goes on. restart: from the begin, where it was false before. factor: how
        fast it is played; what is not above 0 holds it.
        """
        if restart and not self._before:
            self.time = self._lost = 0.0
        self._before = restart
        end = self.motion.seconds
        if play and factor > 0.0 and self.time < end:
            self._on(seconds * factor)
            if self.time >= end:
                self.ends += 1
                self.time = math.fmod(self.time, end) if self.repeat else end
                self._lost = 0.0
        return self.motion.at(self.time)

    def _on(self, seconds: float) -> None:
        """Adds to the time, with what rounding loses (Kahan, 1965): steps are many and short."""
        more = seconds - self._lost
        later = self.time + more
        self._lost = (later - self.time) - more
        self.time = later


def _motion_rows(samples: Samples) -> Floats:
    return np.column_stack(
        [samples.joints, samples.position, samples.quaternion, samples.tcp_speed]
    )
