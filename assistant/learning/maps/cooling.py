"""Cooling: how shares and widths become smaller as a map learns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from assistant.learning.maps.extended_map import LearningRates


@dataclass(frozen=True, slots=True)
class Cooling:
    """From the first pace to the last one in so many steps, and the last one from there on.

    Each number goes down by the same part of itself at each step, as in the source of the map.
    """

    first: LearningRates
    last: LearningRates
    steps: int

    def at(self, step: int) -> LearningRates:
        part = min(step / self.steps, 1.0) if self.steps else 1.0

        def now(name: str) -> float:
            begin, end = float(getattr(self.first, name)), float(getattr(self.last, name))
            return begin * (end / begin) ** part if begin else end

        return LearningRates(
            now("place"),
            now("place_width"),
            now("answer"),
            now("answer_width"),
            now("noise"),
        )


FIRST_RATES: Final = LearningRates(1.0, 1.5, 0.9, 1.2)
LAST_RATES: Final = LearningRates(0.02, 0.15, 0.3, 0.15)
"""By trial on three and five joints: other widths do as well, shares that stay large do not."""
RELEARNING_RATES: Final = LearningRates(0.02, 0.15, 0.9, 0.5)
"""From which a map cools that goes on learning after something has changed."""


def first_cooling(steps: int, noise: float = 0.0) -> Cooling:
    """Of a map that begins. noise: pixels."""
    return _cooling_with_noise(FIRST_RATES, LAST_RATES, steps, noise)


def relearning_cooling(steps: int, noise: float = 0.0) -> Cooling:
    """Of a map that has learnt, and whose arm or cameras have changed."""
    return _cooling_with_noise(RELEARNING_RATES, LAST_RATES, steps, noise)


def rates_in_use(noise: float = 0.0) -> LearningRates:
    """Of a map that learns from what it is used for."""
    return _cooling_with_noise(RELEARNING_RATES, LAST_RATES, 0, noise).last


def _cooling_with_noise(
    first: LearningRates, last: LearningRates, steps: int, noise: float
) -> Cooling:
    def with_noise(pace: LearningRates) -> LearningRates:
        return LearningRates(pace.place, pace.place_width, pace.answer, pace.answer_width, noise)

    return Cooling(with_noise(first), with_noise(last), steps)
