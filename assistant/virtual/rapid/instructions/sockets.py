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
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.instructions.raw import raw_of
from assistant.virtual.rapid.links import Link, Peer, Status, host_of
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.predefined import NUMBERS
from assistant.virtual.rapid.values import Array, Handle

SECONDS: Final = 60.0
MOST_TEXT: Final = 80
MOST_BYTES: Final = 1024
PORTS: Final = range(1, 65536)
STATES: Final[tuple[Status, ...]] = ("created", "connected", "bound", "listening", "closed")
"""From 1, as socketstatus counts them."""


def _link(given: Given, index: int = 0) -> Link:
    handle = given.place(index).get()
    if not isinstance(handle, Handle) or handle.type != "socketdev":
        raise Fault("what is no socket is used as one")
    if not isinstance(handle.inside, Link):
        said = given.machine.task.kernel.peers
        handle.inside = Link() if said is None else Peer(said)
        given.machine.at_end.append(handle.inside.close)
    return handle.inside


def _seconds(given: Given) -> float | None:
    stated = given.optional_number("time")
    if stated is not None and stated >= NUMBERS["wait_max"]:
        return None
    return SECONDS if stated is None else stated


def _where(given: Given) -> tuple[str, int]:
    port = whole(given.number(2), "a port")
    if port not in PORTS:
        raise Fault(f"the port {port}", "ERR_SOCK_ADDR_INVALID")
    options = given.machine.controller.options
    if given.machine.task.kernel.peers is not None:
        return "", port
    if not options.sockets:
        raise NotSimulated("a socket where programs are compared, which reach nothing outside")
    return host_of(given.text(1), options.addresses), port


def _create(given: Given) -> None:
    _link(given).create()


def _close(given: Given) -> None:
    _link(given).close()


def _bind(given: Given) -> None:
    _link(given).bind(*_where(given))


def _listen(given: Given) -> None:
    _link(given).listen()


def _accept(given: Given) -> None:
    address = _link(given).accept(_link(given, 1), given.machine.task, _seconds(given))
    if (node := given.options.get("clientaddress")) is not None:
        place(given.machine, node).set(address)


def _connect(given: Given) -> None:
    _link(given).connect(*_where(given), given.machine.task, _seconds(given))


def _send(given: Given) -> None:
    count = given.optional_number("noofbytes")
    data = _said(given)
    _link(given).send(data if count is None else data[: int(count)], given.machine.task)


def _said(given: Given) -> bytes:
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


def _receive(given: Given) -> None:
    asked = given.optional_number("readnoofbytes")
    most = MOST_TEXT if given.has("str") else MOST_BYTES
    least = 1 if asked is None else whole(asked, "a count of bytes")
    if not 1 <= least <= most:
        raise Fault(f"{least} bytes are asked for, of 1 to {most}")
    wanted = most if asked is None else least
    data = _link(given).receive(wanted, least, given.machine.task, _seconds(given))
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


def _status(given: Given) -> float:
    return float(STATES.index(_link(given).status) + 1)


def _peek(given: Given) -> float:
    given.machine.hangs_on.add("outside")
    return float(_link(given).waiting())


def _packed(_: Given) -> None:
    raise NotSimulated("datagrams (UDP)")


INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        takes("SocketCreate", 1, _create),
        takes("SocketClose", 1, _close),
        takes("SocketBind", 3, _bind),
        takes("SocketListen", 1, _listen),
        takes("SocketAccept", 2, _accept, "clientaddress time"),
        takes("SocketConnect", 3, _connect, "time"),
        takes("SocketSend", 1, _send, "str data rawdata noofbytes"),
        takes("SocketReceive", 1, _receive, "str data rawdata readnoofbytes norecbytes time"),
        takes("SocketSendTo", 3, _packed, "str data noofbytes"),
        takes("SocketReceiveFrom", 3, _packed, "str data norecbytes time"),
    )
)
FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (takes("SocketGetStatus", 1, _status), takes("SocketPeek", 1, _peek))
)
