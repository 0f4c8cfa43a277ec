"""The process of a loop: `python -m assistant.controllers.cyclic.worker FOLDER`, by `process.py`.

FOLDER holds `job.json` and `rows.npy`; `samples.npz` is written there. A line of JSON on stdout
tells now and then where the arm is; the last one what came of it. When stdin ends, which it also
does when the process that started this one is gone, the arm is brought to rest.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import signal
import sys
import threading
from pathlib import Path as FilePath

import numpy as np

from assistant.controllers.cyclic.link import Endpoint, Link
from assistant.controllers.cyclic.loop import Job, Loop, Row, Stop, columns
from assistant.controllers.cyclic.scheduling import real_time
from assistant.controllers.cyclic.settings import Settings
from assistant.controllers.cyclic.wire import Wire


def main(folder: FilePath) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who started it asks by the end of stdin
    described = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    module, name = described["link"]
    fields = {key: _plain(value) for key, value in described["fields"].items()}
    link: Link = getattr(importlib.import_module(module), name)(**fields)
    settings = Settings(**described["settings"])
    rows = np.load(folder / "rows.npy", allow_pickle=False)
    limits = (tuple(described["speeds"]), tuple(described["rises"]))
    job = Job(described["kind"], rows, limits[0], limits[1], settings)
    endpoint = Endpoint(**described["endpoint"])
    stop = Stop()
    threading.Thread(target=_watch, args=(stop,), daemon=True).start()
    try:
        wire = Wire(endpoint, spin=settings.wait == "spin")
    except OSError as error:
        reason = error.strerror or str(error)
        said = {"code": "CN711", "fields": {"address": str(endpoint), "reason": reason}}
        print(json.dumps(said), flush=True)  # noqa: T201
        return
    _set_blocking(False)
    with wire, real_time(settings.real_time and settings.wait == "block") as (priority, refused):
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


def _watch(stop: Stop) -> None:
    while os.read(0, 4096):  # `sys.stdin` would be locked when the process ends
        pass
    stop.asked = True


def _tell(seconds: float, row: float, values: Row) -> None:
    """Tells if someone listens; the loop waits for nobody."""
    said = json.dumps({"seconds": seconds, "row": row, "values": values})
    with contextlib.suppress(OSError):
        os.write(1, said.encode() + b"\n")


def _plain(value: object) -> object:
    return tuple(value) if isinstance(value, list) else value


if __name__ == "__main__":
    main(FilePath(sys.argv[1]))
