"""The motion of a simulation over time, in columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows
from assistant.lazy import pictured
from assistant.robots.robot import Robot
from assistant.robots.timing.plan import Moment, Plan
from assistant.robots.timing.state import History

Columns = dict[str, Floats]
"""The columns of `Moment` by name."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Samples:
    """k samples.

    t: (k,) seconds. position: (k, 3) mm and quaternion: (k, 4) of the tool that moves, in the
    base (of a work piece that the arm carries: of the tool in it). joints: (k, a).
    tcp_speed: (k,) mm/s. joint_velocity, joint_acceleration: (k, a).
    """

    t: Floats
    position: Floats
    quaternion: Floats
    joints: Floats
    tcp_speed: Floats
    joint_velocity: Floats
    joint_acceleration: Floats

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        end = float(self.t[-1]) if len(self.t) else 0.0
        return f"<Samples: {len(self)} row{'s' * (len(self) != 1)}, to {end:.2f} s>"

    def _repr_html_(self) -> str:
        return pictured(self)


def samples_of(
    history: History | None, seconds: float, period: float, robot: Robot, start: Floats
) -> Samples:
    """Samples of a history from 0 to its end, the last one before the end or at it."""
    t = np.arange(int(seconds / period + 1e-9) + 1, dtype=np.float64) * period
    columns = _rest_at(robot, start, len(t))
    if history is not None:
        _fill(columns, history, np.arange(len(t)), t, None)
    velocity = columns["velocities"]
    acceleration = np.gradient(velocity, period, axis=0) if len(t) > 1 else velocity * 0.0
    return Samples(
        t,
        columns["positions"],
        rotations.unflipped(columns["quaternions"]),
        columns["joints"],
        columns["speeds"],
        velocity,
        acceleration,
    )


def _rest_at(robot: Robot, start: Floats, count: int) -> Columns:
    """The columns of `Moment` for an arm that stands still."""
    p, q = robot.fk(start[None])
    rest = Moment(p, q, start[None], np.zeros(1), np.zeros((1, len(start))))
    return {name: np.repeat(getattr(rest, name), count, axis=0) for name in Moment.__slots__}


def _fill(columns: Columns, history: History, rows: Rows, t: Floats, last: Plan | None) -> None:
    """Fills rows (m,) with a history at times (m,) from its start; last: the plan before it.

    The rounds of a loop are filled together, so that it does not matter how many there are.
    """
    chain = history.chain()
    index = np.searchsorted([node.start for node in chain], t, side="left") - 1
    index = np.clip(index, 0, None)
    order = np.argsort(index, kind="stable")
    bounds = np.searchsorted(index[order], np.arange(len(chain) + 1))
    for at in np.unique(index):
        node, some = chain[at], order[bounds[at] : bounds[at + 1]]
        before = (node.before.last if node.before is not None else None) or last
        inside = t[some] - node.start
        if isinstance(node.done, Plan):
            _put(columns, rows[some], node.done.at(inside))
        elif not isinstance(node.done, tuple):
            if before is not None:
                _put(columns, rows[some], before.at(np.full(len(some), before.seconds)))
        else:
            inner, count = node.done
            gone = np.ceil(inside / inner.seconds) - 1.0 if inner.seconds > 0.0 else 0.0 * inside
            gone = np.clip(gone, 0.0, count - 1.0)
            inside = inside - gone * inner.seconds
            for first, came in ((True, before), (False, inner.last or before)):
                mine = (gone == 0.0) == first
                if mine.any():
                    _fill(columns, inner, rows[some[mine]], inside[mine], came)


def _put(columns: Columns, rows: Rows, moment: Moment) -> None:
    for name, column in columns.items():
        column[rows] = getattr(moment, name)
