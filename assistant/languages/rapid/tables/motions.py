"""Speeds and zones between physical values and RAPID's names and records."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from assistant.languages.rapid.tables import words
from assistant.languages.rapid.tables.words import usual_sizes
from assistant.program.expressions import Binary, Expression, Number, Truth
from assistant.program.motion import Blend, Speed
from assistant.program.passes.motions import ValueNames
from assistant.program.statements import ComputedBlend

_SPEED_NAMES: Final = {speed: name for name, speed in words.SPEEDS.items()}
_ZONE_NAMES: Final = {blend: name for name, blend in words.ZONES.items()}
SPEED_PLACES: Final = 3
FASTEST: Final = max(s.tcp for s in words.SPEEDS.values() if math.isfinite(s.tcp))

WIDEST_CHOSEN: Final = 10.0
"""mm of a corner without a size, at most: where it is known to lead along, somebody says so."""
LEAST_CHOSEN: Final = 0.3
"""mm of one at a crawl: z0."""
BRAKING: Final = 5000.0
"""mm/s², as much as arms brake by along a line: with less the way that it takes were longer."""


SPEED_PARTS: Final = ("v_tcp", "v_ori", "v_leax", "v_reax")
ZONE_SIZES: Final = (
    "pzone_tcp", "pzone_ori", "pzone_eax", "zone_ori", "zone_leax", "zone_reax"
)  # fmt: skip
"""Components of speeds, and those of zones that are no stop points (3HAC050917)."""


def speed_name(speed: Speed) -> str:
    """`v150` if predefined, else the name under which it is declared: `speed_147`."""
    first, *rest = speed_values(speed)
    usual = rest == speed_values(Speed(first))[1:]
    return _SPEED_NAMES.get(speed) or _record_name("speed", first, () if usual else rest)


def zone_name(blend: Blend) -> str:
    """`z100` or `fine` if predefined, else the name under which it is declared: `zone_2_5`."""
    return _ZONE_NAMES.get(blend) or _record_name("zone", blend.radius or 0.0, blend.details or ())


def _record_name(kind: str, first: float, more: Sequence[float]) -> str:
    """The name of a record by its values, of one with usual sizes by the first alone."""
    if not more:
        return f"{kind}_{_number_in_name(first)}"
    return f"{kind}_" + "_".join(_number_in_name(v).replace("_", "d") for v in (first, *more))


def _number_in_name(value: float) -> str:
    return f"{value:.{SPEED_PLACES}f}".rstrip("0").rstrip(".").replace(".", "_")


def speed_values(speed: Speed) -> list[float]:
    return [speed.tcp, speed.rotation, speed.external_linear, speed.external_rotary]


def zone_values(blend: Blend) -> list[float]:
    """The six sizes of a zonedata that is no stop point."""
    if blend.radius is None:
        return [0.0] * 6
    return [blend.radius, *(blend.details or usual_sizes(blend.radius))]


def speed_of(values: Sequence[float]) -> Speed:
    return Speed(*(float(v) for v in values))


def zone_of(stop: bool, values: Sequence[float]) -> Blend:
    """A zone without details if these are the usual ones of its radius."""
    if stop:
        return Blend()
    radius, a, b, c, d, e = map(float, values)
    details = (a, b, c, d, e)
    return Blend(radius, details=None if details == usual_sizes(radius) else details)


def computed_zone(stops: Expression, sizes: tuple[Expression, ...]) -> ComputedBlend:
    """A zone of six sizes that are worked out; without details if these are the usual ones."""
    radius, *details = sizes
    usual = tuple(details) == usual_details(radius)
    never = None if stops == Truth(False) else stops
    return ComputedBlend(radius, never, None if usual else tuple(details))


def usual_details(radius: Expression) -> tuple[Expression, ...]:
    """Sizes beside a radius that is worked out, in the proportion of the predefined zones."""
    length = Binary("*", radius, Number(1.5))
    angle = Binary("*", radius, Number(0.15))
    return length, length, angle, length, angle


def sayable_speed(speed: Speed) -> tuple[Speed, str | None]:
    """The speed as RAPID has it, and what was changed."""
    changed = None
    if speed.joint is not None:
        changed, speed = "a joint speed in percent", replace(speed, joint=None)
    if math.isinf(speed.tcp) and speed != Speed(math.inf):
        changed, speed = "an unlimited speed", replace(speed, tcp=FASTEST)
    rounded = [v if math.isinf(v) else round(v, SPEED_PLACES) for v in speed_values(speed)]
    return speed_of(rounded), changed


def corner_of(speed: Speed) -> float:
    """Radius in mm of a corner that the controller is to choose, for a move of that speed.

    A controller that chooses leaves the path where braking begins: v² / 2a, by BRAKING. The largest
    predefined size below that, so that the corner is never wider, and at most WIDEST_CHOSEN.
    """
    if not math.isfinite(speed.tcp):
        return WIDEST_CHOSEN
    braking = speed.tcp * speed.tcp / (2.0 * BRAKING)  # `**` would raise where that is too large
    sizes = (b.radius for b in words.ZONES.values() if b.radius and b.radius <= WIDEST_CHOSEN)
    return max((radius for radius in sizes if radius <= braking), default=LEAST_CHOSEN)


def sayable_blend(blend: Blend) -> tuple[Blend, str | None]:
    """The blend as RAPID has it, and what was changed."""
    if blend.radius is None:
        return Blend(), None
    changed = None
    radius, details = blend.radius, blend.details
    if blend.exit is not None and blend.exit != blend.radius:
        changed, radius, details = "a corner of two sizes", min(radius, blend.exit), None
    if math.isinf(radius):
        changed, radius, details = "a corner without size", LEAST_CHOSEN, None
    radius = round(radius, SPEED_PLACES)
    if details is not None:
        return zone_of(False, [radius, *(round(v, SPEED_PLACES) for v in details)]), changed
    return Blend(radius), changed


SPEEDS: Final = ValueNames("speed", words.SPEEDS, speed_name)
BLENDS: Final = ValueNames("blend", words.ZONES, zone_name)
