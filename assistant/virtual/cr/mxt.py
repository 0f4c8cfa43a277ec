"""What a controller does while a program is in `Mxt` (BFP-A3379-A, 4.2).

It takes the position of one packet in each cycle, gives it to the servos, and answers; without a
packet it holds. It ends with the command 255, or with an error.

    control = MxtControl(MxtArm(robot, robot.home, CYCLE), kind=1)
    end = control.run(threading.Event())
"""

from __future__ import annotations

import json
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, Protocol

import numpy as np

from assistant.virtual.cr import mxt_packet as layout
from assistant.virtual.cr.mxt_arm import PULSES, MxtArm, Refusal
from assistant.virtual.cr.mxt_packet import PACKET, POSITION_KINDS

CYCLE: Final = 64 / 9000
"""Seconds: CR750; 0.0035 of CR800."""
NULL: Final = 0
MOVE: Final = 1
END: Final = 255
TIMED_OUT: Final = 7820
ILLEGAL: Final = 7840
"""Errors of the statement (BFP-A3379-A, 7.1)."""
LATE: Final = 1.5
"""Cycles by which a reply is late that is made so."""
STAMP: Final = 35
"""SO_TIMESTAMPNS of Linux: when a packet arrived, not when it was looked for."""

Fault = Literal["lost", "twice", "garbled", "late", "silent", "stop"]
"""What can befall a reply: `silent` is a controller that says and does no more, `stop` one whose
operation is stopped: it holds, and says no more either."""


class Signals(Protocol):
    """Words of 16 signals."""

    def read(self, kind: int, first: int) -> int:
        """kind: 1 outputs, 2 inputs."""

    def write(self, first: int, mask: int, word: int) -> None:
        """Sets those outputs that the mask has."""


@dataclass
class Bits:
    """Signals of a controller that stands alone."""

    outputs: dict[int, bool] = field(default_factory=dict)
    inputs: dict[int, bool] = field(default_factory=dict)

    def read(self, kind: int, first: int) -> int:
        bits = self.outputs if kind == 1 else self.inputs
        return sum(bits.get(first + i, False) << i for i in range(16))

    def write(self, first: int, mask: int, word: int) -> None:
        for i in range(16):
            if mask >> i & 1:
                self.outputs[first + i] = bool(word >> i & 1)


@dataclass
class MxtEnd:
    """How it ended and what was seen. number: of an error, 0 for none. reason: end, error, stopped.

    answers: seconds from the reply to a move to the arrival of the next one; a packet that arrived
    before the reply answers none. late: of these, beyond half a cycle. overrun: cycles that this
    controller itself was late for.
    """

    reason: Literal["end", "error", "stopped"] = "stopped"
    number: int = 0
    cycles: int = 0
    replies: int = 0
    missed: int = 0
    ignored: int = 0
    overrun: int = 0
    late: int = 0
    answers: list[float] = field(default_factory=list)
    track: list[list[float]] = field(default_factory=list)
    joints: list[float] = field(default_factory=list)

    def told(self) -> str:
        return json.dumps(self.__dict__)


