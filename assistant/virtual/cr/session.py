"""Sessions of the controller link: commands of one client in, answers out, over any port.

A port is a socket, a serial port or a pseudo terminal. Without a procedure clients end a command by
CR, by CR LF, or by nothing: then the command is what arrived before the line went quiet. Once a
client has sent an end code, it has to send it: half a command of such a client is never executed.
With the procedure of RS-232 (BFP-A4288, 3.2) a command is sent in a frame with its length and
checksum, after ENQ and before EOT, and its answer is returned in the same way. `Faults` makes a
controller fail on purpose, so that clients can be tested.
"""

from __future__ import annotations

import os
import re
import select
import socket
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import field
from functools import reduce
from operator import xor
from typing import Final, Protocol

from assistant.base.data_classes import dataclass
from assistant.virtual.melfa.communication_lines import MADE, Rate, Terminal, set_rate

MOST_BYTES: Final = 255
"""Longest command in bytes; longer ones are cut to one byte more, so that they can be
recognised.
"""
_STX, _ETX, _EOT, _ENQ, _ACK, _NAK = (
    bytes([code]) for code in (0x02, 0x03, 0x04, 0x05, 0x06, 0x15)
)
FRAME: Final = re.compile(rb"\x02(D0([0-9A-Fa-f]{2})R(.*))([0-9A-Fa-f]{2})", re.DOTALL)
_MOST_FRAMED: Final = 0xFF - 1
"""Bytes that a frame takes, whose length counts the letter in front of them."""


class Framing:
    """The bytes of one connection on their way to commands."""

    def __init__(self) -> None:
        self._rest = b""
        self._ended_once = False

    def feed(self, data: bytes) -> list[bytes]:
        """The commands that end in the data, without their ends."""
        *whole, rest = re.split(rb"[\r\n]", self._rest + data)
        # A client that has ended a command by a code will
        # do so again: silence ends none of its commands.
        self._ended_once = self._ended_once or bool(whole)
        self._rest = rest[: MOST_BYTES + 1]  # what never ends takes no more room than this
        return [command[: MOST_BYTES + 1] for command in whole if command]

    @property
    def ends_by_silence(self) -> bool:
        """True if a pending command ends once the line stays silent."""
        return bool(self._rest) and not self._ended_once

    def silence(self) -> list[bytes]:
        """The command that a quiet line ended."""
        rest, self._rest = self._rest, b""
        return [rest] if rest else []


def in_frame(text: bytes) -> bytes:
    """A frame: `D0`, the length of what follows, `R`, the text, and the checksum of all that."""
    body = b"D0" + f"{len(text) + 1:02X}".encode() + b"R" + text
    return _STX + body + f"{reduce(xor, body):02X}".encode() + _ETX


def from_frame(data: bytes) -> bytes | None:
    """The text of a frame that came without its ETX; None if it is damaged."""
    found = FRAME.fullmatch(data)
    if found is None or int(found[2], 16) != len(found[3]) + 1:
        return None
    return found[3] if reduce(xor, found[1]) == int(found[4], 16) else None


_MOST_READ: Final = 1 << 16
_WRITE_TIMEOUT: Final = 10.0
"""Seconds that a client may take to receive an answer."""


class Port(Protocol):
    """One line to one client."""

    def receive(self, seconds: float | None) -> bytes:
        """Return the received bytes; b"" once the client has gone. Raises OSError, and TimeoutError
        if nothing arrives in time; None waits without limit.
        """

    def send(self, data: bytes) -> None:
        """Raises OSError."""

    def hang_up(self) -> None:
        """Has `receive` end, whoever waits in it."""


class SocketPort:
    """A connection over TCP."""

    def __init__(self, connection: socket.socket) -> None:
        self._socket = connection

    def receive(self, seconds: float | None) -> bytes:
        self._socket.settimeout(seconds)
        return self._socket.recv(_MOST_READ)

    def send(self, data: bytes) -> None:
        self._socket.settimeout(_WRITE_TIMEOUT)
        self._socket.sendall(data)

    def hang_up(self) -> None:
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)


