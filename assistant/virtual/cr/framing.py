"""Where one command of the controller link ends and the next begins.

Clients end a command by CR, by CR LF, or by nothing: then the command is what came before
the line went quiet. Once a client has sent an end code it is held to it: half a command of
such a client is never executed.
"""

from __future__ import annotations

import re
from typing import Final

MOST_BYTES: Final = 255
"""Of one command; longer ones are cut to one byte more, so that they can be told."""


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
