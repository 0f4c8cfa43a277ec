"""Messages of the Debug Adapter Protocol: a header with their length, and JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from io import RawIOBase
from typing import BinaryIO, Final

Object = dict[str, object]
"""A JSON object."""

_MOST_BYTES: Final = 10_000_000
"""Longest message in bytes; a longer one does not come from an editor."""
_MOST_HEADER: Final = 4_096


class NoMessage(ValueError):
    """Bytes that are not a message of the protocol."""


def read(stream: RawIOBase | BinaryIO) -> Object | None:
    """Return the next message, None at the end; raises NoMessage for invalid bytes."""
    length = _length(stream)
    if length is None:
        return None
    data = b""
    while len(data) < length:
        more = stream.read(length - len(data))
        if not more:
            raise NoMessage(f"the message ends after {len(data)} of {length} bytes")
        data += more
    try:
        message = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise NoMessage(f"a message that is no JSON: {error}") from None
    if not isinstance(message, dict):
        raise NoMessage("a message that is no JSON object")
    return message


def _length(stream: RawIOBase | BinaryIO) -> int | None:
    length = None
    while line := stream.readline(_MOST_HEADER):
        if not line.strip():
            if length is None:
                raise NoMessage("a header without Content-Length")
            return length
        name, _, value = line.decode("ascii", "replace").partition(":")
        if name.strip().lower() == "content-length":
            number = value.strip()
            # int() takes digits of other scripts as well, and thousands of them slowly.
            if not (number.isascii() and number.isdigit()) or len(number) > 9:
                raise NoMessage(f"a Content-Length of `{number[:20]}`")
            length = int(number)
            if length > _MOST_BYTES:
                raise NoMessage(f"a message of {length} bytes, {_MOST_BYTES} at most")
    return None


def write(stream: BinaryIO, message: Mapping[str, object]) -> None:
    data = json.dumps(message).encode()
    stream.write(b"Content-Length: %d\r\n\r\n" % len(data) + data)
    stream.flush()


def text(message: Mapping[str, object], key: str) -> str:
    """Return a text field of a message, empty if it is missing."""
    value = message.get(key)
    return value if isinstance(value, str) else ""


def number(message: Mapping[str, object], key: str) -> int:
    """Return an integer field of a message, 0 if it is missing."""
    value = message.get(key)
    return value if isinstance(value, int) else 0


def inner(message: Mapping[str, object], key: str) -> Object:
    """Return an object inside a message, empty if it is missing."""
    value = message.get(key)
    return value if isinstance(value, dict) else {}


def several(message: Mapping[str, object], key: str) -> list[Object]:
    """The objects in a list of a message."""
    value = message.get(key)
    return [one for one in value if isinstance(one, dict)] if isinstance(value, list) else []
