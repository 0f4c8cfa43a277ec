"""Arcs that are told by a point of the other side or by their centre.

`Mvr2 start,end,reference` runs on the circle of the three points, on the side that does not hold
the reference; `Mvr3 start,end,centre` runs by less than half a turn.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.languages.melfa_basic.lift.values.pallets import unchanged
from assistant.languages.melfa_basic.lift.values.symbols import Symbols, Unliftable
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.positions import target_of
from assistant.program import expressions as e
from assistant.program.geometry import Pose, Target
from assistant.program.statements import Reason

Point = NDArray[np.float64]

KEPT: Final = Reason(
    "the arc is told by points that the program sets, or that lie on no arc",
    "teach a point between start and end, and write Mvr",
)
SAME_RADIUS: Final = 0.01
"""mm that start and end of `Mvr3` may differ in their distance from the centre (COSIROP help)."""
STRAIGHT: Final = 1e-6
"""Sine of an angle below which three points are on a line."""


def via_of(
    keyword: str, points: tuple[s.Expression, ...], symbols: Symbols
) -> e.TargetValue | None:
    """The point halfway on `Mvr2` or `Mvr3`, None for a straight line; raises Unliftable.

    It has the branch of the start and an orientation between those of start and end.
    """
    found = [unchanged(point, symbols) for point in points]
    constants = [constant for constant in found if constant is not None]
    five_axis = symbols.robot is not None and symbols.robot.five_axis
    if len(constants) != 3 or symbols.own or five_axis:
        raise Unliftable(KEPT)
    first, last, third = (target_of(c, symbols.robot) for c in constants)
    start, end, other = (np.array(t.pose.position) for t in (first, last, third))
    middle = (across if keyword == "Mvr2" else around)(start, end, other)
    if middle is None:
        return None
    one, two = np.array(first.pose.quaternion), np.array(last.pose.quaternion)
    between = one + (two if one @ two >= 0 else -two)
    pose = Pose.of(middle, between / np.linalg.norm(between))
    return e.TargetValue(Target(pose, first.configuration, first.external))


def across(start: Point, end: Point, other: Point) -> Point | None:
    """The middle of the arc on the other side of a point of its circle; None on a line."""
    chord, aside = end - start, other - start
    normal = np.cross(chord, aside)
    if np.linalg.norm(normal) <= STRAIGHT * np.linalg.norm(chord) * np.linalg.norm(aside):
        return None
    centre = start + (
        (aside @ aside) * np.cross(normal, chord) + (chord @ chord) * np.cross(aside, normal)
    ) / (2 * normal @ normal)
    away = chord * (aside @ chord) / (chord @ chord) - aside
    middle: Point = centre + away * np.linalg.norm(start - centre) / np.linalg.norm(away)
    return middle


def around(start: Point, end: Point, centre: Point) -> Point:
    """The middle of the arc about a centre; raises Unliftable where there is none."""
    one, two = start - centre, end - centre
    radii = np.linalg.norm(one), np.linalg.norm(two)
    between = one + two
    length = np.linalg.norm(between)
    turned = np.linalg.norm(np.cross(one, two)) > STRAIGHT * radii[0] * radii[1]
    if abs(radii[0] - radii[1]) > SAME_RADIUS or not turned:
        raise Unliftable(KEPT)
    middle: Point = centre + between * (radii[0] + radii[1]) / 2 / length
    return middle
