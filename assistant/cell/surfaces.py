"""Surfaces of shapes as triangles, to be looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Ints
from assistant.cell.scene import Part
from assistant.cell.shapes import Box, Capsule, Convex, Cylinder, Shape, Sphere
from assistant.program.geometry import Pose

ROUND_SIDES: Final = 32
"""Flat sides of what is round."""

Profile = Sequence[tuple[float, float]]
"""Points (radius, z) from the lowest to the highest, to be turned about z."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Triangles (m, 3) of points (n, 3) mm, counter-clockwise as seen from outside.

    flat: its edges are sharp; else it is round between its points.
    """

    points: Floats
    triangles: Ints
    flat: bool

    def at(self, pose: Pose) -> Surface:
        """The surface of what has a pose, in the frame of that pose."""
        return Surface(pose.moved(self.points), self.triangles, self.flat)


def part_surface(part: Part) -> Surface:
    """The surface of a part of a body, in the body's frame; round shapes with `AROUND` sides."""
    return surface(part.shape).at(part.pose)


def surface(shape: Shape) -> Surface:
    """The surface of a shape in its own frame."""
    match shape:
        case Box():
            corners = (np.indices((2, 2, 2)).reshape(3, -1).T - 0.5) * np.array(shape.size)
            return Surface(corners, _BOX, flat=True)
        case Sphere():
            return _revolved([_half_circles(shape.radius, 0.0)])
        case Capsule():
            return _revolved([_half_circles(shape.radius, shape.length)])
        case Cylinder(radius=r, length=length):
            low, high = -length / 2.0, length / 2.0
            sides = [(0.0, low), (r, low)], [(r, low), (r, high)], [(r, high), (0.0, high)]
            return _revolved(sides)
        case Convex():
            return Surface(shape.hull.points, shape.hull.triangles, flat=True)
    return Surface(shape.points, shape.triangles, flat=True)


_BOX: Final[Ints] = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)


def _half_circles(radius: float, length: float) -> Profile:
    """The profile of a sphere that is pulled to a length along z."""
    angles = np.linspace(-np.pi / 2.0, np.pi / 2.0, ROUND_SIDES // 2 + 1)
    half = len(angles) // 2
    lower = [(radius * np.cos(a), radius * np.sin(a) - length / 2.0) for a in angles[: half + 1]]
    upper = [(radius * np.cos(a), radius * np.sin(a) + length / 2.0) for a in angles[half:]]
    return [*lower, *(upper if length else upper[1:])]


def _revolved(profiles: Sequence[Profile]) -> Surface:
    """Profiles turned about z, with a sharp edge from each to the next."""
    angles = np.linspace(0.0, 2.0 * np.pi, ROUND_SIDES, endpoint=False)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points, triangles, first = list[Floats](), list[Ints](), 0
    here = np.arange(ROUND_SIDES)
    there = (here + 1) % ROUND_SIDES
    for profile in profiles:
        for i, (radius, z) in enumerate(profile):
            points.append(np.column_stack([radius * ring, np.full(ROUND_SIDES, z)]))
            if i:
                low, high = first + (i - 1) * ROUND_SIDES, first + i * ROUND_SIDES
                below, above = (profile[j][0] > 1e-9 for j in (i - 1, i))
                if below:
                    triangles.append(np.stack([low + here, low + there, high + there], axis=1))
                if above:
                    triangles.append(np.stack([low + here, high + there, high + here], axis=1))
        first += len(profile) * ROUND_SIDES
    return Surface(np.concatenate(points), np.concatenate(triangles), flat=False)
