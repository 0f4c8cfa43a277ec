"""MELFA-BASIC programs that run in a thread, with communication lines to real sockets and ports."""

import os
import pty
import threading
import time
import tty
from contextlib import contextmanager, suppress
from pathlib import Path

from assistant import languages, robots
from assistant.virtual.kernel import Ending, Kernel
from assistant.virtual.kernel.kernel import Instant
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.melfa import Controller, Entry, Options
from assistant.virtual.melfa.communication_lines import Serial, TcpServer
from assistant.virtual.melfa.world import STEP_TIME

ROBOT = robots.get("rv-2aj")
HOME = (0.0, 0.0, 90.0, 0.0, 90.0, 0.0)
LOOK = 0.02
"""Simulated seconds between two looks whether the run is to end."""


class Running:
    """programs: texts by name; the first one starts, in slot 1.

    lines: by the name that is opened. Time in the run is never ahead of real time.
    """

    def __init__(self, programs, lines, *, timed=False, options=None, most_time=60.0):
        language = languages.get("melfa-basic-4")
        motion = Timed(ROBOT, joints=ROBOT.own_joints(HOME)) if timed else Instant()
        self.kernel = Kernel(statement_time=STEP_TIME, motion=motion, most_time=most_time)
        self.controller = Controller(
            self.kernel,
            {name: language.parse(text) for name, text in programs.items()},
            {1: Entry(next(iter(programs)), "CYC")},
            robot=ROBOT,
            joints=HOME,
            lines=lines,
            options=options or Options(unset="zero"),
        )
        self.done = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *error):
        self._stop.set()
        self._thread.join(30)
        assert not self._thread.is_alive()

    def ended(self):
        """The run, once it is over by itself, or behind a stop of all slots."""
        if self.states == ["waits", "reset", "reset"]:
            self._stop.set()
        self._thread.join(30)
        return self.done

    def stopped(self):
        """Seconds of the run after which all slots stood; fails if they never do."""
        end = time.monotonic() + 30
        while self.states != ["waits", "reset", "reset"]:
            assert self._thread.is_alive() or self.states == ["waits", "reset", "reset"]
            assert time.monotonic() < end, self.states
            time.sleep(0.005)
        return self.kernel.clock

    @property
    def states(self):
        return [slot.state for slot in self.controller.slots[:3]]

    def _run(self):
        self.kernel.__post_init__()  # its hub is the greenlet of this thread
        self.controller.start()
        self._look()
        self.done = self.kernel.run()

    def _look(self):
        if self._stop.is_set():
            self.kernel.end(Ending())
        else:
            self.kernel.at(self.kernel.now + LOOK, self._look)


@contextmanager
def tcp():
    """A line, and the target that a client names."""
    line = TcpServer()
    try:
        yield line, f"127.0.0.1:{line.address[1]}"
    finally:
        line.shut()


@contextmanager
def serial():
    """The same over a pair of pseudo terminals; bytes are carried between them."""
    pairs = [pty.openpty() for _ in range(2)]
    for pair in pairs:
        for end in pair:
            tty.setraw(end)
    (one, one_port), (two, two_port) = pairs
    carriers = [threading.Thread(target=carry, args=ends) for ends in ((one, two), (two, one))]
    for carrier in carriers:
        carrier.start()
    line = Serial(os.ttyname(one_port))
    try:
        yield line, os.ttyname(two_port)
    finally:
        line.close()
        for port in (one_port, two_port):
            os.close(port)
        for carrier in carriers:
            carrier.join(10)
        for end in (one, two):
            os.close(end)


def carry(source, target):
    """Bytes from one end to the other, until the line is gone."""
    with suppress(OSError):
        while data := os.read(source, 4096):
            os.write(target, data)


def samples(folder):
    """The three programs of data link control mode."""
    place = Path(__file__).parents[3] / "samples" / "melfa" / folder
    names = ("MULTITASK", "DATALINK", "CONTROLLINK")
    return {name: (place / f"{name}.prg").read_text("latin-1") for name in names}
