"""The socket of a loop: whom it hears."""

import socket

from assistant.controllers.cyclic import Endpoint
from assistant.controllers.cyclic.loop import PacketSocket


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def speaker(host):
    one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    one.bind((host, 0))
    return one


def test_what_waited_before_the_first_one_spoke_is_of_nobody():
    port = free_port()
    with (
        PacketSocket(Endpoint("127.0.0.1", 0, "127.0.0.1", port)) as wire,
        speaker("127.0.0.1") as first,
        speaker("127.0.0.1") as second,
    ):
        first.sendto(b"first", ("127.0.0.1", port))
        second.sendto(b"stranger", ("127.0.0.1", port))
        first.sendto(b"again", ("127.0.0.1", port))
        heard = [wire.receive(1.0) for _ in range(2)]
        assert [one and one[0] for one in heard] == [b"first", b"again"]
        assert wire.receive(0.01) is None