class MxtControl:
    """kind: argument of the statement, 0 poses, 1 joints, 2 pulses. partner: address that is heard.

    port: UDP, 0 for any. timeout: MXTTOUT, cycles without a packet until error 7820, -1 for never.
    answers_end: whether the command that ends it is answered, which the manual leaves open.
    halted: whether the operation is stopped, so that packets are neither heard nor answered.
    faults: number of a reply, from 1 on → what befalls it. short: packets of 64 bytes.
    counts: whether answers are numbered.
    """

    def __init__(
        self,
        arm: MxtArm,
        kind: int,
        *,
        partner: str = "127.0.0.1",
        host: str = "127.0.0.1",
        port: int = 0,
        timeout: int = -1,
        signals: Signals | None = None,
        answers_end: bool = True,
        faults: Mapping[int, Fault] | None = None,
        short: bool = False,
        counts: bool = True,
        record: bool = True,
        halted: Callable[[], bool] = lambda: False,
    ) -> None:
        self.arm = arm
        self._type = kind + 1
        self._partner, self._timeout, self._answers_end = partner, timeout, answers_end
        self._signals = signals or Bits()
        self._faults = dict(faults or {})
        self._size = layout.SHORT_FIELDS if short else PACKET.itemsize
        self._record, self._counts = record, counts
        self.result = MxtEnd()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((host, port))
        self._socket.setblocking(False)
        self._stamps = sys.platform == "linux" and struct.calcsize("P") == 8
        if self._stamps:
            self._socket.setsockopt(socket.SOL_SOCKET, STAMP, 1)
        self._silent = False
        self._halted = halted
        self._sent: float | None = None
        self._moving = False
        self._waiting: list[tuple[float, bytes, tuple[str, int]]] = []

    @property
    def port(self) -> int:
        return int(self._socket.getsockname()[1])

    def run(self, stop: threading.Event) -> MxtEnd:
        """Goes through cycles until it ends or `stop` is set; closes the socket."""
        result, cycle = self.result, self.arm.cycle
        without = 0
        moment = time.monotonic()
        try:
            while not stop.is_set():
                moment += cycle
                rest = moment - time.monotonic()
                if rest > 0.0:
                    time.sleep(rest)
                elif rest < -cycle:
                    result.overrun += 1
                    moment = time.monotonic()
                result.cycles += 1
                self._send_late()
                got = self._latest()
                if got is None:
                    self.arm.rest()
                    if self._timeout >= 0 and not self._silent and not self._halted():
                        without += 1
                        result.missed += 1
                        if without >= max(1, self._timeout):
                            raise Refusal(TIMED_OUT)
                    continue
                without = 0
                if self._take(*got):
                    result.reason = "end"
                    break
        except Refusal as refusal:
            result.reason, result.number = "error", refusal.number
        finally:
            self._socket.close()
            result.joints = self.arm.commanded.tolist()
            result.late = sum(seconds > cycle / 2.0 for seconds in result.answers)
        return result

    # ---------------------------------------------------------------------------- one cycle

    def _latest(self) -> tuple[np.void, tuple[str, int]] | None:
        """The last packet of this cycle that the partner sent."""
        found = None
        while True:
            try:
                if self._stamps:
                    data, extra, _, sender = self._socket.recvmsg(2048, 64)
                else:
                    data, sender = self._socket.recvfrom(2048)
                    extra = []
            except BlockingIOError:
                return found
            except ConnectionRefusedError:
                continue
            if sender[0] != self._partner or len(data) != self._size:
                self.result.ignored += 1
                continue
            if self._silent or self._halted():
                self.result.ignored += 1
                continue
            found = (np.frombuffer(data.ljust(196, b"\0"), PACKET)[0], sender)
            moves = int(found[0]["Command"]) == MOVE
            if self._sent is not None:
                seconds = _arrival(extra) - self._sent
                if seconds < 0.0:
                    continue  # it was sent before the reply, so it does not answer it
                if moves and self._moving:
                    self.result.answers.append(seconds)
            self._sent, self._moving = None, moves

    def _take(self, packet: np.void, sender: tuple[str, int]) -> bool:
        """Moves as a packet says and answers; whether it ends the statement."""
        command = int(packet["Command"])
        if command == MOVE:
            if int(packet["SendType"]) != self._type:
                raise Refusal(ILLEGAL)
            joints = self._joints(packet["dat"].tobytes())
            self.arm.command(joints)
            if self._record:
                self.result.track.append(joints.tolist())
            self.arm.follow()
        elif command in (NULL, END):
            self.arm.rest()
        else:
            raise Refusal(ILLEGAL)
        if int(packet["SendIOType"]) == 1:
            first, mask = int(packet["BitTop"]), int(packet["BitMask"])
            self._signals.write(first, mask, int(packet["IoData"]))
        if command != END or self._answers_end:
            self._reply(packet, sender)
        return command == END

    def _joints(self, data: bytes) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        values = np.frombuffer(data, POSITION_KINDS[self._type])[0]
        if self._type == 1:
            place = np.array(values["place"], dtype=np.float64)
            if not np.isfinite(place).all():
                raise Refusal(ILLEGAL)
            return self.arm.joints_at(place[:6])
        if self._type == 2:
            angles = np.array(values["angles"], dtype=np.float64)[self.arm.places]
            if not np.isfinite(angles).all():
                raise Refusal(ILLEGAL)
            return self.arm.degrees(angles)
        pulses = np.array(values["pulses"], dtype=np.float64)[self.arm.places]
        return np.asarray(pulses / PULSES)

    # ---------------------------------------------------------------------------- the answer

    def _reply(self, packet: np.void, sender: tuple[str, int]) -> None:
        result = self.result
        result.replies += 1
        reply = np.zeros((), PACKET)
        reply["Command"] = packet["Command"]
        kind = int(packet["RecvType"])
        reply["SendType"] = reply["RecvType"] = kind
        reply["dat"] = self._data(kind)
        wanted = int(packet["RecvIOType"])
        reply["SendIOType"] = wanted
        reply["BitTop"] = packet["BitTop"]
        if wanted in (1, 2):
            reply["IoData"] = self._signals.read(wanted, int(packet["BitTop"]))
        reply["TCount"] = result.missed & 0xFFFF
        reply["CCount"] = result.replies & 0xFFFFFFFF if self._counts else 0
        for i in (1, 2, 3):
            more = int(packet[f"RecvType{i}"])
            reply[f"RecvType{i}"] = more
            reply[f"dat{i}"] = self._data(more)
        self._send(reply.tobytes()[: self._size], sender)

    def _send(self, data: bytes, sender: tuple[str, int]) -> None:
        fault = self._faults.get(self.result.replies)
        if fault in ("silent", "stop"):
            self._silent = True
            return
        if fault == "lost":
            return
        if fault == "late":
            due = time.monotonic() + LATE * self.arm.cycle
            self._waiting.append((due, data, sender))
            return
        if fault == "garbled":
            data = bytes(byte ^ 0xA5 for byte in data)
        for _ in range(2 if fault == "twice" else 1):
            self._out(data, sender)

    def _out(self, data: bytes, sender: tuple[str, int]) -> None:
        self._sent = time.time()
        try:
            self._socket.sendto(data, sender)
        except OSError:  # the partner is gone; the arm holds
            self._sent = None

    def _send_late(self) -> None:
        now = time.monotonic()
        due = [one for one in self._waiting if one[0] <= now]
        self._waiting = [one for one in self._waiting if one[0] > now]
        for _, data, sender in due:
            self._out(data, sender)

    def _data(self, kind: int) -> bytes:
        """What a packet holds for a type of data; 7840 if there is no such type."""
        if kind == 0:
            return bytes(40)
        if kind not in POSITION_KINDS:
            raise Refusal(ILLEGAL)
        values = np.zeros((), POSITION_KINDS[kind])
        if kind >= 10:
            return values.tobytes()
        arm = self.arm
        joints = (arm.commanded, arm.filtered, arm.fed_back)[(kind - 1) // 3]
        name = ("place", "angles", "pulses")[(kind - 1) % 3]
        if name == "place":
            values[name][:6] = arm.pose(joints)
        elif name == "angles":
            values[name][arm.places] = arm.radians(joints)
        else:
            values[name][arm.places] = np.round(joints * PULSES)
        return values.tobytes()


def _arrival(extra: list[tuple[int, int, bytes]]) -> float:
    for level, kind, value in extra:
        if level == socket.SOL_SOCKET and kind == STAMP:
            seconds, nanoseconds = struct.unpack_from("=qq", value)
            return float(seconds) + 1e-9 * float(nanoseconds)
    return time.time()
