"""Cases: commands of the controller link beside a bare echo over the same kind of socket."""

from __future__ import annotations

import multiprocessing
import socket
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, Final

from assistant.controllers.address import parse
from assistant.controllers.mitsubishi.link import link_to
from benchmarks.reading import Reading

COMMANDS: Final = 5_000
PATIENCE: Final = 60.0
"""Seconds in which the other process has started."""
Ask = Callable[[], object]


def served(serve: Callable[[Connection], None]) -> int:
    """The port of a server in a process of its own, which ends with this one."""
    return int(started(serve))


def started(serve: Callable[[Connection], None]) -> Any:
    """What a server tells that runs in a process of its own, which ends with this one."""
    spawning = multiprocessing.get_context("spawn")
    here, there = spawning.Pipe()
    spawning.Process(target=serve, args=(there,), daemon=True).start()
    if not here.poll(PATIENCE):
        raise SystemExit("the server did not start")
    return here.recv()


def serve_controller(told: Connection) -> None:
    from assistant.virtual.cr import VirtualCr

    with VirtualCr("rv-2aj") as controller:
        told.send(controller.port)
        threading.Event().wait()


def serve_echo(told: Connection) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        told.send(server.getsockname()[1])
        peer, _ = server.accept()
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        while data := peer.recv(65536):
            peer.sendall(data)


def link(commands: int) -> tuple[Ask, int]:
    made = link_to(parse(f"melfa://127.0.0.1:{served(serve_controller)}"), timeout=10.0)
    made.open()
    return lambda: made.ask("1;1;JPOSF", doing="asking", state="nothing was changed"), commands


def echo(commands: int) -> tuple[Ask, int]:
    made = socket.create_connection(("127.0.0.1", served(serve_echo)))
    made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def ask() -> bytes:
        made.sendall(b"1;1;JPOSF\r")
        return made.recv(65536)

    return ask, commands


def asked(given: tuple[Ask, int]) -> None:
    ask, commands = given
    for _ in range(commands):
        ask()


TALKING: Final[dict[str, Reading]] = {
    "a bare echo over TCP": Reading((echo, asked), (COMMANDS,), "commands"),
    "controller link, the joints": Reading((link, asked), (COMMANDS,), "commands"),
}
