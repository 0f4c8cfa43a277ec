"""Points that others determine: halfway on arcs, and in grids. All in mm."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.program.arrays import Floats
from assistant.program.geometry import Pose, Target

COLLINEAR_SINE: Final = 1e-6
"""Sine of an angle below which three points are on a line."""


def arc_middle_across(start: Floats, end: Floats, other: Floats) -> Floats | None:
    """The middle of the arc on the other side of a point of its circle; None on a line."""
    chord, aside = end - start, other - start
    normal = np.cross(chord, aside)
    if np.linalg.norm(normal) <= COLLINEAR_SINE * np.linalg.norm(chord) * np.linalg.norm(aside):
        return None
    centre = start + (
        (aside @ aside) * np.cross(normal, chord) + (chord @ chord) * np.cross(aside, normal)
    ) / (2 * normal @ normal)
    away = chord * (aside @ chord) / (chord @ chord) - aside
    middle: Floats = centre + away * np.linalg.norm(start - centre) / np.linalg.norm(away)
    return middle


def arc_middle_around(start: Floats, end: Floats, centre: Floats, most: float) -> Floats | None:
    """The middle of the arc of less than half a turn about a centre; None where there is none.

    most: mm that start and end may differ in their distance from the centre.
    """
    one, two = start - centre, end - centre
    radii = np.linalg.norm(one), np.linalg.norm(two)
    between = one + two
    length = np.linalg.norm(between)
    turned = np.linalg.norm(np.cross(one, two)) > COLLINEAR_SINE * radii[0] * radii[1]
    if abs(radii[0] - radii[1]) > most or not turned:
        return None
    middle: Floats = centre + between * (radii[0] + radii[1]) / 2 / length
    return middle


def target_between(first: Target, last: Target, middle: Floats) -> Target:
    """A point on the way between two targets: turned halfway, in the branch of the first."""
    one, two = np.array(first.pose.quaternion), np.array(last.pose.quaternion)
    turned = one + (two if one @ two >= 0 else -two)
    pose = Pose.of(middle, turned / np.linalg.norm(turned))
    return Target(pose, first.configuration, first.external)


def grid_points(corners: Floats, columns: int, rows: int, zigzag: bool) -> Iterator[Floats]:
    """The points of a grid, row by row.

    corners: (3 or 4, 3) start, end of the first row, end of the first column, and the corner
    across, which makes it bilinear. zigzag: every other row runs backwards.
    """
    start, along, across = corners[:3]
    diagonal = corners[3] if len(corners) > 3 else along + across - start
    for row in range(rows):
        down = row / (rows - 1) if rows > 1 else 0.0
        order = range(columns)
        for column in reversed(order) if zigzag and row % 2 else order:
            right = column / (columns - 1) if columns > 1 else 0.0
            near = (1 - right) * start + right * along
            far = (1 - right) * across + right * diagonal
            yield (1 - down) * near + down * far


def points_on_arc(places: Floats, count: int) -> Iterator[Floats]:
    """Points at equal angles on an arc, its ends among them; at equal distances on a line.

    places: (3, 3) its start, a point on its way, and its end.
    """
    start, via, end = places
    chord, aside = end - start, via - start
    normal = np.cross(aside, chord)
    size = float(np.linalg.norm(normal))
    shares = [k / (count - 1) if count > 1 else 0.0 for k in range(count)]
    if size <= COLLINEAR_SINE * np.linalg.norm(chord) * np.linalg.norm(aside):
        yield from (start + share * chord for share in shares)
        return
    centre = start + (
        (aside @ aside) * np.cross(chord, normal) + (chord @ chord) * np.cross(normal, aside)
    ) / (2 * size**2)
    right, last = start - centre, end - centre
    up = np.cross(normal / size, right)
    whole = float(np.arctan2(last @ up, last @ right)) % (2 * np.pi)
    for share in shares:
        yield centre + np.cos(share * whole) * right + np.sin(share * whole) * up
