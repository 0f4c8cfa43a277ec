"""Sockets of a program: real ones on this computer, which never hold up the other tasks."""

from __future__ import annotations

import errno
import ipaddress
import socket
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Final, Literal

from assistant.virtual.events import Sent
from assistant.virtual.kernel.task import Task
from assistant.virtual.rapid.ends import Fault, NotSimulated

SocketStatus = Literal["created", "connected", "bound", "listening", "closed"]
RETRY_PERIOD: Final = 0.05
"""Real seconds after which a connection that was refused is tried again."""
BACKLOG: Final = 5
MOST_LOOKED_AT: Final = 4096


@dataclass(slots=True, eq=False)
class Link:
    """own: None while it is closed. before: bytes that came and were not asked for yet."""

    own: socket.socket | None = None
    status: SocketStatus = "closed"
    before: bytes = b""

    def open(self) -> socket.socket:
        if self.own is None:
            raise Fault("the socket is not created, or closed", "ERR_SOCK_CLOSED")
        return self.own

    def create(self) -> None:
        if self.own is not None:
            raise NotSimulated("SocketCreate of a socket that is not closed")
        self.take(socket.socket(socket.AF_INET, socket.SOCK_STREAM), "created")

    def take(self, own: socket.socket, status: SocketStatus) -> None:
        own.setblocking(False)
        self.own, self.status, self.before = own, status, b""

    def close(self) -> None:
        if self.own is not None:
            self.own.close()
        self.own, self.status, self.before = None, "closed", b""

    def bind(self, host: str, port: int) -> None:
        own = self.open()
        if self.status != "created":
            raise Fault("the socket is bound or connected already", "ERR_SOCK_IS_BOUND")
        own.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            own.bind((host, port))
        except OSError as error:
            raise Fault(
                f"port {port} is not free: {error.strerror}", "ERR_SOCK_ADDR_INUSE"
            ) from None
        self.status = "bound"

    def listen(self) -> None:
        own = self.open()
        if self.status == "connected":
            raise Fault("a connected socket listens", "ERR_SOCK_IS_CONN")
        if self.status == "created":
            raise Fault("a socket listens before it is bound", "ERR_SOCK_NOT_BOUND")
        try:
            own.listen(BACKLOG)
        except OSError as error:
            raise Fault(f"the port is not free: {error.strerror}", "ERR_SOCK_ADDR_INUSE") from None
        self.status = "listening"

    def accept(self, client: Link, task: Task, seconds: float | None) -> str:
        """The address of who connected."""
        own = self.open()
        if self.status != "listening":
            raise Fault("a socket accepts that does not listen", "ERR_SOCK_NOT_BOUND")
        if client.own is not None:
            raise NotSimulated("SocketAccept into a socket that is not closed")
        came: list[tuple[socket.socket, str]] = []

        def has_come() -> bool:
            with suppress(BlockingIOError):
                one, (host, _) = own.accept()
                came.append((one, host))
            return bool(came)

        _wait_for_link(task, has_come, seconds, "a connection")
        client.take(came[0][0], "connected")
        return came[0][1]

    def connect(self, host: str, port: int, task: Task, seconds: float | None) -> None:
        """Tried again while nobody listens there."""
        if self.status == "connected":
            raise Fault("the socket is connected already", "ERR_SOCK_IS_CONN")
        self.open()
        again = 0.0

        def is_connected() -> bool:
            nonlocal again
            if time.monotonic() < again:
                return False
            code = self.open().connect_ex((host, port))
            if code in (0, errno.EISCONN):
                return True
            if code not in (errno.EINPROGRESS, errno.EALREADY, errno.EWOULDBLOCK):
                self.close()
                self.create()
                again = time.monotonic() + RETRY_PERIOD
            return False

        _wait_for_link(task, is_connected, seconds, f"a connection to port {port}")
        self.status = "connected"

    def send(self, data: bytes, task: Task) -> None:
        own = self._connected()
        left = data

        def is_sent() -> bool:
            nonlocal left
            with suppress(BlockingIOError):
                left = left[own.send(left) :]
            return not left

        try:
            _wait_for_link(task, is_sent, None, "a place for what is sent")
        except ConnectionError:
            raise Fault("the other end is closed", "ERR_SOCK_CLOSED") from None

    def receive(self, most: int, least: int, task: Task, seconds: float | None) -> bytes:
        """Bytes that came: at least so many, and at most; the rest stays for later."""
        self._connected()

        def has_come() -> bool:
            return self._filled(most) >= least or self._is_over()

        _wait_for_link(task, has_come, seconds, "data")
        if len(self.before) < least:
            raise Fault("the other end is closed", "ERR_SOCK_CLOSED")
        found, self.before = self.before[:most], self.before[most:]
        return found

    def waiting(self) -> int:
        """Bytes that came and were not asked for yet."""
        own = self._connected()
        try:
            return len(self.before) + len(own.recv(MOST_LOOKED_AT, socket.MSG_PEEK))
        except BlockingIOError:
            return len(self.before)
        except ConnectionError:
            raise Fault("the other end is closed", "ERR_SOCK_CLOSED") from None

    def _connected(self) -> socket.socket:
        own = self.open()
        if self.status != "connected":
            raise Fault("the socket is not connected", "ERR_SOCK_NOT_CONN")
        return own

    def _filled(self, most: int) -> int:
        """How many bytes there are, with what came by now."""
        with suppress(BlockingIOError, ConnectionError):
            if len(self.before) < most:
                self.before += self.open().recv(most - len(self.before))
        return len(self.before)

    def _is_over(self) -> bool:
        """Whether the other end sends no more."""
        try:
            return not self.open().recv(1, socket.MSG_PEEK)
        except BlockingIOError:
            return False
        except ConnectionError:
            return True


