"""Two programs, each run to its end by itself, and what is unlike in how they move."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.program.arrays import Floats
from assistant.program.diagnostics import Diagnostic
from assistant.studio import rules
from assistant.studio.answering import findings
from assistant.studio.motions import Columns, deviation, shown
from assistant.studio.running import Wanted
from assistant.studio.watching import Inputs
from assistant.virtual.comparing import Unlike, likeness
from assistant.virtual.events import Moved, Run
from assistant.virtual.kernel import Ending, Task
from assistant.virtual.kernel.script import follow
from assistant.virtual.running import Settings, prepared
from assistant.virtual.telling import at_place, ending
from assistant.virtual.tracing import motion_columns

LONGEST: Final = 60.0
"""Seconds that each of them may run here, where nobody can switch what it waits for."""


def compared(first: Wanted, second: Wanted) -> dict[str, Any]:
    """Both motions in columns, the greatest deviation of their paths, and the first event that is
    unlike; programs of two languages are compared by their motions alone, since each calls signals
    otherwise. Raises Refused where a program can not be run.
    """
    pair = (first, second)
    done = [_run(one) for one in pair]
    runs = [run for run, _, _ in done]
    spoken = {None if one.programs.language is None else one.programs.language.family
              for one in pair}  # fmt: skip
    same = len(spoken) == 1
    like = likeness(*(runs if same else map(_motions, runs)))
    far = deviation(done[0][1], done[1][1], (_begins(runs[0]), _begins(runs[1])))
    found = [finding for _, _, one in done for finding in one]
    if like.unlike is not None:
        found.append(_differs(like.unlike, second))
    return {
        "names": [first.programs.title, second.programs.title],
        "seconds": [run.seconds for run in runs],
        "motions": [shown(made[1], one.robot) for made, one in zip(done, pair, strict=True)],
        "deviation": None if far is None else {
            "distance": far.distance, "angle": far.angle, "time": far.time, "of": far.of,
        },
        "same": like.unlike is None,
        "visits": like.visits,
        "signals": same,
        "findings": findings(found),
    }  # fmt: skip


def _run(wanted: Wanted) -> tuple[Run, Columns, Sequence[Diagnostic]]:
    """A run, how the arm moved, and what is wrong with it."""
    settings = Settings(
        robot=wanted.robot,
        inputs=Inputs({one.name: 0.0 for one in wanted.script.changes}),
        options=wanted.script.options,
    )
    kernel = prepared(wanted.programs, settings)
    given = follow(kernel, wanted.script)
    end = time.monotonic() + LONGEST

    def watch(task: Task) -> None:
        if time.monotonic() > end:
            kernel.halt(task, Ending("time", f"more than {LONGEST:g} s of this computer"))

    kernel.watch = watch
    run = kernel.run()
    wrong = ending(run, wanted.programs.sources())
    columns = motion_columns(run, given, kernel.motion)
    return run, columns, [] if wrong is None else [wrong]


def _begins(run: Run) -> Floats:
    """(k,) seconds."""
    return np.array([row.time for row in run.log if isinstance(row.what, Moved)])


def _motions(run: Run) -> Run:
    """A run of which only the motions are told."""
    log = tuple(row for row in run.log if isinstance(row.what, Moved))
    return replace(run, log=log, events=tuple(row.what for row in log))


def _differs(unlike: Unlike, second: Wanted) -> Diagnostic:
    place = None if unlike.second is None else unlike.second.place
    return at_place(rules.RUN_DIFFERS, place, second.programs.sources(), what=unlike)
