"""The canonical text of a tree that was built and never read."""

from __future__ import annotations

import string
from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.text.layout.levels import levels
from assistant.languages.melfa_basic.text.printer import INDENT, constant, expression, line
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import (
    MOST_PLACES,
    MoveRows,
    PositionRows,
    move_text,
    places_of,
    position_text,
)


def print_items(items: Sequence[s.Item], dialect: str, newline: str) -> Iterator[str]:
    """The text of each item, with its line ends."""
    of = DIALECTS[dialect]
    for item, places, level in zip(items, decimals(items), levels(items), strict=True):
        text = item_text(item, of.upper, newline, places, level if of.blocks else 0)
        if isinstance(item, s.Line) and len(text.rstrip("\r\n").encode(errors="replace")) > of.line:
            text = item_text(item, of.upper, newline, places, 0)  # rather than too long
        yield text


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


def decimals(items: Sequence[s.Item]) -> list[int]:
    """Decimal places of each item; neighbours whose names differ in the number only have the same.

    They print every number without loss, as far as any decimals do.
    """
    places: list[int] = []
    for _, group in groupby(items, _kind):
        together = list(group)
        places += [max(map(_needed, together))] * len(together)
    return places


def _kind(item: s.Item) -> object:
    """What position lines have in common that may stand in one table."""
    match item:
        case PositionRows(stem=stem, values=values):
            return stem, values.shape[1], False, True
        case s.Data(variable=variable, value=s.Constant(values=elements, flags=flags)):
            indexed = variable.arguments is not None
            return variable.name.rstrip(string.digits), len(elements), indexed, flags is not None
    return None


def _needed(item: s.Item) -> int:
    match item:
        case PositionRows(values=values):
            return places_of(values)
        case s.Data(value=s.Constant() as value) if exact(value, MOST_PLACES):
            return places_of(np.array([v for v in value.values if v is not None], dtype=np.float64))
    return 2


def exact(value: s.Constant, places: int) -> bool:
    """Whether so many decimals print every number of a constant without loss."""
    return all(v is None or round(v, places) == v for v in value.values)
