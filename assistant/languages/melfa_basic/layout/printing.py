"""The canonical text of a tree that was built and never read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.columnar import (
    MOST_PLACES,
    MoveRows,
    PositionRows,
    move_text,
    places_of,
    position_text,
)
from assistant.languages.melfa_basic.dialects import DIALECTS
from assistant.languages.melfa_basic.layout.levels import Levels
from assistant.languages.melfa_basic.printer import INDENT, constant, expression, line


def print_items(items: Sequence[s.Item], dialect: str, newline: str) -> Iterator[str]:
    """The text of each item, with its line ends."""
    of = DIALECTS[dialect]
    places, levels = decimals(items), Levels()
    for item in items:
        level = levels.of(item) if isinstance(item, s.Line) else levels.inside
        yield item_text(item, of.upper, newline, places, level if of.blocks else 0)


def item_text(item: s.Item, upper: bool, newline: str, places: int, level: int) -> str:
    """An item with its line ends. places: decimals of position lines."""
    match item:
        case PositionRows():
            return position_text(item, newline.encode("ascii"), places)
        case MoveRows():
            return move_text(item, newline.encode("ascii"), upper, INDENT * level)
        case s.Line():
            return line(item, upper, level) + newline
        case s.Data():
            return _data(item, upper, places) + newline
        case s.Unread():
            return item.text + newline
        case s.Blank():
            return newline


def _data(item: s.Data, upper: bool, places: int) -> str:
    declared = f"Def {item.type} " if item.type else ""
    value = item.value
    text = constant(value, places) if isinstance(value, s.Constant) else expression(value)
    return f"{declared.upper() if upper else declared}{expression(item.variable)}={text}"


def decimals(items: Sequence[s.Item]) -> int:
    """Decimal places that print every position line without loss, as far as any number does."""
    most = 2
    for item in items:
        match item:
            case PositionRows(values=values):
                most = max(most, places_of(values, most))
            case s.Data(value=s.Constant() as value):
                known = np.array([v for v in value.values if v is not None], dtype=np.float64)
                places = places_of(known, most)
                if places < MOST_PLACES or exact(value, MOST_PLACES):
                    most = max(most, places)
    return most


def exact(value: s.Constant, places: int) -> bool:
    """Whether so many decimals print every number of a constant without loss."""
    return all(v is None or round(v, places) == v for v in value.values)
