"""Where one command of the controller link ends and the next begins.

Without a procedure clients end a command by CR, by CR LF, or by nothing: then the command is what
came before the line went quiet. Once a client has sent an end code it is held to it: half a
command of such a client is never executed.

With the procedure of RS-232 (BFP-A4288, 3.2) a command stands in a frame with its length and
checksum, behind ENQ and in front of EOT, and its answer comes back in the same way.
"""

from __future__ import annotations

import re
from functools import reduce
from operator import xor
from typing import Final

MOST_BYTES: Final = 255
"""Of one command; longer ones are cut to one byte more, so that they can be told."""
STX, ETX, EOT, ENQ, ACK, NAK = (bytes([code]) for code in (0x02, 0x03, 0x04, 0x05, 0x06, 0x15))
FRAME: Final = re.compile(rb"\x02(D0([0-9A-Fa-f]{2})R(.*))([0-9A-Fa-f]{2})", re.DOTALL)
MOST_FRAMED: Final = 0xFF - 1
"""Bytes that a frame takes, whose length counts the letter in front of them."""


class Framing:
    """The bytes of one connection on their way to commands."""

    def __init__(self) -> None:
        self._rest = b""
        self._ended_once = False

    def feed(self, data: bytes) -> list[bytes]:
        """The commands that end in the data, without their ends."""
        *whole, rest = re.split(rb"[\r\n]", self._rest + data)
        self._ended_once = self._ended_once or bool(whole)
        self._rest = rest[: MOST_BYTES + 1]  # what never ends takes no more room than this
        return [command[: MOST_BYTES + 1] for command in whole if command]

    @property
    def ends_by_silence(self) -> bool:
        """Whether there is a command that has come to its end if nothing follows soon."""
        return bool(self._rest) and not self._ended_once

    def silence(self) -> list[bytes]:
        """The command that a quiet line ended."""
        rest, self._rest = self._rest, b""
        return [rest] if rest else []


def in_frame(text: bytes) -> bytes:
    """A frame: `D0`, the length of what follows, `R`, the text, and the checksum of all that."""
    body = b"D0" + f"{len(text) + 1:02X}".encode() + b"R" + text
    return STX + body + f"{reduce(xor, body):02X}".encode() + ETX


def from_frame(data: bytes) -> bytes | None:
    """The text of a frame that came without its ETX; None if it is damaged."""
    found = FRAME.fullmatch(data)
    if found is None or int(found[2], 16) != len(found[3]) + 1:
        return None
    return found[3] if reduce(xor, found[1]) == int(found[4], 16) else None
