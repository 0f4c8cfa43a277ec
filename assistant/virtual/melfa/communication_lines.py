"""Communication lines of a controller as streams of bytes, and simulated clients on them.

Lines are in memory, over TCP, or serial. A `Peer` sends the same texts each time that its line is
opened.
"""

from __future__ import annotations

import os
import socket
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import field
from pathlib import Path
from typing import Final, Literal, Protocol

from assistant.base.data_classes import dataclass

_MOST_UNSENT: Final = 1 << 12
"""Bytes that wait for a client that does not read, until Print# waits as well."""
_PATIENCE: Final = 1.0
"""Seconds that a client tries to connect."""
_AT_ONCE: Final = 1 << 16
_MOST_PORT: Final = 65_535


class Line(Protocol):
    """outside: whether its other end is not part of the run."""

    outside: bool

    def open(self) -> None:
        """Raises OSError if there is no such line."""

    def connected(self) -> bool:
        """True if a client or server is at the other end."""

    def send(self, data: bytes) -> None:
        """Send data; it is lost if the other end is not connected."""

    def full(self) -> bool:
        """True if earlier data has to go out first."""

    def receive(self) -> bytes:
        """Return the data received since the last call."""

    def close(self) -> None: ...


@dataclass(slots=True)
class Wire:
    """A line in memory. sent: all that programs have sent. heard: is called with the data that they
    send.
    """

    outside: bool = False
    sent: bytearray = field(default_factory=bytearray)
    heard: Callable[[bytes], None] | None = None
    _come: bytearray = field(default_factory=bytearray)

    def put(self, data: bytes) -> None:
        """Add data from the other end."""
        self._come += data

    def open(self) -> None:
        """It is always there."""

    def connected(self) -> bool:
        return True

    def send(self, data: bytes) -> None:
        self.sent += data
        if self.heard is not None:
            self.heard(data)

    def full(self) -> bool:
        return False

    def receive(self) -> bytes:
        data = bytes(self._come)
        self._come.clear()
        return data

    def close(self) -> None:
        """Close the line; data that arrives before it is opened again is lost (COSIROP: INPUT)."""
        self._come.clear()


@dataclass(slots=True)
class Stored:
    """A file on the controller. content: shared by all that open it. mode: `Input` reads it from
    its beginning, `Output` and `Append` write it.
    """

    content: bytearray
    mode: Literal["Input", "Output", "Append"]
    outside: bool = False
    _read: bool = False

    def open(self) -> None:
        if self.mode == "Output":
            self.content.clear()

    def connected(self) -> bool:
        return True

    def send(self, data: bytes) -> None:
        self.content += data

    def full(self) -> bool:
        return False

    def receive(self) -> bytes:
        first, self._read = not self._read, True
        return bytes(self.content) if first else b""

    def close(self) -> None: ...


class Stream:
    """Bytes through a descriptor that never blocks."""

    outside = True

    def __init__(self) -> None:
        self._unsent = bytearray()

    def full(self) -> bool:
        self._flush()
        return len(self._unsent) > _MOST_UNSENT

    def send(self, data: bytes) -> None:
        if self.connected():
            self._unsent += data
            self._flush()

    def receive(self) -> bytes:
        if not self.connected():
            return b""
        self._flush()
        try:
            data = self._read()
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        # Reading nothing means that the other end has closed.
        if not data:
            self._gone()
        return data

    def _flush(self) -> None:
        while self._unsent and self.connected():
            try:
                # The rest stays for the next attempt.
                del self._unsent[: self._write(bytes(self._unsent))]
            except BlockingIOError:
                return
            except OSError:
                self._gone()

    def connected(self) -> bool:
        raise NotImplementedError

    def _read(self) -> bytes:
        raise NotImplementedError

    def _write(self, data: bytes) -> int:
        raise NotImplementedError

    def _gone(self) -> None:
        """Nobody is at the other end any more."""
        self._unsent.clear()


class _Tcp(Stream):
    def __init__(self) -> None:
        super().__init__()
        self._peer: socket.socket | None = None

    def connected(self) -> bool:
        """Not any more once the other end has closed and all that it sent was taken."""
        if self._peer is not None:
            try:
                # Peeking leaves the byte for the next read.
                there = self._peer.recv(1, socket.MSG_PEEK) != b""
            except BlockingIOError:
                there = True
            except OSError:
                there = False
            if not there:
                self._gone()
        return self._peer is not None

    def _read(self) -> bytes:
        return b"" if self._peer is None else self._peer.recv(_AT_ONCE)

    def _write(self, data: bytes) -> int:
        return 0 if self._peer is None else self._peer.send(data)

    def _gone(self) -> None:
        super()._gone()
        if self._peer is not None:
            self._peer.close()
            self._peer = None

    def close(self) -> None:
        self._flush()
        self._gone()


