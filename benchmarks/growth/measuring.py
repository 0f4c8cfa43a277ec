"""What a command costs with a construct of some size: CPU time, or how often functions are called.

Each run is a fork of a process that has loaded everything and run the command once, so that none
finds what another has kept, and none holds the others up for longer than it may take.
"""

from __future__ import annotations

import contextlib
import gc
import io
import json
import math
import os
import resource
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, Final

from assistant import cli
from benchmarks.growth.construct import Construct

Measure = Callable[[Callable[[], object]], float]

MOST_MEMORY: Final = 4 << 30
"""Bytes that a run may have."""


@dataclass(frozen=True, slots=True)
class Growth:
    """costs: by size, what it took beyond that of the smallest text. why: what ended it, if so."""

    construct: str
    command: str
    costs: Mapping[int, float]
    why: str = ""

    @property
    def exponent(self) -> float:
        """By least squares of the logarithms, over the three largest sizes; NaN for one alone."""
        known = [(math.log(n), math.log(cost)) for n, cost in self.costs.items() if cost > 0][-3:]
        if len(known) < 2:
            return math.nan
        x, y = (sum(column) / len(known) for column in zip(*known, strict=True))
        above = sum((a - x) * (b - y) for a, b in known)
        return above / sum((a - x) ** 2 for a, _ in known)


def cpu(work: Callable[[], object]) -> float:
    """Seconds of CPU, with the garbage of before collected."""
    gc.collect()
    gc.disable()
    before = time.process_time()
    work()
    return time.process_time() - before


def calls(work: Callable[[], object]) -> float:
    """How often functions are called: the same number each time."""
    count = 0

    def called(_: object, event: str, __: object) -> None:
        nonlocal count
        count += event != "return"

    sys.setprofile(called)
    try:
        work()
    finally:
        sys.setprofile(None)
    return float(count)


def run(construct: Construct, command: str, n: int, measure: Measure) -> float:
    """What one command costs here, in this process; whatever it answers."""
    with tempfile.TemporaryDirectory(prefix="growth") as folder:
        file = FilePath(folder) / f"a{construct.suffix}"
        file.write_text(construct.text(n), "utf-8", newline="")
        if construct.process is not None:
            file.with_suffix(".process.toml").write_text(construct.process(n), "utf-8")
        places = {"file": str(file), "out": f"{folder}/out"}
        said = [part.format(**places) for part in construct.commands[command]]
        return measure(lambda: _typed(said))


def _typed(said: Sequence[str]) -> None:
    with (
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
        contextlib.suppress(SystemExit),
    ):
        cli.main(list(said))


def forked(work: Callable[[], float], seconds: float) -> float | str:
    """What some work gives in a process of its own, or what ended that; seconds: of its CPU."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        _answer(work, seconds, writing)
    os.close(writing)
    with os.fdopen(reading, "rb") as answered:
        said = answered.read()
    _, status = os.waitpid(child, 0)
    if said:
        answer: Any = json.loads(said)
        return answer if isinstance(answer, str) else float(answer)
    ended = os.waitstatus_to_exitcode(status)
    return f"over {seconds:g} s" if -ended in (signal.SIGXCPU, signal.SIGKILL) else f"ended {ended}"


def _answer(work: Callable[[], float], seconds: float, writing: int) -> None:
    """In the fork: what the work gives, as JSON; never comes back."""
    most = math.ceil(time.process_time() + seconds)
    resource.setrlimit(resource.RLIMIT_CPU, (most, most + 1))
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    signal.signal(signal.SIGXCPU, signal.SIG_DFL)
    answer: float | str = "failed"
    try:
        answer = work()
    except MemoryError:
        answer = f"over {MOST_MEMORY >> 30} GiB"
    finally:
        os.write(writing, json.dumps(answer).encode())
        os._exit(0)


def grown(
    construct: Construct,
    command: str,
    sizes: Sequence[int],
    runs: int,
    seconds: float,
    measure: Measure = cpu,
) -> Growth:
    """How a construct grows in a command, the best of some runs, as far as it stays in the time."""
    start = 0.0
    costs: dict[int, float] = {}
    why = ""
    last = 0.0
    for n in (1, *_within(sizes, construct.largest)):
        if costs and last * (n / max(costs)) ** 1.1 > seconds:
            break
        best = math.inf
        for _ in range(runs):
            answer = forked(lambda n=n: run(construct, command, n, measure), seconds)
            if isinstance(answer, str):
                why = f"{answer} at {n}"
                break
            best = min(best, answer)
        if why:
            break
        if n == 1:
            start = best
        else:
            last, costs[n] = best, best - start
    return Growth(construct.name, command, costs, why)


def _within(sizes: Sequence[int], largest: int | None) -> Iterator[int]:
    yield from (n for n in sizes if largest is None or n <= largest)
