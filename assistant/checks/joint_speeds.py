"""Joints that would have to turn faster than they can at the programmed speed of the TCP."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Truths
from assistant.base.diagnostics import Diagnostic, warning
from assistant.checks.moves import Moves
from assistant.checks.views import ProgramView, RunView, figure

SPEED_TOLERANCE: Final = 1.02
"""By how much a joint may be too fast: rounding of speeds and limits in data sheets."""
SHORTEST_RUN_UP: Final = 0.1
"""seconds between two stops below which no joint gets to its full speed. The maker's own planning
of the FR robots (melfa_ros2_driver) lets an axis take about 0.05 s to get there and as much to
stop."""

TOO_FAST: Final = warning(
    "CK311",
    "{axis} would have to move at {needed:.0f} {unit}/s, its limit is {limit:g}, to keep the "
    "programmed {programmed}{worst}",
    "the robot runs slower there or stops; {possible} is possible",
)


def joint_speeds(view: ProgramView) -> Iterator[Diagnostic]:
    robot = view.robot
    for run_view in view.run_views:
        moves, extremes = run_view.moves, run_view.extremes
        if not len(moves):
            continue
        with np.errstate(invalid="ignore", divide="ignore"):
            ratio = extremes.seconds / run_view.seconds
            stated = (
                np.isfinite(moves.tcp) & np.isfinite(run_view.seconds) & (run_view.seconds > 0.0)
            )
        stated &= ~extremes.crossed & (_between_stops(run_view) >= SHORTEST_RUN_UP)
        fast = np.flatnonzero(stated & (ratio > SPEED_TOLERANCE))
        for group, worst in run_view.groups(moves.rows[fast], ratio[fast]):
            at = int(fast[worst])
            axis = int(extremes.axis[at])
            yield run_view.told(
                TOO_FAST,
                group,
                int(moves.rows[at]),
                axis=robot.axes[axis],
                unit=robot.units[axis],
                needed=robot.speeds[axis] * ratio[at],
                limit=robot.speeds[axis],
                programmed=_speed_text(moves, at, float(run_view.seconds[at])),
                possible=_speed_text(moves, at, float(extremes.seconds[at])),
            )


def _speed_text(moves: Moves, at: int, seconds: float) -> str:
    """How fast a move is that takes so long, of the TCP, or of a turn on the spot."""
    length, turn = float(moves.length[at]), float(moves.turn[at])
    if length / moves.tcp[at] >= turn / moves.rotation[at]:
        return f"{figure(length / seconds)} mm/s"
    return f"{figure(turn / seconds)} degrees/s of reorientation"


def _between_stops(run_view: RunView) -> Floats:
    """(m,) seconds that the joints need from the stop before a move to the one after it."""
    moves = run_view.moves
    needed = np.fmax(run_view.seconds, run_view.extremes.seconds)
    begins, ends = moves.through
    joined = np.append(False, ends[:-1] & begins[1:] & (moves.rows[:-1] == moves.starts[1:]))
    chain = np.cumsum(~joined) - 1
    whole = np.bincount(chain, np.nan_to_num(needed, posinf=0.0), minlength=1)
    # A corner into or out of what is no such move is passed at an unknown, maybe full speed.
    open_ = (
        np.bincount(
            chain, (begins | ends) & ~_between_known_moves(joined, begins, ends), minlength=1
        )
        > 0
    )
    return np.asarray(np.where(open_, np.inf, whole)[chain], dtype=np.float64)


def _between_known_moves(joined: Truths, begins: Truths, ends: Truths) -> Truths:
    """(m,) whether the corners at both ends of a move lead to other moves that are known."""
    after = np.append(joined[1:], False)
    return np.asarray((joined | ~begins) & (after | ~ends))
