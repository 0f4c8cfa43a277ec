"""What Print# writes and Input# reads: numbers, texts, positions and joints as ASCII.

COSIROP: PRINT, INPUT, OPEN. A position is `(x,y,z,a,b,c)(fl1,fl2)` in mm and degrees, joints are
`(j1,...)` in degrees.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Final

from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.stops import Failed, Unknown
from assistant.virtual.melfa.values import Elements, Joints, Kind, Position, Value, eight, number

ALL_DIGITS: Final = 10_000_000
"""From here on seven digits are not enough for the whole part of a number."""

# ------------------------------------------------------------------------------------ writing


def record_text(value: Value, options: Options) -> str:
    """One item of Print#."""
    match value:
        case str():
            return value
        case Position(values, (one, two)):
            if one is None or two is None:
                raise Unknown("the flags of a position that is printed")
            return f"{_bracket_text(values, options)}({one},{two})"
        case Joints(values):
            return _bracket_text(values, options)
        case int() | float():
            return _number_record(number(value), options)
    raise Unknown("how Print # writes a constant that may be a position or joints")


def _number_record(value: float, options: Options) -> str:
    if not math.isfinite(value):
        raise Unknown("a number that is not finite")
    if abs(value) >= ALL_DIGITS:
        return f"{value:.0f}"
    made = f"{value:.{options.printed}g}"
    return made if "e" not in made else f"{value:.12f}".rstrip("0").rstrip(".")


def _bracket_text(values: Elements, options: Options) -> str:
    """Elements up to the last one that is defined."""
    count = max((i + 1 for i, v in enumerate(values) if v is not None), default=0)
    made = ("" if v is None else f"{v + 0.0:.{options.places}f}" for v in values[:count])
    return f"({','.join(made)})"


def padded_text(text: str, width: int) -> str:
    """Up to the next column that items begin in."""
    return text + " " * (-len(text) % width)


# ------------------------------------------------------------------------------------ reading

_ITEM: Final = re.compile(r"(?:\([^()]*\)|[^,()])*")
_POSITION_ITEM: Final = re.compile(r"\s*\(([^()]*)\)\s*(?:\(([^()]*)\))?\s*")


def record_items(line: str) -> Iterator[str]:
    """What stands between commas outside of brackets."""
    at = 0
    while True:
        found = _ITEM.match(line, at)
        assert found is not None
        end = found.end()
        if end < len(line) and line[end] != ",":
            end = len(line)  # a bracket that nothing closes
        yield line[at:end]
        if end >= len(line):
            return
        at = end + 1


def record_value(item: str, kind: Kind) -> Value:
    """An item for a variable of a type; error 3500 if it is of another one."""
    match kind:
        case "text":
            return item
        case "position" | "joints":
            return _position_value(item, kind)
    return _plain_number(item, item)


def _plain_number(text: str, item: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise Failed(3500, f"`{item}` is not of the type of its variable")
    return value


def _position_value(item: str, kind: Kind) -> Value:
    found = _POSITION_ITEM.fullmatch(item)
    if found is None or (kind == "joints" and found[2] is not None):
        raise Failed(3500, f"`{item}` is no {kind}")
    parts = [part.strip() for part in found[1].split(",")]
    values = eight(tuple(_plain_number(part, item) if part else None for part in parts))
    if kind == "joints":
        return Joints(values)
    if found[2] is None:
        raise Unknown("a position without flags that comes over a line")
    flags = [part.strip().rstrip(".") for part in found[2].split(",")]
    if len(flags) != 2:
        raise Unknown("a position with other than two flags that comes over a line")
    one, two = (_plain_number(flag, item) for flag in flags)
    return Position(values, (int(one), int(two)))
