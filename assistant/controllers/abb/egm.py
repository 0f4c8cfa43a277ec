"""Externally Guided Motion (EGM): an ABB arm led cycle by cycle over UDP, every 4 ms.

report = guide("192.168.125.1", Trajectory.of_joints(joints, unit="deg"), Limits(speeds))
report.save("run.csv")

The controller is the client: it sends `EgmRobot` every 4 ms to the address of its UdpUc device, and
takes the `EgmSensor` that comes back (manual 3HAC073318; states as in ros-industrial/abb_libegm).
Messages are Protocol Buffers (proto2). Names and numbers of the fields are those of `egm.proto`,
sensor interface V1.1, as RobotWare installs it and ros-industrial/abb_libegm publishes it; the
encoding is that of protobuf.dev, "Encoding". Unknown fields are skipped.
"""

from __future__ import annotations

import math
import struct
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from typing import Final, Literal

from assistant.base.data_classes import dataclass
from assistant.controllers.cyclic import (
    Ended,
    Endpoint,
    Leading,
    Limits,
    Measured,
    Progress,
    Report,
    Settings,
    Trajectory,
    follow,
    rules,
)
from assistant.controllers.cyclic.trajectory import POSE_COLUMNS, Kind

__all__ = ["Egm", "guide"]

_Scalar = Literal["uint", "double"]
"""`uint`: whole numbers, enumerations and truths."""


@dataclass(frozen=True, slots=True)
class _Field:
    """kind: of a number, or the name of the message that it holds."""

    name: str
    kind: str


def _doubles(*names: str) -> dict[int, _Field]:
    return {number: _Field(name, "double") for number, name in enumerate(names, 1)}


_POSES_AND_JOINTS: Final = {
    1: _Field("joints", "EgmJoints"),
    2: _Field("cartesian", "EgmPose"),
    3: _Field("externalJoints", "EgmJoints"),
    4: _Field("time", "EgmClock"),
}
_MESSAGES: Final[Mapping[str, Mapping[int, _Field]]] = {
    "EgmHeader": {1: _Field("seqno", "uint"), 2: _Field("tm", "uint"), 3: _Field("mtype", "uint")},
    "EgmCartesian": _doubles("x", "y", "z"),
    "EgmQuaternion": _doubles("u0", "u1", "u2", "u3"),
    "EgmClock": {1: _Field("sec", "uint"), 2: _Field("usec", "uint")},
    "EgmPose": {1: _Field("pos", "EgmCartesian"), 2: _Field("orient", "EgmQuaternion")},
    "EgmJoints": _doubles("joints"),
    "EgmFeedBack": _POSES_AND_JOINTS,
    "EgmPlanned": _POSES_AND_JOINTS,
    "EgmState": {1: _Field("state", "uint")},
    "EgmRobot": {
        1: _Field("header", "EgmHeader"),
        2: _Field("feedBack", "EgmFeedBack"),
        3: _Field("planned", "EgmPlanned"),
        4: _Field("motorState", "EgmState"),
        5: _Field("mciState", "EgmState"),
        6: _Field("mciConvergenceMet", "uint"),
        8: _Field("rapidExecState", "EgmState"),
        10: _Field("utilizationRate", "double"),
    },
    "EgmSensor": {1: _Field("header", "EgmHeader"), 2: _Field("planned", "EgmPlanned")},
}
"""Message → number of a field → what it is. Those of motors, EGM and RAPID share `EgmState`."""

_VARINT, _FIXED64, _LENGTH, _FIXED32 = 0, 1, 2, 5
"""Wire types."""
_LONGEST_VARINT: Final = 10
"""Bytes of a whole number."""
_DEEPEST_MESSAGE: Final = 4
_DOUBLE: Final = struct.Struct("<d")


