"""Speed and blend of a move, in physical units."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from assistant.program.expressions import Expression, Name, Number


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

USUAL_ROTATION: Final = Number(500)
USUAL_LINEAR: Final = Number(5000)
USUAL_ROTARY: Final = Number(1000)
"""What a speed states of more than the tool's tip, unless it says otherwise; see `Speed`."""


@dataclass(frozen=True, slots=True)
class ComputedSpeed:
    """A speed that is worked out where its move begins; the parts are those of `Speed`.

    tcp: None for the robot's own maximum.
    """

    tcp: Expression | None
    rotation: Expression = USUAL_ROTATION
    external_linear: Expression = USUAL_LINEAR
    external_rotary: Expression = USUAL_ROTARY
    joint: Expression | None = None


@dataclass(frozen=True, slots=True)
class ComputedBlend:
    """A blend that is worked out where its move begins.

    radius: mm, see `Blend`. stops: whether the move ends exactly at its target instead, None for
    never. details: see `Blend`, None for the usual ones of the radius.
    """

    radius: Expression
    stops: Expression | None = None
    details: tuple[Expression, ...] | None = None


COMPUTED: Final = Name("")
"""Stands for a speed or blend of which only the running program knows the value."""
