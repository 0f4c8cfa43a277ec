"""What a loop did: whether its answers were in time, and what the controller told meanwhile."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic
from assistant.controllers.cyclic.rules import MISSED, PRIORITY
from assistant.controllers.recording import save_columns


@dataclass(frozen=True, slots=True)
class Delays:
    """Seconds from the arrival of a packet in this machine to its answer being sent.

    late: how many were more than half a cycle. measured: `kernel` if the arrival was stamped by
    it, `program` if only when the program saw the packet, which hides the time until it woke up.
    """

    count: int
    median: float
    most_of: float
    longest: float
    late: int
    measured: str

    @staticmethod
    def of(seconds: Floats, cycle: float, measured: str) -> Delays:
        """most_of: the 99th percentile."""
        if not len(seconds):
            return Delays(0, 0.0, 0.0, 0.0, 0, measured)
        median, most_of = np.percentile(seconds, (50, 99))
        late = int((seconds > cycle / 2.0).sum())
        return Delays(
            len(seconds), float(median), float(most_of), float(seconds.max()), late, measured
        )

    def __str__(self) -> str:
        ms = [f"{1e3 * value:.3f}" for value in (self.median, self.most_of, self.longest)]
        return (
            f"delay of {self.count} answers: median {ms[0]} ms, 99 % below {ms[1]} ms, longest "
            f"{ms[2]} ms; {self.late} later than half a cycle"
        )


@dataclass(frozen=True, slots=True)
class Timing:
    """How a loop has kept its time by now.

    cycles: packets that were answered. late: how many of them more than half a cycle after they
    came. longest, jitter: seconds, the greatest of these delays and their standard deviation.
    """

    cycles: int = 0
    late: int = 0
    longest: float = 0.0
    jitter: float = 0.0


@dataclass(slots=True)
class TimingRecorder:
    """Gathers a `Timing` while a loop runs. half: seconds of half a cycle."""

    half: float
    count: int = 0
    late: int = 0
    longest: float = 0.0
    sum: float = 0.0
    squares: float = 0.0

    def add(self, delay: float) -> None:
        self.count += 1
        self.late += delay > self.half
        self.longest = max(self.longest, delay)
        self.sum += delay
        self.squares += delay * delay

    @property
    def timing(self) -> Timing:
        count = max(1, self.count)
        spread = max(0.0, self.squares / count - (self.sum / count) ** 2) ** 0.5
        return Timing(self.count, self.late, self.longest, spread)


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """A trajectory that was followed, or the part of it up to a failure.

    done, rows: points that were sent, of how many. seconds: that it took. cycle: of the controller.
    asked_again: times when the controller was silent for a while. repeated: packets that came
    twice or out of order. garbled: without sense. missed: the most cycles in a row that the
    controller says it was left without a command. priority: what the loop ran with; refused: why
    that is no real-time priority, "" if it is or was not wanted.
    columns: what was recorded, one value a packet: `time` in seconds since the first, `row` of the
    trajectory, where the arm was by the names of its joints or of its pose, `to_…` what it was
    told, and what else the packets tell.
    """

    done: int
    rows: int
    seconds: float
    cycle: float
    delays: Delays
    asked_again: int
    repeated: int
    garbled: int
    missed: int
    priority: str
    refused: str
    columns: Mapping[str, Floats]

    @property
    def findings(self) -> tuple[Diagnostic, ...]:
        """What should be looked at, although all was followed."""
        found = []
        if self.delays.late or self.missed:
            cycles, late = self.delays.count, self.delays.late
            found.append(MISSED(late=late, cycles=cycles, without=self.missed))
        if self.refused:
            found.append(PRIORITY(reason=self.refused))
        return tuple(found)

    def __str__(self) -> str:
        return (
            f"{self.done} of {self.rows} points in {self.seconds:.2f} s, cycle "
            f"{1e3 * self.cycle:.2f} ms, {self.priority}; {self.delays}"
        )

    def save(self, path: str | FilePath) -> None:
        """Writes the columns as `.csv` or `.npz`; see `save_columns`."""
        save_columns(path, self.columns)
