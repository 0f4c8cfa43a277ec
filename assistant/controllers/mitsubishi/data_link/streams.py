"""Where the bytes of a data link go: over TCP as a client or a server, or a serial port."""

from __future__ import annotations

import os
import re
import selectors
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, Protocol

from assistant.base.diagnostics import Refused
from assistant.controllers.mitsubishi.data_link import rules

if TYPE_CHECKING:
    import serial

try:
    from termios import error as _terminal_error

    TERMINAL_ERRORS: tuple[type[Exception], ...] = (_terminal_error,)
except ImportError:  # not on Windows
    TERMINAL_ERRORS = ()
READ_AT_ONCE: Final = 1 << 16
CONNECT_RETRY: Final = 0.1
"""Seconds between two trials to connect to a program that may not have opened its line yet."""


PSEUDO_TERMINAL: Final = re.compile("/dev/pts/")
"""A pseudo terminal has no parity, and refuses to be set to one where nothing else changes."""
PARITY_LETTERS: Final = {"none": "N", "odd": "O", "even": "E"}
PORT_SLICE: Final = 0.05
"""Seconds that a serial port is waited for at a time."""


@dataclass(frozen=True, slots=True)
class Rate:
    """Of a serial line: what a controller is set to when it leaves the factory.

    Parameters CBAU232, CPRTY232 and CSTOP232 (BFP-A5993).
    """

    baud: int = 9600
    parity: Literal["none", "odd", "even"] = "even"
    stops: Literal[1, 2] = 2
    bits: Literal[7, 8] = 8


class Stream(Protocol):
    """Bytes both ways. Raises OSError, TimeoutError where nothing came or went in time."""

    target: str

    def prepare(self) -> None:
        """What can be done before the other end is there: a server listens from here on."""

    def open(self, timeout: float) -> None:
        """Waits for the other end."""

    def send(self, data: bytes, timeout: float) -> None: ...

    def receive(self, timeout: float) -> bytes:
        """At least one byte."""

    def close(self) -> None:
        """May be called at any time, again and again."""


class _Tcp:
    def __init__(self, target: str, host: str, port: int) -> None:
        self.target = target
        self._place = host, port
        self._peer: socket.socket | None = None

    def prepare(self) -> None:
        """A client has nothing to prepare."""

    def open(self, timeout: float) -> None:
        raise NotImplementedError

    def _use(self, peer: socket.socket) -> None:
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        peer.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        self._peer = peer

    def send(self, data: bytes, timeout: float) -> None:
        peer = self._connected()
        peer.settimeout(timeout)
        peer.sendall(data)

    def receive(self, timeout: float) -> bytes:
        peer = self._connected()
        with selectors.DefaultSelector() as selector:  # another thread may set the time-out to send
            try:
                selector.register(peer, selectors.EVENT_READ)
            except ValueError:
                raise ConnectionError("it was closed here") from None
            if not selector.select(timeout):
                raise TimeoutError
        data = peer.recv(READ_AT_ONCE)
        if not data:
            raise ConnectionResetError("the controller closed it")
        return data

    def close(self) -> None:
        if self._peer is not None:
            self._peer.close()
            self._peer = None

    def _connected(self) -> socket.socket:
        if self._peer is None:
            raise ConnectionError("it is not open")
        return self._peer


class TcpClient(_Tcp):
    """To a line of a controller that is the server (NETMODE 1, as it is delivered).

    patient: whether to try again while nothing listens there.
    """

    def __init__(self, target: str, host: str, port: int, *, patient: bool = True) -> None:
        super().__init__(target, host, port)
        self._patient = patient

    def open(self, timeout: float) -> None:
        end = time.monotonic() + timeout
        while True:
            try:
                left = max(CONNECT_RETRY, end - time.monotonic())
                peer = socket.create_connection(self._place, timeout=left)
            except ConnectionRefusedError:
                if not self._patient or time.monotonic() + CONNECT_RETRY > end:
                    raise
                time.sleep(CONNECT_RETRY)
            else:
                return self._use(peer)


