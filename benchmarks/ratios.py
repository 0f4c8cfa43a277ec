"""Speed beside a plain Python loop, and starts of commands beside those of Python: `make speed`.

    python -m benchmarks.ratios

A ratio hardly depends on the machine, and each limit is less than half of what was measured, so
that only a fault that doubles the time of a task fails. A ratio below its limit is measured again.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import assistant
from assistant import sources
from benchmarks.code import code
from benchmarks.emission import adapted, csv, emit, emitted, poses, prove_all, python_rapid
from benchmarks.growth.sources import curve, far_beside
from benchmarks.starting import starts

POINTS: Final = 50_000
LINES: Final = 1_000
CHORDS: Final = 20_000
RUNS: Final = 3


@dataclass(frozen=True, slots=True)
class Task:
    """A task that is timed; the plain loop formats POINTS targets and moves.

    least: the lowest ratio of the loop's CPU time to that of the task; low for proofs,
    since lark parses most of those lines as well.
    """

    prepare: Callable[[], Any]
    work: Callable[[Any], object]
    least: float


def _program(language: str, suffix: str) -> Callable[[], Path]:
    def written() -> Path:
        (data,) = code(language, LINES).values()
        path = Path(_FOLDER.name, f"code.{suffix}")
        path.write_bytes(data)
        return path

    return written


def _drawing() -> Path:
    """A curve of many chords with an offset, and its process file beside it."""
    path = Path(_FOLDER.name, "curve.dxf")
    path.write_text(curve(CHORDS), encoding="ascii")
    path.with_suffix(".process.toml").write_text(far_beside(CHORDS), encoding="ascii")
    return path


def _translated(to: str) -> Callable[[Path], object]:
    return lambda path: assistant.translate(path, to=to)


_FOLDER: Final = TemporaryDirectory()

TASKS: Final[dict[str, Task]] = {
    "read .csv": Task(lambda: csv(POINTS), sources.read, 0.55),
    "read .dxf, an offset curve": Task(_drawing, sources.read, 0.03),
    "emit RAPID": Task(lambda: adapted("rapid")(POINTS), emit, 0.85),
    "prove RAPID": Task(lambda: emitted("rapid")(POINTS), prove_all, 0.2),
    "emit MELFA-BASIC VI": Task(lambda: adapted("melfa-basic-6")(POINTS), emit, 1.5),
    "prove MELFA-BASIC VI": Task(lambda: emitted("melfa-basic-6")(POINTS), prove_all, 0.35),
    "check RAPID": Task(_program("rapid", "mod"), assistant.check, 0.4),
    "check MELFA-BASIC V": Task(_program("melfa-basic-5", "mb5"), assistant.check, 0.27),
    "RAPID to MELFA-BASIC VI": Task(_program("rapid", "mod"), _translated("melfa-basic-6"), 0.17),
    "MELFA-BASIC V to RAPID": Task(_program("melfa-basic-5", "mb5"), _translated("rapid"), 0.09),
}
STARTS: Final = {
    "--help": 14.0,
    "explain a finding": 22.0,
    "check a RAPID module": 28.0,
    "translate a RAPID module": 46.0,
}
"""Command → the most starts of a bare interpreter that its CPU time may be."""


def main() -> None:
    """Print a line a task, and end with status 1 if one is too slow twice."""
    slow = [name for name, task in TASKS.items() if not _is_quick(name, task)]
    slow += [name for name, most in STARTS.items() if not _starts_quickly(name, most)]
    if slow:
        sys.exit(f"more than twice as slow as measured before: {', '.join(slow)}")


def _is_quick(name: str, task: Task) -> bool:
    given = task.prepare()
    for attempt in (1, 2):
        ratio = measured(task.work, given)
        quick = ratio >= task.least
        verdict = "" if quick else ", below it: again" if attempt == 1 else ", below it"
        print(f"{name:<28}{ratio:>8.2f} of the plain loop's speed (least {task.least}){verdict}")
        if quick:
            return True
    return False


def _starts_quickly(name: str, most: float) -> bool:
    for attempt in (1, 2):
        ratio = starts(name)
        verdict = "" if ratio <= most else ", above it: again" if attempt == 1 else ", above it"
        print(f"{name:<28}{ratio:>8.1f} starts of Python (at most {most}){verdict}")
        if ratio <= most:
            return True
    return False


def measured(work: Callable[[Any], object], given: Any) -> float:
    """The CPU time of the plain loop divided by that of some work, the best of RUNS of each.

    The two take turns, so that a machine that is busy for a while slows both.
    """
    plain = poses(POINTS)
    times = [(_seconds(python_rapid, plain), _seconds(work, given)) for _ in range(RUNS)]
    loops, works = zip(*times, strict=True)
    return float(min(loops) / min(works))


def _seconds(work: Callable[[Any], object], given: Any) -> float:
    start = time.process_time()
    work(given)
    return time.process_time() - start


if __name__ == "__main__":
    main()
