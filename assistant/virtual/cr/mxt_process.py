"""A controller in `Mxt`, in a separate process: `python -m assistant.virtual.cr.mxt_process`.

    with MxtProcess("rv-4frl", cycle=0.0035) as controller:
        Mxt("127.0.0.1", port=controller.port, ...)
    controller.result["answers"]

The process prints its port, then, when `Mxt` or its input ends, its observations as JSON.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import threading
from collections.abc import Mapping
from typing import Any, Final, Self, get_args

from assistant.virtual.cr.mxt import CYCLE, Fault, MxtArm, MxtControl

_PATIENCE: Final = 10.0
"""Seconds that the process may take to begin, and to end once asked to."""


class MxtProcess:
    """Controller in a separate process, a context manager; for the arguments see `MxtControl`.
    result: its observations, once it has ended.

    priority: that of SCHED_FIFO, which keeps the cycle well where the system permits it; 0 for
    none.
    """

    def __init__(
        self,
        robot: str = "rv-4frl",
        *,
        cycle: float = CYCLE,
        kind: int = 1,
        filter_ms: float = 0.0,
        timeout: int = -1,
        faults: Mapping[int, Fault] | None = None,
        short: bool = False,
        answers_end: bool = True,
        record: bool = True,
        priority: int = 0,
    ) -> None:
        settings = {"robot": robot, "cycle": cycle, "kind": kind, "filter_ms": filter_ms}
        settings |= {
            "priority": priority,
            "timeout": timeout,
            "short": int(short),
            "answers_end": int(answers_end),
        }
        self._arguments = [f"--{name}={value}" for name, value in settings.items()]
        self._arguments += [f"--fault={number}:{what}" for number, what in (faults or {}).items()]
        self._arguments += ["--record=1"] if record else []
        self.port = 0
        self.result: dict[str, Any] = {}

    def __enter__(self) -> Self:
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, sys.path))}
        self._process = subprocess.Popen(  # noqa: S603
            [sys.executable, "-P", "-m", "assistant.virtual.cr.mxt_process", *self._arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        )
        assert self._process.stdout is not None
        words = self._process.stdout.readline().split()
        if not words:
            raise RuntimeError("the virtual controller did not begin")
        self.port = int(words[-1])
        return self

    def __exit__(self, *error: object) -> None:
        try:
            said, _ = self._process.communicate("", timeout=_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            said, _ = self._process.communicate()
        self.result = json.loads(said) if said.strip() else {}


def main() -> None:
    parser = argparse.ArgumentParser(description="a CR controller in real-time external control")
    parser.add_argument("--robot", default="rv-4frl")
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--cycle", type=float, default=CYCLE)
    parser.add_argument("--kind", type=int, choices=[0, 1, 2], default=1)
    parser.add_argument("--filter_ms", type=float, default=0.0)
    parser.add_argument("--timeout", type=int, default=-1, help="MXTTOUT")
    parser.add_argument("--short", type=int, default=0, help="1 for packets of 64 bytes")
    parser.add_argument("--answers_end", type=int, default=1)
    parser.add_argument("--fault", action="append", default=[], metavar="REPLY:WHAT")
    parser.add_argument("--record", type=int, default=0, help="1 to keep what is commanded")
    parser.add_argument("--priority", type=int, default=0, help="of SCHED_FIFO, 0 for none")
    given = parser.parse_args()
    from assistant import robots

    faults: dict[int, Fault] = {}
    for fault in given.fault:
        number, _, what = fault.partition(":")
        if what not in get_args(Fault):
            parser.error(f"{what} is none of {', '.join(get_args(Fault))}")
        faults[int(number)] = what
    robot = robots.get(given.robot)
    control = MxtControl(
        MxtArm(robot, robot.home, given.cycle, given.filter_ms),
        given.kind,
        port=given.port,
        timeout=given.timeout,
        faults=faults,
        short=bool(given.short),
        answers_end=bool(given.answers_end),
        record=bool(given.record),
    )
    if given.priority and hasattr(os, "sched_setscheduler"):
        with contextlib.suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(given.priority))
    stop = threading.Event()
    threading.Thread(target=_until_over, args=(stop,), daemon=True).start()
    print(f"listening on {control.port}", flush=True)  # noqa: T201
    print(control.run(stop).told(), flush=True)  # noqa: T201


def _until_over(stop: threading.Event) -> None:
    while os.read(0, 4096):  # `sys.stdin` would be locked when the process ends
        pass
    stop.set()


if __name__ == "__main__":
    main()
