"""Cooling: how shares and widths become smaller as a map learns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from assistant.learning.maps.extended_map import Pace


@dataclass(frozen=True, slots=True)
class Cooling:
    """From the first pace to the last one in so many steps, and the last one from there on.

    Each number goes down by the same part of itself at each step, as in the source of the map.
    """

    first: Pace
    last: Pace
    steps: int

    def at(self, step: int) -> Pace:
        part = min(step / self.steps, 1.0) if self.steps else 1.0

        def now(name: str) -> float:
            begin, end = float(getattr(self.first, name)), float(getattr(self.last, name))
            return begin * (end / begin) ** part if begin else end

        return Pace(
            now("place"),
            now("place_width"),
            now("answer"),
            now("answer_width"),
            now("noise"),
        )


FIRST: Final = Pace(1.0, 1.5, 0.9, 1.2)
LAST: Final = Pace(0.02, 0.15, 0.3, 0.15)
"""By trial on three and five joints: other widths do as well, shares that stay large do not."""
AGAIN: Final = Pace(0.02, 0.15, 0.9, 0.5)
"""From which a map cools that goes on learning after something has changed."""


def learning(steps: int, noise: float = 0.0) -> Cooling:
    """Of a map that begins. noise: pixels."""
    return _noisy(FIRST, LAST, steps, noise)


def learning_again(steps: int, noise: float = 0.0) -> Cooling:
    """Of a map that has learnt, and whose arm or cameras have changed."""
    return _noisy(AGAIN, LAST, steps, noise)


def in_use(noise: float = 0.0) -> Pace:
    """Of a map that learns from what it is used for."""
    return _noisy(AGAIN, LAST, 0, noise).last


def _noisy(first: Pace, last: Pace, steps: int, noise: float) -> Cooling:
    def with_noise(pace: Pace) -> Pace:
        return Pace(pace.place, pace.place_width, pace.answer, pace.answer_width, noise)

    return Cooling(with_noise(first), with_noise(last), steps)
