"""The motion of a simulation over time, in columns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from assistant.robots.robot import Robot
from assistant.robots.run import Floats
from assistant.robots.timing.plan import Moment, Plan
from assistant.robots.timing.way import Trace


@dataclass(frozen=True, slots=True, eq=False)
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


def samples_of(
    trace: Trace | None, seconds: float, period: float, robot: Robot, start: Floats
) -> Samples:
    """Samples of a trace from 0 to its end, the last one before the end or at it."""
    t = np.arange(int(seconds / period + 1e-9) + 1, dtype=np.float64) * period
    moments = list(_moments(trace, t, robot, start))
    columns = {
        name: np.concatenate([getattr(moment, name) for moment in moments])
        for name in Moment.__slots__
    }
    velocity = columns["velocities"]
    acceleration = np.gradient(velocity, period, axis=0) if len(t) > 1 else velocity * 0.0
    return Samples(
        t,
        columns["positions"],
        _unflipped(columns["quaternions"]),
        columns["joints"],
        columns["speeds"],
        velocity,
        acceleration,
    )


def _unflipped(quaternions: Floats) -> Floats:
    """The same rotations, each on the side of the one before it."""
    cosine = np.einsum("ij,ij->i", quaternions[1:], quaternions[:-1])
    sign = np.cumprod(np.concatenate([[1.0], np.where(cosine < 0.0, -1.0, 1.0)]))
    return np.asarray(quaternions * sign[:, None])


def _moments(trace: Trace | None, t: Floats, robot: Robot, start: Floats) -> Iterator[Moment]:
    """The samples of each plan and wait that holds any."""
    p, q = robot.fk(start[None])
    last = Moment(p, q, start[None], np.zeros(1), np.zeros((1, len(start))))
    begin, done = 0.0, 0
    for step in trace.steps() if trace is not None else ():
        end = begin + (step.seconds if isinstance(step, Plan) else step)
        until = int(np.searchsorted(t, end, side="right"))
        if isinstance(step, Plan):
            if until > done:
                yield step.at(t[done:until] - begin)
            last = step.at(np.array([step.seconds]))
        elif until > done:
            yield _still(last, until - done)
        begin, done = end, max(done, until)
    if done < len(t):
        yield _still(last, len(t) - done)


def _still(last: Moment, count: int) -> Moment:
    zero = np.zeros(count, dtype=np.intp)
    return Moment(
        last.positions[zero],
        last.quaternions[zero],
        last.joints[zero],
        np.zeros(count),
        np.zeros((count, last.joints.shape[1])),
    )
