"""What a run did over time, in columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.virtual.events import Logged, Switched
from assistant.virtual.motion.timed import Timed

PERIOD: Final = 0.01
"""Seconds between samples."""
MOST_SAMPLES: Final = 1_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """k samples. t: (k,) seconds. position: (k, 3) mm and quaternion: (k, 4) of the tool in the
    base. joints: (k, a) degrees. speed: (k,) mm/s of the tool. signals: (k, s) what the outputs
    were set to, 0 before, by their names.
    """

    t: Floats
    position: Floats
    quaternion: Floats
    joints: Floats
    speed: Floats
    signals: Floats
    names: tuple[str, ...]

    def columns(self) -> dict[str, np.ndarray]:
        """By name, as a file holds them."""
        found = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "names"}
        return {**found, "signal_names": np.array(self.names, dtype=np.str_)}


def track_of(motion: Timed, log: Sequence[Logged], seconds: float, period: float = PERIOD) -> Track:
    """Samples from 0 to the end of a run, farther apart where there would be too many.

    seconds: that the run took.
    """
    period = max(period, seconds / MOST_SAMPLES)
    t = np.arange(int(seconds / period + 1e-9) + 1, dtype=np.float64) * period
    legs = motion.done()
    begins = np.array([leg.begin for leg in legs])
    index = np.searchsorted(begins, t, side="right") - 1
    p, q = motion.robot.fk(motion.home[None])
    position, quaternion = np.repeat(p, len(t), axis=0), np.repeat(q, len(t), axis=0)
    joints = np.repeat(motion.home[None], len(t), axis=0)
    speed = np.zeros(len(t))
    for at in np.unique(index[index >= 0]):
        leg, rows = legs[at], np.flatnonzero(index == at)
        inside = leg.first + t[rows] - leg.begin
        found = leg.plan.at(np.minimum(inside, leg.last))
        position[rows], quaternion[rows], joints[rows] = (
            *(found.positions, found.quaternions, found.joints),
        )
        speed[rows] = np.where(inside < leg.last, found.speeds, 0.0)
    names, signals = _signal_samples(log, t)
    quaternion = rotations.unflipped(quaternion)
    return Track(t, position, quaternion, joints, speed, signals, names)


def _signal_samples(log: Sequence[Logged], t: Floats) -> tuple[tuple[str, ...], Floats]:
    changes = [(row.time, row.what) for row in log if isinstance(row.what, Switched)]
    names = tuple(dict.fromkeys(what.signal for _, what in changes))
    signals = np.zeros((len(t), len(names)))
    for time, what in changes:
        signals[np.searchsorted(t, time - 1e-9) :, names.index(what.signal)] = what.value
    return names, signals
