"""Commands as users start them, with and without a warm server, beside a bare interpreter.

CPU seconds are those of the process and of what it starts; seconds are those of the clock.
"""

from __future__ import annotations

import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Final

PROJECT: Final = Path(__file__).parent.parent
SAMPLES: Final = PROJECT / "samples"
COMMANDS: Final[Mapping[str, tuple[str, ...]]] = {
    "--help": ("--help",),
    "explain a finding": ("explain", "RA102"),
    "fmt a RAPID module": ("fmt", "--check", f"{SAMPLES}/rapid/pick_and_place.mod"),
    "check a RAPID module": ("check", f"{SAMPLES}/rapid/pick_and_place.mod"),
    "check a MELFA-BASIC program": ("check", f"{SAMPLES}/melfa/PALLET.prg"),
    "check a drawing": ("check", f"{SAMPLES}/plate.dxf"),
    "compile a drawing": ("compile", f"{SAMPLES}/plate.dxf", "-l", "rapid", "-o", "out"),
    "translate a RAPID module": (
        *("translate", f"{SAMPLES}/rapid/drilling.mod"),
        *("--to", "melfa-basic-6", "-o", "out"),
    ),
}
_RUNS: Final = 7
_SCRIPT: Final = "from assistant.cli import main\nmain()\n"
_WAIT: Final = 60.0
"""Seconds until a server is there."""


def report() -> None:
    """Print a line for each command: CPU time beside that of Python, and seconds."""
    print(f"\ncommands as users start them; median of {_RUNS} runs\n")
    print(f"{'':<30}{'CPU s':>8}{'Python':>8}{'seconds':>10}{'with a server':>16}")
    bare, seconds = timed([sys.executable, "-c", "pass"], {})
    print(f"{'python -c pass':<30}{bare:>8.3f}{1:>8.1f}{seconds:>10.3f}")
    with _place() as (command, environment):
        for name, words in COMMANDS.items():
            cpu, cold = timed([*command, *words], {**environment, "ROBOT_ASSISTANT_SERVER": "off"})
            _, warm = timed([*command, *words], environment)
            print(f"{name:<30}{cpu:>8.3f}{cpu / bare:>8.1f}{cold:>10.3f}{warm:>16.3f}", flush=True)


def starts(name: str) -> float:
    """The CPU time of a command without a server, divided by that of a bare interpreter."""
    words = [sys.executable, "-m", "assistant", *COMMANDS[name]]
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    cpu, _ = timed(words, environment, 3)
    bare, _ = timed([sys.executable, "-c", "pass"], environment, 3)
    return cpu / bare


def timed(
    command: list[str], environment: Mapping[str, str], runs: int = _RUNS
) -> tuple[float, float]:
    """CPU seconds and seconds of a command in an empty folder, the median of some runs."""
    times = []
    for _ in range(runs):
        with tempfile.TemporaryDirectory() as folder:
            before, start = _children(), time.perf_counter()
            done = subprocess.run(command, cwd=folder, env=environment, capture_output=True)
            if done.returncode > 1:  # 1 is for findings, and for a draft
                sys.exit(done.stderr.decode())
            times.append((_children() - before, time.perf_counter() - start))
    cpu, seconds = zip(*times, strict=True)
    return statistics.median(cpu), statistics.median(seconds)


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@contextmanager
def _place() -> Iterator[tuple[list[str], dict[str, str]]]:
    """A script, and an environment in which a server answers it until the block ends."""
    folder = Path(tempfile.mkdtemp(prefix="starting"))
    script = folder / "robot-assistant"
    script.write_text(_SCRIPT, encoding="ascii")
    environment = {name: value for name, value in os.environ.items() if name != "CI"}
    environment |= {
        "PYTHONPATH": str(PROJECT),
        "ROBOT_ASSISTANT_SERVER": "auto",
        "XDG_RUNTIME_DIR": str(folder),
    }
    command = [sys.executable, str(script)]
    try:
        subprocess.run([*command, "--help"], env=environment, check=True, capture_output=True)
        until = time.monotonic() + _WAIT
        while not any(path.is_socket() for path in folder.glob("*/*")):
            if time.monotonic() > until:
                sys.exit("no warm server started")
            time.sleep(0.1)
        yield command, environment
    finally:
        # Without its socket it ends.
        shutil.rmtree(folder)
