"""Loop that guides an arm along rows, one command for each packet of the controller.

The packets pace the loop; it has no clock. However it ends, it brings the arm to rest on its path,
holds it there, and ends the control. `Report` states whether its answers were in time, and the data
that the controller sent meanwhile. `PacketSocket` stamps each packet with its time of arrival. The
module of a maker provides a frozen dataclass that implements `Link`. The loop runs in a separate
process, which builds the link again from its class and fields: numbers, texts, booleans and tuples
of them.

    @dataclass(frozen=True)
    class Egm:
        cycle: float = 0.004
        ...
"""

from __future__ import annotations

import contextlib
import select
import socket
import struct
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from pathlib import Path as FilePath
from typing import Final, Protocol

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule
from assistant.controllers.cyclic import rules
from assistant.controllers.cyclic.rules import MISSED, PRIORITY
from assistant.controllers.cyclic.setpoint_source import (
    Job,
    LoopFailure,
    Row,
    column_named,
    source_of,
)
from assistant.controllers.cyclic.trajectory import column_names
from assistant.controllers.recording import save_columns


@dataclass(frozen=True, slots=True)
class Measured:
    """Contents of a packet of the controller.

    values: position of the arm, in the columns of the trajectory. counter: of the packet, to detect
    one that arrives twice or late; None if it has none. missed: cycles in a row without a command,
    as the controller counts them. stopped: why the arm does not follow (any more), "" while it
    does. ready: False while a controller that speaks first does not take commands yet. extra:
    further recorded values, as `Link.recorded` names them.
    """

    values: tuple[float, ...]
    counter: int | None = None
    missed: int = 0
    stopped: str = ""
    ready: bool = True
    extra: tuple[float, ...] = ()


class Link(Protocol):
    """Packets of one conversation; the loop makes each call, so it must be quick.

    cycle: seconds from packet to packet of the controller. speaks_first: whether the controller
    sends unasked in each cycle; otherwise it answers a packet with one. recorded: names of
    `Measured.extra`.
    """

    @property
    def cycle(self) -> float: ...

    @property
    def speaks_first(self) -> bool: ...

    @property
    def recorded(self) -> tuple[str, ...]: ...

    def hello(self, count: int) -> bytes:
        """A packet that moves nothing and asks where the arm is; unused if it speaks first."""

    def read(self, packet: bytes) -> Measured | None:
        """Read a packet; None if it is not of this conversation or makes no sense."""

    def command(self, values: Sequence[float], count: int) -> bytes:
        """The packet that leads the arm to a row. count: of packets that were sent before."""

    def end(self, values: Sequence[float], count: int) -> bytes | None:
        """Return the packet that ends the control; None if silence ends it."""


@dataclass(frozen=True, slots=True)
class Endpoint:
    """Destination of the packets. host: of the controller; None to take the first one that speaks.

    port: of the controller, 0 to take it from its first packet. local_host, local_port: on this
    machine, "" and 0 for any.
    """

    host: str | None
    port: int
    local_host: str = ""
    local_port: int = 0

    def __str__(self) -> str:
        if self.host is None:
            return f"port {self.local_port} of this machine"
        return f"{self.host}:{self.port}" if self.port else self.host


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
    """Timing of a loop so far.

    cycles: packets that were answered. late: how many of them more than half a cycle after their
    arrival. longest, jitter: seconds, the greatest of these delays and their standard deviation.
    """

    cycles: int = 0
    late: int = 0
    longest: float = 0.0
    jitter: float = 0.0


