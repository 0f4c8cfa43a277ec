"""What a simulation gives: times of procedures and moves, and the motion over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused, error
from assistant.robots.robot import Robot
from assistant.robots.timing.on_way import OutputTime
from assistant.robots.timing.passed import MovesWithoutStop
from assistant.robots.timing.profile import BINDING_WORDS, FIRST_AXIS
from assistant.robots.timing.samples import Samples, samples_of
from assistant.robots.timing.state import Duration, History

MOST_SAMPLES: Final = 1_000_000
"""Rows of samples that are computed; about 250 bytes each."""
SAMPLE_PERIOD: Final = 0.01
"""seconds between samples, unless that would be too many."""

TOO_MANY_SAMPLES = error(
    "RB301",
    "{seconds:.0f} s at {period:g} s make {count} samples, more than {most}",
    "take a period of {least:g} s or longer, or none for one that fits",
)
NO_PERIOD = error("RB302", "{value:g} is no {what}", "give a number above 0")


@dataclass(frozen=True, slots=True, eq=False)
class MoveTimes:
    """Columns of m moves in order of text; each as it took the longest.

    procedure: (m,) rows of the table procedures. number: (m,) of the motion statement in its
    procedure, from 1. row: (m,) of its path, from 0. kind: (m,) `Kind`. length: (m,) mm.
    turn: (m,) deg. seconds: (m,). binds: (m,) see `bound_by`.
    """

    procedures: tuple[str, ...]
    procedure: NDArray[np.int32]
    number: NDArray[np.int32]
    row: NDArray[np.int32]
    kind: NDArray[np.uint8]
    length: Floats
    turn: Floats
    seconds: Floats
    binds: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.seconds)


@dataclass(frozen=True, slots=True)
class Unknown:
    """What the times do not hold, or only as assumed.

    procedure: where. what: a clause. times: how often it was met.
    """

    procedure: str
    what: str
    times: int = 1

    def __str__(self) -> str:
        often = f" ({self.times} times)" if self.times > 1 else ""
        return f"{self.procedure}: {self.what}{often}"


@dataclass(frozen=True, eq=False)
class Simulation:
    """How long a program takes on a robot.

    duration: of the entry. procedures: name → how long a call takes, over all calls.
    outputs: what moves set on their way, in order of text.
    labels: procedure and number of each of its motion statements → what it moves to.
    history: of the way through the entry that takes the longest. start: (a,) joints where it
    begins. passed: every stretch of moves that was timed, also beside that way.
    wanted_period: see `period`.
    """

    robot: Robot
    duration: Duration
    procedures: Mapping[str, Duration]
    moves: MoveTimes
    outputs: tuple[OutputTime, ...]
    unknown: tuple[Unknown, ...]
    labels: Mapping[tuple[str, int], str]
    history: History | None
    start: Floats
    passed: tuple[MovesWithoutStop, ...]
    wanted_period: float | None

    @property
    def seconds(self) -> float:
        """Of the entry, on the way that takes the longest."""
        return self.duration.most

    @property
    def period(self) -> float:
        """Seconds between samples: as wanted, else `PERIOD` or the least 1, 2 or 5 that fits."""
        if self.wanted_period is not None:
            return self.wanted_period
        period = SAMPLE_PERIOD
        while self.seconds / period >= MOST_SAMPLES:
            period *= 2.5 if f"{period:e}".startswith("2") else 2.0
        return period

    @cached_property
    def samples(self) -> Samples:
        """The motion over time; raises Refused if a wanted period gives too many samples."""
        count = int(self.seconds / self.period) + 1
        if count > MOST_SAMPLES:
            raise Refused(
                TOO_MANY_SAMPLES(
                    seconds=self.seconds,
                    period=self.period,
                    count=count,
                    most=MOST_SAMPLES,
                    least=self.seconds / (MOST_SAMPLES - 1),
                ),
                exit_status=2,
            )
        return samples_of(self.history, self.seconds, self.period, self.robot, self.start)

    def bound_by(self, binds: int) -> str:
        """What a value of `MoveTimes.binds` means, in words."""
        return self.robot.axes[binds - FIRST_AXIS] if binds >= FIRST_AXIS else BINDING_WORDS[binds]
