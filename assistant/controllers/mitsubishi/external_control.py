"""Real-time external control (`Mxt`): leads an arm of a CR controller cycle by cycle over UDP.

with Mxt("192.168.0.20", limits=Limits((420, 336, 250, 540, 623, 720))) as mxt:
    report = mxt.follow(Trajectory.of_joints(angles, times, unit="deg"))

A program on the controller has to be waiting in `Mxt`, see `program` (BFP-A3379-A, 4.2). The
packet, the same in both directions, has 196 bytes, little-endian (4.2.2 and 7.2.2); controllers of
the CRn-500 series know only the first 64, up to the counter (their strdef.h has no RecvType1). A,
B, C of a pose are in radians, R = Rz(C) Ry(B) Rx(A). The loop converts one pose a cycle, which
plain numbers do several times faster than arrays.
"""

from __future__ import annotations

import contextlib
import ipaddress
import socket
import struct
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import asin, atan2, copysign, cos, degrees, isfinite, pi, radians, sin, sqrt
from typing import Final, Literal, Self

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.controllers import cyclic
from assistant.controllers.cyclic import (
    Endpoint,
    Limits,
    Measured,
    Progress,
    Report,
    Settings,
    Trajectory,
)
from assistant.controllers.cyclic.loop import PacketSocket
from assistant.controllers.cyclic.rules import BROKEN, NO_ANSWER
from assistant.controllers.mitsubishi.monitor import Monitor, MonitorSample
from assistant.controllers.mitsubishi.rules import BAD_SETTING, WRONG_KIND, require
from assistant.program.motion import Path

__all__ = ["CYCLES", "Monitor", "MonitorSample", "Mxt", "program"]

PACKET_FIELDS: Final = (
    (0, "H", "command"),
    (2, "H", "send_type"),
    (4, "H", "recv_type"),
    (6, "H", "reserve"),
    (8, "40s", "data"),
    (48, "H", "send_io_type"),
    (50, "H", "recv_io_type"),
    (52, "H", "bit_top"),
    (54, "H", "bit_mask"),
    (56, "H", "io_data"),
    (58, "H", "t_count"),
    (60, "I", "c_count"),
    (64, "H", "recv_type1"),
    (66, "H", "reserve1"),
    (68, "40s", "data1"),
    (108, "H", "recv_type2"),
    (110, "H", "reserve2"),
    (112, "40s", "data2"),
    (152, "H", "recv_type3"),
    (154, "H", "reserve3"),
    (156, "40s", "data3"),
)
"""Offset, form and name of each field; the names are those of the manual."""
PACKET_LAYOUT: Final = struct.Struct("<" + "".join(form for _, form, _ in PACKET_FIELDS))
_FIELD_NAMES: Final = tuple(name for _, _, name in PACKET_FIELDS)
PACKET_SIZE: Final = 196
_SHORT_SIZE: Final = 64
"""Bytes of a packet of the CRn-500 series."""

_NULL_COMMAND: Final = 0
_MOVE_COMMAND: Final = 1
_END_COMMAND: Final = 255
"""Commands: no motion, move, end the control."""
_NO_SIGNALS: Final = 0
_OUTPUTS: Final = 1
_INPUTS: Final = 2

_FILTERED: Final = 3
_FEEDBACK: Final = 6
"""Offset of the type of a command for the same data from the encoders; `_FILTERED` for those after
the filter.
"""
_POSE_DATA: Final = struct.Struct("<8f2I")
_JOINT_DATA: Final = struct.Struct("<8f8x")
_PULSE_DATA: Final = struct.Struct("<8i8x")
_COMMAND_TYPES: Final = {"pose": 1, "joint": 2, "pulse": 3}
"""Mode → type of the data in a command, which also is one more than the statement's argument."""
_DATA_FORMS: Final[Mapping[int, struct.Struct]] = {
    **dict.fromkeys((1, 4, 7), _POSE_DATA),
    **dict.fromkeys((2, 5, 8), _JOINT_DATA),
    **dict.fromkeys((3, 6, 9, 10, 11), _PULSE_DATA),
}
"""Type of data → its form; 10 and 11 are the currents, commanded and fed back, in percent."""
_NO_DATA: Final = bytes(40)


