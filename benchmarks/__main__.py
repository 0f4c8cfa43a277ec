"""Runs every case in a process of its own and prints points per second and peak memory."""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time

from benchmarks import (
    editing,
    exchanging,
    first_page,
    generated,
    in_the_studio,
    learning,
    models,
    mutants,
    planning,
    real_time,
    scenes,
    starting,
    tasks,
)
from benchmarks.arms import ROBOTS
from benchmarks.collision import COLLISION
from benchmarks.collision import TITLE as CELL
from benchmarks.emission import CASES
from benchmarks.growth import report as growth
from benchmarks.reading import READING
from benchmarks.running import RUNNING
from benchmarks.talking import TALKING

TABLES = {
    "reading": {
        f"{title}: targets written out, a move through each": cases
        for title, cases in READING.items()
    },
    "arms": {"Arms: joints at random inside the limits; a tool that goes over a surface": ROBOTS},
    "collision": {CELL: COLLISION},
    "running": {"Running: loops that count, and moves that are simulated in time": RUNNING},
    "talking": {"Talking: a command and its answer, the server in a process of its own": TALKING},
}
MEASURED = (cases for tables in TABLES.values() for cases in tables.values())
EVERY = CASES | {name: one.case for cases in MEASURED for name, one in cases.items()}


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--points", type=int, default=1_000_000)
    arguments.add_argument("--runs", type=int, default=3, help="of each case; the best counts")
    arguments.add_argument(
        "--only",
        choices=[
            "emission",
            *TABLES,
            "generated",
            "exchange",
            "editing",
            "first-page",
            "planning",
            "learning",
            "real-time",
            "models",
            "scenes",
            "starting",
            "growth",
            "tasks",
            "proofs",
        ],
        help="one part of it; growth takes hours; it, tasks and proofs run only if they are named",
    )
    arguments.add_argument("--construct", default="", help="of growth: part of a name")
    arguments.add_argument("--short", action="store_true", help="of growth: a handful, small")
    arguments.add_argument("--cap", type=float, default=10.0, help="of growth: seconds of a run")
    arguments.add_argument("--case", choices=[*EVERY], help="run one case here and print JSON")
    arguments.add_argument(
        "--seconds", type=float, help="of real-time control, 60 if left out; of models, 30"
    )
    arguments.add_argument("--programs", type=int, default=40, help="of proofs, translations")
    arguments.add_argument("--mutants", type=int, default=2, help="of proofs, of each kind")
    tasks.arguments(arguments.add_argument_group("of tasks"))
    chosen = arguments.parse_args()
    if chosen.case:
        print(json.dumps(_measured(chosen.case, chosen.points)))
        return
    if chosen.only == "tasks":
        tasks.run(chosen)
        return
    if chosen.only == "proofs":
        mutants.report(chosen.programs, chosen.mutants)
        return
    if chosen.only == "growth":
        runs = 1 if chosen.short else max(chosen.runs, 5)
        growth.report(growth.Plan(chosen.construct, chosen.cap, runs, chosen.short))
        return
    if chosen.only in (None, "emission"):
        _emission(chosen.points, chosen.runs)
    for part in TABLES:
        if chosen.only in (None, part):
            _tables(part, chosen.runs)
    if chosen.only in (None, "generated"):
        generated.report(chosen.runs)
    if chosen.only in (None, "exchange"):
        exchanging.report()
    if chosen.only in (None, "editing"):
        editing.report()
        in_the_studio.report()
    if chosen.only in (None, "first-page"):
        first_page.report()
    if chosen.only in (None, "planning"):
        planning.report()
    if chosen.only in (None, "learning"):
        learning.report()
    if chosen.only in (None, "real-time"):
        real_time.report(chosen.seconds or 60.0)
    if chosen.only in (None, "models"):
        models.report(chosen.seconds or 30.0)
    if chosen.only in (None, "scenes"):
        scenes.report()
    if chosen.only in (None, "starting"):
        starting.report()


def _emission(points: int, runs: int) -> None:
    print(f"{points:,} random poses, best of {runs} runs, a process each\n")
    print(f"{'case':<52}{'points/s':>12}{'seconds':>10}{'peak MiB':>10}")
    for case in CASES:
        best = _best(case, points, runs)
        rate = points / best["seconds"]
        print(f"{case:<52}{rate:>12,.0f}{best['seconds']:>10.2f}{best['peak']:>10.0f}", flush=True)


def _tables(part: str, runs: int) -> None:
    """A line a case and size, with its time for one target beside that of the first line."""
    for title, cases in TABLES[part].items():
        print(f"\n{title}; best of {runs} runs\n")
        head = f"{'number':>10}{'a second':>12}{'seconds':>10}{'peak MiB':>10}{'times':>8}"
        print(f"{'case':<56}{head}")
        fastest = 0.0
        for case, measured in cases.items():
            for number in measured.sizes:
                best = _best(case, number, runs)
                rate = (best["done"] or number) / best["seconds"]
                fastest = fastest or rate
                numbers = f"{rate:>12,.0f}{best['seconds']:>10.2f}{best['peak']:>10.0f}"
                times = f"{fastest / rate:>8.1f}" if measured.counted == "targets" else ""
                shown = f"{case} ({measured.counted})"
                print(f"{shown:<56}{number:>10,}{numbers}{times}", flush=True)


def _best(case: str, points: int, runs: int) -> dict[str, float]:
    return min((_in_process(case, points) for _ in range(runs)), key=lambda run: run["seconds"])


def _measured(case: str, points: int) -> dict[str, float]:
    prepare, work = EVERY[case]
    given = prepare(points)
    start = time.perf_counter()
    done = work(given)
    seconds = time.perf_counter() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {"seconds": seconds, "peak": peak, "done": done if isinstance(done, float) else 0.0}


def _in_process(case: str, points: int) -> dict[str, float]:
    command = [sys.executable, "-m", "benchmarks", "--case", case, "--points", str(points)]
    answer = subprocess.run(command, check=True, capture_output=True, text=True)
    return json.loads(answer.stdout)


if __name__ == "__main__":
    main()