@dataclass(slots=True)
class _TimingRecorder:
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
        # max(): rounding may make the variance of equal delays slightly negative.
        spread = max(0.0, self.squares / count - (self.sum / count) ** 2) ** 0.5
        return Timing(self.count, self.late, self.longest, spread)


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """Report on a trajectory that was followed, or on the part of it up to a failure.

    done, rows: points that were sent, and their total. seconds: duration. cycle: of the controller.
    asked_again: number of silences of the controller. repeated: packets that arrived twice or out
    of order. garbled: without sense. missed: the most cycles in a row without a command, as the
    controller counts them. priority: of the loop; refused: why that is not a real-time priority, ""
    if it is or was not wanted. columns: the recorded values, one per packet: `time` in seconds
    since the first, `row` of the trajectory, the position of the arm by the names of its joints or
    of its pose, `to_…` the commanded position, and further values of the packets.
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
        """Return the findings that need attention, although all rows were followed."""
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


_BIGGEST_PACKET: Final = 2048
"""Bytes of a packet that are read; longer ones make no sense here."""
_MOST_DROPPED: Final = 1000
_SHORTEST_BLOCK: Final = 0.001
"""Seconds for which it is worth while to block."""
_SO_TIMESTAMPNS: Final = 35
"""SO_TIMESTAMPNS of Linux on machines of 64 bits (asm-generic/socket.h): the kernel stamps each
packet as it arrives."""
_TIMESTAMP: Final = struct.Struct("=qq")
_CONTROL_BYTES: Final = 64
"""Bytes for the stamp and its head."""


class PacketSocket:
    """A UDP socket to one controller; a context manager. Raises OSError.

    spin: seconds before a packet is due, `cycle` after the last one, in which the socket starts to
    poll without pause, until as long afterwards; 0 to block in the kernel all the time, inf never
    to. refused: whether the other side reported that nothing listens on that port.
    """

    def __init__(self, endpoint: Endpoint, *, spin: float = 0.0, cycle: float = 0.0) -> None:
        self._endpoint = endpoint
        self._spin, self._cycle = spin, cycle
        self._came = 0.0
        self._host = None if endpoint.host is None else socket.gethostbyname(endpoint.host)
        self.stamped = self.refused = False
        self._open()

    def _open(self) -> None:
        endpoint = self._endpoint
        self._peer: tuple[str, int] | None = None
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._socket.bind((endpoint.local_host, endpoint.local_port))
            # The layout of the stamp, two numbers of 64 bits, holds for 64-bit Linux alone.
            if sys.platform == "linux" and struct.calcsize("P") == 8:
                self._socket.setsockopt(socket.SOL_SOCKET, _SO_TIMESTAMPNS, 1)
                self.stamped = True
            if self._host is not None:
                self._peer = (self._host, endpoint.port)
                if endpoint.port:
                    # Connected, the socket hears of an ICMP refusal,
                    # and packets of others are dropped by the kernel.
                    self._socket.connect(self._peer)
        except OSError:
            self._socket.close()
            raise
        self._poll = select.poll() if hasattr(select, "poll") else None
        if self._poll is not None:
            self._poll.register(self._socket, select.POLLIN)

    def forget(self) -> None:
        """Hears whoever speaks next, where the one that spoke first is of an earlier run."""
        if not self._endpoint.port:
            self._socket.close()
            self._open()

    def __enter__(self) -> PacketSocket:
        return self

    def __exit__(self, *error: object) -> None:
        self._socket.close()

    @property
    def connected(self) -> bool:
        """True if the peer and its port are known."""
        return self._peer is not None and self._peer[1] != 0

    def send(self, packet: bytes) -> None:
        try:
            self._socket.send(packet)
        except ConnectionRefusedError:  # what an earlier packet met; this one was not sent
            self.refused = True
            with contextlib.suppress(ConnectionRefusedError):
                self._socket.send(packet)

    def receive(self, seconds: float) -> tuple[bytes, float] | None:
        """The next packet and its arrival by `now`, None if none comes in that time.

        Other senders are not heard. The first one that speaks is the peer where none is known.
        """
        until = time.monotonic() + seconds
        while True:
            try:
                packet, data, sender = self._read()
            except ConnectionRefusedError:
                self.refused = True
            except BlockingIOError:
                now = time.monotonic()
                if now >= until:
                    return None
                self._pause(now, until)
                continue
            else:
                if self._is_heard(sender):
                    # By the monotonic clock: it only decides how long to block.
                    self._came = time.monotonic()
                    return packet, self._arrival(data)
            if seconds and time.monotonic() >= until:  # however much others send
                # Packets of other senders must not make this wait without end.
                return None

    def hush(self, seconds: float) -> None:
        """Drops what comes until nothing has come for that long, at most `_MOST_DROPPED`."""
        for _ in range(_MOST_DROPPED):
            if self.receive(seconds) is None:
                return

    def _is_heard(self, sender: tuple[str, int]) -> bool:
        """True if the sender is the peer, or becomes it; packets from earlier may still be
        waiting.
        """
        # The kernel may still hold packets from before the socket was connected.
        if self.connected:
            return sender == self._peer
        if self._peer is not None and sender[0] != self._peer[0]:
            return False
        self._peer = sender
        self._socket.connect(sender)
        return True

    def now(self) -> float:
        """Seconds of the clock that arrivals are stamped with."""
        # Kernel stamps are of the wall clock; without them a clock that nothing sets.
        return time.time() if self.stamped else time.perf_counter()

    def _read(self) -> tuple[bytes, list[tuple[int, int, bytes]], tuple[str, int]]:
        if not self.stamped:  # where the system may lack `recvmsg`
            packet, sender = self._socket.recvfrom(_BIGGEST_PACKET)
            return packet, [], sender
        packet, data, _, sender = self._socket.recvmsg(_BIGGEST_PACKET, _CONTROL_BYTES)
        return packet, data, sender

    def _arrival(self, data: list[tuple[int, int, bytes]]) -> float:
        for level, kind, value in data:
            if (
                level == socket.SOL_SOCKET
                and kind == _SO_TIMESTAMPNS
                and len(value) >= _TIMESTAMP.size
            ):
                seconds, nanoseconds = _TIMESTAMP.unpack_from(value)
                return float(seconds + 1e-9 * nanoseconds)
        return self.now()

    def _pause(self, now: float, until: float) -> None:
        """Blocks until a packet comes or there is a reason to look again."""
        due = self._came + self._cycle
        # The packet is overdue: it may be long in coming, and polling would only take the core.
        if now >= due + self._spin:
            self._wait(until - now)
        elif (rest := min(until, due - self._spin) - now) >= _SHORTEST_BLOCK:
            self._wait(rest, early=True)

    def _wait(self, seconds: float, *, early: bool = False) -> None:
        """early: not a moment longer; the kernel counts in ms here."""
        if self._poll is not None:
            self._poll.poll(int(1e3 * seconds) if early else max(1.0, 1e3 * seconds))
        else:
            select.select([self._socket], [], [], seconds)


ReportProgress = Callable[[float, float, Row, Timing], None]
"""Receives the progress at intervals: seconds since the first packet, the row, the position of the
arm, and the timing so far.
"""
_PROGRESS_INTERVAL: Final = 0.1
"""Seconds from telling to telling."""
_CORRECTED_PROGRESS_INTERVAL: Final = 0.0
"""The same where others work out meanwhile how it goes on: each packet."""
_ENDINGS: Final = 2
"""Packets that end the control, if the first one is not answered."""
_COUNTER_WRAP: Final = 1 << 32
_FEWEST_TIMED: Final = 10
"""Points whose rate tells something; twice as many are awaited."""
_SHORTEST_CYCLE: Final = 0.75
"""Part of the stated cycle that points may be apart on average; cycles differ by a half."""
_SILENT_CYCLES: Final = 4
"""Cycles without a packet after which no packet of an earlier motion is expected."""
_STANDSTILL_TOLERANCE: Final = 1e-3
"""Degrees, mm or pulses between two reported positions of an arm at rest."""
ONE: Final = 0
FIRST: Final = 1
_SECOND: Final = 2
"""Packets in transit: one; or, after a repeated request, perhaps two, of which the loop waits for
the first or for the second. Answering both would double the speed.
"""


@dataclass(slots=True, eq=False)
class LoopResult:
    """Result of a loop so far. code, fields: of the finding that it ended with, "" for none."""

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
    """Request to bring the arm to rest; a subclass may check other sources too."""

    asked = False

    def look(self) -> Rule | None:
        """Return the rule that ends the loop, None as long as it continues; called in each
        cycle.
        """
        return rules.INTERRUPTED if self.asked else None


def columns(job: Job, link: Link) -> tuple[str, ...]:
    """Return the column names of a sample."""
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
            # An arm that was commanded must be ended; one that never was has nothing to end.
            if self._way.told and (self._settings.end or self.result.code):
                self._end()
        return self.result

    def _opening(self, address: str) -> Measured:
        """Return the position of the arm once the controller speaks; raises LoopFailure otherwise.

        A packet of a controller that speaks first counts when it follows another: an earlier run
        may have left one in transit, with the position of that time. A controller that only answers
        must report the same position twice.
        """
        before: int | None = None
        each, left = self._settings.lapse * self._link.cycle, self._settings.first
        reason = f"nothing came within {left:g} s"
        seen: Row = ()
        if not self._link.speaks_first:
            # Answers to an earlier program may still be on their way.
            self._wire.hush(_SILENT_CYCLES * self._link.cycle)
        while left > 0.0:
            if (why := self._stop.look()) is not None:
                raise LoopFailure(why, done=0, rows=self._way.rows)
            if not self._link.speaks_first:
                self._send(self._link.hello(self._count))
            got = self._wire.receive(min(each, left))
            if got is None:
                left -= each
                if before is not None:
                    # After a silence the next packet may be of a
                    # restarted controller: it has to prove itself anew.
                    before = None
                    self._wire.forget()
                continue
            measured = self._link.read(got[0])
            if measured is None:
                # Counted as time too: senseless packets at full
                # rate would otherwise keep the loop here for ever.
                left -= self._link.cycle
                self.result.garbled += 1
            elif not self._follows(before, measured.counter):
                left -= self._link.cycle
                before = measured.counter
            elif not measured.ready:
                left -= self._link.cycle
                before = measured.counter
                reason = measured.stopped or "it does not take commands yet"
                # A controller that speaks first waits for an answer before
                # it takes commands; where it already is moves nothing.
                self._send(self._link.command(measured.values, self._count))
            elif measured.stopped:
                raise LoopFailure(rules.NO_ANSWER, **_unanswered(address, measured.stopped))
            elif self._link.speaks_first or _agree(seen, measured.values):
                self._last = measured.counter
                # A counter is trusted only once it has been seen to count.
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
        """True if a first packet follows the previous one, except for a few lost packets."""
        if not self._link.speaks_first or counter is None:
            return True
        most = max(1.0, self._settings.timeout / self._link.cycle)
        return before is not None and 0 < (counter - before) % _COUNTER_WRAP <= most

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
        # From the last answer to the next packet one cycle
        # passes anyway, besides those without a packet.
        lapse, pause = settings.lapse * cycle, (settings.lapse + 1) * cycle
        most = [settings.lag * speed + settings.slack for speed in self._job.speeds]
        hold = 1 + round(settings.settle / cycle)
        nonsense, cause = 0, None
        kept = _TimingRecorder(cycle / 2.0)
        each = _PROGRESS_INTERVAL if self._job.corrections is None else _CORRECTED_PROGRESS_INTERVAL
        wire.hush(0.0 if link.speaks_first else cycle)  # what came meanwhile, or is still to come
        if not link.speaks_first:
            self._send(link.command(way.told, self._count))
        began = told = self._sent = wire.now()
        heard = answered = time.monotonic()  # which no one sets, as the clock of arrivals
        while hold:
            got = receive(lapse)
            if got is None:
                self._check_silence(heard, cause)
                # Without a command the arm has stopped: the source starts softly again.
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
            # Only a new packet with sense counts as heard.
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
            # The last row is repeated for `settle` seconds, until the arm has come to rest at it.
            if way.is_over or (cause is not None and way.stands):
                hold -= 1
            # The first cause is reported, whatever the braking brings.
            if cause is None:
                cause = self._astray(measured.values, most) or self._hurried(arrival - began)
            if self._sent - told > each:
                told = self._sent
                self._tell(arrival - began, way.row, measured.values, kept.timing)
        if cause is not None:
            raise cause
        result.done = self._way.rows

    def _is_repeated(self, measured: Measured, arrival: float) -> bool:
        """True if a packet arrived before, or is one more than requested."""
        counter, before = measured.counter, self._last
        if counter is not None:
            ahead = (counter - before) % _COUNTER_WRAP if before is not None else 0
            # More than half of the range ahead is behind: the packet is late.
            if self._counts and (ahead == 0 or ahead > _COUNTER_WRAP // 2):
                return True
            self._counts = self._counts or ahead != 0  # one that stays as it is says nothing
            self._last = counter
        if self._extra == FIRST:
            self._extra = _SECOND
        elif self._extra == _SECOND:
            self._extra = ONE
            # The second answer to a repeated request comes
            # right after the first; a later one is the next.
            return arrival - self._sent < self._link.cycle / 2.0
        return False

    def _ask_again(self) -> None:
        self.result.asked_again += 1
        if not self._link.speaks_first:
            self._extra = FIRST
            self._send(self._link.command(self._way.told, self._count))

    def _astray(self, values: Sequence[float], most: Sequence[float]) -> LoopFailure | None:
        """Return a failure if the arm is too far from its commanded position, None otherwise."""
        told = self._way.told
        if self._job.kind == "joints":
            away = [abs(a - b) for a, b in zip(values, told, strict=True)]
        else:
            # Only the distance of a pose is limited here, not its rotation.
            squares = [(a - b) ** 2 for a, b in zip(values[:3], told[:3], strict=True)]
            away = [sum(squares) ** 0.5]
        for column, (distance, allowed) in enumerate(zip(away, most, strict=False)):
            if distance > allowed:
                where = column_named(self._job.kind, column)
                return LoopFailure(rules.NOT_THERE, distance=distance, **where, **self._progress())
        return None

    def _hurried(self, seconds: float) -> LoopFailure | None:
        """Return a failure if the controller takes points faster than the motion has them.

        The first answer may come at once. A delay of this computer cannot look like that for long:
        what was late comes at once then, but never before its time. So the last points have to
        come as fast as all of them: the first ones do if the very first was late.
        """
        cycle, taken = self._link.cycle, len(self.result.samples) - 1
        if taken < 2 * _FEWEST_TIMED or seconds >= _SHORTEST_CYCLE * cycle * taken:
            return None
        samples = self.result.samples
        lately = samples[-1][0] - samples[-1 - _FEWEST_TIMED][0]
        if lately >= _SHORTEST_CYCLE * cycle * _FEWEST_TIMED:
            return None
        found = seconds / taken
        fields = {"found": 1e3 * found, "stated": 1e3 * cycle, "times": cycle / max(found, 1e-6)}
        return LoopFailure(rules.OTHER_CYCLE, **fields, **self._progress())

    def _progress(self) -> dict[str, float]:
        self.result.done = done = self._way.done
        return {"done": done, "rows": self._way.rows}

    def _send(self, packet: bytes) -> None:
        self._wire.send(packet)
        self._sent = self._wire.now()
        self._count += 1

    def _end(self) -> None:
        """Ends the control; a controller that does not answer gets the packet once more."""
        for _ in range(_ENDINGS):
            packet = self._link.end(self._way.told, self._count)
            if packet is None:
                return
            try:
                self._send(packet)
                # Any packet shows that the end arrived, or that
                # the controller is still there to hear it.
                if self._wire.receive(3 * self._link.cycle) is not None:
                    return
            except OSError:
                continue


def _agree(one: Row, two: Row) -> bool:
    """True if an arm at rest has reported the same position twice."""
    if not one:
        return False
    return all(abs(a - b) <= _STANDSTILL_TOLERANCE for a, b in zip(one, two, strict=True))


def _unanswered(address: str, reason: str) -> dict[str, str | float]:
    return {"address": address, "reason": reason}
