"""Real-time control by `Mxt` on the controller's side (BFP-A3379-A, 4.2).

In each cycle it takes the position of one packet, gives it to the servos, and answers; without a
packet it holds. It ends with the command 255, or with an error. A packet has 196 bytes,
little-endian (4.2.2).

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
from dataclasses import field
from typing import TYPE_CHECKING, Final, Literal, Protocol

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.rotations import from_euler, to_euler

if TYPE_CHECKING:
    from assistant.robots import Robot


_BLOCK: Final = "V40"
PACKET: Final = np.dtype(
    [
        ("Command", "<u2"),
        ("SendType", "<u2"),
        ("RecvType", "<u2"),
        ("reserve", "<u2"),
        ("dat", _BLOCK),
        ("SendIOType", "<u2"),
        ("RecvIOType", "<u2"),
        ("BitTop", "<u2"),
        ("BitMask", "<u2"),
        ("IoData", "<u2"),
        ("TCount", "<u2"),
        ("CCount", "<u4"),
        ("RecvType1", "<u2"),
        ("reserve1", "<u2"),
        ("dat1", _BLOCK),
        ("RecvType2", "<u2"),
        ("reserve2", "<u2"),
        ("dat2", _BLOCK),
        ("RecvType3", "<u2"),
        ("reserve3", "<u2"),
        ("dat3", _BLOCK),
    ]
)
assert PACKET.itemsize == 196
_SHORT_FIELDS: Final = 64
"""Bytes that a controller of the CRn-500 series knows: up to the counter."""

POSE: Final = np.dtype([("place", "<f4", 8), ("flags", "<u4", 2)])
JOINT: Final = np.dtype([("angles", "<f4", 8), ("unused", "V8")])
_PULSE: Final = np.dtype([("pulses", "<i4", 8), ("unused", "V8")])
_POSITION_KINDS: Final[Mapping[int, np.dtype[np.void]]] = {
    1: POSE,
    2: JOINT,
    3: _PULSE,
    4: POSE,
    5: JOINT,
    6: _PULSE,
    7: POSE,
    8: JOINT,
    9: _PULSE,
    10: _PULSE,
    11: _PULSE,
}
"""Type of data → what it is: 1 to 3 as commanded, 4 to 6 behind the filter, 7 to 9 as fed back,
10 and 11 the currents."""


PULSES: Final = 100.0
"""Pulses of a motor to a degree (or mm) of its axis: no maker publishes them, any number serves."""
_LIMIT_ROUNDING: Final = 1e-3
"""Part of a step, and degrees, that single precision may add."""
_SERVO_TIME: Final = 0.5
"""Part of the way to its command that an arm goes in a cycle: it is some two cycles behind."""
SPEED: Final = 2130
_BEYOND: Final = 2160
_BELOW: Final = 2170
"""Errors; the number of the axis is added (error list BFP-A8871)."""
_NO_SOLUTION: Final = 2802
"""A pose that the arm cannot take, at those flags."""


class _Refusal(Exception):
    """A command that the controller answers with an error; `number` of it."""

    def __init__(self, number: int) -> None:
        super().__init__(str(number))
        self.number = number


class MxtArm:
    """Arm in real-time control: joints (a,) in degrees, those of sliding axes in mm.

    places: (a,) position of each axis in a packet: J5 of an arm without J4 is still the fifth.
    joints: those of the arm at the start. cycle: seconds. filter_ms: time constant of the received
    command. servo: part of the distance to its command that the arm moves in a cycle, 0 for an arm
    that is stuck.
    """

    def __init__(
        self,
        robot: Robot,
        joints: Floats,
        cycle: float,
        filter_ms: float = 0.0,
        servo: float = _SERVO_TIME,
    ) -> None:
        self.robot, self.cycle = robot, cycle
        self.commanded = np.array(joints, dtype=np.float64)
        self.filtered = self.commanded.copy()
        self.fed_back = self.commanded.copy()
        self._servo = servo
        self._part = cycle / (cycle + filter_ms / 1e3)
        self._turning = ~np.asarray(robot.sliding)
        self.places = np.array(robot.places)

    def command(self, joints: Floats) -> None:
        """Takes a command; raises Refusal if it is out of range or too far for one cycle."""
        low, high = self.robot.limits.T
        # `for` with `raise` takes the first axis that is out of range, if there is one.
        for axis in map(int, np.flatnonzero(joints > high + _LIMIT_ROUNDING)):
            raise _Refusal(_BEYOND + self._number(axis))
        for axis in map(int, np.flatnonzero(joints < low - _LIMIT_ROUNDING)):
            raise _Refusal(_BELOW + self._number(axis))
        filtered = self.filtered + self._part * (joints - self.filtered)
        # Single precision of the packet may exceed the limit by rounding.
        most = self.robot.speeds * self.cycle * (1.0 + _LIMIT_ROUNDING) + _LIMIT_ROUNDING
        for axis in map(int, np.flatnonzero(np.abs(filtered - self.filtered) > most)):
            raise _Refusal(SPEED + self._number(axis))
        self.commanded, self.filtered = joints, filtered

    def follow(self) -> None:
        """One cycle of the servos."""
        # A fixed part of the way each cycle: the arm lags its command as real servos do.
        self.fed_back = self.fed_back + self._servo * (self.filtered - self.fed_back)

    def rest(self) -> None:
        """One cycle without a command: the position is held."""
        self.filtered = self.filtered + self._part * (self.commanded - self.filtered)
        self.follow()

    def _number(self, axis: int) -> int:
        return int(self.places[axis]) + 1

    def radians(self, joints: Floats) -> Floats:
        return np.where(self._turning, np.radians(joints), joints)

    def degrees(self, values: Floats) -> Floats:
        return np.where(self._turning, np.degrees(values), values)

    def pose(self, joints: Floats) -> Floats:
        """(6,) x, y, z in mm and a, b, c in radians of the flange."""
        place, turn = self.robot.flange_poses(joints[None])
        return np.concatenate([place[0], np.radians(to_euler(turn[0], "ZYX")[::-1])])

    def joints_at(self, pose: Floats) -> Floats:
        """Return the joints (a,) at a pose (6,), nearest to the commanded ones; raises Refusal if
        no joints reach it.

        The flags are ignored: a step within a cycle leads to no other branch of the arm.
        """
        turn = from_euler(np.degrees(pose[3:6])[None, ::-1], "ZYX")
        found, valid = self.robot.ik(pose[None, :3], turn)
        if not valid.any():
            raise _Refusal(_NO_SOLUTION)
        solutions = found[0][valid[0]]
        # An angle may be a full turn away: the one nearest to the command counts.
        turns = np.round((self.commanded - solutions) / 360.0) * 360.0
        near = np.where(self._turning, solutions + turns, solutions)
        away = np.abs(near - self.commanded).max(axis=1)
        return np.asarray(near[int(np.argmin(away))])


CYCLE: Final = 64 / 9000
"""Seconds: CR750; 0.0035 of CR800."""
_NULL: Final = 0
MOVE: Final = 1
END: Final = 255
_TIMED_OUT: Final = 7820
_ILLEGAL: Final = 7840
"""Errors of the statement (BFP-A3379-A, 7.1)."""
_LATE: Final = 1.5
"""Cycles by which a reply is late that is made so."""
_STAMP: Final = 35
"""SO_TIMESTAMPNS of Linux: time of a packet's arrival, not of its reading."""

