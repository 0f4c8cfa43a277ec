"""The three programs of data link control mode in three slots, with a client on their two lines.

`samples/melfa` holds them as they were printed (Kohrt et al., A robot manipulator communications
and control framework), `samples/melfa/datalink` programs that stop at any time.
"""

from __future__ import annotations

import os
import pty
import select
import socket
import tty
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import Any

import pytest

from assistant import languages, robots
from assistant.languages.melfa_basic.tree.syntax import File
from assistant.virtual.events import Moved, Run
from assistant.virtual.kernel import Ending, Kernel, Motion
from assistant.virtual.kernel.kernel import Instant
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.melfa import Controller, Entry, Options, status
from assistant.virtual.melfa.communication_lines import Line, Serial, TcpServer, Wire
from assistant.virtual.melfa.world import STEP_TIME

PRINTED = Path(__file__).parents[2] / "samples" / "melfa"
HARDENED = PRINTED / "datalink"
NAMES = ("MULTITASK", "DATALINK", "CONTROLLINK")
ROBOT = robots.get("rv-2aj")
HOME = (0.0, 0.0, 90.0, 0.0, 90.0, 0.0)
JOINTS = "({},0,90,0,90,0)\r"


@cache
def programs(folder: Path, level: int) -> dict[str, File]:
    language = languages.get(f"melfa-basic-{level}")
    return {name: language.parse(language.read(folder / f"{name}.prg")) for name in NAMES}


@dataclass
class Cell:
    """A controller with the programs of a folder, and the two lines in memory."""

    folder: Path
    level: int = 4
    motion: Motion = field(default_factory=Instant)
    options: Options = field(default_factory=lambda: Options(unset="zero"))
    seconds: float = 8.0
    com1: Wire = field(default_factory=Wire)
    com2: Wire = field(default_factory=Wire)

    def __post_init__(self) -> None:
        self.kernel = Kernel(statement_time=STEP_TIME, motion=self.motion, most_time=self.seconds)
        self.controller = self.made({"COM1:": self.com1, "COM2:": self.com2})

    def made(self, lines: dict[str, Line]) -> Controller:
        return Controller(
            self.kernel,
            programs(self.folder, self.level),
            {1: Entry("MULTITASK", "CYC")},
            robot=ROBOT,
            joints=HOME,
            lines=lines,
            options=self.options,
        )

    def send(self, seconds: float, line: Wire, text: str) -> None:
        self.kernel.at(seconds, lambda: line.put(text.encode()))

    def run(self) -> Run:
        self.controller.start()
        return self.kernel.run()

    def watch(self, seconds: float) -> dict[int, str]:
        """What each slot does at a time."""
        found: dict[int, str] = {}

        def look() -> None:
            found.update({slot.number: slot.state for slot in self.controller.slots[:3]})

        self.kernel.at(seconds, look)
        return found

    @property
    def stream(self) -> list[str]:
        return self.com2.sent.decode().split("\r")[:-1]


def turned(run: Run) -> list[float]:
    """J1 of each motion."""
    moved = [event for event in run.events if isinstance(event, Moved)]
    return [event.joints[0] for event in moved if event.joints is not None]


# ------------------------------------------------------------------------------- as printed


def test_joints_that_are_sent_are_moved_to_while_the_status_is_received() -> None:
    cell = Cell(PRINTED, seconds=2.0)
    cell.send(0.1, cell.com2, "1\r")
    for number in range(5):
        cell.send(0.3 + 0.2 * number, cell.com1, JOINTS.format(10 * number))
    done = cell.run()
    assert turned(done) == [0, 10, 20, 30, 40]
    fields = [[part.strip() for part in line.split("|")] for line in cell.stream]
    assert all(len(parts) == 5 for parts in fields)
    times = [float(parts[0]) for parts in fields]
    assert times == sorted(times) and len(times) > 100
    assert fields[0][1].endswith("(6,0)")
    assert [parts[2] for parts in fields] == [parts[3] for parts in fields]
    turns = [float(parts[3][1:].split(",")[0]) for parts in fields]
    assert sorted(set(turns)) == [0, 10, 20, 30, 40] and turns == sorted(turns)


def test_zero_ends_the_status_stream_as_the_first_message() -> None:
    cell = Cell(PRINTED, seconds=2.0)
    cell.send(0.5, cell.com2, "0\r")
    states = cell.watch(1.9)
    cell.run()
    assert not cell.stream
    assert cell.controller.shared.place("M_02").get() == 1
    assert states == {1: "runs", 2: "runs", 3: "runs"}
    world = cell.controller.slots[1].world
    assert world is not None and status.read(world, "M_LINE", ()) == 170


