"""The table of all tasks, their totals, and the reasons that cost most."""

from __future__ import annotations

import json
import multiprocessing
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from benchmarks.tasks.crossing import NOTHING, Crossing, crossed
from benchmarks.tasks.finding import TO, Found, found

CONTEXT: Any = multiprocessing.get_context("spawn" if sys.platform == "win32" else "fork")
"""Forked, a process has what was read to find the tasks, and the tables of the grammars."""
MOST_REASONS = 10
TOLD = 150
"""Characters of a reason in the table of them."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What is tried, and how: see `benchmarks.tasks`."""

    corpus: Path
    to: str | None = None
    task: str = ""
    proof: float = 10.0
    robot: str | None = None
    from_robot: str | None = None
    alone: bool = False
    jobs: int = 1
    limit: float = 300.0
    details: Path | None = None


def report(plan: Plan) -> None:
    """Prints each task as it is done, in order, and what all of them come to."""
    details = []
    with tempfile.TemporaryDirectory(prefix="tasks-") as work:
        tasks = [
            task
            for kind in TO
            if plan.to in (None, TO[kind])
            for task in found(plan.corpus / kind, Path(work) / kind, plan.task, alone=plan.alone)
        ]
        for kind in TO:
            of_kind = [task for task in tasks if task.kind == kind]
            if not of_kind:
                continue
            print(f"\n{kind} to {TO[kind]}: {len(of_kind)} tasks\n")
            print(f"{'said':>6}{'partly':>7}{'not':>6}  {'whole':<7}{'filled':<7}", end="")
            print(f"{'proof':<12}{'s':>6}  task")
            done = []
            for task, out in _all(of_kind, plan):
                done.append((task, out))
                print(_line(task, out), flush=True)
                details.append({"task": task.name, "files": len(task.task.files), **out})
            _totals(done)
            _reasons(done)
    if plan.details is not None:
        plan.details.write_text(json.dumps(details, indent=1), encoding="utf-8")


def _all(tasks: Sequence[Found], plan: Plan) -> Iterator[tuple[Found, dict[str, Any]]]:
    """What becomes of each task, in order; so many at a time, each in a process of its own."""
    waiting = list(enumerate(tasks))[::-1]
    running: dict[Connection, _Running] = {}
    done: dict[int, dict[str, Any]] = {}
    told = 0
    while waiting or running:
        while waiting and len(running) < plan.jobs:
            place, task = waiting.pop()
            connection, started = _started(place, task, plan)
            running[connection] = started
        soonest = min(one.until for one in running.values())
        ready = wait([*running], max(0.0, soonest - time.monotonic()))
        for connection, one in list(running.items()):
            if connection in ready or time.monotonic() >= one.until:
                done[one.place] = _ended(connection, one, plan, connection in ready)
                del running[connection]
        while told in done:
            yield tasks[told], done[told]
            told += 1


@dataclass(frozen=True, slots=True)
class _Running:
    """A process. place: of its task. until: when it is ended, on the clock of `monotonic`."""

    place: int
    process: BaseProcess
    until: float


def _started(place: int, task: Found, plan: Plan) -> tuple[Connection, _Running]:
    how = Crossing(TO[task.kind], plan.robot, plan.from_robot, plan.proof)
    ours, theirs = CONTEXT.Pipe(duplex=False)
    process = CONTEXT.Process(target=_one, args=(theirs, task, how))
    process.start()
    theirs.close()
    return ours, _Running(place, process, time.monotonic() + plan.limit)


def _one(connection: Connection, task: Found, how: Crossing) -> None:
    connection.send(crossed(task.task, how))


def _ended(connection: Connection, one: _Running, plan: Plan, answered: bool) -> dict[str, Any]:
    out = {**NOTHING, "seconds": plan.limit, "stops": [f"not done in {plan.limit:g} s"]}
    if answered:
        try:
            out = connection.recv()
        except EOFError:
            out["stops"] = ["the process ended"]
    else:
        one.process.kill()
    one.process.join()
    connection.close()
    return out


def _line(task: Found, out: dict[str, Any]) -> str:
    read = out["said"] + out["not"]
    whole, filled = (
        "whole" if out[key] else "no" if read else "-" for key in ("alone_whole", "whole")
    )
    numbers = f"{out['said']:>6}{out['partly']:>7}{out['not']:>6}"
    library = "" if task.begins else " (library)"
    lost = ""
    if not read:
        lost = f": {'; '.join(out['stops'])[:TOLD]}"
    why = f": {out['why'][0][:TOLD]}" if out.get("why") else ""
    tail = f"{_short(task.name)}{library}{lost}{why}"
    return f"{numbers}  {whole:<7}{filled:<7}{out['proof']:<12}{out['seconds']:>6.1f}  {tail}"


def _short(name: str) -> str:
    """A path without what is in its middle."""
    repository, *folders, file = name.split("/")
    return "/".join([repository, *(["…"] if len(folders) > 2 else []), *folders[-2:], file])


def _totals(done: Sequence[tuple[Found, dict[str, Any]]]) -> None:
    levels = [[out[key] for key in ("said", "partly", "not")] for _, out in done]
    print()
    for title, rows in (
        ("as they are", [out["alone"] for _, out in done]),
        ("in the neutral cell", levels),
    ):
        said, partly, no = (sum(column) for column in zip(*rows, strict=True))
        share = 100 * (said + partly) / ((said + partly + no) or 1)
        numbers = f"{said} said, {partly} partly, {no} not"
        print(f"statements, tasks {title}: {numbers}: {share:.1f} % said or partly")
    plain = sum(bool(out["alone_whole"]) for _, out in done)
    print(f"whole as they are: {plain} of {len(done)} tasks")
    whole = [(task, out) for task, out in done if out["whole"]]
    programs = [out for task, out in whole if task.begins]
    proofs = Counter(out["proof"] for out in programs)
    equal = proofs["equal"]
    percent = 100 * equal / (len(done) or 1)
    words = ", ".join(f"{count} {word}" for word, count in proofs.most_common())
    count = f"{len(whole)} of {len(done)} tasks, {len(programs)} of them programs"
    print(f"whole in the neutral cell: {count} ({words or 'none'})")
    print(f"whole and proven equal: {equal} of {len(done)} ({percent:.0f} %)")
    libraries = [task for task, _ in done if not task.begins]
    print(
        f"libraries, in which nothing is run: {len(libraries)},"
        f" {len(whole) - len(programs)} of them whole"
    )
    seconds = sorted(((out["seconds"], task.name) for task, out in done), reverse=True)
    slow = ", ".join(f"{_short(name)} {time:.0f} s" for time, name in seconds[:3])
    print(f"time: {sum(time for time, _ in seconds):.0f} s in all; slowest: {slow}")


def _reasons(done: Sequence[tuple[Found, dict[str, Any]]]) -> None:
    statements: Counter[str] = Counter()
    tasks: Counter[str] = Counter()
    only: Counter[str] = Counter()
    for _, out in done:
        statements.update(out["reasons"])
        stops = set(out["stops"]) | set(out["reasons"])
        tasks.update(stops)
        if len(stops) == 1:
            only.update(stops)
    if statements:
        print("\nby statements:   statements  tasks")
        for why, count in statements.most_common(MOST_REASONS):
            print(f"{count:>12}{tasks[why]:>7}  {why[:TOLD]}")
    if only:
        print("\nthe only hindrance of a task:   tasks")
        for why, count in only.most_common(MOST_REASONS):
            print(f"{count:>12}  {why[:TOLD]}")