class TcpServer(_Tcp):
    """A line that one client at a time connects to (NETMODE 1). port: 0 for any that is free.

    address: where it listens, from the beginning to `shut`.
    """

    def __init__(self, port: int = 0, host: str = "127.0.0.1") -> None:
        super().__init__()
        self._server = socket.create_server((host, port))
        self._server.setblocking(False)
        self.address: tuple[str, int] = self._server.getsockname()[:2]
        self._open = False

    def open(self) -> None:
        self._open = True

    def connected(self) -> bool:
        if super().connected():
            return True
        if self._open:
            # No client is there yet; one that came before `open` is served now.
            with suppress(BlockingIOError):
                self._peer = self._server.accept()[0]
                self._peer.setblocking(False)
        return self._peer is not None

    def close(self) -> None:
        super().close()
        self._open = False

    def shut(self) -> None:
        """Close the line and its server, so that no client can connect any more."""
        self.close()
        self._server.close()


class TcpClient(_Tcp):
    """A line that connects to a server when it is opened (NETMODE 0)."""

    def __init__(self, host: str, port: int) -> None:
        super().__init__()
        self._target = host, port

    def open(self) -> None:
        """Open a connection; without a server the line is open unconnected, as M_Open shows."""
        with suppress(OSError):
            self._peer = socket.create_connection(self._target, _PATIENCE)
            self._peer.setblocking(False)


@dataclass(frozen=True, slots=True)
class Rate:
    """Settings of a serial port, the maker's defaults: 9600 bits/s, 8 bits, even parity, 2 stop
    bits.
    """

    baud: int = 9600
    parity: Literal["even", "odd", "none"] = "even"
    stops: Literal[1, 2] = 2


