"""Messages of Externally Guided Motion: Protocol Buffers (proto2), by a table of their fields.

Names and numbers of the fields are those of `egm.proto`, sensor interface V1.1, as RobotWare
installs it and ros-industrial/abb_libegm publishes it; the encoding is that of protobuf.dev,
"Encoding". Fields that a controller sends beyond these are passed over.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

Scalar = Literal["uint", "double"]
"""`uint`: whole numbers, enumerations and truths."""


@dataclass(frozen=True, slots=True)
class Field:
    """kind: of a number, or the name of the message that it holds."""

    name: str
    kind: str


def _doubles(*names: str) -> dict[int, Field]:
    return {number: Field(name, "double") for number, name in enumerate(names, 1)}


_POSES_AND_JOINTS: Final = {
    1: Field("joints", "EgmJoints"),
    2: Field("cartesian", "EgmPose"),
    3: Field("externalJoints", "EgmJoints"),
    4: Field("time", "EgmClock"),
}
MESSAGES: Final[Mapping[str, Mapping[int, Field]]] = {
    "EgmHeader": {1: Field("seqno", "uint"), 2: Field("tm", "uint"), 3: Field("mtype", "uint")},
    "EgmCartesian": _doubles("x", "y", "z"),
    "EgmQuaternion": _doubles("u0", "u1", "u2", "u3"),
    "EgmClock": {1: Field("sec", "uint"), 2: Field("usec", "uint")},
    "EgmPose": {1: Field("pos", "EgmCartesian"), 2: Field("orient", "EgmQuaternion")},
    "EgmJoints": _doubles("joints"),
    "EgmFeedBack": _POSES_AND_JOINTS,
    "EgmPlanned": _POSES_AND_JOINTS,
    "EgmState": {1: Field("state", "uint")},
    "EgmRobot": {
        1: Field("header", "EgmHeader"),
        2: Field("feedBack", "EgmFeedBack"),
        3: Field("planned", "EgmPlanned"),
        4: Field("motorState", "EgmState"),
        5: Field("mciState", "EgmState"),
        6: Field("mciConvergenceMet", "uint"),
        8: Field("rapidExecState", "EgmState"),
        10: Field("utilizationRate", "double"),
    },
    "EgmSensor": {1: Field("header", "EgmHeader"), 2: Field("planned", "EgmPlanned")},
}
"""Message → number of a field → what it is. Those of motors, EGM and RAPID share `EgmState`."""

VARINT, FIXED64, LENGTH, FIXED32 = 0, 1, 2, 5
"""Wire types."""
LONGEST_VARINT: Final = 10
"""Bytes of a whole number."""
DEEPEST_MESSAGE: Final = 4
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
        """All numbers of a field, which stands in parts of parts; none if it is not there."""
        *parts, name = path
        message: Message | None = self
        for part in parts:
            message = message.parts.get(part) if message is not None else None
        return tuple(message.numbers.get(name, ())) if message is not None else ()


def decode(kind: str, data: bytes) -> Message:
    """The message that bytes are; raises ValueError if they are none."""
    return _decode(kind, memoryview(data), 0)


def _decode(kind: str, data: memoryview, depth: int) -> Message:
    if depth > DEEPEST_MESSAGE:
        raise ValueError("messages in messages without end")
    message, fields = Message(), MESSAGES[kind]
    for number, wire, value, inside in _fields(data):
        known = fields.get(number)
        if known is None:
            continue
        if known.kind in MESSAGES:
            if wire != LENGTH:
                raise ValueError(f"{known.name} is no message")
            part = _decode(known.kind, inside, depth + 1)
            merged = message.parts.setdefault(known.name, part)
            if merged is not part:  # the same field again adds to it
                for name, numbers in part.numbers.items():
                    merged.numbers.setdefault(name, []).extend(numbers)
                merged.parts.update(part.parts)
            continue
        numbers = message.numbers.setdefault(known.name, [])
        if known.kind == "double" and wire == FIXED64:
            numbers.append(_DOUBLE.unpack(inside)[0])
        elif known.kind == "double" and wire == LENGTH:  # packed
            if len(inside) % _DOUBLE.size:
                raise ValueError(f"{known.name} ends within a number")
            numbers.extend(one for (one,) in _DOUBLE.iter_unpack(inside))
        elif known.kind == "uint" and wire == VARINT:
            numbers.append(value)
        else:
            raise ValueError(f"{known.name} has the wire type {wire}")
    return message


def _fields(data: memoryview) -> Iterator[tuple[int, int, int, memoryview]]:
    """Number, wire type, whole number, and bytes of each field."""
    at, size = 0, len(data)
    while at < size:
        tag, at = _varint(data, at)
        number, wire = tag >> 3, tag & 7
        value, length = 0, 0
        if number == 0:
            raise ValueError("a field without a number")
        if wire == VARINT:
            value, at = _varint(data, at)
        elif wire == LENGTH:
            length, at = _varint(data, at)
        elif wire in (FIXED64, FIXED32):
            length = 8 if wire == FIXED64 else 4
        else:
            raise ValueError(f"the wire type {wire}")
        if at + length > size:
            raise ValueError("the message ends within a field")
        yield number, wire, value, data[at : at + length]
        at += length


def _varint(data: memoryview, at: int) -> tuple[int, int]:
    value = 0
    for place in range(LONGEST_VARINT):
        if at + place >= len(data):
            raise ValueError("the message ends within a number")
        byte = data[at + place]
        value |= (byte & 0x7F) << (7 * place)
        if byte < 0x80:
            return value, at + place + 1
    raise ValueError("a whole number without end")


def encode(kind: str, message: Message) -> bytes:
    """The bytes of a message, its fields by number, repeated numbers one by one (proto2)."""
    made = bytearray()
    for number, known in sorted(MESSAGES[kind].items()):
        if known.kind in MESSAGES:
            part = message.parts.get(known.name)
            if part is not None:
                inside = encode(known.kind, part)
                made += _tag(number, LENGTH) + _encode_varint(len(inside)) + inside
            continue
        for value in message.numbers.get(known.name, ()):
            if known.kind == "double":
                made += _tag(number, FIXED64) + _DOUBLE.pack(value)
            else:
                made += _tag(number, VARINT) + _encode_varint(int(value))
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
