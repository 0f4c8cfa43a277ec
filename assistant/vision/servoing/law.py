"""What a law of servoing is told, and what it says: features or poses → how the tool is to move.

A law knows neither the arm nor the way that leads there. It gives a `Task`: what is still wrong,
and how that changes by the twist of the flange. Who leads the arm makes it 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Protocol

import numpy as np

from assistant.base.arrays import Floats
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera

ARM_LENGTH: Final = 100.0
"""mm by which a turn is weighed against a way: one degree as 1.7 mm."""


@dataclass(frozen=True, slots=True, eq=False)
class TargetSighting:
    """What was seen at one moment. seconds: when the pictures were taken, of the clock of the loop;
    those of several cameras have the time of the oldest. number: of the picture.

    target, mark: camera → (n, 2) pixels of the points of the thing that is led to, and of what the
    tool carries; NaN for what is not seen.
    """

    seconds: float
    number: int
    target: Mapping[str, Floats] = field(default_factory=dict)
    mark: Mapping[str, Floats] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class ServoMoment:
    """A sight, with the cameras where they stand in the base then, and the flange there."""

    cameras: Sequence[Camera]
    sight: TargetSighting
    flange: Pose


@dataclass(frozen=True, slots=True, eq=False)
class ServoTask:
    """error: (m,) what is to become 0. slopes: (m, 6) its change by the twist of the flange, of its
    point in the axes of the base, mm/s and rad/s. rank: how many of the six it tells.

    pixels: of the error, root mean square, NaN for a law that does not go by them. distance, turn:
    mm and degrees that are left, NaN where that is not told.
    """

    error: Floats
    slopes: Floats
    rank: int
    pixels: float = np.nan
    distance: float = np.nan
    turn: float = np.nan

    @property
    def size(self) -> float:
        """Of what is left, in a unit that stays the same for a law: to see whether it grows."""
        if np.isfinite(self.pixels):
            return self.pixels
        turn = 0.0 if np.isnan(self.turn) else np.radians(self.turn)
        return float(self.distance + ARM_LENGTH * turn)

    @property
    def condition(self) -> float:
        """How much worse the worst direction that it should tell is told than the best one.

        Turns are weighed by `ARM_LENGTH`.
        """
        scaled = self.slopes / np.array([1.0] * 3 + [ARM_LENGTH] * 3)
        values = np.linalg.svd(scaled, compute_uv=False)
        if len(values) < self.rank or not values[self.rank - 1] > 0.0:
            return float("inf")
        return float(values[0] / values[self.rank - 1])


class ControlLaw(Protocol):
    """Made for one servoing: it may remember what it saw before."""

    def task(self, moment: ServoMoment) -> ServoTask | str:
        """What is to be done, or in words why that cannot be told: then it counts as not seen."""

    def forget(self) -> None:
        """What was seen before is of another time."""
