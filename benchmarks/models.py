"""A model in real time that leads an arm cycle by cycle, beside a loop that sleeps.

A trajectory goes through the block of external control to a virtual controller in a process of its
own, a step each 7.1 ms. Beside it, in the same run, what one would write first: a loop that sends a
packet, takes what came, and sleeps for 7.1 ms. Steps are late when they begin more than half a step
after their moment, answers when they arrive more than half a cycle after the packet of the
controller.
"""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from assistant import robots
from assistant.base.arrays import Floats
from assistant.blocks.connections import Connection
from assistant.blocks.diagrams import LATE_SHARE, Diagram, RealTime, run
from assistant.blocks.library.external_control import ExternalControl, Led
from assistant.blocks.library.sources import Constant, joint_table
from assistant.controllers.cyclic import Leading, Limits
from assistant.controllers.cyclic.worker import real_time
from assistant.controllers.mitsubishi.external_control import CYCLES, Mxt, MxtLink
from assistant.controllers.setpoint_streams import CyclicCarrier
from assistant.virtual.cr.mxt_process import MxtProcess
from assistant.vision.servoing.bounds import Bounds, Guard
from benchmarks.real_time import PATIENT, ROBOT, busy, trajectory

STEP: Final = 0.0071
CYCLE: Final = CYCLES["CR750"]
BOUNDS: Final = Bounds(speed=2000.0, turning=720.0, part=1.0, margin=0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """lateness: (n,) seconds that steps began late. answers: (k,) seconds, as the controller saw
    them. told: what the loop says of itself.
    """

    lateness: Floats
    answers: Floats
    told: str


def by_block(controller: MxtProcess, seconds: float) -> Callable[[], tuple[Floats, str]]:
    """A diagram with the trajectory and the block; when it is called it runs."""
    arm = robots.get(ROBOT)

    @contextmanager
    def opening() -> Iterator[Led]:
        guard = Guard(arm, BOUNDS)

        def made(limits: Limits, opened: ExitStack) -> Leading:
            axes = len(limits.speeds)
            mxt = Mxt("127.0.0.1", port=controller.port, limits=limits, axes=axes, settings=PATIENT)
            return opened.enter_context(mxt).leading()

        with CyclicCarrier(guard.arm(), made) as carrier:
            yield Led(guard, carrier)

    given = trajectory(seconds)
    assert given.times is not None
    diagram = Diagram()
    way = diagram.add(joint_table("way", arm, given.times, given.rows))
    led = diagram.add(ExternalControl("arm", Connection("cell", opening, moves=True), arm))
    diagram.wire((way, "joints"), (led, "wanted"))
    diagram.wire(diagram.add(Constant("on", 1.0)), (led, "enable"))

    def runs() -> tuple[Floats, str]:
        ran = run(diagram, seconds, STEP, clock=RealTime(), moving=["cell"])
        return ran.lateness, led.summary

    return runs


def at_priority(controller: MxtProcess, seconds: float) -> Callable[[], tuple[Floats, str]]:
    """The same with the priority and memory of real time, where that is permitted."""
    runs = by_block(controller, seconds)

    def prior() -> tuple[Floats, str]:
        with real_time(True) as (priority, refused):
            late, told = runs()
        return late, f"steps by {refused or priority}; {told}"

    return prior


def by_sleeping(controller: MxtProcess, seconds: float) -> Callable[[], tuple[Floats, str]]:
    """The same trajectory, a packet and a sleep a step."""
    given, link = trajectory(seconds), MxtLink("joint", CYCLE)
    assert given.times is not None
    moments = np.arange(int(seconds / STEP) + 1) * STEP
    rows = np.array([np.interp(moments, given.times, column) for column in given.rows.T]).T

    def runs() -> tuple[Floats, str]:
        late = []
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
            line.connect(("127.0.0.1", controller.port))
            line.settimeout(5.0)
            line.send(link.hello(0))
            line.recv(4096)
            line.setblocking(False)
            began = time.monotonic()
            for count, row in enumerate(rows.tolist(), 1):
                late.append(time.monotonic() - began - (count - 1) * STEP)
                line.send(link.command(row, count))
                with suppress(BlockingIOError):
                    link.read(line.recv(4096))
                time.sleep(STEP)
            line.send(link.end(rows[-1].tolist(), len(rows) + 1))
        return np.array(late), ""

    return runs


LOOPS: Final[dict[str, Callable[[MxtProcess, float], Callable[[], tuple[Floats, str]]]]] = {
    "model with the block": by_block,
    "the same, real-time priority": at_priority,
    "send, take, sleep": by_sleeping,
}


def measured(loop: str, seconds: float, load: bool) -> Measured:
    """One run against a controller of its own."""
    with busy(load), MxtProcess(ROBOT, record=False, priority=70) as controller:
        lateness, told = LOOPS[loop](controller, seconds)()
    seen: dict[str, Any] = controller.result
    if seen["reason"] != "end":
        raise SystemExit(f"the controller ended with {seen['reason']}")
    return Measured(lateness, np.array(seen["answers"]), told)


def report(seconds: float) -> None:
    """A line a loop and load."""
    print(
        f"\nA model in real time: {seconds:g} s of a trajectory, a step each {1e3 * STEP:.1f} ms; "
        "how late steps\nbegan, and how late their packets were at the controller, whose cycle "
        f"is {1e3 * CYCLE:.2f} ms\n"
    )
    head = (
        f"{'steps':>7}{'late':>7}{'mean':>10}{'worst':>10}{'answers':>11}{'late':>7}{'longest':>10}"
    )
    print(f"{'loop':<31}{head}  ms")
    for load in (False, True):
        print("a core busy" if load else "idle")
        for loop in LOOPS:
            row = measured(loop, seconds, load)
            late, ms = row.lateness, 1e3 * row.lateness
            numbers = f"{len(late):>7}{int((late > LATE_SHARE * STEP).sum()):>7}"
            numbers += f"{ms.mean():>10.3f}{ms.max():>10.3f}{len(row.answers):>11}"
            numbers += f"{int((row.answers > CYCLE / 2).sum()):>7}{1e3 * row.answers.max():>10.3f}"
            print(f"  {loop:<29}{numbers}", flush=True)
            if row.told:
                print(f"    {row.told}", flush=True)
