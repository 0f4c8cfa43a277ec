"""Circles through three places, and places halfway on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats

FLAT: Final = 1e-9
"""Sine of the angle between two chords below which three places lie on a line."""


@dataclass(frozen=True, slots=True)
class Circle:
    """centre (3,) mm, normal (3,): the way round is positive about it."""

    centre: Floats
    normal: Floats

    def middle(self, start: Floats, end: Floats) -> Floats:
        """The place halfway from one place to another, the positive way round."""
        return self.at(start, self.angle(start, end) / 2.0)

    def at(self, start: Floats, angle: float) -> Floats:
        """The place by an angle in radian from another one, the positive way round."""
        u = start - self.centre
        v = np.cross(self.normal, u)
        return np.asarray(self.centre + np.cos(angle) * u + np.sin(angle) * v)

    def angle(self, start: Floats, end: Floats) -> float:
        """Radian from one place to another the positive way round, from 0 to a whole turn."""
        u, w = start - self.centre, end - self.centre
        return float(np.arctan2(w @ np.cross(self.normal, u), w @ u) % (2.0 * np.pi))


def circle_through(a: Floats, b: Floats, c: Floats) -> Circle | None:
    """The circle from a through b to c; None where they lie on a line or fall together."""
    p, q = b - a, c - a
    normal = np.cross(p, q)
    size = float(np.linalg.norm(normal))
    if size <= FLAT * float(np.linalg.norm(p)) * float(np.linalg.norm(q)):
        return None
    to = (p @ p * np.cross(q, normal) + q @ q * np.cross(normal, p)) / (2.0 * size**2)
    return Circle(a + to, normal / size)


def circle_about(a: Floats, b: Floats, centre: Floats) -> Circle | None:
    """The circle from a to b by less than half a turn; None where they lie on a line."""
    p, q = a - centre, b - centre
    normal = np.cross(p, q)
    size = float(np.linalg.norm(normal))
    if size <= FLAT * float(np.linalg.norm(p)) * float(np.linalg.norm(q)):
        return None
    return Circle(centre, normal / size)
