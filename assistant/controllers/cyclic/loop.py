"""The loop that leads an arm along rows: one command for each packet of the controller.

It is paced by these packets and by no clock of its own. Whatever happens, it brings the arm to rest
on its way, holds it, and ends the control.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.controllers.cyclic import rules
from assistant.controllers.cyclic.link import Link, Measured
from assistant.controllers.cyclic.settings import Settings
from assistant.controllers.cyclic.space import Kind, Limits, names, sizes
from assistant.controllers.cyclic.trajectory import Trajectory, resampled
from assistant.controllers.cyclic.wire import Wire
from assistant.program.arrays import Floats
from assistant.program.diagnostics import Rule

Row = tuple[float, ...]
Tell = Callable[[float, float, Row], None]
"""Is told now and then: seconds since the first packet, the row, where the arm is."""
TOLD_EACH: Final = 0.1
"""Seconds from telling to telling."""
ENDINGS: Final = 2
"""Packets that end the control, if the first one is not answered."""
WRAP: Final = 1 << 32
HUSH: Final = 4
"""Cycles without a packet behind which nothing of an earlier motion is taken to come."""
SAME: Final = 1e-3
"""Degrees, mm or pulses between two places that are told of an arm that stands."""
ONE: Final = 0
FIRST: Final = 1
SECOND: Final = 2
"""What is under way: one packet; or, once it was asked again, perhaps two, of which the first, or
the second is waited for. Two that were both answered for good would double the speed."""


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """What is to be done. rows: (n, c), resampled. speeds, rises: (k,) limits of its kind."""

    kind: Kind
    rows: Floats
    speeds: tuple[float, ...]
    rises: tuple[float, ...]
    settings: Settings


@dataclass(slots=True, eq=False)
class Done:
    """What came of it, by then. code, fields: of the finding that it ended with, "" for none."""

    code: str = ""
    fields: Mapping[str, str | float] = field(default_factory=dict)
    done: int = 0
    asked_again: int = 0
    repeated: int = 0
    garbled: int = 0
    missed: int = 0
    delays: list[float] = field(default_factory=list)
    samples: list[Row] = field(default_factory=list)


class Failed(Exception):
    """The loop cannot go on; what has to be said of it."""

    def __init__(self, rule: Rule, **fields: str | float) -> None:
        super().__init__(rule.code)
        self.rule = rule
        self.fields = fields


class Stop:
    """Whether the loop is to bring the arm to rest; who runs it may look elsewhere, too."""

    asked = False

    def look(self) -> Rule | None:
        """What to say of it, None as long as it goes on; called in each cycle."""
        return rules.INTERRUPTED if self.asked else None


def columns(job: Job, link: Link) -> tuple[str, ...]:
    """What the parts of a sample are called."""
    own = names(job.kind, job.rows.shape[1])
    return ("time", "row", *own, *(f"to_{name}" for name in own), *link.recorded)


class Loop:
    """One job over one wire; `run` once."""

    def __init__(self, link: Link, wire: Wire, job: Job, stop: Stop, tell: Tell) -> None:
        self._link, self._wire, self._job, self._stop, self._tell = link, wire, job, stop, tell
        self._settings = job.settings
        self.result = Done()
        self._rows: list[Row] = []
        self._lead = 0
        """Rows of the soft start, before the first one of the trajectory."""
        self._at = 0.0
        self._rate = 1.0
        self._gain = 1.0
        self._told: Row = ()
        self._count = 0
        self._last: int | None = None
        self._counts = False
        self._sent = 0.0
        self._extra = ONE

    def run(self, address: str) -> Done:
        """All of it; never raises but for what no one foresaw, and then it has ended first."""
        moved = False
        try:
            begin = self._opening(address)
            self._prepare(begin.values)
            moved = True
            self._follow()
        except Failed as failure:
            self.result.code, self.result.fields = failure.rule.code, failure.fields
        except OSError as error:
            rule = rules.BROKEN if moved else rules.NO_ANSWER
            self.result.code = rule.code
            reason = error.strerror or str(error)
            self.result.fields = {"reason": reason} if moved else _unanswered(address, reason)
        finally:
            if self._told and (self._settings.end or self.result.code):
                self._end()
        return self.result

    def _opening(self, address: str) -> Measured:
        """Where the arm is, once the controller speaks; raises Failed if it does not.

        Of one that speaks first a packet counts when it follows another: an earlier run may have
        left one on its way, which tells where the arm was then. One that only answers has to tell
        the same place twice.
        """
        before: int | None = None
        each, left = self._settings.lapse * self._link.cycle, self._settings.first
        reason = f"nothing came within {left:g} s"
        seen: Row = ()
        if not self._link.speaks_first:
            self._wire.hush(HUSH * self._link.cycle)
        while left > 0.0:
            if (why := self._stop.look()) is not None:
                raise Failed(why, done=0, rows=len(self._job.rows))
            if not self._link.speaks_first:
                self._send(self._link.hello(self._count))
            got = self._wire.receive(min(each, left))
            if got is None:
                left -= each
                if before is not None:
                    before = None
                    self._wire.forget()
                continue
            measured = self._link.read(got[0])
            if measured is None:
                left -= self._link.cycle
                self.result.garbled += 1
            elif not self._follows(before, measured.counter):
                left -= self._link.cycle
                before = measured.counter
            elif not measured.ready:
                left -= self._link.cycle
                before = measured.counter
                reason = measured.stopped or "it does not take commands yet"
                self._send(self._link.command(measured.values, self._count))
            elif measured.stopped:
                raise Failed(rules.NO_ANSWER, **_unanswered(address, measured.stopped))
            elif self._link.speaks_first or _agree(seen, measured.values):
                self._last = measured.counter
                self._counts = self._link.speaks_first and measured.counter is not None
                return measured
            else:  # it may tell of an earlier motion, and come late
                left -= self._link.cycle
                seen = measured.values
                reason = "it tells of another place each time"
        if self._wire.refused:
            reason = "nothing listens on that port"
        if self.result.garbled:
            reason = "what it sends makes no sense"
        raise Failed(rules.NO_ANSWER, **_unanswered(address, reason))

    def _follows(self, before: int | None, counter: int | None) -> bool:
        """Whether a packet at the beginning is the one behind another, up to some that are lost."""
        if not self._link.speaks_first or counter is None:
            return True
        most = max(1.0, self._settings.timeout / self._link.cycle)
        return before is not None and 0 < (counter - before) % WRAP <= most

    def _prepare(self, here: Row) -> None:
        """The rows with a soft start before them; raises Failed if that would go too far."""
        job, settings, cycle = self._job, self._settings, self._link.cycle
        start, first = np.array([here]), job.rows[:1]
        if job.kind == "poses" and float(start[0, 3:] @ first[0, 3:]) < 0.0:
            start[0, 3:] *= -1.0
        away = sizes(job.kind, first - start)[0]
        worst = int(np.argmax(away))
        if away[worst] > settings.approach:
            raise Failed(
                rules.NOT_SOFT,
                distance=float(away[worst]),
                most=settings.approach,
                **_what(job.kind, worst),
            )
        parts = [job.rows]
        if away[worst] > 1e-6:
            soft = [tuple(settings.softness * v for v in some) for some in (job.speeds, job.rises)]
            ramp = Trajectory(job.kind, np.concatenate([start, first]))
            parts.insert(0, resampled(ramp, Limits(soft[0], soft[1]), cycle)[:-1])
        self._lead = sum(map(len, parts)) - len(job.rows)
        rows = np.concatenate(parts)
        steps = sizes(job.kind, np.diff(rows, axis=0)) if len(rows) > 1 else np.zeros((1, 1))
        fastest = np.maximum(steps.max(axis=0) / cycle, 1e-12)
        self._gain = float(min(1.0, (np.array(job.rises) / (2.0 * fastest)).min() * cycle))
        self._rows = list(map(tuple, rows.tolist()))
        self._told = self._rows[0]

    def _check_silence(self, heard: float, cause: Failed | None) -> None:
        """Raises Failed if nothing new has come for too long."""
        silent = time.monotonic() - heard
        if silent > self._settings.timeout:
            raise cause or Failed(rules.SILENT, seconds=silent, **self._progress())

    def _check_sense(self, packet: bytes, count: int, heard: float, cause: Failed | None) -> None:
        """Raises Failed if too many packets in a row made no sense, or for too long."""
        settings = self._settings
        if time.monotonic() - heard > settings.timeout or count >= settings.garbled:
            sample = packet[:12].hex(" ")
            raise cause or Failed(rules.GARBLED, count=count, sample=sample, **self._progress())

    def _follow(self) -> None:
        link, wire, settings, result = self._link, self._wire, self._settings, self.result
        cycle, receive = link.cycle, wire.receive
        lapse, pause = settings.lapse * cycle, (settings.lapse + 1) * cycle
        most = [settings.lag * speed + settings.slack for speed in self._job.speeds]
        hold = 1 + round(settings.settle / cycle)
        last, nonsense, cause = len(self._rows) - 1, 0, None
        wire.hush(0.0 if link.speaks_first else cycle)  # what came meanwhile, or is still to come
        if not link.speaks_first:
            self._send(link.command(self._told, self._count))
        began = told = self._sent = wire.now()
        heard = answered = time.monotonic()  # which no one sets, as the clock of arrivals
        while hold:
            got = receive(lapse)
            if got is None:
                self._check_silence(heard, cause)
                self._rate = 0.0
                self._ask_again()
                continue
            packet, arrival = got
            measured = link.read(packet)
            if measured is None:
                nonsense += 1
                result.garbled += 1
                self._check_sense(packet, nonsense, heard, cause)
                continue
            if self._is_repeated(measured, arrival):
                result.repeated += 1
                self._check_silence(heard, cause)
                continue
            if measured.stopped:
                raise cause or Failed(rules.STOPPED, reason=measured.stopped, **self._progress())
            why = self._stop.look()
            if why is not None and cause is None:
                cause = Failed(why, **self._progress())
            heard, nonsense = time.monotonic(), 0
            if heard - answered > pause:
                self._rate = 0.0  # the arm was left without a command, and stands by now
            self._told = self._next(0.0 if cause else 1.0, last)
            wire.send(link.command(self._told, self._count))
            self._sent = wire.now()
            answered = heard
            self._count += 1
            result.delays.append(self._sent - arrival)
            row = self._at - self._lead
            result.samples.append((arrival, row, *measured.values, *self._told, *measured.extra))
            result.missed = max(result.missed, measured.missed)
            if self._at >= last or (cause is not None and self._rate == 0.0):
                hold -= 1
            if cause is None:
                cause = self._astray(measured.values, most)
            if self._sent - told > TOLD_EACH:
                told = self._sent
                self._tell(arrival - began, row, measured.values)
        if cause is not None:
            raise cause
        result.done = len(self._job.rows)

    def _next(self, target: float, last: int) -> Row:
        """The row to command now; `_rate` goes towards the target as the limits let it."""
        rate = self._rate
        rate = min(target, rate + self._gain) if rate < target else max(target, rate - self._gain)
        self._rate = rate
        self._at = at = min(self._at + rate, float(last))
        i = int(at)
        part = at - i
        if part == 0.0:
            return self._rows[i]
        between = zip(self._rows[i], self._rows[i + 1], strict=True)
        return tuple(a + part * (b - a) for a, b in between)

    def _is_repeated(self, measured: Measured, arrival: float) -> bool:
        """Whether a packet came before, or is one more than was asked for."""
        counter, before = measured.counter, self._last
        if counter is not None:
            ahead = (counter - before) % WRAP if before is not None else 0
            if self._counts and (ahead == 0 or ahead > WRAP // 2):
                return True
            self._counts = self._counts or ahead != 0  # one that stays as it is says nothing
            self._last = counter
        if self._extra == FIRST:
            self._extra = SECOND
        elif self._extra == SECOND:
            self._extra = ONE
            return arrival - self._sent < self._link.cycle / 2.0
        return False

    def _ask_again(self) -> None:
        self.result.asked_again += 1
        if not self._link.speaks_first:
            self._extra = FIRST
            self._send(self._link.command(self._told, self._count))

    def _astray(self, values: Sequence[float], most: Sequence[float]) -> Failed | None:
        """That the arm is too far from where it was told to be."""
        if self._job.kind == "joints":
            away = [abs(a - b) for a, b in zip(values, self._told, strict=True)]
        else:
            squares = [(a - b) ** 2 for a, b in zip(values[:3], self._told[:3], strict=True)]
            away = [sum(squares) ** 0.5]
        for column, (distance, allowed) in enumerate(zip(away, most, strict=False)):
            if distance > allowed:
                where = _what(self._job.kind, column)
                return Failed(rules.NOT_THERE, distance=distance, **where, **self._progress())
        return None

    def _progress(self) -> dict[str, float]:
        done = max(0, min(len(self._job.rows), int(self._at) - self._lead + 1))
        self.result.done = done
        return {"done": done, "rows": len(self._job.rows)}

    def _send(self, packet: bytes) -> None:
        self._wire.send(packet)
        self._sent = self._wire.now()
        self._count += 1

    def _end(self) -> None:
        """Ends the control; a controller that does not answer gets the packet once more."""
        for _ in range(ENDINGS):
            packet = self._link.end(self._told, self._count)
            if packet is None:
                return
            try:
                self._send(packet)
                if self._wire.receive(3 * self._link.cycle) is not None:
                    return
            except OSError:
                continue


def _agree(one: Row, two: Row) -> bool:
    """Whether an arm that stands has told the same place twice."""
    if not one:
        return False
    return all(abs(a - b) <= SAME for a, b in zip(one, two, strict=True))


def _unanswered(address: str, reason: str) -> dict[str, str | float]:
    return {"address": address, "reason": reason}


def _what(kind: Kind, column: int) -> dict[str, str]:
    if kind == "joints":
        return {"what": f"J{column + 1}", "unit": "deg"}
    return {"what": ("position", "turning")[column], "unit": ("mm", "deg")[column]}
