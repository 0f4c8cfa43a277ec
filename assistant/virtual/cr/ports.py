"""What carries the bytes of a controller link: a socket, a serial port, or a pseudo terminal."""

from __future__ import annotations

import os
import select
import socket
import time
from contextlib import suppress
from typing import Final, Protocol

from assistant.virtual.melfa.lines import MADE, Rate, Terminal, set_rate

MOST_READ: Final = 1 << 16
WRITE_TIMEOUT: Final = 10.0
"""Seconds that a client may take to receive an answer."""


class Port(Protocol):
    """One line to one client."""

    def receive(self, seconds: float | None) -> bytes:
        """What has come; b"" once nobody is there any more. Raises OSError; TimeoutError if
        nothing comes in time, None for waiting on.
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
        return self._socket.recv(MOST_READ)

    def send(self, data: bytes) -> None:
        self._socket.settimeout(WRITE_TIMEOUT)
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
        self._woken, self._wake = os.pipe()

    def receive(self, seconds: float | None) -> bytes:
        ready = select.select([self.descriptor, self._woken], [], [], seconds)[0]
        if not ready:
            raise TimeoutError
        return b"" if self._woken in ready else os.read(self.descriptor, MOST_READ)

    def send(self, data: bytes) -> None:
        end = time.monotonic() + WRITE_TIMEOUT
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
