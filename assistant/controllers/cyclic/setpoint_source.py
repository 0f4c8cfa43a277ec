"""Sources of setpoints for a cyclic motion: rows known before, or corrections computed meanwhile.

A `Job` describes the motion and its `Settings`. Each source begins where the arm is, keeps to the
limits of speed and acceleration, and brakes on its path when it is not to go on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field
from typing import Final, Literal, Protocol

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Rule
from assistant.controllers.cyclic import rules
from assistant.controllers.cyclic.rules import BAD_SETTING
from assistant.controllers.cyclic.trajectory import (
    Kind,
    Limits,
    Trajectory,
    braked,
    resampled,
    sizes,
)

PRIORITY: Final = 80
"""Priority for SCHED_FIFO (1 to 99): above other programs, below the kernel's important threads."""


@dataclass(frozen=True, slots=True)
class Settings:
    """timeout: seconds without a packet after which the loop gives up. opening: the same for the
    first one, None for as many: a controller that speaks first may begin later. lapse: cycles
    without one after which the arm counts as stopped, so that it starts softly again, and a
    controller that only answers is queried again. garbled: packets without sense in a row that end
    it. approach: largest motion of the soft start, degrees of a joint or mm (degrees) of a pose.
    softness: part of the limits that it uses. lag: seconds that the arm may lag its command, at the
    speeds of the limits; inf to follow at any distance. slack: degrees or mm in addition. settle:
    seconds for which the last point is held. wait: `block` in the kernel for a packet; `spin`,
    which takes a complete core at ordinary priority, as the kernel takes it from a real-time loop
    for 50 ms of each second; or `mixed`, which blocks until a third of a cycle before the packet is
    due and then spins: a sleeping processor, above all that of a virtual machine, may wake up late.
    real_time: whether to request real-time priority, and processors that stay awake. alive: seconds
    without a sign of life of the program that requested the motion, which Ctrl-Z stops, after which
    the loop brings the arm to rest. end: whether to end the control after the last point; otherwise
    the controller waits for more.
    """

    timeout: float = 0.5
    opening: float | None = None
    lapse: int = 4
    garbled: int = 20
    approach: float = 10.0
    softness: float = 0.1
    lag: float = 0.25
    slack: float = 1.0
    settle: float = 0.05
    wait: Literal["mixed", "block", "spin"] = "mixed"
    real_time: bool = True
    alive: float = 2.0
    end: bool = True

    @property
    def first(self) -> float:
        """Seconds to wait for the first packet."""
        return self.timeout if self.opening is None else self.opening

    def __post_init__(self) -> None:
        ranges = {
            "timeout": (0.005, 60.0),
            "opening": (0.005, 3600.0),
            "lapse": (1, 1000),
            "garbled": (1, 1_000_000),
            "approach": (0.0, float("inf")),
            "softness": (0.001, 1.0),
            "lag": (0.0, float("inf")),
            "slack": (0.0, float("inf")),
            "settle": (0.0, 60.0),
            "alive": (0.5, 60.0),
        }
        for name, (least, most) in ranges.items():
            value = getattr(self, name)
            if value is None:
                continue
            if not least <= value <= most:
                reason = f"it is a number from {least:g} to {most:g}"
                raise Refused(BAD_SETTING(name=name, value=value, reason=reason), exit_status=2)
        if self.wait not in ("mixed", "block", "spin"):
            reason = "it is mixed, block or spin"
            raise Refused(BAD_SETTING(name="wait", value=self.wait, reason=reason), exit_status=2)


Row = tuple[float, ...]
_ZERO_SPEED: Final = 1e-9
"""Degrees or mm a second that count as standstill."""


class LoopFailure(Exception):
    """The loop cannot continue; holds the rule and fields of its finding."""

    def __init__(self, rule: Rule, **fields: str | float) -> None:
        super().__init__(rule.code)
        self.rule = rule
        self.fields = fields