class Serial(Stream):
    """A serial port, or a pseudo terminal, by its path."""

    def __init__(self, path: str, rate: Rate | None = None) -> None:
        super().__init__()
        self._path, self._rate = path, rate or Rate()
        self._port: int | None = None

    def open(self) -> None:
        # Not as the controlling terminal, and without waiting for a carrier or for data.
        port = os.open(self._path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            set_rate(port, self._rate)
        except OSError:
            os.close(port)
            raise
        self._port = port

    def connected(self) -> bool:
        return self._port is not None

    def _read(self) -> bytes:
        return b"" if self._port is None else os.read(self._port, _AT_ONCE)

    def _write(self, data: bytes) -> int:
        return 0 if self._port is None else os.write(self._port, data)

    def _gone(self) -> None:
        super()._gone()
        self._shut()

    def close(self) -> None:
        if self._port is not None:
            self._flush()
            self._shut()

    def _shut(self) -> None:
        if self._port is not None:
            os.close(self._port)
            self._port = None


class Descriptor(Stream):
    """A serial line that is open all the time, while programs have it."""

    def __init__(self, descriptor: int) -> None:
        super().__init__()
        self._descriptor = descriptor

    def open(self) -> None:
        """It is always there."""

    def connected(self) -> bool:
        return True

    def close(self) -> None:
        self._flush()

    def _read(self) -> bytes:
        data = os.read(self._descriptor, _AT_ONCE)
        # A pseudo terminal without data is not closed: clients come and go.
        if not data:
            raise BlockingIOError
        return data

    def _write(self, data: bytes) -> int:
        return os.write(self._descriptor, data)


MADE: Final = "pty"
"""Name of a pseudo terminal that is created, alone or before a `:` and the name of a link."""


class Terminal:
    """A pseudo terminal: the controller's end of a serial line, whose other end clients open.

    descriptor: that of the controller's end, which never blocks. path: file that clients open, the
    same each time if a link to the other end is requested.
    """

    def __init__(self, link: str = "", rate: Rate | None = None) -> None:
        """link: file that leads to the clients' end while the line is there. Raises OSError."""
        if os.name == "nt":
            raise OSError("serial lines are made on Linux and macOS only")
        self.descriptor, self._other = os.openpty()  # both stay open: it is there without a client
        self._link = Path(link).absolute() if link else None
        self._target = os.ttyname(self._other)
        try:
            set_rate(self._other, rate or Rate())
            os.set_blocking(self.descriptor, False)
            if self._link is not None:
                _link(self._link, self._target)
        except OSError:
            os.close(self.descriptor)
            os.close(self._other)
            raise
        self.path = str(self._link or self._target)

    @staticmethod
    def asked(target: str, rate: Rate | None = None) -> Terminal | None:
        """The one that `pty` or `pty:LINK` asks for, None for another target; raises OSError."""
        kind, _, link = target.partition(":")
        return Terminal(link, rate) if kind == MADE else None

    def close(self) -> None:
        """Takes the link away, unless it leads elsewhere by now."""
        if self._link is not None:
            with suppress(OSError):
                if str(self._link.readlink()) == self._target:
                    self._link.unlink()
        for descriptor in (self.descriptor, self._other):
            with suppress(OSError):
                os.close(descriptor)


def _link(link: Path, target: str) -> None:
    """Replaces a link to a terminal that is gone; raises OSError for anything else there."""
    # Only a link that leads nowhere, or to this very terminal, is replaced.
    if link.is_symlink() and (not link.exists() or str(link.readlink()) == target):
        link.unlink()
    try:
        link.symlink_to(target)
    except FileExistsError:
        raise FileExistsError(f"{link} is there already") from None


def line_to(target: str) -> tuple[Line, Callable[[], None]]:
    """A line by what it leads to, and what ends it for good; raises OSError.

    target: a port of this computer that a client connects to, `address:port` of a server, the
    path of a serial port with the maker's rate, or `pty:LINK` for a pseudo terminal that is made.
    """
    if target == MADE:
        raise OSError(f"a line that is made needs a name: write {MADE}:FILE")
    if (terminal := Terminal.asked(target)) is not None:
        return Descriptor(terminal.descriptor), terminal.close
    if target.isdecimal():
        server = TcpServer(_port(target))
        return server, server.shut
    host, _, port = target.rpartition(":")
    if port.isdecimal():
        client = TcpClient(host, _port(port))
        return client, client.close
    if os.name == "nt":
        raise OSError("serial ports can be opened on Linux and macOS only")
    if not Path(target).exists():
        raise FileNotFoundError(f"there is no {target}")
    serial = Serial(target)
    return serial, serial.close


def _port(digits: str) -> int:
    if len(digits) > len(str(_MOST_PORT)) or int(digits) > _MOST_PORT:
        raise OSError(f"a port is a number up to {_MOST_PORT}")
    return int(digits)


def set_rate(port: int, rate: Rate) -> None:
    """Bytes as they are, at a rate; raises OSError for what is no terminal."""
    import termios
    import tty

    try:
        tty.setraw(port, termios.TCSANOW)  # what has come already stays
        settings = termios.tcgetattr(port)
        baud = getattr(termios, f"B{rate.baud}")
        flags = settings[2] & ~(termios.PARENB | termios.PARODD | termios.CSTOPB)
        flags |= {"even": termios.PARENB, "odd": termios.PARENB | termios.PARODD, "none": 0}[
            rate.parity
        ]
        settings[2] = flags | (termios.CSTOPB if rate.stops == 2 else 0)
        settings[4] = settings[5] = baud
        termios.tcsetattr(port, termios.TCSANOW, settings)
    # This error is no OSError, which callers handle.
    except termios.error as error:
        raise OSError(*error.args) from None
    # The system has no such rate.
    except AttributeError as error:
        raise OSError(f"{error}") from None


_GREETING: Final = b"GATEWAY 1"
"""First text that a program sends to a gateway, and a gateway to it."""
_MOST_SENT: Final = 50
"""Bytes that a gateway hands over at once."""
_ENDLESS: Final = 99_999_000
"""Milliseconds that stand for no end of a wait."""


class SimulatedClient(Wire):
    """Sends its texts at once; to a program that greets a gateway it sends them as bytes, on
    request.
    """

    def __init__(self, texts: Iterable[str]) -> None:
        super().__init__()
        self._texts = [f"{text}\r".encode("latin-1") for text in texts]
        self._left: deque[bytes] = deque()
        self._taken = b""
        self._said = b""
        self._is_gateway = False

    def open(self) -> None:
        self._is_gateway, self._said = False, b""
        self._left = deque(self._texts)
        self.put(b"".join(self._texts))

    def send(self, data: bytes) -> None:
        super().send(data)
        self._said += data
        while b"\r" in self._said:
            line, _, self._said = self._said.partition(b"\r")
            if line == _GREETING:
                self.receive()  # what was said before is not for a gateway
                self._is_gateway = True
                self._answer(_GREETING)
            elif self._is_gateway:
                self._asked(line)

    def _answer(self, text: bytes) -> None:
        self.put(text + b"\r")

    def _asked(self, line: bytes) -> None:
        """Answer a request as a gateway whose other end sends the texts and accepts everything."""
        match line.split():
            case [b"S"]:
                self._answer(b"K")
            case [b"A", least, most, wait]:
                taken = self._bytes(int(least), int(most))
                if taken is not None:
                    self._taken = taken
                    self._answer(b"B%04X" % len(taken))
                elif int(wait) < _ENDLESS:
                    self._answer(b"T")
            case [b"G"]:
                piece, self._taken = self._taken[:_MOST_SENT], self._taken[_MOST_SENT:]
                self._answer(b"D" + piece.hex().upper().encode())
            case [b"P"]:
                self._answer(b"B%04X" % (len(self._left[0]) if self._left else 0))

    def _bytes(self, least: int, most: int) -> bytes | None:
        """A text without its end, or so many bytes of all texts; None if there are not enough."""
        if least < most:
            text = self._left.popleft() if self._left else None
            return None if text is None else text.removesuffix(b"\r")[:most]
        whole = b"".join(self._left)
        if len(whole) < least:
            return None
        self._left = deque([whole[least:]] if len(whole) > least else [])
        return whole[:least]
