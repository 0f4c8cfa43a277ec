"""The loop that leads an arm along rows: one command for each packet of the controller.

It is paced by these packets and by no clock of its own. Whatever happens, it brings the arm to rest
on its way, holds it, and ends the control.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from assistant.base.diagnostics import Rule
from assistant.controllers.cyclic import rules
from assistant.controllers.cyclic.link import Link, Measured
from assistant.controllers.cyclic.report import Timing, TimingRecorder
from assistant.controllers.cyclic.space import column_names
from assistant.controllers.cyclic.ways import Job, LoopFailure, Row, column_named, source_of
from assistant.controllers.cyclic.wire import PacketSocket

ReportProgress = Callable[[float, float, Row, Timing], None]
"""Is told now and then: seconds since the first packet, the row, where the arm is, how the time was
kept by then."""
PROGRESS_INTERVAL: Final = 0.1
"""Seconds from telling to telling."""
CORRECTED_PROGRESS_INTERVAL: Final = 0.0
"""The same where others work out meanwhile how it goes on: each packet."""
ENDINGS: Final = 2
"""Packets that end the control, if the first one is not answered."""
COUNTER_WRAP: Final = 1 << 32
SILENT_CYCLES: Final = 4
"""Cycles without a packet behind which nothing of an earlier motion is taken to come."""
STANDSTILL_TOLERANCE: Final = 1e-3
"""Degrees, mm or pulses between two places that are told of an arm that stands."""
ONE: Final = 0
FIRST: Final = 1
SECOND: Final = 2
"""What is under way: one packet; or, once it was asked again, perhaps two, of which the first, or
the second is waited for. Two that were both answered for good would double the speed."""


@dataclass(slots=True, eq=False)
class LoopResult:
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


class Stop:
    """Whether the loop is to bring the arm to rest; who runs it may look elsewhere, too."""

    asked = False

    def look(self) -> Rule | None:
        """What to say of it, None as long as it goes on; called in each cycle."""
        return rules.INTERRUPTED if self.asked else None


def columns(job: Job, link: Link) -> tuple[str, ...]:
    """What the parts of a sample are called."""
    own = column_names(job.kind, job.rows.shape[1])
    return ("time", "row", *own, *(f"to_{name}" for name in own), *link.recorded)


class Loop:
    """One job over one wire; `run` once."""

    def __init__(
        self, link: Link, wire: PacketSocket, job: Job, stop: Stop, tell: ReportProgress
    ) -> None:
        self._link, self._wire, self._job, self._stop, self._tell = link, wire, job, stop, tell
        self._settings = job.settings
        self.result = LoopResult()
        self._way = source_of(job)
        self._count = 0
        self._last: int | None = None
        self._counts = False
        self._sent = 0.0
        self._extra = ONE

    def run(self, address: str) -> LoopResult:
        """All of it; never raises but for what no one foresaw, and then it has ended first."""
        moved = False
        try:
            begin = self._opening(address)
            self._way.begin(begin.values, self._link.cycle)
            moved = True
            self._follow()
        except LoopFailure as failure:
            self.result.code, self.result.fields = failure.rule.code, failure.fields
        except OSError as error:
            rule = rules.BROKEN if moved else rules.NO_ANSWER
            self.result.code = rule.code
            reason = error.strerror or str(error)
            self.result.fields = {"reason": reason} if moved else _unanswered(address, reason)
        finally:
            if self._way.told and (self._settings.end or self.result.code):
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
            self._wire.hush(SILENT_CYCLES * self._link.cycle)
        while left > 0.0:
            if (why := self._stop.look()) is not None:
                raise LoopFailure(why, done=0, rows=self._way.rows)
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
                raise LoopFailure(rules.NO_ANSWER, **_unanswered(address, measured.stopped))
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
        raise LoopFailure(rules.NO_ANSWER, **_unanswered(address, reason))

    def _follows(self, before: int | None, counter: int | None) -> bool:
        """Whether a packet at the beginning is the one behind another, up to some that are lost."""
        if not self._link.speaks_first or counter is None:
            return True
        most = max(1.0, self._settings.timeout / self._link.cycle)
        return before is not None and 0 < (counter - before) % COUNTER_WRAP <= most

    def _check_silence(self, heard: float, cause: LoopFailure | None) -> None:
        """Raises Failed if nothing new has come for too long."""
        silent = time.monotonic() - heard
        if silent > self._settings.timeout:
            raise cause or LoopFailure(rules.SILENT, seconds=silent, **self._progress())

    def _check_sense(
        self, packet: bytes, count: int, heard: float, cause: LoopFailure | None
    ) -> None:
        """Raises Failed if too many packets in a row made no sense, or for too long."""
        settings = self._settings
        if time.monotonic() - heard > settings.timeout or count >= settings.garbled:
            sample = packet[:12].hex(" ")
            raise cause or LoopFailure(
                rules.GARBLED, count=count, sample=sample, **self._progress()
            )

    def _follow(self) -> None:
        link, wire, settings, result = self._link, self._wire, self._settings, self.result
        way = self._way
        cycle, receive = link.cycle, wire.receive
        lapse, pause = settings.lapse * cycle, (settings.lapse + 1) * cycle
        most = [settings.lag * speed + settings.slack for speed in self._job.speeds]
        hold = 1 + round(settings.settle / cycle)
        nonsense, cause = 0, None
        kept = TimingRecorder(cycle / 2.0)
        each = PROGRESS_INTERVAL if self._job.corrections is None else CORRECTED_PROGRESS_INTERVAL
        wire.hush(0.0 if link.speaks_first else cycle)  # what came meanwhile, or is still to come
        if not link.speaks_first:
            self._send(link.command(way.told, self._count))
        began = told = self._sent = wire.now()
        heard = answered = time.monotonic()  # which no one sets, as the clock of arrivals
        while hold:
            got = receive(lapse)
            if got is None:
                self._check_silence(heard, cause)
                way.stood()
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
                raise cause or LoopFailure(
                    rules.STOPPED, reason=measured.stopped, **self._progress()
                )
            why = self._stop.look()
            if why is not None and cause is None:
                cause = LoopFailure(why, **self._progress())
            heard, nonsense = time.monotonic(), 0
            if heard - answered > pause:
                way.stood()  # without a command, the arm stands by now
            row = way.next(cause is None)
            wire.send(link.command(row, self._count))
            self._sent = wire.now()
            answered = heard
            self._count += 1
            result.delays.append(self._sent - arrival)
            kept.add(self._sent - arrival)
            result.samples.append((arrival, way.row, *measured.values, *row, *measured.extra))
            result.missed = max(result.missed, measured.missed)
            if way.is_over or (cause is not None and way.stands):
                hold -= 1
            if cause is None:
                cause = self._astray(measured.values, most)
            if self._sent - told > each:
                told = self._sent
                self._tell(arrival - began, way.row, measured.values, kept.timing)
        if cause is not None:
            raise cause
        result.done = self._way.rows

    def _is_repeated(self, measured: Measured, arrival: float) -> bool:
        """Whether a packet came before, or is one more than was asked for."""
        counter, before = measured.counter, self._last
        if counter is not None:
            ahead = (counter - before) % COUNTER_WRAP if before is not None else 0
            if self._counts and (ahead == 0 or ahead > COUNTER_WRAP // 2):
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
            self._send(self._link.command(self._way.told, self._count))

    def _astray(self, values: Sequence[float], most: Sequence[float]) -> LoopFailure | None:
        """That the arm is too far from where it was told to be."""
        told = self._way.told
        if self._job.kind == "joints":
            away = [abs(a - b) for a, b in zip(values, told, strict=True)]
        else:
            squares = [(a - b) ** 2 for a, b in zip(values[:3], told[:3], strict=True)]
            away = [sum(squares) ** 0.5]
        for column, (distance, allowed) in enumerate(zip(away, most, strict=False)):
            if distance > allowed:
                where = column_named(self._job.kind, column)
                return LoopFailure(rules.NOT_THERE, distance=distance, **where, **self._progress())
        return None

    def _progress(self) -> dict[str, float]:
        self.result.done = done = self._way.done
        return {"done": done, "rows": self._way.rows}

    def _send(self, packet: bytes) -> None:
        self._wire.send(packet)
        self._sent = self._wire.now()
        self._count += 1

    def _end(self) -> None:
        """Ends the control; a controller that does not answer gets the packet once more."""
        for _ in range(ENDINGS):
            packet = self._link.end(self._way.told, self._count)
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
    return all(abs(a - b) <= STANDSTILL_TOLERANCE for a, b in zip(one, two, strict=True))


def _unanswered(address: str, reason: str) -> dict[str, str | float]:
    return {"address": address, "reason": reason}
