"""Pallets whose corners never change: grids of targets that are known beforehand.

    Def Plt 1,PS,PA,PB,PD,4,3,2
    Mov (Plt 1,MK)

becomes an array of 12 targets and a move to one of its elements.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from assistant.languages.melfa_basic.lift.values.symbols import Symbols, Unliftable
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.positions import target_of
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.constructions import along_arc
from assistant.program.constructions import grid as points_of_grid
from assistant.program.geometry import Target
from assistant.program.program import Variable
from assistant.program.rewriting import records

MOST_POINTS: Final = 999
"""Elements that an array may have."""
ZIGZAG, SAME_WAY, ARC = 1, 2, 3
"""Directions: every other row runs backwards, or none does; places on an arc."""
FIXED: Final = 10
"""Added to a direction whose places all have the posture of the start (CR1D 4-190)."""
KEPT: Final = p.Reason(
    "the points of the pallet are not known beforehand, turn, or stand in no plain grid",
    "give corners of one orientation that the program never sets",
)
_MENTIONED: Final = re.compile(r"\bPlt\b", re.IGNORECASE)


def pallets(code: Sequence[s.Entry], symbols: Symbols) -> dict[int, tuple[str, tuple[Target, ...]]]:
    """The array of each pallet that has one definition and corners that stay, by its number."""
    found: dict[int, list[s.DefOther]] = {}
    for item in code:
        if isinstance(item.statement, s.DefOther) and item.statement.kind == "Plt":
            number = symbols.constants.value(item.statement.arguments[0])
            if not isinstance(number, float):
                return {}
            found.setdefault(round(number), []).append(item.statement)
    made = {}
    for key, definitions in found.items():
        points = grid(definitions[0], symbols) if len(definitions) == 1 else None
        if points is not None:
            made[key] = symbols.free(array_name(key)), points
    return made


def array_name(number: float) -> str:
    """What the array of a pallet is called, if nothing else has that name."""
    return f"pallet_{number:g}"


def grid(node: s.DefOther, symbols: Symbols) -> tuple[Target, ...] | None:
    """The targets of a pallet in their order; None if they are not known or turn.

    Start S, end of the first row A, end of the first column B, and the corner D across, which
    makes it bilinear; of an arc its start, a place on its way, and its end. Each keeps the
    orientation and the branch of the start.
    """
    if len(node.arguments) != 8:
        return None
    _, start, along, across, diagonal, *counts = node.arguments
    numbers = [symbols.constants.value(count) for count in counts]
    corners = [unchanged(point, symbols) for point in (start, along, across)]
    arc = symbols.constants.value(counts[-1]) in (ARC, ARC + FIXED)
    if diagonal is not None and not arc:
        corners.append(unchanged(diagonal, symbols))
    known = [corner for corner in corners if corner is not None]
    if len(known) != len(corners) or not all(isinstance(n, float) for n in numbers):
        return None
    columns, rows, given = (round(n) for n in numbers if isinstance(n, float))
    direction, rows = given % FIXED, 1 if arc else rows
    if given // FIXED > 1 or direction not in (ZIGZAG, SAME_WAY, ARC) or columns < 1 or rows < 1:
        return None
    if columns * rows > MOST_POINTS or not _alike(known):
        return None
    places = np.array([[float(v or 0) for v in corner.values[:3]] for corner in known])
    points = points_of_grid(places, columns, rows, direction == ZIGZAG)
    if arc:
        points = along_arc(places, columns)
    made = []
    for point in points:
        values = (*(float(v) for v in point), *known[0].values[3:])
        made.append(target_of(s.Constant(values, known[0].flags), symbols.robot))
    return tuple(made)


def unchanged(node: s.Expression | None, symbols: Symbols) -> s.Constant | None:
    """The value of a position that no line changes; other programs change shared ones."""
    if not isinstance(node, s.Variable) or node.arguments is not None or node.component:
        return None
    if node.key[1:2] == "_" or node.key in symbols.constants.assigned:
        return None
    constant = symbols.positions.constant(node.name)
    if constant is None or len(constant.values) < 6 or None in constant.values[:6]:
        return None
    return constant


def _alike(corners: Sequence[s.Constant]) -> bool:
    """Whether they differ in X, Y and Z alone."""
    first = corners[0]
    return first.flags is not None and all(
        (c.values[3:], c.flags) == (first.values[3:], first.flags) for c in corners
    )


def define(node: s.DefOther, symbols: Symbols) -> list[p.Statement]:
    """`Def Plt`, which is no statement where the points are known."""
    number = symbols.constants.value(node.arguments[0]) if node.kind == "Plt" else None
    if not isinstance(number, float):
        raise Unliftable
    if round(number) not in symbols.pallets or not (symbols.grids or symbols.telling):
        raise Unliftable(KEPT)
    declared(round(number), symbols)
    return []


def declared(number: int, symbols: Symbols) -> e.Name:
    """The array of a pallet, declared where it is first met."""
    name, points = symbols.pallets[number]
    values = e.Aggregate(tuple(e.TargetValue(point) for point in points))
    symbols.variables.setdefault(
        name, Variable("position", values, (len(points),), storage="constant")
    )
    return e.Name(name)


def still_mentioned(parts: Any) -> bool:
    """Whether a text that was kept needs the definitions of pallets."""
    return any(
        isinstance(part, e.Verbatim | p.Opaque) and _MENTIONED.search(part.text) is not None
        for part in records(parts)
    )