@dataclass(slots=True)
class Message:
    """numbers: of a field, in their order. parts: messages that it holds."""

    numbers: dict[str, list[float]] = field(default_factory=dict)
    parts: dict[str, Message] = field(default_factory=dict)

    def number(self, name: str) -> float | None:
        """The last one, which holds where a field comes twice."""
        found = self.numbers.get(name)
        return found[-1] if found else None

    def all(self, *path: str) -> tuple[float, ...]:
        """Return all numbers of a field in nested parts; empty if it is missing."""
        *parts, name = path
        message: Message | None = self
        for part in parts:
            message = message.parts.get(part) if message is not None else None
        return tuple(message.numbers.get(name, ())) if message is not None else ()


def decode(kind: str, data: bytes) -> Message:
    """Decode a message; raises ValueError if the bytes are not a message."""
    return _decode(kind, memoryview(data), 0)


def _decode(kind: str, data: memoryview, depth: int) -> Message:
    if depth > _DEEPEST_MESSAGE:
        raise ValueError("messages in messages without end")
    message, fields = Message(), _MESSAGES[kind]
    for number, wire, value, inside in _fields(data):
        known = fields.get(number)
        if known is None:
            continue
        if known.kind in _MESSAGES:
            if wire != _LENGTH:
                raise ValueError(f"{known.name} is no message")
            part = _decode(known.kind, inside, depth + 1)
            merged = message.parts.setdefault(known.name, part)
            if merged is not part:  # the same field again adds to it
                for name, numbers in part.numbers.items():
                    merged.numbers.setdefault(name, []).extend(numbers)
                merged.parts.update(part.parts)
            continue
        numbers = message.numbers.setdefault(known.name, [])
        if known.kind == "double" and wire == _FIXED64:
            numbers.append(_DOUBLE.unpack(inside)[0])
        elif known.kind == "double" and wire == _LENGTH:  # packed
            if len(inside) % _DOUBLE.size:
                raise ValueError(f"{known.name} ends within a number")
            numbers.extend(one for (one,) in _DOUBLE.iter_unpack(inside))
        elif known.kind == "uint" and wire == _VARINT:
            numbers.append(value)
        else:
            raise ValueError(f"{known.name} has the wire type {wire}")
    return message


def _fields(data: memoryview) -> Iterator[tuple[int, int, int, memoryview]]:
    """Number, wire type, whole number, and bytes of each field."""
    at, size = 0, len(data)
    while at < size:
        tag, at = _varint(data, at)
        # Lowest three bits: the wire type.
        number, wire = tag >> 3, tag & 7
        value, length = 0, 0
        if number == 0:
            raise ValueError("a field without a number")
        if wire == _VARINT:
            value, at = _varint(data, at)
        elif wire == _LENGTH:
            length, at = _varint(data, at)
        elif wire in (_FIXED64, _FIXED32):
            length = 8 if wire == _FIXED64 else 4
        else:
            raise ValueError(f"the wire type {wire}")
        if at + length > size:
            raise ValueError("the message ends within a field")
        yield number, wire, value, data[at : at + length]
        at += length


def _varint(data: memoryview, at: int) -> tuple[int, int]:
    value = 0
    # More than 64 bits: no number of this format.
    for place in range(_LONGEST_VARINT):
        if at + place >= len(data):
            raise ValueError("the message ends within a number")
        byte = data[at + place]
        # Seven bits of a byte, the lowest group first; the top bit says that another byte follows.
        value |= (byte & 0x7F) << (7 * place)
        if byte < 0x80:
            return value, at + place + 1
    raise ValueError("a whole number without end")


def encode(kind: str, message: Message) -> bytes:
    """The bytes of a message, its fields by number, repeated numbers one by one (proto2)."""
    made = bytearray()
    for number, known in sorted(_MESSAGES[kind].items()):
        if known.kind in _MESSAGES:
            part = message.parts.get(known.name)
            if part is not None:
                inside = encode(known.kind, part)
                made += _tag(number, _LENGTH) + _encode_varint(len(inside)) + inside
            continue
        for value in message.numbers.get(known.name, ()):
            if known.kind == "double":
                made += _tag(number, _FIXED64) + _DOUBLE.pack(value)
            else:
                made += _tag(number, _VARINT) + _encode_varint(int(value))
    return bytes(made)


def _tag(number: int, wire: int) -> bytes:
    return _encode_varint(number << 3 | wire)