def test_zero_ends_nothing_once_the_status_stream_goes_on() -> None:
    cell = Cell(PRINTED, seconds=3.0)
    cell.send(0.1, cell.com2, "1\r")
    for moment in (0.5, 1.0, 1.5):
        cell.send(moment, cell.com2, "0\r")
    cell.run()
    assert cell.controller.shared.place("M_02").get() == 0
    assert float(cell.stream[-1].split("|")[0]) > 2500


def test_the_first_program_waits_for_ever_for_m_01() -> None:
    """Nothing sets it, whatever the client says."""
    cell = Cell(PRINTED, seconds=3600.0)
    cell.send(0.5, cell.com2, "0\r")
    done = cell.run()
    assert done.ended == "stopped"  # before the hour is over: nothing more can happen
    assert cell.controller.shared.place("M_01").get() == 0


def test_the_second_program_needs_m_02_before_the_first_one_sets_it() -> None:
    """Line 30 starts it, line 50 gives M_02 its value; if that begins as 0, nothing is wrong."""
    done = Cell(PRINTED, options=Options(shared="error")).run()
    assert done.ended == "error" and "slot 2: error 3700" in done.message


# ---------------------------------------------------------------------------------- hardened


def stops(cell: Cell, last: float) -> None:
    """All slots are stopped, the arm is with the first one, and nothing is sent any more."""
    done = cell.run()
    states = [slot.state for slot in cell.controller.slots[:3]]
    assert (done.ended, states) == ("end", ["waits", "reset", "reset"]), done.message
    assert cell.controller.shared.place("M_01").get() == 1
    assert cell.stream[-1] == "END" and cell.stream.count("END") == 1
    assert cell.stream[0] == "READY"
    assert done.seconds - last < 3.0


@pytest.mark.parametrize("level", [4, 6, pytest.param(5, marks=pytest.mark.slow)])
def test_the_hardened_programs_do_what_the_printed_ones_do(level: int, tmp_path: Path) -> None:
    import assistant

    folder = HARDENED
    if level != 4:
        folder = tmp_path
        for name in NAMES:
            made = assistant.compile(HARDENED / f"{name}.prg", language=f"melfa-basic-{level}")
            (tmp_path / f"{name}.prg").write_bytes(made.files[f"{name}.prg"])
    cell = Cell(folder, level)
    cell.send(0.2, cell.com2, "1\r")
    for number in range(5):
        cell.send(0.3 + 0.2 * number, cell.com1, JOINTS.format(10 * number))
    cell.send(1.5, cell.com2, "0\r")
    stops(cell, 1.5)
    turns = [float(line.split("|")[3].strip()[1:].split(",")[0]) for line in cell.stream[1:-1]]
    assert sorted(set(turns)) == [0, 10, 20, 30, 40] and turns == sorted(turns)


@pytest.mark.parametrize("started", [False, True])
@pytest.mark.parametrize("each", [47, pytest.param(1, marks=pytest.mark.slow)])
def test_zero_stops_them_at_any_time(started: bool, each: int) -> None:
    """Between two statements of the first half second, and later."""
    moments = [0.0005 + 0.001 * step for step in range(0, 500, each)]
    for moment in (*moments, 0.8, 1.3, 2.0):
        cell = Cell(HARDENED)
        if started:
            cell.send(0.1, cell.com2, "1\r")
        cell.send(0.15, cell.com1, JOINTS.format(10))
        cell.send(0.2, cell.com1, JOINTS.format(20))
        cell.send(moment, cell.com2, "0\r")
        stops(cell, moment)


@pytest.mark.parametrize("moment", [0.25, 0.6, 0.9])
def test_zero_stops_them_while_the_arm_is_on_its_way(moment: float) -> None:
    cell = Cell(HARDENED, motion=Timed(ROBOT, joints=ROBOT.own_joints(HOME)))
    cell.send(0.1, cell.com2, "1\r")
    cell.send(0.2, cell.com1, JOINTS.format(60))
    cell.send(0.25, cell.com1, JOINTS.format(-60))
    cell.send(moment, cell.com2, "0\r")
    stops(cell, moment)
    fields = [line.split("|") for line in cell.stream[1:-1]]
    speeds = [float(parts[4]) for parts in fields]
    assert max(speeds) > 1.0 and min(speeds) == 0.0
    turns = {float(parts[3].strip()[1:].split(",")[0]) for parts in fields}
    assert len(turns) > 5 and 0.0 < max(turns) <= 60.0


def test_zero_behind_other_messages_stops_them() -> None:
    cell = Cell(HARDENED)
    cell.send(0.3, cell.com2, "1\r1\r0\r1\r")
    stops(cell, 0.3)


