"""Conversations of a controller with one client: commands in, answers out, over any port."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

from assistant.virtual.cr.faults import Faults
from assistant.virtual.cr.framing import (
    ACK,
    ENQ,
    EOT,
    ETX,
    MOST_BYTES,
    MOST_FRAMED,
    NAK,
    STX,
    Framing,
    from_frame,
    in_frame,
)
from assistant.virtual.cr.ports import Port

LOOK_PERIOD: Final = 1.0
"""Seconds for a step of the procedure; no manual at hand tells how long a controller waits."""
MOST_TRIALS: Final = 4
"""Of a step: the first one, and three more (projects of RT ToolBox)."""
TOO_LONG: Final = b"QeR6080"

Answer = Callable[[bytes], bytes]


class HungUp(OSError):
    """A fault has the controller hang up."""


class Plain:
    """No procedure. quiet: seconds of silence that end a command without end code."""

    def __init__(self, terminator: bytes, quiet: float, faults: Faults) -> None:
        self._terminator, self._quiet, self._faults = terminator, quiet, faults

    def converse(self, port: Port, answer: Answer) -> None:
        """Until nobody is there any more; raises OSError."""
        framing = Framing()
        while True:
            try:
                data = port.receive(self._quiet if framing.ends_by_silence else None)
            except TimeoutError:
                commands = framing.silence()
            else:
                if not data:
                    return
                commands = framing.feed(data)
            for command in commands:
                text = answer(command)
                for piece in self._faults.answers(text, self._terminator):
                    send_answer(port, piece, self._faults)


class Procedural:
    """The procedure of RS-232: ENQ, ACK, frame, ACK, EOT, one way and the other."""

    def __init__(self, faults: Faults) -> None:
        self._faults = faults
        self._come = b""

    def converse(self, port: Port, answer: Answer) -> None:
        """Until nobody is there any more; raises OSError."""
        while True:
            self._code(port, None, ENQ)
            try:
                command = self._command(port)
            except TimeoutError:
                continue
            if command is None:
                continue
            text = answer(command)
            for piece in self._faults.answers(text, b""):
                self._reply(port, piece if len(piece) <= MOST_FRAMED else TOO_LONG)

    def _command(self, port: Port) -> bytes | None:
        """What a client that has asked for the line sends before its EOT; None for nothing."""
        found: bytes | None = None
        reply = ACK
        for _ in range(2 * MOST_TRIALS):
            send_answer(port, reply, self._faults)
            code = self._code(port, LOOK_PERIOD, STX, EOT, ENQ)
            if code == EOT:
                return found
            reply = NAK
            if code == STX:
                text = from_frame(STX + self._until(port, ETX))
                found, reply = (found, NAK) if text is None else (text, ACK)
        return None

    def _reply(self, port: Port, text: bytes) -> None:
        """Gives up if the client does not take it."""
        try:
            taken = self._insist(port, ENQ) and self._insist(port, in_frame(text))
        except TimeoutError:
            taken = False
        send_answer(port, EOT, self._faults)
        if not taken:
            self._come = b""

    def _insist(self, port: Port, data: bytes) -> bool:
        """Sends until it is acknowledged."""
        for _ in range(MOST_TRIALS):
            send_answer(port, data, self._faults)
            try:
                if self._code(port, LOOK_PERIOD, ACK, NAK, EOT) == ACK:
                    return True
            except TimeoutError:
                continue
        return False

    # ------------------------------------------------------------------------------ bytes

    def _code(self, port: Port, seconds: float | None, *wanted: bytes) -> bytes:
        """The next of some control codes; what comes before is left out. Raises TimeoutError."""
        end = None if seconds is None else time.monotonic() + seconds
        while True:
            byte = self._byte(port, end)
            if byte in wanted:
                return byte

    def _until(self, port: Port, code: bytes) -> bytes:
        """What comes before a control code; of what never ends only enough to tell it is wrong."""
        data, end = b"", time.monotonic() + LOOK_PERIOD
        while (byte := self._byte(port, end)) != code:
            if len(data) <= 2 * MOST_BYTES:
                data += byte
        return data

    def _byte(self, port: Port, end: float | None) -> bytes:
        if not self._come:
            self._come = port.receive(None if end is None else max(0.0, end - time.monotonic()))
            if not self._come:
                raise HungUp
        byte, self._come = self._come[:1], self._come[1:]
        return byte


def send_answer(port: Port, data: bytes, faults: Faults) -> None:
    """Sends what a fault leaves of it; raises HungUp where it ends the line."""
    data, goes_on = faults.spoilt(data)
    if data:
        port.send(data)
    if not goes_on:
        raise HungUp