@dataclass(slots=True)
class Corrections:
    """Commanded position of the arm, and its time in seconds; the newest one counts.

    said: the incomplete line received so far. count: corrections received.
    """

    count: int = 0
    newest: tuple[float, Row] | None = None
    said: bytes = b""

    def take(self, said: bytes) -> None:
        """Read text as it arrives: a line of seconds and a row each; empty lines have no effect."""
        # The last piece has no line end yet: the rest of its line comes with the next bytes.
        *lines, self.said = (self.said + said).split(b"\n")
        for line in filter(None, lines):
            seconds, *row = map(float, line.split())
            # Values that are no numbers would reach the arm unchecked.
            if all(map(math.isfinite, (seconds, *row))):
                self.newest, self.count = (seconds, tuple(row)), self.count + 1


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """Job of a loop. rows: (n, c), resampled; for corrections (0, c). speeds, rises: (k,) its
    limits. corrections: guide the joints instead of rows; lowest, highest: their range.
    """

    kind: Kind
    rows: Floats
    speeds: tuple[float, ...]
    rises: tuple[float, ...]
    settings: Settings
    corrections: Corrections | None = None
    lowest: tuple[float, ...] = ()
    highest: tuple[float, ...] = ()


class SetpointSource(Protocol):
    """told: the row that was commanded last, () before `begin`."""

    told: Row

    @property
    def row(self) -> float:
        """Present row, below 0 in a soft start."""

    @property
    def rows(self) -> int: ...

    @property
    def done(self) -> int:
        """Rows that were commanded."""

    @property
    def is_over(self) -> bool:
        """True if its last row was commanded."""

    @property
    def stands(self) -> bool: ...

    def begin(self, here: Row, cycle: float) -> None:
        """From where the arm is; raises Failed if that is too far away."""

    def next(self, going: bool) -> Row:
        """The row to command now. going: else it comes to rest."""

    def stood(self) -> None:
        """The arm was left without a command, and stands."""


@dataclass(slots=True, eq=False)
class _TrajectorySource:
    """The rows of a job, with a soft start before them."""

    job: Job
    told: Row = ()
    _rows: list[Row] = field(default_factory=list)
    _lead: int = 0
    """Rows of the soft start, before the first one of the trajectory."""
    _at: float = 0.0
    _rate: float = 1.0
    _gain: float = 1.0

    @property
    def row(self) -> float:
        return self._at - self._lead

    @property
    def rows(self) -> int:
        return len(self.job.rows)

    @property
    def done(self) -> int:
        return max(0, min(self.rows, int(self._at) - self._lead + 1))

    @property
    def is_over(self) -> bool:
        return self._at >= len(self._rows) - 1

    @property
    def stands(self) -> bool:
        return self._rate == 0.0

    def begin(self, here: Row, cycle: float) -> None:
        job, settings = self.job, self.job.settings
        start, first = np.array([here]), job.rows[:1]
        # q and -q are the same turn: start from the sign
        # of the first row, or the arm seems far away.
        if job.kind == "poses" and float(start[0, 3:] @ first[0, 3:]) < 0.0:
            start[0, 3:] *= -1.0
        away = sizes(job.kind, first - start)[0]
        worst = int(np.argmax(away))
        if away[worst] > settings.approach:
            raise LoopFailure(
                rules.NOT_SOFT,
                distance=float(away[worst]),
                most=settings.approach,
                **column_named(job.kind, worst),
            )
        parts = [job.rows]
        if away[worst] > 1e-6:
            soft = [tuple(settings.softness * v for v in some) for some in (job.speeds, job.rises)]
            ramp = Trajectory(job.kind, np.concatenate([start, first]))
            # [:-1]: the ramp ends at the first row of the trajectory.
            parts.insert(0, resampled(ramp, Limits(soft[0], soft[1]), cycle)[:-1])
        self._lead = sum(map(len, parts)) - len(job.rows)
        rows = np.concatenate(parts)
        steps = sizes(job.kind, np.diff(rows, axis=0)) if len(rows) > 1 else np.zeros((1, 1))
        fastest = np.maximum(steps.max(axis=0) / cycle, 1e-12)
        # The rate changes by so much in a cycle that braking takes half of the accelerations.
        self._gain = float(min(1.0, (np.array(job.rises) / (2.0 * fastest)).min() * cycle))
        self._rows = list(map(tuple, rows.tolist()))
        self.told = self._rows[0]

    def next(self, going: bool) -> Row:
        """`_rate` goes towards all or nothing as the limits let it."""
        rate, target = self._rate, float(going)
        rate = min(target, rate + self._gain) if rate < target else max(target, rate - self._gain)
        self._rate = rate
        self._at = at = min(self._at + rate, float(len(self._rows) - 1))
        i = int(at)
        part = at - i
        # Whole rows are sent as they are, without rounding.
        if part == 0.0:
            self.told = self._rows[i]
        else:
            between = zip(self._rows[i], self._rows[i + 1], strict=True)
            self.told = tuple(a + part * (b - a) for a, b in between)
        return self.told

    def stood(self) -> None:
        self._rate = 0.0


