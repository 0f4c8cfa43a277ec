"""Several tasks of one controller, run together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from assistant.languages.rapid.tree import syntax as s
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.virtual.events import Run
from assistant.virtual.kernel import MOST_STEPS, Board, Kernel, Motion, Signals
from assistant.virtual.kernel.motion import Instant
from assistant.virtual.kernel.script import Script, follow
from assistant.virtual.rapid.controller import Controller, Kind
from assistant.virtual.rapid.running import Inputs, start_task
from assistant.virtual.running import BUSY_TIME

STATEMENT_TIME: Final = 0.0001
"""Seconds that a statement may be taken to last in a run with motions that take time: a guess, for
no reference at hand states a figure. The controllers vary with their load.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskProgram:
    """modules: parsed. kind, moves: see `start_task`."""

    name: str
    modules: Sequence[s.File]
    kind: Kind = "normal"
    entry: str = "main"
    moves: bool | None = None


def run_tasks(
    tasks: Sequence[TaskProgram],
    inputs: Inputs | None = None,
    robot: Robot | None = None,
    *,
    motion: Motion | None = None,
    script: Script | None = None,
    statement_time: float = 0.0,
    pace: float | None = None,
    most_steps: int = MOST_STEPS,
    most_time: float = math.inf,
    start: Pose | None = None,
    controller: Controller | None = None,
) -> Run:
    """Runs one cycle of the normal tasks, and the others again and again until those have ended.

    inputs, robot, start, controller: as `run` has them. motion: how the arm follows, None where
    motions take no time. script: inputs that change and answers to what programs ask.
    statement_time: seconds that each statement takes, see `STATEMENT_TIME`. pace, most_time: of
    the simulated clock, see `Kernel`.
    """
    happens = script or Script()
    if inputs is None:
        inputs = dict.fromkeys((change.name for change in happens.changes), 0.0)
    kernel = Kernel(
        Board(Signals(inputs)),
        motion=motion or Instant(),
        most_steps=most_steps,
        most_time=most_time,
        statement_time=statement_time,
        busy_time=BUSY_TIME,
        pace=pace,
    )
    shared = controller or Controller()
    for task in tasks:
        start_task(
            kernel,
            task.modules,
            name=task.name,
            robot=robot,
            entry=task.entry,
            start=start,
            controller=shared,
            kind=task.kind,
            moves=task.moves,
        )
    sources = [tree.source for task in tasks for tree in task.modules if tree.source is not None]
    follow(kernel, happens, sources)
    return kernel.run()
