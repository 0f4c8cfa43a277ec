"""Generated kinematics beside ours, in the same run: C that the system's compiler makes, Python."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from assistant import robots
from assistant.base.file_sets import write_files
from assistant.blocks.code import kinematics, source_identifier
from assistant.robots import Robot
from benchmarks.arms import ARMS, joints

POSES: Final = 100_000
FEW: Final = 2_000
"""Poses of the generated Python."""
TIMER: Final = """\
#define _POSIX_C_SOURCE 199309L
#include "ARM.h"
#include <stdio.h>
#include <time.h>

static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static double joints[POSES][AXES], p[POSES][3], q[POSES][4];

int main(void)
{
    double found[BRANCHES][AXES], rates[6][AXES], start, fk, ik, jacobian, sum = 0.0;
    int valid[BRANCHES], i;

    if (fread(joints, sizeof joints, 1, stdin) != 1)
        return 1;
    start = now();
    for (i = 0; i < POSES; i++)
        ARM_fk(joints[i], p[i], q[i]);
    fk = now() - start;
    start = now();
    for (i = 0; i < POSES; i++)
        sum += ARM_ik(p[i], q[i], found, valid);
    ik = now() - start;
    start = now();
    for (i = 0; i < POSES; i++) {
        ARM_jacobian(joints[i], rates);
        sum += rates[0][0];
    }
    jacobian = now() - start;
    printf("%g %g %g %g", fk / POSES, ik / POSES, jacobian / POSES, sum);
    return 0;
}
"""


def report(runs: int) -> None:
    """A line an arm and source: microseconds a pose, all branches of inverse kinematics."""
    print(f"\nGenerated kinematics, microseconds a pose; best of {runs} runs, {POSES:,} poses\n")
    print(f"{'arm':<20}{'source':<26}{'forward':>10}{'inverse':>10}{'Jacobian':>10}")
    for name in ARMS:
        for source, measured in _sources(robots.get(name), runs):
            times = "".join("" if t is None else f"{t * 1e6:>10.3f}" for t in measured)
            print(f"{name:<20}{source:<26}{times}", flush=True)


Times = tuple[float | None, ...]
"""Seconds of a pose: forward, inverse, Jacobian."""


def _sources(robot: Robot, runs: int) -> Iterator[tuple[str, Times]]:
    _, angles = joints(robot.name)(POSES)
    poses = robot.fk(angles)
    yield (
        "ours, columns at once",
        (
            _best(runs, lambda: robot.fk(angles)) / POSES,
            _best(runs, lambda: robot.ik(*poses)) / POSES,
        ),
    )
    yield "ours, a pose at a time", _one_by_one(robot, angles, runs)
    with tempfile.TemporaryDirectory() as folder:
        yield "generated Python", _python(robot, angles, Path(folder), runs)
        if shutil.which("cc") is None:
            print("(no C compiler here)")
            return
        yield "generated C (cc -O2)", _c(robot, angles, Path(folder), runs)


def _best(runs: int, work: Callable[[], Any]) -> float:
    """Seconds."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def _one_by_one(robot: Robot, angles: np.ndarray, runs: int) -> Times:
    some = angles[:FEW]
    p, q = robot.fk(some)
    forward = _best(runs, lambda: [robot.fk(row) for row in some])
    inverse = _best(runs, lambda: [robot.ik(*pose) for pose in zip(p, q, strict=True)])
    return forward / FEW, inverse / FEW


def _python(robot: Robot, angles: np.ndarray, folder: Path, runs: int) -> Times:
    stem = source_identifier(robot.name)
    write_files(kinematics(robot, "python"), folder)
    spec = importlib.util.spec_from_file_location(stem, folder / f"{stem}.py")
    assert spec is not None and spec.loader is not None
    arm = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(arm)
    some = angles[:FEW].tolist()
    poses = [arm.fk(row) for row in some]
    forward = _best(runs, lambda: [arm.fk(row) for row in some])
    inverse = _best(runs, lambda: [arm.ik(*pose) for pose in poses])
    jacobian = _best(runs, lambda: [arm.jacobian(row) for row in some])
    return forward / FEW, inverse / FEW, jacobian / FEW


def _c(robot: Robot, angles: np.ndarray, folder: Path, runs: int) -> Times:
    stem = source_identifier(robot.name)
    write_files(kinematics(robot, "c"), folder)
    text = TIMER.replace("ARM", stem).replace("POSES", str(POSES))
    text = text.replace("AXES", str(len(robot.axes))).replace("BRANCHES", str(robot.branches))
    (folder / "timer.c").write_text(text)
    words = ["cc", "-std=c99", "-O2", f"{stem}.c", "timer.c", "-lm", "-o", "timer"]
    subprocess.run(words, cwd=folder, check=True)
    given = np.ascontiguousarray(angles).tobytes()
    found = [
        subprocess.run(["./timer"], cwd=folder, input=given, capture_output=True, check=True).stdout
        for _ in range(runs)
    ]
    times = np.array([[float(word) for word in line.split()[:3]] for line in found])
    forward, inverse, jacobian = times.min(axis=0).tolist()
    return forward, inverse, jacobian
