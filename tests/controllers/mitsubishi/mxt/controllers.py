"""Controllers in `Mxt` that run in a thread of the test, and jobs led without a process."""

import contextlib
import threading

import numpy as np

from assistant import robots
from assistant.controllers.cyclic import Endpoint, Limits, Settings, Trajectory, resampled
from assistant.controllers.cyclic.loop import Job, Loop, PacketSocket, Stop
from assistant.controllers.mitsubishi.external_control import MxtLink
from assistant.virtual.cr.mxt import MxtArm, MxtControl
from tests.virtual.cr.waiting import wait_for

ARM = robots.get("rv-4frl")
CYCLE = 0.002
LIMITS = Limits(tuple(ARM.speeds), tuple(20.0 * ARM.speeds))
PATIENT = Settings(timeout=30.0, lapse=1000, softness=0.5, alive=60.0)
"""A busy machine may stop for a while where nothing is to be seen of that."""
FAULTY = Settings(timeout=30.0, softness=0.5)


@contextlib.contextmanager
def controller(kind=1, *, servo=0.5, filter_ms=0.0, **settings):
    arm = MxtArm(ARM, ARM.home, CYCLE, filter_ms, servo)
    control = MxtControl(arm, kind, **settings)
    stop = threading.Event()
    thread = threading.Thread(target=control.run, args=(stop,))
    thread.start()
    try:
        yield control
    finally:
        # What was sent is heard before it is stopped, however late this thread gets the processor.
        cycles = control.result.cycles
        wait_for(lambda: not thread.is_alive() or control.result.cycles > cycles + 1)
        stop.set()
        thread.join()


def joints(points=3):
    """From near home on, and back."""
    away = np.sin(np.linspace(0.0, np.pi, points))
    return Trajectory.of_joints(ARM.home + np.outer(away, [6, 3, -4, 5, 2, 8]) + 0.1, unit="deg")


def led(control, trajectory, *, mode="joint", settings=PATIENT, stop=None, tell=None, **link):
    """What came of a trajectory: the loop's own report, and what the controller saw."""
    made = MxtLink(mode, CYCLE, **link)
    limits = LIMITS if trajectory.kind == "joints" else Limits((400.0, 200.0), (8000.0, 4000.0))
    if mode == "pulse":
        limits = Limits(tuple(100.0 * ARM.speeds), tuple(2000.0 * ARM.speeds))
    speeds, rises = limits.columns(trajectory.kind, trajectory.rows.shape[1])
    rows = resampled(trajectory, limits, CYCLE)
    job = Job(trajectory.kind, rows, tuple(speeds), tuple(rises), settings)
    with PacketSocket(Endpoint("127.0.0.1", control.port)) as wire:
        loop = Loop(made, wire, job, stop or Stop(), tell or (lambda *told: None))
        return loop.run("127.0.0.1")
