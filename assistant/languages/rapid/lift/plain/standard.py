"""The values of data that every controller has, where a program asks for their parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, Final

from assistant.languages.rapid.lift.plain.layouts import RecordLayouts
from assistant.languages.rapid.lift.plain.scopes import predefined_type
from assistant.languages.rapid.tables.words import (
    LEAST_CENTRE,
    LEAST_MASS,
    SPEEDS,
    ZONES,
    usual_sizes,
)
from assistant.languages.rapid.tree import syntax as s

_BASE_POSE: Any = [[0, 0, 0], [1, 0, 0, 0]]
_LEAST_LOAD: Any = [LEAST_MASS, list(LEAST_CENTRE), [1, 0, 0, 0], 0, 0, 0]


VMAX_SPEED: Final = 10000.0
"""mm/s in the place of `vmax`, which is what the arm can: no arm's tool is faster."""


ARM_MAXIMA: Final[Mapping[str, float]] = {"maxrobspeed": 5000.0, "maxrobreorientspeed": 500.0}
"""What functions that ask for the most of the arm are taken to give: mm/s and deg/s.

Those of `vmax` of the arms that they are usual for (3HAC050917, speeddata)."""


def arm_maximum(name: str) -> s.NumberLiteral | None:
    """What a function in lower case is taken to give that asks for the most of the arm."""
    return s.NumberLiteral(f"{ARM_MAXIMA[name]:g}") if name in ARM_MAXIMA else None


@cache
def predefined_value(name: str) -> s.Expression | None:
    """The value of predefined data of that name in lower case, None if it is not known here.

    Source: the instruction and data type manual (3HAC050917): tool0, wobj0, load0, speeddata,
    zonedata.
    """
    match name:
        case "tool0":
            return _literal([True, _BASE_POSE, _LEAST_LOAD])
        case "wobj0":
            return _literal([False, True, "", _BASE_POSE, _BASE_POSE])
        case "load0":
            return _literal(_LEAST_LOAD)
    speed, zone = SPEEDS.get(name), ZONES.get(name)
    if speed is not None:
        return _literal([min(speed.tcp, VMAX_SPEED), 500, 5000, 1000])
    if zone is not None and zone.radius is not None:
        return _literal([False, zone.radius, *usual_sizes(zone.radius)])
    return None if zone is None else _literal([True, *(0,) * 6])


def _literal(value: Any) -> s.Expression:
    match value:
        case bool():
            return s.BoolLiteral(value)
        case str():
            return s.StringLiteral(value)
        case list():
            return s.AggregateNode(tuple(map(_literal, value)))
    return s.NumberLiteral(f"{value:g}")


def predefined_component(
    layouts: RecordLayouts, name: str, path: Sequence[str]
) -> s.Expression | None:
    """A component of predefined data, None if its value is not known here."""
    low, type = name.lower(), predefined_type(name)
    value = None if low == "vmax" else predefined_value(low)
    for component in path:
        names = [inner.lower() for inner, _ in layouts.components(type)]
        low = component.lower()
        if not isinstance(value, s.AggregateNode) or low not in names:
            return None
        value = value.items[names.index(low)]
        type = layouts.component(type, component) or ""
    whole = not isinstance(value, s.AggregateNode) or layouts.is_whole(type)
    return value if whole else None
