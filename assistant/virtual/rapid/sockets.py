"""Sockets: messages over TCP, and the rawbytes that values are packed into.

Sockets are real ones on this computer, which never block the other tasks. Instructions manual,
SocketCreate, PackRawBytes and their kin; reference, 3: a string of 80 characters a message, or 1024
bytes, and 60 s without the option `Time`. Rawbytes hold whole numbers and floats with the lowest
byte first, with the option `Network` with the highest.
"""

from __future__ import annotations

import errno
import ipaddress
import socket
import struct
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import field
from functools import partial
from typing import Final, Literal

from assistant.base.data_classes import dataclass
from assistant.virtual.events import Sent
from assistant.virtual.kernel.task import Task
from assistant.virtual.rapid import records
from assistant.virtual.rapid.call_arguments import Given, table_row
from assistant.virtual.rapid.control_flow import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.expressions import place, whole
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.records import NUMBER_DATA, number
from assistant.virtual.rapid.values import Array, Double, Handle, Value

SocketStatus = Literal["created", "connected", "bound", "listening", "closed"]
_RETRY_PERIOD: Final = 0.05
"""Real seconds after which a connection that was refused is tried again."""
_BACKLOG: Final = 5
_MOST_LOOKED_AT: Final = 4096


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
        # The port of a run that has just ended stays in
        # TIME_WAIT; without this it cannot be bound again.
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
            own.listen(_BACKLOG)
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
            # Other codes than these are a refusal. POSIX leaves the state of
            # a socket open after it, so that the next try needs a new one.
            if code not in (errno.EINPROGRESS, errno.EALREADY, errno.EWOULDBLOCK):
                self.close()
                self.create()
                again = time.monotonic() + _RETRY_PERIOD
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

        # The other end may close with fewer bytes than asked for: the wait has to end for that too.
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
            # MSG_PEEK leaves the bytes where they are, for the next SocketReceive.
            return len(self.before) + len(own.recv(_MOST_LOOKED_AT, socket.MSG_PEEK))
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
        """Receive waiting bytes and return the number of bytes available."""
        # A reset connection is reported by `_is_over`; bytes that came before it still count.
        with suppress(BlockingIOError, ConnectionError):
            if len(self.before) < most:
                self.before += self.open().recv(most - len(self.before))
        return len(self.before)

    def _is_over(self) -> bool:
        """True if the other end has stopped sending."""
        try:
            return not self.open().recv(1, socket.MSG_PEEK)
        except BlockingIOError:
            return False
        except ConnectionError:
            return True


class _Peer(Link):
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
        # Only SocketReceive with \ReadNoOfBytes asks for as many bytes at least as at most.
        if most == least:
            enough = partial(self._has, least)
            # The texts are at hand: the simulated clock need not follow real time during this wait.
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


def _host_of(address: str, addresses: Mapping[str, str]) -> str:
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


_RAW_SIZE: Final = 1024
_HEX_CODES: Final = "latin-1"
_WHOLE_FORMATS: Final = {1: "B", 2: "H", 4: "I", 8: "Q", -1: "b", -2: "h", -4: "i", -8: "q"}
"""Codes of `struct` by inttypes, whose numbers are the size, negative with a sign."""


@dataclass(slots=True)
class _RawBytes:
    """length: of the bytes from the first on that hold something."""

    data: bytearray = field(default_factory=lambda: bytearray(_RAW_SIZE))
    length: int = 0

    def put(self, start: int, found: bytes) -> None:
        """start: from 1."""
        if not 1 <= start <= _RAW_SIZE - len(found) + 1:
            raise Fault(f"{len(found)} bytes from {start} of {_RAW_SIZE}", UNSURE)
        self.data[start - 1 : start - 1 + len(found)] = found
        self.length = max(self.length, start - 1 + len(found))

    def take(self, start: int, count: int) -> bytes:
        if not (start >= 1 and count >= 0 and start - 1 + count <= self.length):
            raise Fault(f"{count} bytes from {start} of {self.length}", UNSURE)
        return bytes(self.data[start - 1 : start - 1 + count])


def _raw_of(value: Value) -> _RawBytes:
    """The bytes of data of type rawbytes."""
    if not isinstance(value, Handle) or value.type != "rawbytes":
        raise Fault("what is no rawbytes is used as some")
    if not isinstance(value.inside, _RawBytes):
        value.inside = _RawBytes()
    return value.inside


def _raw_argument(given: Given, index: int) -> _RawBytes:
    return _raw_of(given.place(index).get())


