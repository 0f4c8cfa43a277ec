"""Packets of EGM as a controller writes and reads them, field by field with their raw numbers.

`egm.proto` of RobotWare, sensor interface V1.1, as ros-industrial/abb_libegm publishes it. Nothing
here is shared with the client, so that a mistake of either shows.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import Final, Literal

from assistant.base.data_classes import dataclass

Kind = Literal["joints", "poses"]
_MSGTYPE_DATA, _MSGTYPE_CORRECTION = 2, 3
MOTORS_ON, MOTORS_OFF = 1, 2
MCI_ERROR, MCI_STOPPED, MCI_RUNNING = 1, 2, 3
RAPID_STOPPED, RAPID_RUNNING = 1, 2
_ROBOT_AXES: Final = 6


@dataclass(frozen=True, slots=True)
class RobotState:
    """Contents of a robot's packet. tm: ms. measured, planned: joints in degrees, or x y z in mm
    with the quaternion.
    """

    seqno: int
    tm: int
    measured: Sequence[float]
    planned: Sequence[float]
    motors: int = MOTORS_ON
    mci: int = MCI_RUNNING
    rapid: int = RAPID_RUNNING
    converged: bool = False


@dataclass(frozen=True, slots=True)
class SensorCommand:
    """Command of a sensor."""

    seqno: int
    values: tuple[float, ...]


def robot_packet(told: RobotState, kind: Kind) -> bytes:
    """EgmRobot."""
    header = (
        _number_field(1, told.seqno) + _number_field(2, told.tm) + _number_field(3, _MSGTYPE_DATA)
    )
    clock = _number_field(1, told.tm // 1000) + _number_field(2, told.tm % 1000 * 1000)
    parts = [
        _bytes_field(1, header),
        _bytes_field(2, _place_fields(told.measured, kind) + _bytes_field(4, clock)),
        _bytes_field(3, _place_fields(told.planned, kind) + _bytes_field(4, clock)),
        _bytes_field(4, _number_field(1, told.motors)),
        _bytes_field(5, _number_field(1, told.mci)),
        _number_field(6, int(told.converged)),
        _bytes_field(7, b"".join(_double_field(1, 0.0) for _ in range(2))),
        _bytes_field(8, _number_field(1, told.rapid)),
        _double_field(10, 0.0),
    ]
    return b"".join(parts)


def _place_fields(values: Sequence[float], kind: Kind) -> bytes:
    """EgmFeedBack and EgmPlanned without their time."""
    if kind == "joints":
        own = b"".join(_double_field(1, value) for value in values[:_ROBOT_AXES])
        more = b"".join(_double_field(1, value) for value in values[_ROBOT_AXES:])
        # A robot without additional axes sends no field for them.
        return _bytes_field(1, own) + (_bytes_field(3, more) if more else b"")
    place = b"".join(_double_field(i, value) for i, value in enumerate(values[:3], 1))
    turn = b"".join(_double_field(i, value) for i, value in enumerate(values[3:], 1))
    return _bytes_field(2, _bytes_field(1, place) + _bytes_field(2, turn))


def read_sensor_packet(packet: bytes, kind: Kind, count: int) -> SensorCommand | None:
    """Return the command of an EgmSensor packet; None if it is invalid or requests something
    else.
    """
    try:
        top = _read_fields(packet)
        # The last occurrence of a field holds (proto2).
        header = _read_fields(_only_field(top, 1))
        planned = _read_fields(_only_field(top, 2))
        if _whole_field(header, 3) != _MSGTYPE_CORRECTION:
            return None
        values = _joint_fields(planned) if kind == "joints" else _pose_fields(planned)
        seqno = _whole_field(header, 1)
    except (_Damaged, struct.error):
        return None
    if len(values) != count or not all(map(math.isfinite, values)):
        return None
    return SensorCommand(seqno, values)


def _joint_fields(planned: _Fields) -> tuple[float, ...]:
    found: list[float] = []
    for number in (1, 3):
        for inside in planned.get(number, []):
            if not isinstance(inside, bytes):
                raise _Damaged("joints are no message")
            found += (_float_field(value) for value in _read_fields(inside).get(1, []))
    return tuple(found)


def _pose_fields(planned: _Fields) -> tuple[float, ...]:
    pose = _read_fields(_only_field(planned, 2))
    place, turn = _read_fields(_only_field(pose, 1)), _read_fields(_only_field(pose, 2))
    return tuple(
        _float_field(part[number][-1])
        for part, numbers in ((place, range(1, 4)), (turn, range(1, 5)))
        for number in numbers
        if number in part
    )


# ------------------------------------------------------------------------------------- bytes

_Fields = dict[int, list[int | bytes]]


class _Damaged(ValueError):
    """Bytes that do not form a message."""


def _only_field(fields: _Fields, number: int) -> bytes:
    found = fields.get(number, [0])[-1]
    if not isinstance(found, bytes):
        raise _Damaged(f"the field {number} is missing")
    return found


def _whole_field(fields: _Fields, number: int) -> int:
    found = fields.get(number, [0])[-1]
    if not isinstance(found, int):
        raise _Damaged(f"the field {number} is no whole number")
    return found


def _float_field(value: int | bytes) -> float:
    if not isinstance(value, bytes):
        raise _Damaged("a whole number instead of a double")
    (number,) = struct.unpack("<d", value)
    return float(number)


def _read_fields(data: bytes) -> _Fields:
    fields: _Fields = {}
    while data:
        tag, data = _varint(data)
        match tag & 7:
            case 0:
                value, data = _varint(data)
                fields.setdefault(tag >> 3, []).append(value)
                continue
            case 1:
                size = 8
            case 2:
                size, data = _varint(data)
            case 5:
                size = 4
            case other:
                raise _Damaged(f"wire type {other}")
        if len(data) < size:
            raise _Damaged("a field without its end")
        fields.setdefault(tag >> 3, []).append(data[:size])
        data = data[size:]
    return fields


def _varint(data: bytes) -> tuple[int, bytes]:
    value = 0
    for i, byte in enumerate(data[:10]):
        value += (byte & 127) << (7 * i)
        if byte < 128:
            return value, data[i + 1 :]
    raise _Damaged("a number without its end")


def _field_head(number: int, wire: int) -> bytes:
    return bytes([number * 8 + wire])  # all numbers are below 16


def _number_field(number: int, value: int) -> bytes:
    made = bytearray(_field_head(number, 0))
    while value >= 128:
        made.append(value % 128 + 128)
        value //= 128
    made.append(value)
    return bytes(made)


def _double_field(number: int, value: float) -> bytes:
    return _field_head(number, 1) + struct.pack("<d", value)


def _bytes_field(number: int, inside: bytes) -> bytes:
    # A varint of the length without its tag, which `_number_field` puts before it.
    return _field_head(number, 2) + _number_field(0, len(inside))[1:] + inside
