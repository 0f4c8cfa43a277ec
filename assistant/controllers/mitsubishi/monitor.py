"""Real-time monitor: the data that a CR controller sends in each cycle (BFP-A3379-A, 5).

with Monitor("192.168.0.20", ("joints_feedback", "current")) as monitor:
    for sample in itertools.islice(monitor, 1000):
        print(sample.seconds, sample.values["joints_feedback"])

It needs MONMODE = 1, no program and no operation right, and never moves anything.
"""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Iterator, Mapping, Sequence
from itertools import count, islice
from math import isfinite
from types import TracebackType
from typing import Final, Self

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.controllers.mitsubishi.rules import MONITOR_SILENT, NO_MONITOR, require

PORT: Final = 12000
"""First element of MONPORT as delivered."""
_PACKET_SIZE: Final = 196
_START_COMMAND: Final = 1
_END_COMMAND: Final = 255
FIELDS: Final = (
    *((0, "H", "command"), (4, "H", "type1"), (8, "40s", "data1")),
    *((48, "H", "first_input"), (50, "H", "first_output")),
    *((52, "I", "inputs"), (56, "I", "outputs"), (60, "I", "counter")),
    *((64, "H", "type2"), (68, "40s", "data2")),
    *((108, "H", "type3"), (112, "40s", "data3")),
    *((152, "H", "type4"), (156, "40s", "data4")),
)
"""Offset, form and name of each field that is used; little-endian."""
_FIELD_STRUCTS: Final = {name: (offset, struct.Struct("<" + form)) for offset, form, name in FIELDS}

AXES: Final = tuple(f"J{i}" for i in range(1, 9))
POSE: Final = (*"xyzabc", "l1", "l2", "flag1", "flag2")
_FORCE: Final = ("fx", "fy", "fz", "mx", "my", "mz")
ROBOT: Final = (
    *("speed_feedback", "left_feedback", "speed", "left", "gap", "factor", "accelerating"),
    *("step", "temperature", "cycles"),
)
FORMS: Final[Mapping[str, tuple[struct.Struct, tuple[str, ...]]]] = {
    "pose": (struct.Struct("<8f2i"), POSE),
    "joint": (struct.Struct("<8f8x"), AXES),
    "pulse": (struct.Struct("<8i8x"), AXES),
    "float8": (struct.Struct("<8f8x"), AXES),
    "force": (struct.Struct("<6f16x"), _FORCE),
    "robot": (struct.Struct("<5f3h6xh2xI"), ROBOT),
}
"""Structure → its form and what its numbers are called; of `robot` mm/s, mm, tenths of degrees
Celsius and cycles since the controller was switched on, without the name of the program."""
_PROGRAM_NAME_BYTES: Final = slice(26, 32)
"""Bytes of `robot` with the name of the program in slot 1."""

TYPES: Final[Mapping[str, tuple[int, str]]] = {
    "pose": (1001, "pose"),
    "joints": (1002, "joint"),
    "pulses": (3, "pulse"),
    "pose_feedback": (1007, "pose"),
    "joints_feedback": (1008, "joint"),
    "pulses_feedback": (9, "pulse"),
    "pose_radians": (1, "pose"),
    "joints_radians": (2, "joint"),
    "pose_feedback_radians": (7, "pose"),
    "joints_feedback_radians": (8, "joint"),
    "current_permille": (10, "pulse"),
    "current_feedback_permille": (11, "pulse"),
    "robot": (12, "robot"),
    "droop": (13, "pulse"),
    "speed_rpm": (14, "pulse"),
    "speed_feedback_rpm": (15, "pulse"),
    "load_percent": (16, "float8"),
    "encoder_temperature": (17, "pulse"),
    "encoder_miscounts": (18, "pulse"),
    "motor_voltage": (19, "pulse"),
    "regeneration_percent": (20, "pulse"),
    "tolerable_plus_permille": (21, "pulse"),
    "tolerable_minus_permille": (22, "pulse"),
    "rms_current_permille": (23, "pulse"),
    "force": (101, "force"),
    "force_raw": (102, "force"),
    "force_raw_with_offset": (103, "force"),
    "force_pose": (104, "pose"),
    "presumed_torque_permille": (111, "pulse"),
    "collision_plus_permille": (112, "pulse"),
    "collision_minus_permille": (113, "pulse"),
    "current": (1010, "float8"),
    "current_feedback": (1011, "float8"),
    "tolerable_plus": (1012, "float8"),
    "tolerable_minus": (1013, "float8"),
    "rms_current": (1014, "float8"),
}
"""Name → data type ID and structure (table 5-8). Those from 1001 on are degrees and amperes, which
controllers know from software R4b/S4b on; those with units in their name are older."""
_MOST_TYPES: Final = 4
_START_RETRY: Final = 0.1
"""Seconds after which a start that is not answered is sent again."""