def pack_packet(fields: Mapping[str, int | bytes], size: int = PACKET_SIZE) -> bytes:
    """A packet of these fields; those that are left out are 0."""
    empty: Mapping[str, int | bytes] = {"data": _NO_DATA, "data1": _NO_DATA}
    given = {**empty, "data2": _NO_DATA, "data3": _NO_DATA, **fields}
    # A short packet is the beginning of a long one:
    # the CRn-500 series knows only its first 64 bytes.
    return PACKET_LAYOUT.pack(*(given.get(name, 0) for name in _FIELD_NAMES))[:size]


def unpack_packet(packet: bytes, size: int = PACKET_SIZE) -> dict[str, int | bytes] | None:
    """The fields of a packet, None if it has another size."""
    if len(packet) != size:
        return None
    return dict(
        zip(_FIELD_NAMES, PACKET_LAYOUT.unpack(packet.ljust(PACKET_SIZE, b"\0")), strict=True)
    )


def pack_data(kind: int, values: Sequence[float], flags: tuple[int, int] = (0, 0)) -> bytes:
    """Eight numbers as data of a type; what is left out is 0. flags: of a pose."""
    eight = [*values, *[0.0] * (8 - len(values))]
    form = _DATA_FORMS[kind]
    if form is _POSE_DATA:
        return form.pack(*eight, *flags)
    if form is _PULSE_DATA:
        return form.pack(*(round(value) for value in eight))
    return form.pack(*eight)


def quaternion_of_angles(a: float, b: float, c: float) -> tuple[float, float, float, float]:
    """(w, x, y, z), w not below 0."""
    ca, sa, cb, sb = cos(a / 2), sin(a / 2), cos(b / 2), sin(b / 2)
    cc, sc = cos(c / 2), sin(c / 2)
    w = ca * cb * cc + sa * sb * sc
    x = sa * cb * cc - ca * sb * sc
    y = ca * sb * cc + sa * cb * sc
    z = ca * cb * sc - sa * sb * cc
    # Both signs are the same turn; w >= 0 makes the quaternion of a pose unique.
    return (w, x, y, z) if w >= 0.0 else (-w, -x, -y, -z)