def _first_byte(given: Given, index: int) -> int:
    return whole(given.number(index), "the place of a byte")


def _byte_format(given: Given) -> str:
    """Return the format of `struct` for a number."""
    order = ">" if given.has("network") else "<"
    if given.has("float4"):
        return order + "f"
    if given.has("hex1"):
        return order + "B"
    kind = whole(given.optional_number("intx") or 0.0, "a type of whole numbers")
    if kind not in _WHOLE_FORMATS:
        raise Fault("PackRawBytes or UnpackRawBytes without a format", UNSURE)
    return order + _WHOLE_FORMATS[kind]


def _pack_raw(given: Given) -> None:
    value = given.value(0)
    if given.has("ascii"):
        found = value if isinstance(value, str) else chr(whole(number(value), "a character") % 256)
        packed = found.encode(_HEX_CODES, "replace")
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
        found = raw.take(start, count).decode(_HEX_CODES)
        target.set(found if target.shape.type == "string" else float(ord(found[:1] or "\0")))
        return
    if target.shape.type == "string":
        raise NotSimulated("a string of UnpackRawBytes in another format than \\ASCII")
    code = _byte_format(given)
    (value,) = struct.unpack(code, raw.take(start, struct.calcsize(code)))
    target.set(Double(value))


def _clear_raw(given: Given) -> None:
    raw = _raw_argument(given, 0)
    stated = given.optional_number("fromindex")
    first = 1 if stated is None else whole(stated, "the place of a byte")
    if not 1 <= first <= _RAW_SIZE:
        raise Fault(f"byte {first} of {_RAW_SIZE}", UNSURE)
    raw.data[first - 1 :] = bytes(_RAW_SIZE - first + 1)
    raw.length = min(raw.length, first - 1)


def _copy_raw(given: Given) -> None:
    source, start = _raw_argument(given, 0), _first_byte(given, 1)
    stated = given.optional_number("noofbytes")
    count = source.length - start + 1 if stated is None else whole(stated, "a number of bytes")
    _raw_argument(given, 2).put(_first_byte(given, 3), source.take(start, count))


def _raw_length(given: Given) -> float:
    return float(_raw_argument(given, 0).length)


_RAW_FORMATS: Final = "network hex1 intx float4 ascii"
RAW_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("PackRawBytes", 3, _pack_raw, _RAW_FORMATS),
        table_row("UnpackRawBytes", 3, _unpack_raw, _RAW_FORMATS),
        table_row("ClearRawBytes", 1, _clear_raw, "fromindex"),
        table_row("CopyRawBytes", 4, _copy_raw, "noofbytes"),
    )
)
RAW_FUNCTIONS: Final[Mapping[str, Function]] = dict((table_row("RawBytesLen", 1, _raw_length),))


_DEFAULT_TIMEOUT: Final = 60.0
_MOST_TEXT: Final = 80
_MOST_BYTES: Final = 1024
_PORT_RANGE: Final = range(1, 65536)
_STATUS_NUMBERS: Final[tuple[SocketStatus, ...]] = (
    "created",
    "connected",
    "bound",
    "listening",
    "closed",
)
"""From 1, as socketstatus counts them."""


def _socket_link(given: Given, index: int = 0) -> Link:
    handle = given.place(index).get()
    if not isinstance(handle, Handle) or handle.type != "socketdev":
        raise Fault("what is no socket is used as one")
    if not isinstance(handle.inside, Link):
        # The link is made on first use: declared data of socketdev has nothing
        # inside. A run that ends closes its real sockets, however it ends.
        said = given.machine.task.kernel.peers
        handle.inside = Link() if said is None else _Peer(said)
        given.machine.at_end.append(handle.inside.close)
    return handle.inside


def _socket_timeout(given: Given) -> float | None:
    stated = given.optional_number("time")
    # WAIT_MAX means that the socket waits without end.
    if stated is not None and stated >= NUMBER_DATA["wait_max"]:
        return None
    return _DEFAULT_TIMEOUT if stated is None else stated


def _socket_address(given: Given) -> tuple[str, int]:
    port = whole(given.number(2), "a port")
    if port not in _PORT_RANGE:
        raise Fault(f"the port {port}", "ERR_SOCK_ADDR_INVALID")
    options = given.machine.controller.options
    if given.machine.task.kernel.peers is not None:
        return "", port
    if not options.sockets:
        raise NotSimulated("a socket where programs are compared, which reach nothing outside")
    return _host_of(given.text(1), options.addresses), port