def _encode_varint(value: int) -> bytes:
    made = bytearray()
    while value > 0x7F:
        made.append(value & 0x7F | 0x80)
        value >>= 7
    made.append(value)
    return bytes(made)


_CORRECTION: Final = 3
"""MSGTYPE_CORRECTION: position guidance by a sensor."""
_MOTORS_OFF: Final = 2
_EGM_ERROR, _EGM_RUNNING = 1, 3
_RAPID_STOPPED: Final = 1
"""RAPID is `undefined` after each restart of a controller although it runs (abb_libegm, #96)."""
_ROBOT_AXES: Final = 6
"""Number of axes in `joints`; the others are in `externalJoints`."""
_COUNTER_WRAP: Final = 1 << 32


@dataclass(frozen=True, slots=True)
class Egm:
    r"""The packets of one guidance.

    kind: joints in degrees, or poses as x, y, z in mm with w, x, y, z, in the frames of EGMActPose.
    axes: of the joints, additional ones (degrees or mm) behind the six of the robot.
    cycle: seconds, \SampleRate of EGMActJoint or EGMActPose.
    """

    kind: Kind = "joints"
    axes: int = _ROBOT_AXES
    cycle: float = 0.004
    speaks_first: bool = True
    recorded: tuple[str, ...] = ("tm", "converged", "utilization")

    def hello(self, count: int) -> bytes:  # noqa: ARG002
        """Nothing: the controller speaks first."""
        return b""

    def read(self, packet: bytes) -> Measured | None:
        try:
            message = decode("EgmRobot", packet)
        except ValueError:
            return None
        values = self._values(message)
        seqno = message.all("header", "seqno")
        # Values that are not finite would become the start of the motion.
        if values is None or not seqno or not all(map(math.isfinite, values)):
            return None
        stopped = _stopped(message)
        # Motors that are off stop the arm for good; EGM that has not begun yet only makes it wait.
        ready = _state(message, "mciState") == _EGM_RUNNING
        if not ready and not stopped:
            stopped = "its EGM does not run (any more)"
        extra = (
            next(iter(message.all("header", "tm")), math.nan),
            message.number("mciConvergenceMet") or 0.0,
            _finite(message.number("utilizationRate")),
        )
        return Measured(values, int(seqno[-1]) % _COUNTER_WRAP, 0, stopped, ready, extra)

    def command(self, values: Sequence[float], count: int) -> bytes:
        milliseconds = time.monotonic_ns() // 1_000_000
        header = Message(
            {
                "seqno": [count % _COUNTER_WRAP],
                "tm": [milliseconds % _COUNTER_WRAP],
                "mtype": [_CORRECTION],
            }
        )
        if self.kind == "poses":
            x, y, z, *turn = values
            place = Message({"x": [x], "y": [y], "z": [z]})
            orient = Message({f"u{i}": [part] for i, part in enumerate(turn)})
            planned = {"cartesian": Message(parts={"pos": place, "orient": orient})}
        else:
            planned = {"joints": Message({"joints": list(values[:_ROBOT_AXES])})}
            if len(values) > _ROBOT_AXES:
                planned["externalJoints"] = Message({"joints": list(values[_ROBOT_AXES:])})
        sensor = Message(parts={"header": header, "planned": Message(parts=planned)})
        return encode("EgmSensor", sensor)

    def end(self, values: Sequence[float], count: int) -> bytes | None:  # noqa: ARG002
        """None: the controller ends when the arm has converged, or when nothing comes any more."""
        return None

    def _values(self, message: Message) -> tuple[float, ...] | None:
        """Return the position of the arm, None if the message does not contain all of it."""
        if self.kind == "poses":
            pose = ("feedBack", "cartesian")
            # [-1:]: of a field that comes twice the last one holds, and a missing one stays empty.
            place = [message.all(*pose, "pos", name)[-1:] for name in "xyz"]
            turn = [message.all(*pose, "orient", f"u{i}")[-1:] for i in range(4)]
            found = tuple(value for part in (*place, *turn) for value in part)
            return found if len(found) == POSE_COLUMNS else None
        own = message.all("feedBack", "joints", "joints")
        more = message.all("feedBack", "externalJoints", "joints")
        # A controller with a seventh axis sends it in `externalJoints`.
        found = (*own[:_ROBOT_AXES], *more)
        return found[: self.axes] if len(found) >= self.axes else None