@dataclass(slots=True, eq=False)
class CorrectionSource:
    """Joints that go from where they should be by now to where the newest correction wants them in
    its time, and come to rest there when no other follows.

    One that comes before the last one's time is over, or after, goes on from where they should be
    then. What they are behind is caught up with no faster than it can be braked for; so are the
    ends of the range. A correction without time has them come to rest at once.
    """

    job: Job
    told: Row = ()
    _speed: list[float] = field(default_factory=list)
    _from: Row = ()
    _goal: Row = ()
    _seconds: float = 0.0
    _part: float = 1.0
    _taken: int = 0
    _cycle: float = 0.0

    @property
    def row(self) -> float:
        return float(self.done)

    @property
    def rows(self) -> int:
        return self.done

    @property
    def done(self) -> int:
        return self.corrections.count

    @property
    def corrections(self) -> Corrections:
        assert self.job.corrections is not None
        return self.job.corrections

    @property
    def is_over(self) -> bool:
        return False

    @property
    def stands(self) -> bool:
        return all(abs(speed) <= _ZERO_SPEED for speed in self._speed)

    def begin(self, here: Row, cycle: float) -> None:
        self.told = self._from = self._goal = here
        self._speed, self._cycle = [0.0] * len(here), cycle

    def next(self, going: bool) -> Row:
        corrections = self.corrections
        if corrections.count != self._taken and corrections.newest is not None:
            self._taken = corrections.count
            self._take(*corrections.newest)
        moves = going and self._seconds > 0.0
        gone = self._part
        self._part = min(1.0, gone + self._cycle / self._seconds) if moves else 1.0
        self._speed = [self._risen(i, gone, moves) for i in range(len(self.told))]
        cycle = self._cycle
        self.told = tuple(a + v * cycle for a, v in zip(self.told, self._speed, strict=True))
        return self.told

    def stood(self) -> None:
        self._speed = [0.0] * len(self.told)

    def _take(self, seconds: float, goal: Row) -> None:
        if len(goal) != len(self.told):
            return
        # A correction without time has stopped the arm: the next one starts from where it is.
        stood = self._seconds <= 0.0
        self._from = self.told if stood else tuple(map(self._due, range(len(goal))))
        self._goal, self._seconds, self._part = goal, seconds, 0.0

    def _due(self, i: int) -> float:
        """Return the present setpoint of an axis."""
        return self._from[i] + self._part * (self._goal[i] - self._from[i])

    def _risen(self, i: int, gone: float, moves: bool) -> float:
        """The speed of an axis in this cycle. gone: part of the time that was over before it."""
        job, cycle, at, before = self.job, self._cycle, self.told[i], self._speed[i]
        most, rise = job.speeds[i], job.rises[i]
        wanted = 0.0
        if moves:
            way = self._goal[i] - self._from[i]
            behind = self._from[i] + gone * way - at
            along = way * (self._part - gone) / cycle
            wanted = max(-most, min(most, along + behind * rise / most))
        speed = before + max(-rise * cycle, min(rise * cycle, wanted - before))
        room = job.highest[i] - at if speed > 0.0 else at - job.lowest[i]
        bound = braked(room, rise, cycle)
        return max(-bound, min(bound, speed))


def column_named(kind: Kind, column: int) -> dict[str, str]:
    if kind == "joints":
        return {"what": f"J{column + 1}", "unit": "deg"}
    return {"what": ("position", "turning")[column], "unit": ("mm", "deg")[column]}


def source_of(job: Job) -> SetpointSource:
    return _TrajectorySource(job) if job.corrections is None else CorrectionSource(job)


def correction_line(row: Sequence[float], seconds: float) -> bytes:
    """A correction as `Corrections.take` reads it."""
    return (" ".join(map(repr, map(float, (seconds, *row)))) + "\n").encode("ascii")