def test_a_client_that_says_zero_again_stops_them_whatever_com_on_does() -> None:
    """Where a line does not interrupt for what came before `Com On`, the next message does."""
    for moment in (0.001, 0.005, 0.01, 0.02):
        cell = Cell(HARDENED, options=Options(unset="error", early=False))
        for again in range(3):
            cell.send(moment + 0.5 * again, cell.com2, "0\r")
        stops(cell, moment + 1.0)


def test_a_client_that_asks_to_be_watched_and_dies_leaves_no_arm_that_moves() -> None:
    cell = Cell(HARDENED, motion=Timed(ROBOT, joints=ROBOT.own_joints(HOME)), seconds=20.0)
    for moment in (0.2, 1.5, 3.0):
        cell.send(moment, cell.com2, "2\r")
    for number in range(8):
        cell.send(2.0, cell.com1, JOINTS.format((-1) ** number * 150))
    cell.run()
    assert cell.stream[-1] == "END" and 4.9 < float(cell.stream[-2].split("|")[0]) / 1000 < 5.1
    assert [slot.state for slot in cell.controller.slots[:3]] == ["waits", "reset", "reset"]


def test_a_client_that_does_not_ask_for_it_is_not_watched() -> None:
    cell = Cell(HARDENED, seconds=6.0)
    cell.send(0.2, cell.com2, "1\r")
    cell.run()
    assert float(cell.stream[-1].split("|")[0]) > 5900


def test_they_start_again_behind_a_stop() -> None:
    cell = Cell(HARDENED)
    cell.send(0.3, cell.com2, "0\r")
    cell.kernel.task("operator", lambda task: (task.wait(None, 1.0), Ending())[1])
    cell.kernel.at(1.0, cell.controller.slot(1).run)
    cell.controller.slot(1).mode = "REP"
    cell.send(1.5, cell.com1, JOINTS.format(10))
    cell.send(2.0, cell.com2, "0\r")
    done = cell.run()
    assert [slot.state for slot in cell.controller.slots[:3]] == ["waits", "reset", "reset"]
    assert cell.stream == ["READY", "END", "READY", "END"] and turned(done) == [10]


# ------------------------------------------------------------------------------ over real lines

Talk = tuple[Callable[[bytes], object], Callable[[], bytes]]
"""What sends to a line, and what receives from it."""
PATIENCE = 20.0
"""Seconds after which a client that hears nothing gives up."""


@contextmanager
def over_tcp() -> Iterator[tuple[Line, Talk]]:
    line = TcpServer()
    with socket.create_connection(line.address, PATIENCE) as client:

        def hear() -> bytes:
            data = client.recv(4096)
            assert data, "the line was closed"
            return data

        yield line, (client.sendall, hear)
    line.shut()


def heard(port: int) -> bytes:
    assert select.select([port], [], [], PATIENCE)[0], "nothing comes"
    return os.read(port, 4096)


@contextmanager
def over_serial() -> Iterator[tuple[Line, Talk]]:
    own, other = pty.openpty()
    tty.setraw(own)
    try:
        yield Serial(os.ttyname(other)), (partial(os.write, own), partial(heard, own))
    finally:
        os.close(own)
        os.close(other)


@pytest.mark.parametrize(("one", "two"), [(over_tcp, over_serial), (over_serial, over_tcp)])
def test_a_client_on_real_lines(one: Callable[..., Any], two: Callable[..., Any]) -> None:
    received: list[str] = []
    with ThreadPoolExecutor() as pool, one() as (com1, (move, _)), two() as (com2, (say, hear)):

        def lines() -> Iterator[str]:
            data = b""
            while True:
                data += hear()
                *whole, data = data.split(b"\r")
                for line in whole:
                    received.append(line.decode())
                    yield received[-1]

        def client() -> None:
            told = lines()
            assert next(told) == "READY"
            say(b"1\r")
            for turn in (10, 20):
                move(JOINTS.format(turn).encode())
                place = f"({turn}.00,0.00,90.00"
                while place not in next(told):
                    pass
            say(b"0\r")
            while next(told) != "END":
                pass

        cell = Cell(HARDENED, seconds=3 * PATIENCE)
        cell.controller = cell.made({"COM1:": com1, "COM2:": com2})
        person = pool.submit(client)
        done = cell.run()
        person.result()
    assert (done.ended, turned(done)) == ("end", [10, 20]), done.message
    assert [slot.state for slot in cell.controller.slots[:3]] == ["waits", "reset", "reset"]
    assert received[0] == "READY" and received[-1] == "END"
