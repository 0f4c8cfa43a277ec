"""Where along a run the turn of a tool is chosen, and what there is to choose from.

A turn is told in degrees about the tool's z axis, from a direction that is carried along the run
without turning about that axis. So a turn that stays the same does not turn the tool, however the
targets were drawn.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.program.expressions import Name
from assistant.program.motion import Kind, Speed
from assistant.robots.motion.arcs import Arcs
from assistant.robots.motion.on_the_way import MoveSampler
from assistant.robots.motion.run import Run
from assistant.robots.robot import Robot

MOST_TURN_RATE: Final = 45.0
"""degrees a second that a tool is turned by on its way at most: its tip never waits for that."""
UNKNOWN_SPEED: Final = 100.0
"""mm/s of moves whose speed only running the program tells, or which is unlimited."""
UPRIGHT: Final = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class FreeRun:
    """A run whose tool may be turned at some of its n rows.

    free: (n,) at which. positions, references: (n, 3) mm, (n, 4) of the tool in the frame, with the
    turn 0. drawn: (n,) degrees of the turn that the targets were given with. seconds: (n,) that the
    tool takes to a row, 0 of joint moves. tied: (n,) the row before with the same target, or -1.
    fixed: (n,) degrees of a turn that is settled, NaN where it is not. own: (n,) the branch that a
    row states, or -1. arcs: those of the circular moves. same: (n,) whether a row is reached with
    the tool and frame of the row before.
    """

    run: Run
    free: Truths
    positions: Floats
    references: Floats
    drawn: Floats
    seconds: Floats
    tied: Rows
    fixed: Floats
    own: Rows
    arcs: Arcs | None
    same: Truths

    def __len__(self) -> int:
        return len(self.free)

    def turned(self, rows: Rows, turns: Floats) -> Floats:
        """Quaternions (k, 4) of the tool at rows (k,) with turns (k,) in degrees."""
        return np.asarray(
            rotations.multiply(self.references[rows], rotations.about(UPRIGHT, turns))
        )


def free_run_of(
    run: Run, robot: Robot, free: Truths, keys: Rows, own: Rows, fixed: Floats
) -> FreeRun:
    """keys: (n,) numbers of the targets of the rows, -1 for one that no other row has.

    fixed: (n,) degrees from what was drawn that are settled, else NaN.
    """
    look = MoveSampler(run, robot, np.zeros((len(run), len(robot.axes))))
    positions, quaternions = run.targets(slice(0, len(run)))
    quaternions = quaternions / norms(quaternions)[:, None]
    references, drawn = _carried_along(quaternions, look.same)
    tied = np.full(len(run), -1, dtype=np.intp)
    last: dict[int, int] = {}
    for row in np.flatnonzero(keys >= 0).tolist():
        tied[row] = last.get(int(keys[row]), -1)
        last[int(keys[row])] = row
    settled = np.where(np.isnan(fixed), np.where(free, np.nan, 0.0), fixed) + drawn
    return FreeRun(
        run,
        free,
        positions,
        references,
        drawn,
        _move_seconds(run, positions, look.arcs),
        tied,
        settled,
        own,
        look.arcs,
        look.same,
    )


def _carried_along(quaternions: Floats, same: Truths) -> tuple[Floats, Floats]:
    """Quaternions (n, 4) with the z axes of others that do not turn about them, and (n,) degrees
    about z from these to the others. same: (n,) whether a row goes on from the one before.
    """
    n = len(quaternions)
    out = quaternions.copy()
    z = rotations.rotate(quaternions, np.broadcast_to(UPRIGHT, (n, 3)))
    drawn = np.zeros(n)
    tilted = np.zeros(n, dtype=bool)
    tilted[1:] = norms(np.diff(z, axis=0)) > 1e-9
    for row in range(1, n):
        if not same[row]:
            continue
        before = out[row - 1]
        if tilted[row]:
            turn = _least_turn(z[row - 1], z[row])
            if turn is None:  # the tool is turned over: no direction goes on
                continue
            before = rotations.multiply(turn, before)
        out[row] = before
    relative = rotations.multiply(rotations.conjugate(out), quaternions)
    drawn = np.degrees(2.0 * np.arctan2(relative[:, 3], relative[:, 0]))
    # The z axes are those of the targets to the last digit.
    back = rotations.about(np.broadcast_to(UPRIGHT, (n, 3)), -drawn)
    return np.asarray(rotations.multiply(quaternions, back)), (drawn + 180.0) % 360.0 - 180.0


def _least_turn(one: Floats, other: Floats) -> Floats | None:
    """The quaternion of the smallest turn from a unit vector to another; None for opposite ones."""
    w = 1.0 + float(one @ other)
    if w < 1e-9:
        return None
    quaternion = np.concatenate([[w], np.cross(one, other)])
    return np.asarray(quaternion / np.linalg.norm(quaternion))


def _move_seconds(run: Run, positions: Floats, arcs: Arcs | None) -> Floats:
    lengths = np.zeros(len(run))
    lengths[1:] = norms(np.diff(positions, axis=0))
    if arcs is not None:
        lengths[arcs.rows] = arcs.lengths
    speeds = np.array([_tcp(speed) for speed in run.pace.speeds])
    out = lengths / speeds[run.pace.speed]
    out[run.kinds == Kind.JOINT] = 0.0
    return np.asarray(out)


def _tcp(speed: Speed | Name) -> float:
    known = isinstance(speed, Speed) and 0.0 < speed.tcp < np.inf
    return speed.tcp if known and isinstance(speed, Speed) else UNKNOWN_SPEED


def stations(free_run: FreeRun, step: float) -> Rows:
    """(s,) rows at which a turn is chosen; between them it changes evenly with the time.

    step: degrees from one choice to the next.
    """
    n, kinds = len(free_run), free_run.run.kinds
    must = ~free_run.free | np.isfinite(free_run.fixed) | (kinds == Kind.JOINT) | ~free_run.same
    must[0] = must[-1] = True
    must[:-1] |= (kinds[1:] == Kind.JOINT) | ~free_run.same[1:] | ~free_run.free[1:]
    must[1:] |= ~free_run.free[:-1]
    ties = np.flatnonzero(free_run.tied >= 0)
    must[ties] = must[free_run.tied[ties]] = True
    chosen, since = [], 0.0
    for row in range(n):
        since += float(free_run.seconds[row])
        if must[row] or since * MOST_TURN_RATE >= step:
            chosen.append(row)
            since = 0.0
    return np.array(chosen, dtype=np.intp)
