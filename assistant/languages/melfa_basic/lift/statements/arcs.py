"""Arcs given by a point on the opposite side or by their centre, and full circles.

`Mvr2 start,end,reference` runs on the circle of the three points, on the side that does not hold
the reference; `Mvr3 start,end,centre` runs by less than half a turn.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.languages.melfa_basic.lift.values.pallets import unchanged_position
from assistant.languages.melfa_basic.lift.values.symbols import Symbols, Unliftable
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.positions import target_of
from assistant.program import expressions as e
from assistant.program.geometry import Target, arc_middle_across, arc_middle_around, target_between
from assistant.program.motion import Blend
from assistant.program.statements import Reason

COMPUTED_ARC: Final = Reason(
    "the arc is told by points that the program sets, or that lie on no arc",
    "teach a point between start and end, and write Mvr",
)
RADIUS_TOLERANCE: Final = 0.01
"""mm that start and end of `Mvr3` may differ in their distance from the centre (COSIROP help)."""


LARGEST_CORNER_SHARE: Final = 0.1
"""Share of the radius of a circle that the corner between its two arcs has at the most."""
LARGEST_CORNER: Final = 1.0
"""mm that this corner has at the most."""


def _taught_points(
    points: tuple[s.Expression, ...], symbols: Symbols
) -> tuple[Target, Target, Target]:
    """Three taught points that no line changes; raises Unliftable for others."""
    found = [unchanged_position(point, symbols) for point in points]
    constants = [constant for constant in found if constant is not None]
    five_axis = symbols.robot is not None and symbols.robot.five_axis
    if len(constants) != 3 or symbols.own or five_axis:
        raise Unliftable(COMPUTED_ARC)
    first, second, third = (target_of(c, symbols.robot) for c in constants)
    return first, second, third


def circle_of(
    points: tuple[s.Expression, ...], symbols: Symbols
) -> tuple[e.TargetValue, e.TargetValue, e.TargetValue, Blend]:
    """The circle of `Mvc` as two arcs: a point on the first, its end, a point on the second.

    Its orientation is that of the start. The corner is that between both. Raises Unliftable.
    """
    first, via, last = _taught_points(points, symbols)
    start, other, end = (np.array(t.pose.position) for t in (first, via, last))
    back = arc_middle_across(end, start, other)
    there = None if back is None else arc_middle_across(start, end, back)
    if back is None or there is None:
        raise Unliftable(COMPUTED_ARC)
    around, half, home = (
        e.TargetValue(target_between(first, first, place)) for place in (there, end, back)
    )
    radius = float(np.linalg.norm(there - back)) / 2.0
    return around, half, home, Blend(min(LARGEST_CORNER, LARGEST_CORNER_SHARE * radius))


def via_of(
    keyword: str, points: tuple[s.Expression, ...], symbols: Symbols
) -> e.TargetValue | None:
    """The point halfway on `Mvr2` or `Mvr3`, None for a straight line; raises Unliftable.

    It has the branch of the start and an orientation between those of start and end.
    """
    first, last, third = _taught_points(points, symbols)
    start, end, other = (np.array(t.pose.position) for t in (first, last, third))
    if keyword == "Mvr2":
        middle = arc_middle_across(start, end, other)
        if middle is None:
            return None
    else:
        middle = arc_middle_around(start, end, other, RADIUS_TOLERANCE)
        if middle is None:
            raise Unliftable(COMPUTED_ARC)
    return e.TargetValue(target_between(first, last, middle))
