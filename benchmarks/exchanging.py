"""Poses by files: how long a round trip takes with the virtual IRC5, and where the time goes."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Final

import numpy as np

from assistant.controllers import Controller, connect
from assistant.controllers.abb.exchange import Module, PoseExchange, Spent
from benchmarks.talking import started

PASSWORD: Final = "of this run"
FILE: Final = "PoseExchange.mod"
TRIPS: Final = 300
STEP: Final = 1.0
"""mm to the next pose."""
PAPER: Final = """
looking: until both sides have looked for a file; all on this computer.
A published exchange with an IRC5 takes 2 to 3 s to get a pose (Krishnan, Vijayan and Ashok,
"Real-Time Integration of Industrial Robot with MATLAB", section 4)."""


def serve(told: Connection) -> None:
    from assistant.virtual.irc5 import VirtualIrc5

    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / FILE).write_text(Module().text(), encoding="ascii")
        with VirtualIrc5(folder, password=PASSWORD) as controller:
            told.send((controller.address, controller.rws_address))
            threading.Event().wait()


def report(trips: int = TRIPS) -> None:
    """Prints a line a kind of request; the controller runs in a process of its own."""
    files, operated = started(serve)
    with connect(operated, password=PASSWORD) as controller:
        assert isinstance(controller, Controller)
        controller.load(FILE)
        controller.motors(on=True)
        controller.start()
    print(f"\nPoses by files over FTP, {trips} round trips each, in ms\n")
    heads = ("median", "99th", "to send", "motion", "looking", "to fetch")
    print(f"{'request':<44}" + "".join(f"{head:>9}" for head in heads))
    with connect(files, password=PASSWORD) as programs, PoseExchange(programs) as exchange:
        start = exchange.current_pose().pose
        poses = [start.offset(z=-STEP * (1 + i % 2)) for i in range(trips)]
        kinds: dict[str, Callable[[int], object]] = {
            "where the robot is": lambda _: exchange.current_pose(),
            f"a pose {STEP:g} mm away, standing there": lambda i: exchange.move_to(poses[i]),
            f"a pose {STEP:g} mm away, on the way": lambda i: exchange.move_to(
                poses[i], through=True
            ),
        }
        for title, ask in kinds.items():
            print(f"{title:<44}{_line(_spent(exchange, ask, trips))}", flush=True)
        exchange.stop()
    print(PAPER)


def _spent(exchange: PoseExchange, ask: Callable[[int], object], trips: int) -> list[Spent]:
    found = []
    for i in range(trips):
        ask(i)
        found.append(exchange.spent)
    return found


def _line(spent: list[Spent]) -> str:
    whole = np.array([one.round_trip for one in spent])
    parts = [
        [one.hand_over, one.motion, max(0.0, one.waiting - one.motion), one.fetching]
        for one in spent
    ]
    columns = [np.median(whole), np.percentile(whole, 99), *np.median(parts, axis=0)]
    return "".join(f"{1e3 * value:>9.1f}" for value in columns)