class TcpServer(_Tcp):
    """For a controller that is the client (NETMODE 0): one at a time."""

    def __init__(self, target: str, host: str, port: int) -> None:
        super().__init__(target, host, port)
        self._listener: socket.socket | None = None

    @property
    def port(self) -> int:
        """Where it listens; of 0, the one that was free."""
        assert self._listener is not None
        return int(self._listener.getsockname()[1])

    def prepare(self) -> None:
        if self._listener is None:
            family = socket.AF_INET6 if ":" in self._place[0] else socket.AF_INET
            self._listener = socket.create_server(self._place, family=family)

    def open(self, timeout: float) -> None:
        self.prepare()
        assert self._listener is not None
        self._listener.settimeout(timeout)
        self._use(self._listener.accept()[0])

    def close(self) -> None:
        super().close()
        if self._listener is not None:
            self._listener.close()
            self._listener = None


class Serial:
    """A serial port by its path or name."""

    def __init__(self, target: str, rate: Rate) -> None:
        self.target = target
        self._rate = rate
        self._port: serial.Serial | None = None

    def prepare(self) -> None:
        """A port that was opened earlier would keep what came for somebody else."""

    def open(self, timeout: float) -> None:
        try:
            import serial
        except ImportError:
            raise Refused(rules.NO_SERIAL(place=self.target), exit_status=2) from None
        try:
            self._port = serial.Serial(
                self.target,
                self._rate.baud,
                bytesize=self._rate.bits,
                parity="N" if _is_pseudo(self.target) else PARITY_LETTERS[self._rate.parity],
                stopbits=self._rate.stops,
                timeout=PORT_SLICE,  # and not changed later: that would set the port anew each time
                write_timeout=timeout,
                exclusive=None if os.name == "nt" else True,
            )
        except TERMINAL_ERRORS as error:
            raise OSError(f"the port takes no such rate ({error.args[-1]})") from None

    def send(self, data: bytes, timeout: float) -> None:  # noqa: ARG002 - that of `open`
        import serial

        try:
            self._opened().write(data)
        except serial.SerialTimeoutException:
            raise TimeoutError from None

    def receive(self, timeout: float) -> bytes:
        port, end = self._opened(), time.monotonic() + timeout
        if timeout <= 0 and not port.in_waiting:
            raise TimeoutError
        try:
            while not (data := bytes(port.read(1))):
                if time.monotonic() >= end:
                    raise TimeoutError
            return data + bytes(port.read(port.in_waiting))
        except TypeError:  # of pyserial, whose port another thread has closed meanwhile
            raise ConnectionError("it was closed here") from None

    def close(self) -> None:
        if self._port is not None:
            self._port.close()
            self._port = None

    def _opened(self) -> serial.Serial:
        if self._port is None:
            raise ConnectionError("it is not open")
        return self._port


def _is_pseudo(target: str) -> bool:
    """Whether a serial port is a pseudo terminal, or a link to one."""
    return PSEUDO_TERMINAL.match(os.path.realpath(target)) is not None


def stream_to(target: str, rate: Rate | None = None) -> Stream:
    """What carries the bytes, by what it leads to; raises Refused.

    target: `host:port` of a controller's line, `listen:address:port` of this computer for a
    controller that connects itself, or a serial port as `/dev/ttyUSB0` or `COM3`.
    rate: of a serial port.
    """
    if re.fullmatch(r"(?:/[^\x00-\x1f]+|COM\d{1,3})", target):
        return Serial(target, rate or Rate())
    listens, rest = target.startswith("listen:"), target.removeprefix("listen:")
    host, _, port = rest.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    wrong = (
        (not re.fullmatch(r"[A-Za-z0-9_.:-]+", host), "the host is no name"),
        (not re.fullmatch(r"\d{1,5}", port) or int(port) > 65535, "the port is no number"),
        (not listens and port.strip("0") == "", "port 0 cannot be connected to"),
    )
    for is_wrong, reason in wrong:
        if is_wrong:
            raise Refused(rules.BAD_LINE(target=target, reason=reason), exit_status=2)
    kind: Callable[[str, str, int], Stream] = TcpServer if listens else TcpClient
    return kind(target, host, int(port))