class SerialPort:
    """A serial port by its path, or a pseudo terminal that is made for it; not on Windows.

    path: where clients of a pseudo terminal connect, or the port itself.
    """

    def __init__(self, target: str = MADE, rate: Rate | None = None) -> None:
        """target: `pty`, `pty:LINK`, or the path of a serial port. Raises OSError."""
        if os.name == "nt":
            raise OSError("serial ports are served on Linux and macOS only")
        self._terminal = Terminal.asked(target, rate)
        if self._terminal is not None:
            self.path, self.descriptor = self._terminal.path, self._terminal.descriptor
        else:
            self.path = target
            self.descriptor = os.open(target, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            set_rate(self.descriptor, rate or Rate())
        # A pipe wakes up `select`: closing the descriptor from another thread would not.
        self._woken, self._wake = os.pipe()

    def receive(self, seconds: float | None) -> bytes:
        ready = select.select([self.descriptor, self._woken], [], [], seconds)[0]
        if not ready:
            raise TimeoutError
        return b"" if self._woken in ready else os.read(self.descriptor, _MOST_READ)

    def send(self, data: bytes) -> None:
        end = time.monotonic() + _WRITE_TIMEOUT
        while data:
            left = max(0.0, end - time.monotonic())
            if not select.select([], [self.descriptor], [], left)[1]:
                raise TimeoutError
            data = data[os.write(self.descriptor, data) :]

    def hang_up(self) -> None:
        os.write(self._wake, b"\0")

    def close(self) -> None:
        if self._terminal is not None:
            self._terminal.close()
        else:
            os.close(self.descriptor)
        os.close(self._wake)
        os.close(self._woken)


_SPOILED_ANSWERS: Final = 0x55
"""XOR of a byte that is broken on the line."""


@dataclass(eq=False)
class Faults:
    """Faults of each answer, on every line. Fields may be changed at any time.

    delay: seconds before an answer. drop_after: bytes that are sent, of all lines together, until
    the controller hangs up, which resets it to None. terminator: end of answers instead of the
    right code. garbage: bytes sent instead of an answer. twice: True to send an answer twice.
    errors: beginnings of commands, without robot and slot, with the error number that answers them.
    broken: one byte of so many arrives corrupted, 0 for none. times: number of answers that the
    delay, terminator, garbage or twice spoil, None for all.
    """

    delay: float = 0.0
    drop_after: int | None = None
    terminator: bytes | None = None
    garbage: bytes | None = None
    twice: bool = False
    errors: Mapping[str, int] = field(default_factory=dict)
    broken: int = 0
    times: int | None = None
    _sent: int = 0
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)

    def error(self, command: str) -> int | None:
        """The number that a command is answered with, None for as it should be."""
        body = command.split(";", 2)[-1].lstrip()
        found = [name for name in self.errors if body.startswith(name)]
        # The longest beginning wins: `PRGLOAD=` before `PRG`.
        return self.errors[max(found, key=len)] if found else None

    def answers(self, text: bytes, terminator: bytes) -> list[bytes]:
        """Return the byte strings to send instead of an answer."""
        if self._over():
            return [text + terminator]
        if self.delay:
            time.sleep(self.delay)
        end = terminator if self.terminator is None else self.terminator
        sent = (text if self.garbage is None else self.garbage) + end
        return [sent] * (1 + self.twice)

    def spoilt(self, data: bytes) -> tuple[bytes, bool]:
        """Return the bytes that arrive after faults, and whether the line stays open after them."""
        with self._lock:
            if self.broken:
                marks = enumerate(data, start=self._sent + 1)
                # Counted over all bytes of all lines, so that every answer may be hit.
                data = bytes(
                    b ^ _SPOILED_ANSWERS if at % self.broken == 0 else b for at, b in marks
                )
            self._sent += len(data)
            if self.drop_after is None:
                return data, True
            if len(data) < self.drop_after:
                self.drop_after -= len(data)
                return data, True
            data, self.drop_after = data[: self.drop_after], None
            return data, False

    def _over(self) -> bool:
        """True if the requested number of answers has been spoilt; counts this one."""
        with self._lock:
            if self.times is None:
                return False
            if self.times == 0:
                return True
            self.times -= 1
            return False


