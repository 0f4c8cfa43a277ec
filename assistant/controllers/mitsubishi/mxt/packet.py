"""The packet of real-time external control, which goes both ways (BFP-A3379-A, 4.2.2 and 7.2.2).

196 bytes, little-endian. Controllers of the CRn-500 series know the first 64 of them only, up to
the counter (their sample program's strdef.h has no RecvType1).
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from typing import Final

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
FIELD_NAMES: Final = tuple(name for _, _, name in PACKET_FIELDS)
PACKET_SIZE: Final = 196
SHORT_SIZE: Final = 64
"""Bytes of a packet of the CRn-500 series."""

NULL_COMMAND: Final = 0
MOVE_COMMAND: Final = 1
END_COMMAND: Final = 255
"""Commands: no motion, move, end the control."""
NO_SIGNALS: Final = 0
OUTPUTS: Final = 1
INPUTS: Final = 2

FILTERED: Final = 3
FEEDBACK: Final = 6
"""What is added to the type of a command for the same after the filter, and from the encoders."""
POSE_DATA: Final = struct.Struct("<8f2I")
JOINT_DATA: Final = struct.Struct("<8f8x")
PULSE_DATA: Final = struct.Struct("<8i8x")
COMMAND_TYPES: Final = {"pose": 1, "joint": 2, "pulse": 3}
"""Mode → type of the data in a command, which also is one more than the statement's argument."""
DATA_FORMS: Final[Mapping[int, struct.Struct]] = {
    **dict.fromkeys((1, 4, 7), POSE_DATA),
    **dict.fromkeys((2, 5, 8), JOINT_DATA),
    **dict.fromkeys((3, 6, 9, 10, 11), PULSE_DATA),
}
"""Type of data → its form; 10 and 11 are the currents, commanded and fed back, in percent."""
NO_DATA: Final = bytes(40)


def pack_packet(fields: Mapping[str, int | bytes], size: int = PACKET_SIZE) -> bytes:
    """A packet of these fields; those that are left out are 0."""
    empty: Mapping[str, int | bytes] = {"data": NO_DATA, "data1": NO_DATA}
    given = {**empty, "data2": NO_DATA, "data3": NO_DATA, **fields}
    return PACKET_LAYOUT.pack(*(given.get(name, 0) for name in FIELD_NAMES))[:size]


def unpack_packet(packet: bytes, size: int = PACKET_SIZE) -> dict[str, int | bytes] | None:
    """The fields of a packet, None if it has another size."""
    if len(packet) != size:
        return None
    return dict(
        zip(FIELD_NAMES, PACKET_LAYOUT.unpack(packet.ljust(PACKET_SIZE, b"\0")), strict=True)
    )


def pack_data(kind: int, values: Sequence[float], flags: tuple[int, int] = (0, 0)) -> bytes:
    """Eight numbers as data of a type; what is left out is 0. flags: of a pose."""
    eight = [*values, *[0.0] * (8 - len(values))]
    form = DATA_FORMS[kind]
    if form is POSE_DATA:
        return form.pack(*eight, *flags)
    if form is PULSE_DATA:
        return form.pack(*(round(value) for value in eight))
    return form.pack(*eight)
