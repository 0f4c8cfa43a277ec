"""An arm moves only for the window that has control, and only while its key is held."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from assistant import controllers
from assistant.virtual.cr import VirtualCr
from tests.studio.cells import BENCHES, PASSWORD, Bench, serial
from tests.studio.serving import Answer, Page
from tests.studio.test_controller import codes, done
from tests.virtual.cr.waiting import wait_for

STEP = 1.0
"""Degrees of a step at 10 %."""
LONG = 400
"""Ticks after which something should have happened."""


@dataclass
class Record:
    """What the virtual controller itself says of its first joint: (seconds, degrees)."""

    cell: VirtualCr
    rows: list[tuple[float, float]] = field(default_factory=list)
    ended: threading.Event = field(default_factory=threading.Event)

    @property
    def now(self) -> float:
        return self.cell.state.joints[0]

    def run(self) -> None:
        while not self.ended.wait(0.005):
            self.rows.append((time.monotonic(), self.now))

    def last_motion(self) -> float:
        """When it was seen for the first time where it is now."""
        rows = list(self.rows)
        first = rows[-1][0]
        for when, value in reversed(rows):
            if value != rows[-1][1]:
                break
            first = when
        return first

    def until_it_stands(self) -> float:
        """Where it is when it has not moved for a while."""
        while time.monotonic() < self.last_motion() + 0.6:
            time.sleep(0.05)
        return self.now


@contextmanager
def recorded(cell: VirtualCr) -> Iterator[Record]:
    record = Record(cell)
    thread = threading.Thread(target=record.run)
    thread.start()
    try:
        yield record
    finally:
        record.ended.set()
        thread.join()


@dataclass
class Window:
    """A page with its line. hold: the number of the press that its beats tell of."""

    page: Page
    line: ClientConnection
    hold: int = 0
    told: list[Any] = field(default_factory=list)

    def beat(self, tick: int, **other: Any) -> None:
        beat = {"kind": "beat", "tick": tick, "hold": self.hold, "axis": "J1", "by": 1}
        self.line.send(json.dumps({**beat, "frame": "base", "speed": 10, **other}))

    def tick(self) -> int:
        """The next one that it is told."""
        until = time.monotonic() + 20.0
        while (message := self.page.hear(self.line))["kind"] != "tick":
            self.keep(message)
            assert time.monotonic() < until, "no tick is told"  # others come again and again
        return int(message["tick"])

    def keep(self, message: Any) -> None:
        assert not message.get("ended"), "control was given up meanwhile"
        self.told.append(message)

    def catch_up(self) -> None:
        """Ticks that were told meanwhile have passed by."""
        with suppress(TimeoutError):
            while True:
                self.keep(json.loads(self.line.recv(0.01)))

    def answer(self, ticks: int, **other: Any) -> None:
        """Answers that many ticks."""
        self.catch_up()
        for _ in range(ticks):
            self.beat(self.tick(), **other)

    def press_until(self, so: Callable[[], bool], **other: Any) -> None:
        """Holds the key until it is so; anew where this computer was too slow for the watchdog."""
        self.hold += 1
        self.catch_up()
        for _ in range(LONG):
            self.told.clear()
            self.beat(self.tick(), **other)
            if so():
                return
            self.hold += any(one.get("cut") for one in self.told)
        raise AssertionError("it did not come to it")

    def told_of_while_held(self) -> list[str]:
        """Codes of the findings that end a hold."""
        found: list[str] = []

        def told() -> bool:
            kinds = (one for one in self.told if one["kind"] == "control")
            found.extend(f["code"] for one in kinds for f in one.get("findings", ()))
            return bool(found)

        self.press_until(told)
        return found

    def hears(self, kind: str, key: str, within: float = 20.0) -> Any:
        """The next message of a kind that tells of something, None after these seconds."""
        until = time.monotonic() + within
        while time.monotonic() < until:
            message = self.told.pop(0) if self.told else self.page.hear(self.line)
            if message["kind"] == kind and message.get(key):
                return message
            assert not message.get("ended"), "control was given up meanwhile"
        return None

    def falls_silent(self, record: Record, beyond: float) -> tuple[float, Any]:
        """Holds the key until the arm is beyond; where it is then, and what is told of its stop.

        Anew where this computer was so slow that the key counted as held no more.
        """
        for _ in range(10):
            self.press_until(lambda: record.now > beyond)
            before = record.now
            if (told := self.hears("control", "cut", within=1.5)) is not None:
                return before, told
        raise AssertionError("nobody told of a stop")

    def until_it_stands(self, record: Record, **other: Any) -> float:
        """Answers ticks until the arm has not moved for a while; where it is then."""
        while time.monotonic() < record.last_motion() + 0.6:
            self.answer(1, **other)
        return record.now

    def asks(self, does: Callable[..., Answer], *words: str, **values: Any) -> Answer:
        """Answers ticks, of the key as it was held last, while something is done."""
        with ThreadPoolExecutor(1) as other:
            asked = other.submit(does, *words, **values)
            while not asked.done():
                self.answer(1)
        return asked.result()

    def meanwhile(self, does: Callable[..., Answer], *words: str, **values: Any) -> Any:
        return done(self.asks(does, *words, **values))


@pytest.fixture
def bench(folder: Path, tmp_path: Path) -> Iterator[Bench]:
    with BENCHES["cr"](folder, tmp_path / "home") as made:
        yield made


@pytest.fixture
def window(bench: Bench, address: str) -> Iterator[Window]:
    """Has control, with motors on."""
    page = Page(address)
    with page.line() as line:
        while not page.writes:
            page.hear(line)
        yield taken(page, line)
    wait_for(lambda: not _motors(bench))


def _motors(bench: Bench) -> bool:
    cell = bench.cell
    return (
        cell.state.servo if isinstance(cell, VirtualCr) else cell.cabinet.panel.state == "motoron"
    )


def taken(page: Page, line: ClientConnection) -> Window:
    done(page.post("controller/connect", name="cell1", password=PASSWORD))
    done(page.post("control/take", word="cell1"))
    window = Window(page, line)
    window.meanwhile(page.post, "control/motors", on=True)
    return window


@pytest.fixture
def record(bench: Bench) -> Iterator[Record]:
    assert isinstance(bench.cell, VirtualCr)
    with recorded(bench.cell) as made:
        yield made


def test_another_name_gives_no_control(bench: Bench, page: Page, record: Record) -> None:
    done(page.post("controller/connect", name="cell1"))
    for word, code in (("", "ST041"), ("cell2", "ST042"), ("CELL1", "ST042")):
        assert codes(page.post("control/take", word=word)) == [code]
        assert not done(page.get("controller"))["controlled"]
    for path in ("control/motors", "control/teach", "control/hand", "control/give-up"):
        assert codes(page.post(path, on=True, name="p1", file="t.toml", number=1)) == ["ST043"]
    assert not record.cell.state.servo


def test_it_moves_only_while_the_key_is_held(window: Window, record: Record) -> None:
    window.answer(4)
    assert window.until_it_stands(record) == 0.0
    window.press_until(lambda: record.now > 2 * STEP)
    before = record.now
    moved = window.until_it_stands(record, hold=0)
    assert 2 * STEP < before <= moved <= before + 2 * STEP
    window.press_until(lambda: record.now < moved - STEP, by=-1)
    assert record.now < moved - STEP


def slowly(bench: Bench) -> None:
    """A step takes so long that it is the stop that ends it."""
    with controllers.connect(bench.cell.address) as session:
        assert isinstance(session, controllers.Controller)
        session.set_override(2)


def test_it_stops_when_beats_stay_away_and_needs_the_key_anew(
    bench: Bench, window: Window, record: Record
) -> None:
    slowly(bench)
    before, told = window.falls_silent(record, STEP / 10)
    where = record.now
    assert told["stands"]
    assert STEP / 10 < before <= where < before + 0.7 * STEP
    window.answer(20)  # of the same press, which somebody may still hold
    assert window.until_it_stands(record) == where
    assert record.cell.state.servo
    window.press_until(lambda: record.now > where)


def test_it_stops_when_the_link_is_cut_and_the_motors_go_off(
    bench: Bench, window: Window, record: Record
) -> None:
    slowly(bench)
    window.press_until(lambda: record.now > STEP / 10)
    before = record.now
    window.line.socket.close()
    where = record.until_it_stands()
    assert STEP / 10 < before <= where < before + 0.7 * STEP
    wait_for(lambda: not record.cell.state.servo)
    other = Page(window.page.address)
    with other.line():
        assert not done(other.get("controller"))["connected"]


@pytest.mark.parametrize("after", [0.0, 0.02, 0.05, 0.1])
def test_motors_go_off_with_a_window_that_goes_while_they_are_switched_on(
    after: float, bench: Bench, address: str, record: Record
) -> None:
    page = Page(address)
    with ThreadPoolExecutor(1) as meanwhile, page.line() as line:
        while not page.writes:
            page.hear(line)
        done(page.post("controller/connect", name="cell1"))
        done(page.post("control/take", word="cell1"))
        switching = meanwhile.submit(page.post, "control/motors", on=True)
        time.sleep(after)
        line.close()
        switching.result()
    wait_for(lambda: not record.cell.state.servo)
    time.sleep(0.3)  # what was asked for is over
    assert not record.cell.state.servo


def test_old_beats_and_those_of_others_move_nothing(window: Window, record: Record) -> None:
    old = window.tick()
    window.answer(8)
    other = Page(window.page.address)
    with other.line() as line:
        assert codes(other.post("control/take", word="cell1")) == ["ST010"]
        assert codes(other.post("control/motors", on=False)) == ["ST010"]
        stranger = Window(other, line, hold=9)
        window.hold = 7
        for _ in range(10):
            tick = window.tick()
            stranger.beat(tick)
            window.beat(old)
            window.beat(tick + 1000)
            for wrong in (
                *({"axis": "J9"}, {"axis": ["J1"]}, {"by": 50}, {"speed": 11}),
                *({"speed": True}, {"speed": None}, {"frame": "world"}, {"hold": "7"}),
            ):
                window.beat(tick, **wrong)
    assert record.until_it_stands() == 0.0


def test_control_of_a_window_that_says_nothing_is_given_up(window: Window, record: Record) -> None:
    assert window.hears("control", "ended")["findings"] == []
    assert not record.cell.state.servo
    assert codes(window.page.post("control/motors", on=True)) == ["ST043"]


def test_limits_hold(window: Window, record: Record) -> None:
    record.cell.state.joints = (239.5, *record.cell.state.joints[1:])
    assert window.told_of_while_held() == ["CO711"]
    assert record.until_it_stands() == 239.5


def test_any_window_stops_at_any_time(window: Window, record: Record) -> None:
    other = Page(window.page.address)
    with other.line():
        window.press_until(lambda: record.now > 0)
        stopped = window.meanwhile(other.post, "control/stop")
        assert stopped["stands"]
        where = record.now
        window.answer(10)
        assert window.until_it_stands(record) == where


@pytest.mark.parametrize("maker", sorted(BENCHES))
def test_a_place_is_taught(maker: str, folder: Path, tmp_path: Path, address: str) -> None:
    page = Page(address)
    with BENCHES[maker](folder, tmp_path / "home") as bench:
        with page.line() as line:
            while not page.writes:
                page.hear(line)
            teach = partial(taken(page, line).asks, page.post, "control/teach")
            asked = {"name": "p1", "file": "taught.toml"}
            assert done(teach(**asked))["file"] == "taught.toml"
            assert "p1" in (folder / "taught.toml").read_text("utf-8")
            assert teach(**asked).status == 422
            done(teach(**asked, replace=True))
            assert codes(teach(name="p2", file="../out.toml")) == ["ST023"]
            assert codes(teach(name="p2", file="CON.toml")) == ["ST020"]
        wait_for(lambda: not _motors(bench))


def test_an_arm_that_cannot_be_jogged_says_so(folder: Path, tmp_path: Path, address: str) -> None:
    page = Page(address)
    with BENCHES["irc5"](folder, tmp_path / "home") as bench:
        with page.line() as line:
            while not page.writes:
                page.hear(line)
            assert taken(page, line).told_of_while_held() == ["CN209"]
            assert _motors(bench)
        wait_for(lambda: not _motors(bench))


def test_one_line_for_one_session_stops_by_that_session(folder: Path, address: str) -> None:
    page = Page(address)
    with serial(folder) as cell, recorded(cell) as record, page.line() as line:
        while not page.writes:
            page.hear(line)
        done(page.post("project/build"))
        window = taken(page, line)
        cell.state.override = 2
        before, told = window.falls_silent(record, STEP / 10)
        where = record.now
        assert told["stands"] and before <= where < before + 0.7 * STEP
        (plan,) = window.meanwhile(page.post, "controller/plan")["targets"]
        assert [one["change"] for one in plan["files"]] == ["create"]
        window.press_until(lambda: record.now > where)
        window.line.socket.close()
        assert record.until_it_stands() < where + 0.7 * STEP
        wait_for(lambda: not cell.state.servo)


@pytest.mark.slow
def test_a_studio_that_dies_leaves_the_arm_at_the_end_of_a_step(
    bench: Bench, folder: Path, record: Record
) -> None:
    command = [sys.executable, "-m", "assistant", "studio", str(folder), "--no-open"]
    with subprocess.Popen([*command, "--format", "json"], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        said = b""
        while not said.endswith(b"}\n"):
            said += process.stdout.readline()
        page = Page(json.loads(said)["address"])
        with suppress(ConnectionError, ConnectionClosed), page.line() as line:
            window = taken(page, line)
            slowly(bench)
            window.press_until(lambda: record.now > STEP / 10)
            process.kill()
            window.answer(LONG)
    assert record.until_it_stands() == STEP
