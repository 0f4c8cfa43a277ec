"""Real-time external control against a virtual controller in a process of its own.

How long after each packet of the controller its answer arrives there, by the kernel's clock, of the
loop of `assistant.controllers.cyclic` beside what one would write first: asyncio in the process
that does everything else, its samples kept as dictionaries, the garbage collector on.
"""

from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Final, cast

import numpy as np

from assistant import robots
from assistant.controllers.cyclic import Ended, Limits, Settings, Trajectory
from assistant.controllers.mitsubishi.external_control import CYCLES, Mxt, MxtLink
from assistant.virtual.cr.mxt_process import MxtProcess

ROBOT: Final = "rv-4frl"
PART: Final = 4
"""Of the time that a loop of ours is measured, what the others are: they are late at once."""
PATIENT: Final = Settings(timeout=2.0)


def trajectory(seconds: float) -> Trajectory:
    """All joints to and fro about home; shorter ones have fewer swings, none is faster."""
    arm = robots.get(ROBOT)
    times = np.linspace(0.0, seconds, max(8, int(50 * seconds)))
    swing = np.sin(np.pi * times / seconds) * np.sin(2 * np.pi * times / 3.0)
    return Trajectory.of_joints(
        arm.home + np.outer(swing, [20, 10, 15, 20, 20, 40]), times, unit="deg"
    )


def ours(port: int, cycle: float, seconds: float, settings: Settings = PATIENT) -> str:
    """Follows; what the loop ran with."""
    limits = Limits(tuple(robots.get(ROBOT).speeds))
    with Mxt("127.0.0.1", port=port, cycle=cycle, limits=limits, settings=settings) as mxt:
        try:
            return mxt.follow(trajectory(seconds)).priority
        except Ended as ended:  # so often without the processor that it never comes to its end
            return f"ended with {ended.findings[0].code}"


class _Naive(asyncio.DatagramProtocol):
    """Answers each packet as it comes, and keeps all it has seen."""

    def __init__(self, link: MxtLink, rows: np.ndarray, done: asyncio.Future[None]) -> None:
        self.link, self.rows, self.done = link, rows, done
        self.samples: list[dict[str, object]] = []

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        # Before Python 3.12 what arrives here is of another class.
        self.transport = cast("asyncio.DatagramTransport", transport)
        self.transport.sendto(self.link.hello(0))

    def datagram_received(self, data: bytes, addr: object) -> None:
        del addr
        measured = self.link.read(data)
        row = len(self.samples)
        if row >= len(self.rows):
            self.transport.sendto(self.link.end(self.rows[-1], row))
            if not self.done.done():
                self.done.set_result(None)
            return
        self.samples.append({"row": row, "at": measured, "to": self.rows[row].tolist()})
        self.transport.sendto(self.link.command(self.rows[row].tolist(), row))


def naive(port: int, cycle: float, seconds: float) -> str:
    """Follows without limits or a soft start, from where the arm is."""
    home = robots.get(ROBOT).home
    count = int(seconds / cycle)
    swing = np.sin(2 * np.pi * np.arange(count) * cycle / 3.0)
    rows = home + np.outer(swing, [2, 1, 1, 2, 2, 4])

    async def go() -> None:
        loop = asyncio.get_running_loop()
        done: asyncio.Future[None] = loop.create_future()
        transport, _ = await loop.create_datagram_endpoint(
            lambda: _Naive(MxtLink("joint", cycle), rows, done), remote_addr=("127.0.0.1", port)
        )
        await asyncio.wait_for(done, 4 * seconds + 10)
        transport.close()

    asyncio.run(go())
    return "garbage collector on"


LOOPS: Final[dict[str, tuple[Callable[[int, float, float], str], int]]] = {
    "cyclic": (ours, 1),
    "cyclic, spinning": (lambda *given: ours(*given, replace(PATIENT, wait="spin")), PART),
    "cyclic, ordinary priority": (
        lambda *given: ours(*given, replace(PATIENT, real_time=False)),
        PART,
    ),
    "asyncio in this process": (naive, PART),
}
"""Loop → how it is run, and which part of the time."""


@contextmanager
def busy(wanted: bool) -> Iterator[None]:
    """A process that computes without end, where it is wanted."""
    if not wanted:
        yield
        return
    with subprocess.Popen([sys.executable, "-c", "while True: pass"]) as other:
        try:
            yield
        finally:
            other.kill()


def measured(loop: str, cycle: float, seconds: float, load: bool) -> dict[str, float | str]:
    """Delays in ms as the controller saw them, and how many were beyond half a cycle."""
    run, part = LOOPS[loop]
    with busy(load), MxtProcess(ROBOT, cycle=cycle, record=False, priority=70) as controller:
        ran = run(controller.port, cycle, seconds / part)
    answers = np.array(controller.result["answers"])
    if controller.result["reason"] != "end" or not len(answers):
        raise SystemExit(f"the controller ended with {controller.result['reason']}")
    most_of = np.percentile(answers, 99)
    return {
        "ran": ran,
        "cycles": len(answers),
        "late": int((answers > cycle / 2.0).sum()),
        "median": 1e3 * float(np.median(answers)),
        "most_of": 1e3 * float(most_of),
        "longest": 1e3 * float(answers.max()),
    }


def report(seconds: float) -> None:
    """A line a loop, cycle and load."""
    print(
        f"\nReal-time control: {seconds:g} s of each cycle, a {PART}th of it for the others; from "
        "a packet\nof the controller to the arrival of the answer there\n"
    )
    head = f"{'answers':>9}{'late':>7}{'median':>9}{'99 %':>9}{'longest':>9}"
    print(f"{'loop':<54}{head}  ms")
    for cycle in CYCLES.values():
        for load in (False, True):
            print(f"cycle {1e3 * cycle:.2f} ms, {'a core busy' if load else 'idle'}")
            for loop in LOOPS:
                row = measured(loop, cycle, seconds, load)
                numbers = f"{row['cycles']:>9}{row['late']:>7}"
                numbers += "".join(f"{row[key]:>9.3f}" for key in ("median", "most_of", "longest"))
                print(f"  {loop:<28}{row['ran']:<24}{numbers}", flush=True)
