"""Process of a loop: `python -m assistant.controllers.cyclic.worker FOLDER`, started by `process`.

FOLDER holds `job.json` and `rows.npy`; the worker writes `samples.npz` there. Lines of JSON on
stdout report the position of the arm, the last one how the run ended. The worker brings the arm to
rest when stdin ends, which also happens when the parent process is gone, and when nothing arrives
on stdin for a while, for example when the parent is stopped. Corrections arrive as lines on stdin.
While the loop runs, the process has real-time priority and locked memory where that is permitted,
and no garbage collection.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import importlib
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import astuple
from pathlib import Path as FilePath
from typing import Final

import numpy as np

from assistant.base.diagnostics import Rule
from assistant.controllers.cyclic import rules
from assistant.controllers.cyclic.loop import (
    Endpoint,
    Link,
    Loop,
    PacketSocket,
    Stop,
    Timing,
    columns,
)
from assistant.controllers.cyclic.setpoint_source import PRIORITY, Corrections, Job, Row, Settings

_DMA_LATENCY: Final = "/dev/cpu_dma_latency"
_CURRENT: Final = 1
_FUTURE: Final = 2
"""MCL_CURRENT and MCL_FUTURE of Linux."""


@contextmanager
def real_time(wanted: bool) -> Iterator[tuple[str, str]]:
    """Context with the garbage collector off and, where that is permitted, real-time priority.

    Yields the priority, and why it is not a real-time priority ("" if none was wanted).
    """
    said = _priority() if wanted else ("ordinary priority", "")
    _keep_memory()
    # Objects made until now are never searched again; those of the loop are few.
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        with _awake() if wanted else nullcontext():
            yield said
    finally:
        gc.enable()
        gc.unfreeze()
        if said[0].startswith("SCHED_FIFO"):
            # Other programs of this process must not keep a real-time priority.
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


@contextmanager
def _awake() -> Iterator[None]:
    """Keep processors from sleeping as long as the file is open, where that is permitted.

    The file takes the microseconds that waking up may last
    (Documentation/power/pm_qos_interface.rst of Linux).
    """
    with ExitStack() as kept:
        with suppress(OSError):
            # 32 bits of 0: no microsecond to wake up. The request ends when the file is closed.
            kept.enter_context(FilePath(_DMA_LATENCY).open("wb", buffering=0)).write(bytes(4))
        yield


def _keep_memory() -> None:
    """Keeps all pages in memory where that is permitted: to fetch one again may cost a cycle."""
    if sys.platform == "linux":
        ctypes.CDLL(None).mlockall(_CURRENT | _FUTURE)


def _priority() -> tuple[str, str]:
    if not hasattr(os, "sched_setscheduler"):
        return "ordinary priority", "this system has no SCHED_FIFO"
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError as error:
        return "ordinary priority", f"SCHED_FIFO is not permitted: {error.strerror}"
    return f"SCHED_FIFO {PRIORITY}", ""


_SPUN: Final = 1.0 / 3.0
"""Part of a cycle before a packet is due, and after, in which the socket is polled without
pause.
"""


def main(folder: FilePath) -> None:
    # Ctrl-C reaches this process as well; the parent
    # asks by the end of stdin, to brake on the path.
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who started it asks by the end of stdin
    described = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    module, name = described["link"]
    # JSON has lists only; the fields of a link are tuples.
    fields = {key: _plain(value) for key, value in described["fields"].items()}
    link: Link = getattr(importlib.import_module(module), name)(**fields)
    settings = Settings(**described["settings"])
    rows = np.load(folder / "rows.npy", allow_pickle=False)
    limits = (tuple(described["speeds"]), tuple(described["rises"]))
    corrections = Corrections() if described["corrected"] else None
    bounds = (tuple(described["lowest"]), tuple(described["highest"]))
    job = Job(described["kind"], rows, *limits, settings, corrections, *bounds)
    endpoint = Endpoint(**described["endpoint"])
    stop = Watched(settings.alive, corrections)
    try:
        spin = {"block": 0.0, "mixed": link.cycle * _SPUN, "spin": float("inf")}[settings.wait]
        wire = PacketSocket(endpoint, spin=spin, cycle=link.cycle)
    except OSError as error:
        reason = error.strerror or str(error)
        said = {"code": "CN711", "fields": {"address": str(endpoint), "reason": reason}}
        print(json.dumps(said), flush=True)  # noqa: T201
        return
    # A parent that does not read must not delay the loop: a full pipe drops the report instead.
    _set_blocking(False)
    with wire, real_time(settings.real_time and settings.wait != "spin") as (priority, refused):
        loop = Loop(link, wire, job, stop, _tell)
        result = loop.run(str(endpoint))
        measured = "kernel" if wire.stamped else "program"
    # The last report must arrive complete.
    _set_blocking(True)
    table = np.array(result.samples, dtype=np.float64)
    named = columns(job, link)
    # Without samples the array is flat.
    table = table.reshape(-1, len(named))
    np.savez(folder / "samples.npz", table=table, delays=np.array(result.delays))
    said = {
        "code": result.code,
        "fields": dict(result.fields),
        "priority": priority,
        "refused": refused,
        "measured": measured,
        "columns": named,
        **{n: getattr(result, n) for n in ("done", "asked_again", "repeated", "garbled", "missed")},
    }
    print(json.dumps(said), flush=True)  # noqa: T201


def _set_blocking(blocking: bool) -> None:
    """Set stdout to blocking or not, where the system can."""
    if hasattr(os, "set_blocking"):
        os.set_blocking(1, blocking)


class Watched(Stop):
    """Asked by the end of stdin, or when nothing has come there for `alive` seconds.

    The loop itself looks: another thread would have the interpreter when a packet comes, at the
    priority of any other program. Where a pipe cannot be read so, a thread has to do.
    """

    def __init__(self, alive: float, corrections: Corrections | None = None) -> None:
        self._alive, self._heard, self._over = alive, time.monotonic(), False
        self._corrections = corrections
        self._threaded = sys.platform == "win32"
        if self._threaded:
            threading.Thread(target=self._listen, daemon=True).start()
        else:
            os.set_blocking(0, False)

    def look(self) -> Rule | None:
        if not self._threaded:
            with contextlib.suppress(BlockingIOError):
                # A read of nothing means that stdin has ended;
                # BlockingIOError means that nothing has come.
                self._take(os.read(0, 4096))  # `sys.stdin` would be locked when the process ends
        if self._over:
            return rules.INTERRUPTED
        return rules.LEFT if time.monotonic() - self._heard > self._alive else None

    def _take(self, said: bytes) -> bool:
        # Every byte is a sign of life, also the empty lines of `_beat`.
        self._heard, self._over = time.monotonic(), not said
        if self._corrections is not None:
            self._corrections.take(said)
        return bool(said)

    def _listen(self) -> None:
        while self._take(os.read(0, 4096)):
            pass


def _tell(seconds: float, row: float, values: Row, timing: Timing) -> None:
    """Tells if someone listens; the loop waits for nobody."""
    told = {"seconds": seconds, "row": row, "values": values, "timing": astuple(timing)}
    said = json.dumps(told)
    # The pipe is full, or nobody reads.
    with contextlib.suppress(OSError):
        os.write(1, said.encode() + b"\n")


def _plain(value: object) -> object:
    return tuple(value) if isinstance(value, list) else value


if __name__ == "__main__":
    main(FilePath(sys.argv[1]))
