"""Timing: how long the moves of a program take, and the motion over time.

An estimate, not the planner of a controller: docs/simulating.md states the model.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.budgets import TIMING, staged
from assistant.base.diagnostics import Refused, has_errors
from assistant.program.program import Program
from assistant.robots.solved_program import SolvedProgram
from assistant.robots.timing.plan import TIME_TO_SPEED, Drive, drive_of
from assistant.robots.timing.program_walk import Walker
from assistant.robots.timing.segments import Carried, Duration, State
from assistant.robots.timing.simulation import (
    NO_PERIOD,
    MoveTimes,
    OutputTime,
    Samples,
    Simulation,
    Unknown,
)

__all__ = [
    "TIME_TO_SPEED",
    "Carried",
    "Drive",
    "Duration",
    "MoveTimes",
    "OutputTime",
    "Samples",
    "Simulation",
    "Unknown",
    "drive_of",
    "simulate",
]


@staged(TIMING, lambda solution, **_: solution.program.size())
def simulate(
    solution: SolvedProgram,
    *,
    period: float | None = None,
    acceleration: float | None = None,
    start: ArrayLike | None = None,
    drive: Drive | None = None,
    carried: Carried | None = None,
) -> Simulation:
    """Compute the duration of a solved program, and the motion of the arm while it runs.

    period: seconds between samples; None for 0.01, or longer if those would be too many.
    acceleration: largest mm/s² of the tool on lines and arcs; None if only the axes bound it.
    start: (a,) joints at the start of the program, None for home. drive: speeds and accelerations
    of the axes, None for those of the robot. carried: the bodies that the arm carries at first,
    None if they are not needed; `Segment.carried` of the segments in `passed` then states them.
    Raises Refused if the solution has errors: an unreachable target has no time.
    """
    if has_errors(solution.findings):
        raise Refused(*solution.findings)
    for what, value in (("period", period), ("acceleration", acceleration)):
        if value is not None and not 0.0 < value < np.inf:
            raise Refused(NO_PERIOD(what=what, value=value), exit_status=2)
    robot, program = solution.robot, solution.program
    begin = np.array(robot.home if start is None else start, dtype=np.float64)
    walker = Walker(solution, drive or drive_of(robot, acceleration, _load(program)))
    place = tuple(begin.tolist())
    first = State(places=(place,), known=walker.begin(), carried=carried)
    entry = program.procedure(program.entry) if program.entry else None
    done = first if entry is None else walker.procedure(entry, first, {})
    for procedure in program.procedures:
        if procedure.name not in walker.procedures:
            walker.procedure(procedure, State(carried=carried), {})
    order = [procedure.name for procedure in program.procedures]
    return Simulation(
        robot=robot,
        duration=Duration(done.least, done.most),
        procedures={name: walker.procedures[name] for name in order},
        moves=walker.ledger.move_times(order),
        outputs=walker.ledger.output_times(order),
        unknown=walker.ledger.unknown(),
        labels=walker.pieces.labels,
        history=done.history,
        passed=tuple(walker.passed),
        start=begin,
        wanted_period=period,
    )


def _load(program: Program) -> float | None:
    """Kg of the heaviest tool, None if the mass of one is not known."""
    loads = [tool.load for tool in program.tools.values()]
    known = [load.mass for load in loads if load is not None]
    return max(known, default=0.0) if len(known) == len(loads) else None