_LOOK_PERIOD: Final = 1.0
"""Seconds for a step of the procedure; no manual at hand tells how long a controller waits."""
_MOST_TRIALS: Final = 4
"""Trials of a step: the first one, and three more (projects of RT ToolBox)."""
_TOO_LONG: Final = b"QeR6080"

Answer = Callable[[bytes], bytes]


class _HungUp(OSError):
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
                # Only a client without end codes is timed out: others may pause within a command.
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
                    _send_answer(port, piece, self._faults)


class Procedural:
    """The procedure of RS-232: ENQ, ACK, frame, ACK, EOT, one way and the other."""

    def __init__(self, faults: Faults) -> None:
        self._faults = faults
        self._come = b""

    def converse(self, port: Port, answer: Answer) -> None:
        """Until nobody is there any more; raises OSError."""
        while True:
            self._code(port, None, _ENQ)
            try:
                command = self._command(port)
            except TimeoutError:
                continue
            if command is None:
                continue
            text = answer(command)
            for piece in self._faults.answers(text, b""):
                # A frame holds 254 bytes: a longer answer is refused by its error.
                self._reply(port, piece if len(piece) <= _MOST_FRAMED else _TOO_LONG)

    def _command(self, port: Port) -> bytes | None:
        """Return the command that a client sends between its request for the line and its EOT; None
        for nothing.
        """
        found: bytes | None = None
        reply = _ACK
        for _ in range(2 * _MOST_TRIALS):
            _send_answer(port, reply, self._faults)
            code = self._code(port, _LOOK_PERIOD, _STX, _EOT, _ENQ)
            if code == _EOT:
                return found
            reply = _NAK
            if code == _STX:
                text = from_frame(_STX + self._until(port, _ETX))
                # A damaged frame does not replace a good one that came before.
                found, reply = (found, _NAK) if text is None else (text, _ACK)
        return None

    def _reply(self, port: Port, text: bytes) -> None:
        """Gives up if the client does not take it."""
        try:
            taken = self._insist(port, _ENQ) and self._insist(port, in_frame(text))
        except TimeoutError:
            taken = False
        _send_answer(port, _EOT, self._faults)
        if not taken:
            # Bytes that the client sent meanwhile belong to the exchange that failed.
            self._come = b""

    def _insist(self, port: Port, data: bytes) -> bool:
        """Sends until it is acknowledged."""
        for _ in range(_MOST_TRIALS):
            _send_answer(port, data, self._faults)
            try:
                if self._code(port, _LOOK_PERIOD, _ACK, _NAK, _EOT) == _ACK:
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
        """Return the bytes before a control code; of an endless text only enough to show that it is
        wrong.
        """
        data, end = b"", time.monotonic() + _LOOK_PERIOD
        while (byte := self._byte(port, end)) != code:
            # Text without end is read to its end, but not kept.
            if len(data) <= 2 * MOST_BYTES:
                data += byte
        return data

    def _byte(self, port: Port, end: float | None) -> bytes:
        if not self._come:
            self._come = port.receive(None if end is None else max(0.0, end - time.monotonic()))
            if not self._come:
                raise _HungUp
        byte, self._come = self._come[:1], self._come[1:]
        return byte


def _send_answer(port: Port, data: bytes, faults: Faults) -> None:
    """Sends what a fault leaves of it; raises HungUp where it ends the line."""
    data, goes_on = faults.spoilt(data)
    if data:
        port.send(data)
    if not goes_on:
        raise _HungUp
