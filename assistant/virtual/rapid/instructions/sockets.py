r"""Sockets: messages over TCP.

Instructions manual, SocketCreate and its kin; reference, 3: a string of 80 characters a message,
or 1024 bytes, and 60 s without `\Time`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.virtual.rapid import poses
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.expressions import place
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.instructions.raw import raw_of
from assistant.virtual.rapid.links import Link, Peer, SocketStatus, host_of
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.predefined import NUMBER_DATA
from assistant.virtual.rapid.values import Array, Handle

DEFAULT_TIMEOUT: Final = 60.0
MOST_TEXT: Final = 80
MOST_BYTES: Final = 1024
PORT_RANGE: Final = range(1, 65536)
STATUS_NUMBERS: Final[tuple[SocketStatus, ...]] = (
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
        said = given.machine.task.kernel.peers
        handle.inside = Link() if said is None else Peer(said)
        given.machine.at_end.append(handle.inside.close)
    return handle.inside


def _socket_timeout(given: Given) -> float | None:
    stated = given.optional_number("time")
    if stated is not None and stated >= NUMBER_DATA["wait_max"]:
        return None
    return DEFAULT_TIMEOUT if stated is None else stated


def _socket_address(given: Given) -> tuple[str, int]:
    port = whole(given.number(2), "a port")
    if port not in PORT_RANGE:
        raise Fault(f"the port {port}", "ERR_SOCK_ADDR_INVALID")
    options = given.machine.controller.options
    if given.machine.task.kernel.peers is not None:
        return "", port
    if not options.sockets:
        raise NotSimulated("a socket where programs are compared, which reach nothing outside")
    return host_of(given.text(1), options.addresses), port


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
    count = given.optional_number("noofbytes")
    data = _message_bytes(given)
    _socket_link(given).send(data if count is None else data[: int(count)], given.machine.task)


def _message_bytes(given: Given) -> bytes:
    if given.has("str"):
        return poses.text(given.optional("str", "string") or "").encode("latin-1")
    if (node := given.options.get("rawdata")) is not None:
        raw = raw_of(place(given.machine, node).get())
        return raw.take(1, raw.length)
    array = given.optional("data", "")
    if not isinstance(array, Array):
        raise Fault("a socket sends nothing")
    numbers = [whole(poses.number(item), "a byte") for item in array.items]
    if len(numbers) > MOST_BYTES or not all(0 <= number < 256 for number in numbers):
        raise Fault(f"what is sent are {MOST_BYTES} bytes from 0 to 255 at most")
    return bytes(numbers)


def _receive_message(given: Given) -> None:
    asked = given.optional_number("readnoofbytes")
    most = MOST_TEXT if given.has("str") else MOST_BYTES
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
        raw = raw_of(place(given.machine, node).get())
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
    return float(STATUS_NUMBERS.index(_socket_link(given).status) + 1)


def _pending_bytes(given: Given) -> float:
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