Fault = Literal["lost", "twice", "garbled", "late", "silent", "stop"]
"""Faults of a reply: `silent` is a controller that sends and does nothing more, `stop` one whose
operation is stopped: it holds, and sends nothing more either.
"""


class Signals(Protocol):
    """Words of 16 signals."""

    def read(self, kind: int, first: int) -> int:
        """kind: 1 outputs, 2 inputs."""

    def write(self, first: int, mask: int, word: int) -> None:
        """Sets those outputs that the mask has."""


@dataclass
class Bits:
    """Signals of a controller without programs around it."""

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
    """End of real-time control and what was observed. number: that of an error, 0 for none. reason:
    end, error, stopped.

    answers: seconds from the reply to a move to the arrival of the next one; a packet that arrived
    before the reply answers none. late: count of those later than half a cycle. overrun: cycles
    that this controller itself was late for.
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
        self._size = _SHORT_FIELDS if short else PACKET.itemsize
        self._record, self._counts = record, counts
        self.result = MxtEnd()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((host, port))
        self._socket.setblocking(False)
        self._stamps = sys.platform == "linux" and struct.calcsize("P") == 8
        if self._stamps:
            self._socket.setsockopt(socket.SOL_SOCKET, _STAMP, 1)
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
                # From the planned moment, so that delays do not add up.
                moment += cycle
                rest = moment - time.monotonic()
                if rest > 0.0:
                    time.sleep(rest)
                # More than a cycle late: go on from now, or
                # packets of lost cycles would be taken at once.
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
                            raise _Refusal(_TIMED_OUT)
                    continue
                without = 0
                if self._take(*got):
                    result.reason = "end"
                    break
        except _Refusal as refusal:
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
                raise _Refusal(_ILLEGAL)
            joints = self._joints(packet["dat"].tobytes())
            self.arm.command(joints)
            if self._record:
                self.result.track.append(joints.tolist())
            self.arm.follow()
        # These commands move nothing, whatever position they hold.
        elif command in (_NULL, END):
            self.arm.rest()
        else:
            raise _Refusal(_ILLEGAL)
        if int(packet["SendIOType"]) == 1:
            first, mask = int(packet["BitTop"]), int(packet["BitMask"])
            self._signals.write(first, mask, int(packet["IoData"]))
        if command != END or self._answers_end:
            self._reply(packet, sender)
        return command == END

    def _joints(self, data: bytes) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        values = np.frombuffer(data, _POSITION_KINDS[self._type])[0]
        if self._type == 1:
            place = np.array(values["place"], dtype=np.float64)
            if not np.isfinite(place).all():
                raise _Refusal(_ILLEGAL)
            return self.arm.joints_at(place[:6])
        if self._type == 2:
            angles = np.array(values["angles"], dtype=np.float64)[self.arm.places]
            if not np.isfinite(angles).all():
                raise _Refusal(_ILLEGAL)
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
        # Fields of 16 and 32 bits wrap.
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
            due = time.monotonic() + _LATE * self.arm.cycle
            self._waiting.append((due, data, sender))
            return
        if fault == "garbled":
            data = bytes(byte ^ 0xA5 for byte in data)
        for _ in range(2 if fault == "twice" else 1):
            self._out(data, sender)

    def _out(self, data: bytes, sender: tuple[str, int]) -> None:
        # The clock of arrivals, see `_STAMP`: delays are differences of both.
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
        """Return the contents of a packet for a type of data; raises Refusal 7840 for an unknown
        type.
        """
        if kind == 0:
            return bytes(40)
        if kind not in _POSITION_KINDS:
            raise _Refusal(_ILLEGAL)
        values = np.zeros((), _POSITION_KINDS[kind])
        if kind >= 10:
            return values.tobytes()
        arm = self.arm
        # 1 to 3 commanded, 4 to 6 filtered, 7 to 9 fed back; of each pose, joints, pulses.
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
        if level == socket.SOL_SOCKET and kind == _STAMP:
            seconds, nanoseconds = struct.unpack_from("=qq", value)
            return float(seconds) + 1e-9 * float(nanoseconds)
    return time.time()