@dataclass(frozen=True, slots=True)
class MonitorSample:
    """One cycle. seconds: since the first sample, by the clock of this machine. counter: of the
    controller. values: by name, as `FORMS` lists them. inputs, outputs: 32 signals each from the
    first that was requested. program: in slot 1, where `robot` is requested. lost: packets of the
    controller that did not arrive before this one.
    """

    seconds: float
    counter: int
    values: Mapping[str, tuple[float, ...]]
    inputs: int
    outputs: int
    program: str = ""
    lost: int = 0


class Monitor:
    """A stream of what a controller tells; a context manager, and an iterator without end.

    types: up to four names of `TYPES`. port: first element of MONPORT. local_port: second element,
    where that is not 0. inputs, outputs: numbers of the first signals. timeout: seconds without a
    packet until it gives up. The controller sends to the last one that asked only.
    """

    def __init__(
        self,
        host: str,
        types: Sequence[str] = ("joints", "joints_feedback"),
        *,
        port: int = PORT,
        local_port: int = 0,
        inputs: int = 0,
        outputs: int = 0,
        timeout: float = 2.0,
    ) -> None:
        unknown = sorted(set(types) - set(TYPES))
        require("types", unknown, not unknown, f"known are {', '.join(TYPES)}")
        right = 1 <= len(types) <= _MOST_TYPES and len(set(types)) == len(types)
        require("types", tuple(types), right, "a packet has room for four different ones")
        require("port", port, 0 < port < 65536, "it is a number from 1 to 65535")
        require("local_port", local_port, 0 <= local_port < 65536, "it is 0 or a port")
        signals = 0 <= inputs <= 32767 and 0 <= outputs <= 32767
        require("inputs, outputs", (inputs, outputs), signals, "numbers from 0 to 32767")
        require("timeout", timeout, 0.0 < timeout <= 3600.0, "it is seconds above 0")
        self._host, self._port, self._types = host, port, tuple(types)
        self._local_port, self._timeout = local_port, timeout
        self._signals = (inputs, outputs)
        self._address = f"{host}:{port}"

    def __enter__(self) -> Self:
        """Asks for the data; raises Refused if none comes."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._peer = (socket.gethostbyname(self._host), self._port)
            self._socket.bind(("", self._local_port))
            self._first = self._opened()
        except OSError as error:
            self._socket.close()
            reason = error.strerror or str(error)
            finding = NO_MONITOR(address=self._address, reason=reason)
            raise Refused(finding, exit_status=2) from None
        except BaseException:
            self._stop()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stop()

    def __iter__(self) -> Iterator[MonitorSample]:
        began, packet = self._first
        before, moment = None, began
        while True:
            counter = int(
                _FIELD_STRUCTS["counter"][1].unpack_from(packet, _FIELD_STRUCTS["counter"][0])[0]
            )
            ahead = 1 if before is None else (counter - before) % (1 << 32)
            # UDP may repeat and reorder packets: one from before is left out.
            if 0 < ahead < 1 << 31:
                before = counter
                yield self._sample(packet, moment - began, counter, ahead - 1)
            moment, packet = self._next()

    def record(self, samples: int) -> dict[str, Floats]:
        """The next samples as columns: `time`, `counter`, `inputs`, `outputs`, `joints_J1`, …

        `controllers.recording.save_columns` writes them.
        """
        rows = list(islice(self, samples))
        columns: dict[str, Floats] = {
            "time": np.array([row.seconds for row in rows]),
            **{
                name: np.array([getattr(row, name) for row in rows], dtype=np.float64)
                for name in ("counter", "inputs", "outputs")
            },
        }
        for name in self._types:
            table = np.array([row.values[name] for row in rows], dtype=np.float64)
            parts = FORMS[TYPES[name][1]][1]
            columns |= {f"{name}_{part}": table[:, i] for i, part in enumerate(parts)}
        return columns

    def _opened(self) -> tuple[float, bytes]:
        """The first packet and when it came."""
        until = time.monotonic() + self._timeout
        for _ in count():
            self._send(_START_COMMAND)
            got = self._receive(min(_START_RETRY, max(0.0, until - time.monotonic())))
            if got is not None:
                return got
            if time.monotonic() >= until:
                break
        reason = f"nothing came within {self._timeout:g} s"
        raise Refused(NO_MONITOR(address=self._address, reason=reason), exit_status=2)

    def _next(self) -> tuple[float, bytes]:
        got = self._receive(self._timeout)
        if got is None:
            finding = MONITOR_SILENT(address=self._address, seconds=self._timeout)
            raise Refused(finding, exit_status=2)
        return got

    def _receive(self, seconds: float) -> tuple[float, bytes] | None:
        """Return the next requested packet; ignore others, and other senders."""
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0.0:
            self._socket.settimeout(left)
            try:
                packet, sender = self._socket.recvfrom(2048)
            except TimeoutError:
                return None
            except ConnectionError:  # nothing listened on that port when it was asked
                continue
            if (
                sender[0] == self._peer[0]
                and len(packet) == _PACKET_SIZE
                and self._is_asked(packet)
            ):
                return time.monotonic(), packet
        return None

    def _is_asked(self, packet: bytes) -> bool:
        wanted = [TYPES[name][0] for name in self._types]
        for i, number in enumerate(wanted, 1):
            offset, form = _FIELD_STRUCTS[f"type{i}"]
            if form.unpack_from(packet, offset)[0] != number:
                return False
        return True

    def _sample(self, packet: bytes, seconds: float, counter: int, lost: int) -> MonitorSample:
        values: dict[str, tuple[float, ...]] = {}
        program = ""
        for i, name in enumerate(self._types, 1):
            offset = _FIELD_STRUCTS[f"data{i}"][0]
            structure = TYPES[name][1]
            numbers = FORMS[structure][0].unpack_from(packet, offset)
            values[name] = tuple(float(v) if isfinite(v) else float("nan") for v in numbers)
            if structure == "robot":
                named = packet[
                    offset + _PROGRAM_NAME_BYTES.start : offset + _PROGRAM_NAME_BYTES.stop
                ]
                program = named.split(b"\0")[0].decode("ascii", "replace").strip()
        inputs, outputs = (
            int(_FIELD_STRUCTS[n][1].unpack_from(packet, _FIELD_STRUCTS[n][0])[0])
            for n in ("inputs", "outputs")
        )
        return MonitorSample(seconds, counter, values, inputs, outputs, program, lost)

    def _send(self, command: int) -> None:
        packet = bytearray(_PACKET_SIZE)
        fields = {"command": command}
        if command == _START_COMMAND:
            fields |= {f"type{i}": TYPES[name][0] for i, name in enumerate(self._types, 1)}
            fields |= {"first_input": self._signals[0], "first_output": self._signals[1]}
        for name, value in fields.items():
            offset, form = _FIELD_STRUCTS[name]
            form.pack_into(packet, offset, value)
        self._socket.sendto(packet, self._peer)

    def _stop(self) -> None:
        """Asks the controller to send no more."""
        try:
            self._send(_END_COMMAND)
        except OSError:
            return  # there is no way to the controller, whose packets go nowhere then
        finally:
            self._socket.close()
