"""The process of a loop: `python -m assistant.controllers.cyclic.worker FOLDER`, by `process.py`.

FOLDER holds `job.json` and `rows.npy`; `samples.npz` is written there. A line of JSON on stdout
tells now and then where the arm is; the last one what came of it. When stdin ends, which it also
does when the process that started this one is gone, or when nothing comes there for a while, as
that one is stopped, the arm is brought to rest. Where the job is led by corrections, they come as
lines on stdin.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import signal
import sys
import threading
import time
from dataclasses import astuple
from pathlib import Path as FilePath
from typing import Final

import numpy as np

from assistant.base.diagnostics import Rule
from assistant.controllers.cyclic import rules
from assistant.controllers.cyclic.link import Endpoint, Link
from assistant.controllers.cyclic.loop import Loop, Stop, columns
from assistant.controllers.cyclic.report import Timing
from assistant.controllers.cyclic.scheduling import real_time
from assistant.controllers.cyclic.settings import Settings
from assistant.controllers.cyclic.ways import Corrections, Job, Row
from assistant.controllers.cyclic.wire import PacketSocket

SPUN: Final = 1.0 / 3.0
"""Part of a cycle before a packet is due, and after, in which it is looked for without pause."""


def main(folder: FilePath) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who started it asks by the end of stdin
    described = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    module, name = described["link"]
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
        spin = {"block": 0.0, "mixed": link.cycle * SPUN, "spin": float("inf")}[settings.wait]
        wire = PacketSocket(endpoint, spin=spin, cycle=link.cycle)
    except OSError as error:
        reason = error.strerror or str(error)
        said = {"code": "CN711", "fields": {"address": str(endpoint), "reason": reason}}
        print(json.dumps(said), flush=True)  # noqa: T201
        return
    _set_blocking(False)
    with wire, real_time(settings.real_time and settings.wait != "spin") as (priority, refused):
        loop = Loop(link, wire, job, stop, _tell)
        result = loop.run(str(endpoint))
        measured = "kernel" if wire.stamped else "program"
    _set_blocking(True)
    table = np.array(result.samples, dtype=np.float64)
    named = columns(job, link)
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
    """Of stdout, where the system can."""
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
                self._take(os.read(0, 4096))  # `sys.stdin` would be locked when the process ends
        if self._over:
            return rules.INTERRUPTED
        return rules.LEFT if time.monotonic() - self._heard > self._alive else None

    def _take(self, said: bytes) -> bool:
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
    with contextlib.suppress(OSError):
        os.write(1, said.encode() + b"\n")


def _plain(value: object) -> object:
    return tuple(value) if isinstance(value, list) else value


if __name__ == "__main__":
    main(FilePath(sys.argv[1]))
