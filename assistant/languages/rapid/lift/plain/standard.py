"""The values of data that every controller has, where a program asks for their parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, Final

from assistant.languages.rapid.lift.plain.layouts import Layouts
from assistant.languages.rapid.lift.plain.scopes import predefined_type
from assistant.languages.rapid.tables.words import (
    LEAST_CENTRE,
    LEAST_MASS,
    SPEEDS,
    ZONES,
    usual_sizes,
)
from assistant.languages.rapid.tree import syntax as s

_NOWHERE: Any = [[0, 0, 0], [1, 0, 0, 0]]
_LOAD: Any = [LEAST_MASS, list(LEAST_CENTRE), [1, 0, 0, 0], 0, 0, 0]


FASTEST: Final = 10000.0
"""mm/s in the place of `vmax`, which is what the arm can: no arm's tool is faster."""


MOST: Final[Mapping[str, float]] = {"maxrobspeed": 5000.0, "maxrobreorientspeed": 500.0}
"""What functions that ask for the most of the arm are taken to give: mm/s and deg/s.

Those of `vmax` of the arms that they are usual for (3HAC050917, speeddata)."""


def most(name: str) -> s.NumberLiteral | None:
    """What a function in lower case is taken to give that asks for the most of the arm."""
    return s.NumberLiteral(f"{MOST[name]:g}") if name in MOST else None


@cache
def standard(name: str) -> s.Expression | None:
    """The value of predefined data of that name in lower case, None if it is not known here.

    Source: the instruction and data type manual (3HAC050917): tool0, wobj0, load0, speeddata,
    zonedata.
    """
    match name:
        case "tool0":
            return _node([True, _NOWHERE, _LOAD])
        case "wobj0":
            return _node([False, True, "", _NOWHERE, _NOWHERE])
        case "load0":
            return _node(_LOAD)
    speed, zone = SPEEDS.get(name), ZONES.get(name)
    if speed is not None:
        return _node([min(speed.tcp, FASTEST), 500, 5000, 1000])
    if zone is not None and zone.radius is not None:
        return _node([False, zone.radius, *usual_sizes(zone.radius)])
    return None if zone is None else _node([True, *(0,) * 6])


def _node(value: Any) -> s.Expression:
    match value:
        case bool():
            return s.BoolLiteral(value)
        case str():
            return s.StringLiteral(value)
        case list():
            return s.AggregateNode(tuple(map(_node, value)))
    return s.NumberLiteral(f"{value:g}")


def standard_part(layouts: Layouts, name: str, path: Sequence[str]) -> s.Expression | None:
    """A component of predefined data, None if its value is not known here."""
    low, type = name.lower(), predefined_type(name)
    value = None if low == "vmax" else standard(low)
    for component in path:
        names = [inner.lower() for inner, _ in layouts.components(type)]
        low = component.lower()
        if not isinstance(value, s.AggregateNode) or low not in names:
            return None
        value = value.items[names.index(low)]
        type = layouts.component(type, component) or ""
    whole = not isinstance(value, s.AggregateNode) or layouts.is_whole(type)
    return value if whole else None