def _create_socket(given: Given) -> None:
    _socket_link(given).create()


def _close_socket(given: Given) -> None:
    _socket_link(given).close()


def _bind_socket(given: Given) -> None:
    _socket_link(given).bind(*_socket_address(given))


def _listen_socket(given: Given) -> None:
    _socket_link(given).listen()


def _accept_client(given: Given) -> None:
    address = _socket_link(given).accept(
        _socket_link(given, 1), given.machine.task, _socket_timeout(given)
    )
    if (node := given.options.get("clientaddress")) is not None:
        place(given.machine, node).set(address)


def _connect_socket(given: Given) -> None:
    _socket_link(given).connect(*_socket_address(given), given.machine.task, _socket_timeout(given))


def _send_message(given: Given) -> None:
    stated, data = given.optional_number("noofbytes"), _message_bytes(given)
    count = len(data) if stated is None else whole(stated, "a number of bytes")
    if not 0 <= count <= len(data):
        raise Fault(f"{count} bytes of {len(data)} are to be sent", UNSURE)
    _socket_link(given).send(data[:count], given.machine.task)


def _message_bytes(given: Given) -> bytes:
    if given.has("str"):
        return records.text(given.optional("str", "string") or "").encode(_HEX_CODES, "replace")
    if (node := given.options.get("rawdata")) is not None:
        raw = _raw_of(place(given.machine, node).get())
        return raw.take(1, raw.length)
    array = given.optional("data", "")
    if not isinstance(array, Array):
        raise Fault("a socket sends nothing")
    numbers = [whole(records.number(item), "a byte") for item in array.items]
    if len(numbers) > _MOST_BYTES or not all(0 <= number < 256 for number in numbers):
        raise Fault(f"what is sent are {_MOST_BYTES} bytes from 0 to 255 at most")
    return bytes(numbers)


def _receive_message(given: Given) -> None:
    asked = given.optional_number("readnoofbytes")
    most = _MOST_TEXT if given.has("str") else _MOST_BYTES
    least = 1 if asked is None else whole(asked, "a count of bytes")
    if not 1 <= least <= most:
        raise Fault(f"{least} bytes are asked for, of 1 to {most}")
    wanted = most if asked is None else least
    data = _socket_link(given).receive(wanted, least, given.machine.task, _socket_timeout(given))
    if (node := given.options.get("norecbytes")) is not None:
        place(given.machine, node).set(float(len(data)))
    if (node := given.options.get("str")) is not None:
        place(given.machine, node).set(data.decode("latin-1"))
        return
    if (node := given.options.get("rawdata")) is not None:
        raw = _raw_of(place(given.machine, node).get())
        raw.length = 0
        raw.put(1, data)
        return
    if (node := given.options.get("data")) is None:
        raise Fault("a socket receives into nothing")
    array = place(given.machine, node).get()
    if not isinstance(array, Array) or len(array.items) < len(data):
        raise Fault(f"{len(data)} bytes for an array of fewer")
    array.items[: len(data)] = [float(byte) for byte in data]


def _socket_status(given: Given) -> float:
    return float(_STATUS_NUMBERS.index(_socket_link(given).status) + 1)


def _pending_bytes(given: Given) -> float:
    # No statement of the run changes what has come: a wait for it has to be checked in real time.
    given.machine.hangs_on.add("outside")
    return float(_socket_link(given).waiting())


def _packed_size(_: Given) -> None:
    raise NotSimulated("datagrams (UDP)")


SOCKET_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("SocketCreate", 1, _create_socket),
        table_row("SocketClose", 1, _close_socket),
        table_row("SocketBind", 3, _bind_socket),
        table_row("SocketListen", 1, _listen_socket),
        table_row("SocketAccept", 2, _accept_client, "clientaddress time"),
        table_row("SocketConnect", 3, _connect_socket, "time"),
        table_row("SocketSend", 1, _send_message, "str data rawdata noofbytes"),
        table_row(
            "SocketReceive", 1, _receive_message, "str data rawdata readnoofbytes norecbytes time"
        ),
        table_row("SocketSendTo", 3, _packed_size, "str data noofbytes"),
        table_row("SocketReceiveFrom", 3, _packed_size, "str data norecbytes time"),
    )
)
SOCKET_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (table_row("SocketGetStatus", 1, _socket_status), table_row("SocketPeek", 1, _pending_bytes))
)
