"""An arm is let go of whatever happens meanwhile: by what its virtual controller was told."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from assistant import controllers
from assistant.virtual.cr import VirtualCr
from tests.cli.processes import Command
from tests.forks import Forks
from tests.studio.cells import Bench, serial
from tests.studio.serving import Page
from tests.studio.test_control import Window, bench, codes, taken
from tests.studio.test_controller import done
from tests.virtual.cr.waiting import wait_for

__all__ = ["bench"]
LATE = 20.0
"""Seconds after which motors must be off on a computer however busy."""


@dataclass
class Heard:
    """What a controller is told. lag: seconds before each answer. deaf: lines, by the order in
    which they were opened, that get none until `hears` is set. to: of commands with that alone.
    """

    told: list[tuple[float, int, str]] = field(default_factory=list)
    lag: float = 0.0
    deaf: frozenset[int] = frozenset()
    to: str = ""
    hears: threading.Event = field(default_factory=threading.Event)
    lines: list[object] = field(default_factory=list)

    def since(self, moment: float, what: str) -> list[int]:
        """The lines by which it was told something."""
        return [line for when, line, said in self.told if when > moment and what in said]


@contextmanager
def heard(cell: VirtualCr) -> Iterator[Heard]:
    found, answer = Heard(), cell.answer

    def listening(session: Any, command: bytes) -> str:
        if session not in found.lines:
            found.lines.append(session)
        line = found.lines.index(session)
        said = command.decode("latin-1")
        found.told.append((time.monotonic(), line, said))
        time.sleep(found.lag)
        if line in found.deaf and found.to in said:
            found.hears.wait()
        return answer(session, command)

    cell.answer = listening  # type: ignore[method-assign]
    try:
        yield found
    finally:
        found.hears.set()
        found.lag = 0.0


@contextmanager
def controlled(address: str) -> Iterator[Window]:
    page = Page(address)
    with page.line() as line:
        while not page.writes:
            page.hear(line)
        yield taken(page, line)


def cell_of(bench: Bench) -> VirtualCr:
    assert isinstance(bench.cell, VirtualCr)
    return bench.cell


def test_a_key_that_is_pressed_while_a_stop_is_under_way_moves_nothing(
    bench: Bench, address: str
) -> None:
    with heard(cell_of(bench)) as there, controlled(address) as window:
        other = Page(address)
        with ThreadPoolExecutor(1) as meanwhile, other.line():
            window.answer(2)
            there.lag, began = 0.03, time.monotonic()
            stopping = meanwhile.submit(other.post, "control/stop")
            wait_for(lambda: bool(there.since(began, "STOP")))
            window.hold += 1
            while not stopping.done():
                window.answer(1)
        there.lag = 0.0
        window.answer(10)
        assert done(stopping.result())["stands"]
        assert there.since(began, "EXECMOV") == []
    wait_for(lambda: not cell_of(bench).state.servo, LATE)


def test_a_key_is_let_go_however_late_that_is_told(folder: Path, address: str) -> None:
    with serial(folder) as cell, heard(cell) as there, controlled(address) as window:
        cell.state.override = 2
        window.press_until(lambda: cell.state.joints[0] > 0.05)
        there.lag, began, last = 0.004, time.monotonic(), 0
        while not there.since(began, "STOP"):  # the watchdog's
            message = json.loads(window.line.recv(10.0))
            last = message.get("tick", last)
        window.hold += 1
        window.beat(last)
        time.sleep(0.21)
        released = time.monotonic()
        window.beat(last, hold=0)
        time.sleep(1.0)
        assert there.since(released + 0.05, "EXECMOV") == []
        window.line.close()
        wait_for(lambda: not cell.state.servo, LATE)


def test_a_stop_goes_out_although_the_line_that_waits_for_it_is_dead(
    bench: Bench, address: str, folder: Path
) -> None:
    project = folder / "assistant.toml"
    text = project.read_text("utf-8")
    project.write_text(text.replace("timeout = 5", "timeout = 60"), encoding="utf-8")
    with heard(cell_of(bench)) as there, controlled(address) as window:
        window.answer(2)
        there.deaf, began = frozenset({1}), time.monotonic()
        with ThreadPoolExecutor(1) as meanwhile:
            stopping = meanwhile.submit(window.page.post, "control/stop")
            wait_for(lambda: any(line != 1 for line in there.since(began, "STOP")))
            there.hears.set()
            assert done(stopping.result())["stands"]
    wait_for(lambda: not cell_of(bench).state.servo, LATE)


def test_motors_that_were_on_and_are_switched_on_again_go_off(bench: Bench, address: str) -> None:
    cell = cell_of(bench)
    with controllers.connect(cell.address) as session:
        assert isinstance(session, controllers.Controller)
        session.motors(True)
    with controlled(address):
        pass
    wait_for(lambda: not cell.state.servo, LATE)


def test_motors_that_wait_to_be_switched_on_stay_off_if_somebody_switches_them_off(
    bench: Bench, address: str
) -> None:
    with heard(cell_of(bench)) as there, controlled(address) as window:
        window.meanwhile(window.page.post, "control/motors", on=False)
        there.deaf, began = frozenset({0}), time.monotonic()
        wait_for(lambda: 0 in there.since(began, ""))  # the monitor waits for its answer
        with ThreadPoolExecutor(1) as meanwhile:
            waiting = meanwhile.submit(window.page.post, "control/motors", on=True)
            time.sleep(0.2)
            window.meanwhile(window.page.post, "control/motors", on=False)  # by another line
            there.hears.set()
            assert codes(waiting.result()) == ["ST049"]
        assert there.since(began, "SRVON") == []


def test_motors_that_are_switched_on_behind_the_end_of_control_go_off_again(
    bench: Bench, address: str
) -> None:
    cell = cell_of(bench)
    with heard(cell) as there, ThreadPoolExecutor(1) as meanwhile:
        with controlled(address) as window:
            window.meanwhile(window.page.post, "control/motors", on=False)
            there.deaf, there.to, began = frozenset({0}), "CNTLON", time.monotonic()
            switching = meanwhile.submit(window.page.post, "control/motors", on=True)
            wait_for(lambda: 0 in there.since(began, "CNTLON"))
        wait_for(lambda: any(line != 0 for line in there.since(began, "SRVOFF")))
        there.hears.set()
        switching.result()
        wait_for(lambda: 0 in there.since(began, "SRVOFF"))
        wait_for(lambda: not cell.state.servo)
        time.sleep(0.3)  # what was asked for is over
        assert not cell.state.servo


@pytest.mark.slow
def test_motors_that_cannot_be_switched_off_are_told_to_every_window(
    bench: Bench, address: str
) -> None:
    other = Page(address)
    with controlled(address) as window, other.line() as looking:
        cell_of(bench).stop()
        window.line.close()
        told: dict[str, Any] = {}
        while not told.get("left_on"):
            told = other.hear(looking)
        assert told["findings"][0]["code"] == "ST044"


@pytest.mark.parametrize("path", ["controller/leave", "control/give-up"])
def test_a_window_that_closes_while_its_control_ends_ends_it_too(
    path: str, folder: Path, address: str
) -> None:
    """With one line, on which a backup goes on."""
    with serial(folder) as cell, heard(cell) as there:
        with ThreadPoolExecutor(2) as meanwhile, controlled(address) as window:
            there.lag = 0.1
            meanwhile.submit(window.page.post, "controller/backup", folder="b")
            window.press_until(lambda: True)
            meanwhile.submit(window.page.post, path)
            time.sleep(0.1)
        wait_for(lambda: not cell.state.servo, LATE)


def test_a_hand_stays_as_it_is_once_its_window_has_gone(bench: Bench, address: str) -> None:
    cell = cell_of(bench)
    with heard(cell) as there, ThreadPoolExecutor(1) as meanwhile:
        with controlled(address) as window:
            there.deaf = frozenset({0})
            began = time.monotonic()
            wait_for(lambda: 0 in there.since(began, ""))  # the monitor waits for its answer
            asked = {"number": 1, "open": True, "word": "cell1"}
            opening = meanwhile.submit(window.page.post, "control/hand", **asked)
            time.sleep(0.2)
        wait_for(lambda: not cell.state.servo, LATE)  # by another line
        there.hears.set()
        assert codes(opening.result()) in (["ST040"], ["ST043"])
        assert there.since(began, "HND") == []


@pytest.mark.skipif(os.name == "nt", reason="it has no such signals")
@pytest.mark.parametrize(
    ("closes", "signals"),
    [(True, ["SIGTERM"]), (False, ["SIGINT", "SIGINT"]), (False, ["SIGTERM", "SIGHUP"]),
     (False, ["SIGTSTP"])],
    ids=["a window and SIGTERM", "Ctrl-C twice", "SIGTERM and SIGHUP", "Ctrl-Z"],
)  # fmt: skip
def test_motors_go_off_before_the_studio_ends(
    closes: bool, signals: list[str], bench: Bench, folder: Path, forks: Forks
) -> None:
    cell = cell_of(bench)
    words = ("studio", folder, "--no-open", "--format", "json")
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with heard(cell) as there, Command(forks, *words, **streams) as process:
        assert process.stdout is not None
        said = ""
        while not said.endswith("}\n"):
            said += process.stdout.readline()
        with controlled(json.loads(said)["address"]) as window:
            there.lag = 0.2
            if closes:
                window.line.close()
            for name in signals:
                process.send_signal(getattr(signal, name))
                time.sleep(0.1)
            process.wait(60)
        assert not cell.state.servo