class Peer(Link):
    """A socket at whose other end somebody says the same texts each time that it is connected."""

    def __init__(self, texts: Iterable[str]) -> None:
        super().__init__()
        self._texts = [f"{text}\r".encode("latin-1") for text in texts]
        self._left: deque[bytes] = deque()

    def create(self) -> None:
        self.status = "created"

    def close(self) -> None:
        self.status = "closed"
        self._left.clear()

    def bind(self, host: str, port: int) -> None:  # noqa: ARG002
        self.status = "bound"

    def listen(self) -> None:
        self.status = "listening"

    def accept(self, client: Link, task: Task, seconds: float | None) -> str:
        if self.status != "listening":
            raise Fault("a socket accepts that does not listen", "ERR_SOCK_NOT_BOUND")
        client.connect("", 0, task, seconds)
        return "127.0.0.1"

    def connect(self, host: str, port: int, task: Task, seconds: float | None) -> None:  # noqa: ARG002
        self.status = "connected"
        self._left = deque(self._texts)

    def send(self, data: bytes, task: Task) -> None:
        self._there()
        task.tell(Sent(data))

    def receive(self, most: int, least: int, task: Task, seconds: float | None) -> bytes:
        """A text without its end; a stated number of bytes of all texts with their ends."""
        self._there()
        if most == least:
            enough = partial(self._has, least)
            _wait_for_link(task, enough, seconds, "data", outside=False)
            whole = b"".join(self._left)
            self._left = deque([whole[most:]] if len(whole) > most else [])
            return whole[:most]
        _wait_for_link(task, lambda: bool(self._left), seconds, "data", outside=False)
        text = self._left.popleft()
        found, rest = text[:most], text[most:]
        if rest:
            self._left.appendleft(rest)
        return found.removesuffix(b"\r")

    def waiting(self) -> int:
        self._there()
        return len(self._left[0]) if self._left else 0

    def _has(self, count: int) -> bool:
        return sum(map(len, self._left)) >= count

    def _there(self) -> None:
        if self.status != "connected":
            raise Fault("the socket is not connected", "ERR_SOCK_NOT_CONN")


def _wait_for_link(
    task: Task,
    until: Callable[[], bool],
    seconds: float | None,
    what: str,
    *,
    outside: bool = True,
) -> None:
    if not task.wait(until, seconds, what, outside=outside):
        raise Fault(f"{what} does not come in time", "ERR_SOCK_TIMEOUT")


def host_of(address: str, addresses: Mapping[str, str]) -> str:
    """The real host that an address of a program stands for: this computer, or one that is named.

    Raises NotSimulated for others, so that no program reaches further than whoever runs it says.
    """
    if address in addresses:
        return addresses[address]
    if address.lower() == "localhost":
        return "127.0.0.1"
    try:
        known = ipaddress.IPv4Address(address)
    except ValueError:
        raise Fault(f"`{address}` is no address", "ERR_SOCK_ADDR_INVALID") from None
    if not known.is_loopback:
        raise NotSimulated(
            f"a socket at {address}, which is neither this computer nor an address that the run was"
            " given a place for"
        )
    return address
