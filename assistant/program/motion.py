"""Speed and blend of a move, in physical units."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Speed:
    """Speed of a move.

    tcp: mm/s along the path; infinite for the robot's own maximum.
    rotation: deg/s of reorientation. external_linear, external_rotary: mm/s and deg/s of
    external axes. joint: percent of the joints' maximum in a joint move, None if not stated.
    The defaults are those of every predefined RAPID speed.
    """

    tcp: float
    rotation: float = 500.0
    external_linear: float = 5000.0
    external_rotary: float = 1000.0
    joint: float | None = None


MAXIMUM_SPEED: Final = Speed(math.inf)


@dataclass(frozen=True, slots=True)
class Blend:
    """Corner rounding at a target.

    radius: mm before the target at which the path may leave it; None stops there exactly,
    infinite leaves the corner to the controller. exit: mm after the target at which the
    path is back, None for the same as radius. details: further zone sizes as RAPID's
    zonedata gives them (reorientation mm, external mm, reorientation deg, external linear
    mm, external rotary deg), None for the usual ones of the radius.
    """

    radius: float | None = None
    exit: float | None = None
    details: tuple[float, float, float, float, float] | None = None

    @property
    def fine(self) -> bool:
        return self.radius is None


FINE: Final = Blend()
FULL_BLEND: Final = Blend(math.inf)