def _state(message: Message, name: str) -> float | None:
    return next(iter(message.all(name, "state")[-1:]), None)


def _stopped(message: Message) -> str:
    """Return the reason why the arm cannot move whatever is sent, "" if it can."""
    if _state(message, "motorState") == _MOTORS_OFF:
        return "its motors are off"
    if _state(message, "mciState") == _EGM_ERROR:
        return "its EGM reports an error"
    if _state(message, "rapidExecState") == _RAPID_STOPPED:
        return "its program is stopped"
    return ""


def _finite(value: float | None) -> float:
    return value if value is not None and math.isfinite(value) else math.nan


CYCLE: Final = 0.004
"""Seconds, of all controllers that know it."""
PORT: Final = 6510
"""Port of this computer, as the UdpUc device of a new system names it."""
_OPENING_TIMEOUT: Final = 60.0
"""Seconds in which the program on the controller has to begin."""
_HOLD_AT_END: Final = 0.3
"""Seconds for which the last point is held. The program on the controller sees the end as its
communication time-out, or as convergence where its \\CondTime is shorter.
"""
_OF_THE_CONTROLLER: Final = {rules.STOPPED.code, rules.SILENT.code}
"""Codes of findings for an end that the controller itself caused."""


def guide(
    host: str,
    trajectory: Trajectory,
    limits: Limits,
    *,
    port: int = PORT,
    local_host: str = "",
    cycle: float = 0.004,
    settings: Settings | None = None,
    watch: Callable[[Progress], None] | None = None,
    stop: threading.Event | None = None,
) -> Report:
    """Waits for the controller, leads the arm along the trajectory, and holds it at its end.

    host: the controller's address; packets of others are not heard. port, local_host: of this
    computer. limits: of the joints, or of the tool. settings: None to wait a minute for the program
    on the controller.
    Raises Refused before anything is sent, Ended afterwards.
    """
    chosen = settings or Settings(opening=_OPENING_TIMEOUT, settle=_HOLD_AT_END)
    link = Egm(trajectory.kind, trajectory.rows.shape[1], cycle)
    # Port 0: the controller is the client, and its port is known from its first packet.
    endpoint = Endpoint(host, 0, local_host, port)
    try:
        return follow(link, endpoint, trajectory, limits, chosen, watch=watch, stop=stop)
    except Ended as ended:
        report = ended.report
        code = ended.findings[0].code
        # The controller may end first, by convergence or
        # time-out: a success if the arm is at the end.
        if report is None or report.done < report.rows or code not in _OF_THE_CONTROLLER:
            raise
        if not _is_there(report, trajectory, chosen):
            raise
        return replace(report, done=report.rows)


def guide_by_corrections(
    host: str,
    axes: int,
    limits: Limits,
    *,
    port: int = PORT,
    local_host: str = "",
    cycle: float = 0.004,
    settings: Settings | None = None,
) -> Leading:
    """The arm, to be led by corrections of its joints once the controller begins.

    limits: with the range of the joints. Else as `guide`.
    """
    chosen = settings or Settings(opening=_OPENING_TIMEOUT, settle=_HOLD_AT_END)
    return Leading(
        Egm("joints", axes, cycle), Endpoint(host, 0, local_host, port), axes, limits, chosen
    )


def _is_there(report: Report, trajectory: Trajectory, settings: Settings) -> bool:
    """True if the arm was at the last point when the controller ended."""
    last = trajectory.rows[-1].tolist()
    # The first two columns are `time` and `row`.
    columns = list(report.columns.values())[2 : 2 + len(last)]
    places = range(3) if trajectory.kind == "poses" else range(len(last))
    return all(len(columns[i]) and abs(columns[i][-1] - last[i]) <= settings.slack for i in places)
