"""Two programs compared, and how the arm moves in each."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic
from assistant.compiler.comparison import Comparison, compare
from assistant.compiler.motion_proof import Proving
from assistant.studio.answering import finding_records
from assistant.studio.motions import MotionColumns, path_deviation, shown_motion
from assistant.studio.running import RunRequest
from assistant.studio.watching import WatchedInputs
from assistant.virtual.events import Moved, Run
from assistant.virtual.kernel import Ending, Task
from assistant.virtual.kernel.script import follow
from assistant.virtual.program_run import Settings, prepared
from assistant.virtual.run_log import end_finding, motion_columns

LONGEST_RUN: Final = 60.0
"""Seconds that each of them may run here, where nobody can switch what it waits for."""


def compare_files(first: RunRequest, second: RunRequest, script: str) -> Comparison:
    """Compare two files of the project as `compare` does. script: drives both; empty for none.

    Raises Unreadable or Refused where they cannot be compared at all.
    """
    return compare(
        first.path,
        second.path,
        robot=second.robot,
        from_robot=first.robot,
        proving=Proving(script=FilePath(script) if script else None),
    )


def compared_motions(first: RunRequest, second: RunRequest) -> dict[str, Any]:
    """Both motions in columns, and the greatest deviation of their paths. Raises Refused where a
    program cannot be run.
    """
    pair = (first, second)
    done = [_run_program(one) for one in pair]
    runs = [run for run, _, _ in done]
    far = path_deviation(done[0][1], done[1][1], (_start_times(runs[0]), _start_times(runs[1])))
    found = [finding for _, _, one in done for finding in one]
    return {
        "names": [first.programs.title, second.programs.title],
        "seconds": [run.seconds for run in runs],
        "motions": [shown_motion(made[1], one.robot) for made, one in zip(done, pair, strict=True)],
        "deviation": None if far is None else {
            "distance": far.distance, "angle": far.angle, "time": far.time, "of": far.of,
        },
        "findings": finding_records(found),
    }  # fmt: skip


def _run_program(wanted: RunRequest) -> tuple[Run, MotionColumns, Sequence[Diagnostic]]:
    """A run, how the arm moved, and what is wrong with it."""
    settings = Settings(
        robot=wanted.robot,
        inputs=WatchedInputs({one.name: 0.0 for one in wanted.script.changes}),
        options=wanted.script.options,
    )
    kernel = prepared(wanted.programs, settings)
    given = follow(kernel, wanted.script, wanted.programs.sources())
    end = time.monotonic() + LONGEST_RUN

    def watch(task: Task) -> None:
        if time.monotonic() > end:
            kernel.halt(task, Ending("time", f"more than {LONGEST_RUN:g} s of this computer"))

    kernel.watch = watch
    run = kernel.run()
    wrong = end_finding(run, wanted.programs.sources())
    columns = motion_columns(run, given, kernel.motion)
    return run, columns, [] if wrong is None else [wrong]


def _start_times(run: Run) -> Floats:
    """(k,) seconds."""
    return np.array([row.time for row in run.log if isinstance(row.what, Moved)])
