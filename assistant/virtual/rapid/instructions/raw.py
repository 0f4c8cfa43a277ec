r"""Bytes that values are packed into and taken out of: rawbytes.

Manual, PackRawBytes, UnpackRawBytes and their kin: 1024 bytes, whole numbers and floats with the
lowest byte first, with \Network with the highest.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from assistant.virtual.rapid.ends import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.poses import number
from assistant.virtual.rapid.precision import Double
from assistant.virtual.rapid.values import Handle, Value

RAW_SIZE: Final = 1024
HEX_CODES: Final = "latin-1"
WHOLE_FORMATS: Final = {1: "B", 2: "H", 4: "I", 8: "Q", -1: "b", -2: "h", -4: "i", -8: "q"}
"""Codes of `struct` by inttypes, whose numbers are the size, negative with a sign."""


@dataclass(slots=True)
class RawBytes:
    """length: of the bytes from the first on that hold something."""

    data: bytearray = field(default_factory=lambda: bytearray(RAW_SIZE))
    length: int = 0

    def put(self, start: int, found: bytes) -> None:
        """start: from 1."""
        if not 1 <= start <= RAW_SIZE - len(found) + 1:
            raise Fault(f"{len(found)} bytes from {start} of {RAW_SIZE}", UNSURE)
        self.data[start - 1 : start - 1 + len(found)] = found
        self.length = max(self.length, start - 1 + len(found))

    def take(self, start: int, count: int) -> bytes:
        if not (start >= 1 and count >= 0 and start - 1 + count <= self.length):
            raise Fault(f"{count} bytes from {start} of {self.length}", UNSURE)
        return bytes(self.data[start - 1 : start - 1 + count])


def raw_of(value: Value) -> RawBytes:
    """The bytes of data of type rawbytes."""
    if not isinstance(value, Handle) or value.type != "rawbytes":
        raise Fault("what is no rawbytes is used as some")
    if not isinstance(value.inside, RawBytes):
        value.inside = RawBytes()
    return value.inside


def _raw_argument(given: Given, index: int) -> RawBytes:
    return raw_of(given.place(index).get())


def _first_byte(given: Given, index: int) -> int:
    return whole(given.number(index), "the place of a byte")


def _byte_format(given: Given) -> str:
    """Of `struct`, for a number."""
    order = ">" if given.has("network") else "<"
    if given.has("float4"):
        return order + "f"
    if given.has("hex1"):
        return order + "B"
    kind = whole(given.optional_number("intx") or 0.0, "a type of whole numbers")
    if kind not in WHOLE_FORMATS:
        raise Fault("PackRawBytes or UnpackRawBytes without a format", UNSURE)
    return order + WHOLE_FORMATS[kind]


def _pack_raw(given: Given) -> None:
    value = given.value(0)
    if given.has("ascii"):
        found = value if isinstance(value, str) else chr(whole(number(value), "a character") % 256)
        packed = found.encode(HEX_CODES, "replace")
    else:
        code = _byte_format(given)
        stated = number(value)
        try:
            packed = struct.pack(code, stated if code[1] == "f" else whole(stated, "an integer"))
        except (struct.error, OverflowError):
            raise Fault(f"the number {stated:g} in this format", UNSURE) from None
    _raw_argument(given, 1).put(_first_byte(given, 2), packed)


def _unpack_raw(given: Given) -> None:
    raw, start, target = _raw_argument(given, 0), _first_byte(given, 1), given.place(2)
    if given.has("ascii"):
        count = whole(given.optional_number("ascii") or 0.0, "a number of characters")
        found = raw.take(start, count).decode(HEX_CODES)
        target.set(found if target.shape.type == "string" else float(ord(found[:1] or "\0")))
        return
    if target.shape.type == "string":
        raise NotSimulated("a string of UnpackRawBytes in another format than \\ASCII")
    code = _byte_format(given)
    (value,) = struct.unpack(code, raw.take(start, struct.calcsize(code)))
    target.set(Double(value))


def _clear_raw(given: Given) -> None:
    raw = _raw_argument(given, 0)
    first = whole(given.optional_number("fromindex") or 1.0, "the place of a byte")
    raw.data[first - 1 :] = bytes(RAW_SIZE - first + 1)
    raw.length = min(raw.length, first - 1)


def _copy_raw(given: Given) -> None:
    source, start = _raw_argument(given, 0), _first_byte(given, 1)
    stated = given.optional_number("noofbytes")
    count = source.length - start + 1 if stated is None else whole(stated, "a number of bytes")
    _raw_argument(given, 2).put(_first_byte(given, 3), source.take(start, count))


def _raw_length(given: Given) -> float:
    return float(_raw_argument(given, 0).length)


RAW_FORMATS: Final = "network hex1 intx float4 ascii"
RAW_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("PackRawBytes", 3, _pack_raw, RAW_FORMATS),
        table_row("UnpackRawBytes", 3, _unpack_raw, RAW_FORMATS),
        table_row("ClearRawBytes", 1, _clear_raw, "fromindex"),
        table_row("CopyRawBytes", 4, _copy_raw, "noofbytes"),
    )
)
RAW_FUNCTIONS: Final[Mapping[str, Function]] = dict((table_row("RawBytesLen", 1, _raw_length),))