def angles_of_quaternion(w: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A, B, C in radians; where B is a quarter turn, A is all of what A and C turn together."""
    size = sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / size, x / size, y / size, z / size
    sine = 2.0 * (w * y - z * x)
    # At a quarter turn A and C turn about the same axis: only their sum is known.
    if abs(sine) > 1.0 - 1e-12:
        b = copysign(pi / 2, sine)
        return 2.0 * atan2(x, w), b, 0.0
    a = atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    c = atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    # Rounding may put the sine slightly beyond 1, where asin has no value.
    return a, asin(max(-1.0, min(1.0, sine))), c


Mode = Literal["pose", "joint", "pulse"]
Watched = Literal["command", "filtered", "feedback"]
_WATCHED_OFFSETS: Final = {"command": 0, "filtered": _FILTERED, "feedback": _FEEDBACK}
_FARTHEST: Final = 1e6
"""mm or radians (pulses are not bounded): what a controller sends beyond is no position."""


@dataclass(frozen=True)
class MxtLink:
    """See `Mxt` for most of it. also: up to three more types of data that the controller sends.

    signals: what signals the controller sends, 0 none, 1 outputs, 2 inputs. first: the first of
    16. mask: which of them are set as outputs to those bits of `word`.
    """

    mode: Mode
    cycle: float
    axes: int = 6
    sliding: tuple[int, ...] = ()
    flags: tuple[int, int] = (0, 0)
    watched: Watched = "feedback"
    also: tuple[int, ...] = ()
    signals: int = 0
    first: int = 0
    mask: int = 0
    word: int = 0
    short: bool = False

    @property
    def speaks_first(self) -> bool:
        return False

    @property
    def recorded(self) -> tuple[str, ...]:
        more = [f"type{kind}_{i}" for kind in self.also for i in range(1, 9)]
        return ("t_count", "c_count", "signals", *more)

    @property
    def size(self) -> int:
        return _SHORT_SIZE if self.short else PACKET_SIZE

    def hello(self, count: int) -> bytes:
        """Asks for the commanded position, where a motion has to begin."""
        return self._packed(_NULL_COMMAND, 0, _COMMAND_TYPES[self.mode], _NO_DATA, count)

    def command(self, values: Sequence[float], count: int) -> bytes:
        kind = _COMMAND_TYPES[self.mode]
        asked = kind + _WATCHED_OFFSETS[self.watched]
        return self._packed(_MOVE_COMMAND, kind, asked, self._data(kind, values), count)

    def end(self, values: Sequence[float], count: int) -> bytes:
        kind = _COMMAND_TYPES[self.mode]
        asked = kind + _WATCHED_OFFSETS[self.watched]
        return self._packed(_END_COMMAND, kind, asked, self._data(kind, values), count)

    def read(self, received: bytes) -> Measured | None:
        if len(received) != self.size:
            return None
        fields = PACKET_LAYOUT.unpack(received.ljust(PACKET_SIZE, b"\0"))
        command, send_type, kind, data = fields[0], fields[1], fields[2], fields[4]
        # An answer states the type of its data in both fields.
        if send_type != kind or command not in (
            _NULL_COMMAND,
            _MOVE_COMMAND,
            _END_COMMAND,
        ):
            return None
        # Types of one mode differ by 3: commanded, filtered, fed back.
        if not 1 <= kind <= 9 or (kind - _COMMAND_TYPES[self.mode]) % 3:
            return None
        values = self._values(kind, data)
        if values is None:
            return None
        extra: list[float] = [
            fields[_MISSED_FIELD],
            fields[_COUNTER_FIELD],
            fields[_SIGNAL_WORD_FIELD],
        ]
        for i, asked in enumerate(self.also):
            extra.extend(
                self._more(asked, fields[_MORE_DATA_FIELDS[i] - 2], fields[_MORE_DATA_FIELDS[i]])
            )
        return Measured(values, fields[_COUNTER_FIELD], fields[_MISSED_FIELD], extra=tuple(extra))

    def _packed(self, command: int, kind: int, asked: int, data: bytes, count: int) -> bytes:
        more = [*self.also, 0, 0, 0]
        nothing = _NO_DATA
        signals = _OUTPUTS if self.mask else _NO_SIGNALS
        head = (command, kind, asked, 0, data, signals, self.signals)
        bits = (self.first, self.mask, self.word, 0, count & 0xFFFFFFFF)
        rest = (more[0], 0, nothing, more[1], 0, nothing, more[2], 0, nothing)
        return PACKET_LAYOUT.pack(*head, *bits, *rest)[: self.size]

    def _data(self, kind: int, values: Sequence[float]) -> bytes:
        if self.mode == "pose":
            return pack_data(kind, (*values[:3], *angles_of_quaternion(*values[3:])), self.flags)
        if self.mode == "joint":
            return pack_data(kind, [self._turned(i, v, radians(v)) for i, v in enumerate(values)])
        return pack_data(kind, values)

    def _values(self, kind: int, data: bytes) -> tuple[float, ...] | None:
        found = _DATA_FORMS[kind].unpack(data)
        if self.mode == "pulse":
            return tuple(float(v) for v in found[: self.axes])
        if not all(isfinite(v) and abs(v) < _FARTHEST for v in found[:8]):
            return None
        if self.mode == "pose":
            return (*found[:3], *quaternion_of_angles(*found[3:6]))
        return tuple(self._turned(i, v, degrees(v)) for i, v in enumerate(found[: self.axes]))

    def _turned(self, axis: int, length: float, angle: float) -> float:
        return length if axis + 1 in self.sliding else angle

    def _more(self, asked: int, kind: int, data: bytes) -> list[float]:
        """Eight numbers as they are sent, nan where the controller sent other data."""
        if kind != asked:
            return [float("nan")] * 8
        return [float(v) for v in _DATA_FORMS[kind].unpack(data)[:8]]


_COUNTER_FIELD: Final = _FIELD_NAMES.index("c_count")
_MISSED_FIELD: Final = _FIELD_NAMES.index("t_count")
_SIGNAL_WORD_FIELD: Final = _FIELD_NAMES.index("io_data")
_MORE_DATA_FIELDS: Final = tuple(_FIELD_NAMES.index(f"data{i}") for i in (1, 2, 3))


PORT: Final = 10000
"""First element of NETPORT as delivered."""
CYCLES: Final = {"CR750": 64 / 9000, "CR800": 0.0035}
"""Series → seconds of a cycle: CRn-500, CRn-700 and CR750 7.11 ms; CR800 3.5 ms, but 7.11 ms with
a user mechanism."""


def usual_cycle(controller: str) -> float:
    """Return the seconds of a cycle of a controller series, such as CR800."""
    return CYCLES.get(controller, CYCLES["CR750"])


_KINDS: Final = {"pose": "poses", "joint": "joints", "pulse": "joints"}
_END_PACKETS: Final = 2
"""Packets that end the control, if the first one is not answered."""


class Mxt:
    """Real-time external control of one arm; a context manager that ends it on every way out.

    host: name or address of the controller. mode: "joint", "pose" or "pulse", as the
    program's `Mxt` names by 1, 0 or 2.
    limits: of the joints in degrees (mm of axes that slide, or pulses), or of a pose; they can be
    given with each trajectory as well. cycle: seconds, see `CYCLES`. axes: of the arm, and more
    ones. sliding: those of them, counted from 1, that slide. flags: structure flags 1 and 2 of
    poses. watched: what is compared with the command: what the encoders feed back, what comes
    behind the filter, or the command alone, where a controller knows nothing else.
    also: up to three more types of data to be recorded (10 and 11 are the currents).
    outputs: first of 16 output signals, mask, word: these are set in every cycle. inputs: first of
    16 input signals that are recorded as `signals`; with outputs, the same numbers are read.
    short: packets of 64 bytes, for the CRn-500 series. local_port: of this machine, 0 for any.
    Raises Refused for what cannot be.
    """

    def __init__(
        self,
        host: str,
        *,
        port: int = PORT,
        mode: Mode = "joint",
        limits: Limits | None = None,
        cycle: float = CYCLES["CR750"],
        axes: int = 6,
        sliding: tuple[int, ...] = (),
        flags: tuple[int, int] = (0, 0),
        watched: Watched = "feedback",
        also: tuple[int, ...] = (),
        outputs: tuple[int, int, int] | None = None,
        inputs: int | None = None,
        short: bool = False,
        settings: Settings | None = None,
        local_port: int = 0,
    ) -> None:
        known = isinstance(mode, str) and mode in _COMMAND_TYPES
        require("mode", mode, known, "it is pose, joint or pulse")
        require(
            "watched",
            watched,
            watched in _WATCHED_OFFSETS,
            f"it is one of {', '.join(_WATCHED_OFFSETS)}",
        )
        require("port", port, 0 < port < 65536, "it is a number from 1 to 65535")
        require("local_port", local_port, 0 <= local_port < 65536, "it is 0 or a port")
        require("cycle", cycle, 0.001 <= cycle <= 0.1, "it is seconds, 0.0035 or 0.00711")
        require("axes", axes, 1 <= axes <= 8, "a packet has room for 1 to 8")
        require("sliding", sliding, set(sliding) <= set(range(1, axes + 1)), "axes are from 1 on")
        require(
            "also", also, len(also) <= 3 and set(also) <= set(_DATA_FORMS), "three types, 1 to 11"
        )
        require("also", also, not (short and also), "short packets carry one type only")
        first, mask, word = outputs or (inputs or 0, 0, 0)
        numbers = all(0 <= value <= 0xFFFF for value in (first, mask, word, *flags))
        require("outputs", (first, mask, word), numbers, "numbers from 0 to 65535")
        same = outputs is None or inputs is None or outputs[0] == inputs
        require("inputs", inputs, same, "a packet names one first signal for both")
        self._link = MxtLink(
            mode,
            cycle,
            axes,
            tuple(sliding),
            flags,
            watched,
            tuple(also),
            2 if inputs is not None else 0,
            first,
            mask,
            word,
            short,
        )
        self._limits = limits
        self._settings = settings or Settings()
        self._endpoint = Endpoint(host, port, local_port=local_port)
        self._open = False
        self._count = 0
        self._told: tuple[float, ...] = ()

    def __enter__(self) -> Self:
        """Takes a port of this machine, which all packets come from; sends nothing yet."""
        if not self._endpoint.local_port:
            # A free port is looked up and released: every socket of the session then binds
            # to this one, since the controller answers the address that it first heard from.
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
                probe.bind(("", 0))
                self._endpoint = replace(self._endpoint, local_port=probe.getsockname()[1])
        return self

    def __exit__(self, *error: object) -> None:
        if self._open:
            self.end()

    @property
    def link(self) -> MxtLink:
        return self._link

    def position(self) -> tuple[float, ...]:
        """Return the arm's commanded joints, or x, y, z and w, x, y, z. Moves nothing."""
        with self._wire() as wire:
            try:
                reason = self._asked(wire)
            except OSError as error:
                reason = error.strerror or str(error)
        if reason:
            raise Refused(NO_ANSWER(address=self._endpoint, reason=reason), exit_status=2)
        self._open = True
        return self._told

    def _asked(self, wire: PacketSocket) -> str:
        """Has the controller tell where the arm is; why it did not, "" if it did."""
        left = self._settings.timeout
        each = self._settings.lapse * self._link.cycle
        wire.hush(self._link.cycle)  # answers to what was asked before
        while left > 0.0:
            wire.send(self._link.hello(self._count))
            self._count += 1
            got = wire.receive(min(each, left))
            measured = None if got is None else self._link.read(got[0])
            if measured is not None:
                self._told = measured.values
                return ""
            left -= each
        if wire.refused:
            return "nothing listens on that port"
        return f"nothing came within {self._settings.timeout:g} s"

    def follow(
        self,
        trajectory: Trajectory | Path,
        limits: Limits | None = None,
        *,
        end: bool = False,
        watch: Callable[[Progress], None] | None = None,
        stop: threading.Event | None = None,
    ) -> Report:
        """Guide the arm along a trajectory from its present position; return when it has stopped.

        end: whether `Mxt` ends after the last point; otherwise the controller holds and waits for
        the next one until the context ends, without packets: with MXTTOUT set, end each one. watch,
        stop, and errors: see `cyclic.follow`.
        """
        led = Trajectory.of_path(trajectory) if isinstance(trajectory, Path) else trajectory
        if led.kind != _KINDS[self._link.mode]:
            raise Refused(WRONG_KIND(kind=led.kind, mode=self._link.mode), exit_status=2)
        width = led.rows.shape[1]
        if led.kind == "joints":
            require("axes", self._link.axes, width == self._link.axes, f"it has {width} columns")
        bounds = limits or self._limits
        if bounds is None:
            refusal = BAD_SETTING(name="limits", value=None, reason="nothing moves without them")
            raise Refused(refusal, exit_status=2)
        settings = replace(self._settings, end=end)
        # As if open while the loop runs: leaving the context after a failure must end `Mxt`.
        opened, self._open = self._open, True
        try:
            report = cyclic.follow(
                self._link, self._endpoint, led, bounds, settings, watch=watch, stop=stop
            )
        except cyclic.Ended as ended:
            # Where the loop itself failed, nobody may have ended the control.
            self._open = ended.findings[0].code == BROKEN.code
            self._told = ()
            raise
        except Refused:
            self._open = opened
            raise
        self._open = not end
        told = [values[-1] for name, values in report.columns.items() if name.startswith("to_")]
        self._told = tuple(map(float, told))
        return report

    def leading(self, limits: Limits | None = None) -> cyclic.Leading:
        """The arm, to be led by corrections of its joints; `Mxt` ends when that context does.

        limits: with the range of the joints. Raises Refused.
        """
        bounds = limits or self._limits
        if _KINDS[self._link.mode] != "joints" or bounds is None:
            wrong = WRONG_KIND(kind="joints", mode=self._link.mode)
            none = BAD_SETTING(name="limits", value=None, reason="nothing moves without them")
            raise Refused(none if bounds is None else wrong, exit_status=2)
        settings = replace(self._settings, end=True)
        return cyclic.Leading(self._link, self._endpoint, self._link.axes, bounds, settings)

    def end(self) -> bool:
        """End `Mxt`, so that the program continues after it; True if the controller answered."""
        self._open = False
        with self._wire() as wire, contextlib.suppress(OSError):
            # The end packet holds a position: without one, the controller has to be asked first.
            if not self._told and self._asked(wire):
                return False
            for _ in range(_END_PACKETS):
                wire.send(self._link.end(self._told, self._count))
                self._count += 1
                if wire.receive(4 * self._link.cycle) is not None:
                    return True
        return False

    def _wire(self) -> PacketSocket:
        try:
            return PacketSocket(self._endpoint)
        except OSError as error:
            reason = error.strerror or str(error)
            refusal = NO_ANSWER(address=self._endpoint, reason=reason)
            raise Refused(refusal, exit_status=2) from None


_LONGEST_FILTER: Final = 10_000
"""ms; the manual states no most, and no one smooths longer."""


def program(pc: str, mode: Mode = "joint", *, filter_ms: int = 0, file: int = 1) -> str:
    """Return the program text, with step numbers, which every version of MELFA-BASIC accepts.

    pc: the address of this machine as the controller sees it; packets from others are ignored.
    filter_ms: time constant with which the controller smooths its commands; the arm lags by about
    as much. file: 1 to 8. Raises Refused for invalid settings.
    """
    if not 0 <= filter_ms <= _LONGEST_FILTER:
        reason = f"it is milliseconds from 0 to {_LONGEST_FILTER}"
        refusal = BAD_SETTING(name="filter_ms", value=filter_ms, reason=reason)
        raise Refused(refusal, exit_status=2)
    if file not in range(1, 9):
        refusal = BAD_SETTING(name="file", value=file, reason="it is 1 to 8")
        raise Refused(refusal, exit_status=2)
    try:
        address = ipaddress.IPv4Address(pc)
    except ValueError:
        reason = "it is four numbers with dots"
        refusal = BAD_SETTING(name="pc", value=repr(pc), reason=reason)
        raise Refused(refusal, exit_status=2) from None
    smoothed = f",{filter_ms}" if filter_ms else ""
    lines = (
        f'OPEN "ENET:{address}" AS #{file}',
        f"MXT {file},{_COMMAND_TYPES[mode] - 1}{smoothed}",
        f"CLOSE #{file}",
        "END",
    )
    return "".join(f"{10 * i} {line}\r\n" for i, line in enumerate(lines, 1))
