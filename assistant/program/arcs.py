"""What three points say of the arc through them, for many arcs at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assistant.program.arrays import Floats


@dataclass(frozen=True, slots=True)
class ArcMeasures:
    """Measures of n arcs, NaN where a point is not known.

    sides: (n, 3) mm from start to via, from via to end, from start to end.
    area: (n,) mm² of the parallelogram that via and end span from the start.
    apart: (n,) degrees between via and end, seen from the start.
    around: (n,) degrees that the arc goes round.
    """

    sides: Floats
    area: Floats
    apart: Floats
    around: Floats

    @staticmethod
    def through(points: Floats) -> ArcMeasures:
        """points: (n, 3, 3) start, via and end."""
        start, via, end = (points[:, i] for i in range(3))
        to_via, to_end, rest = via - start, end - start, end - via
        lengths = np.linalg.norm(np.stack([to_via, rest, to_end], axis=1), axis=2)
        area = np.linalg.norm(np.cross(to_via, to_end), axis=1)
        # the angle at the via point stands on the part of the circle that is left out
        return ArcMeasures(
            lengths,
            area,
            angles_between(to_via, to_end),
            360.0 - 2.0 * angles_between(-to_via, rest),
        )


def angles_between(a: Floats, b: Floats) -> Floats:
    """(n,) degrees between vectors (n, 3)."""
    sine = np.linalg.norm(np.cross(a, b), axis=1)
    angles: Floats = np.degrees(np.arctan2(sine, (a * b).sum(axis=1)))
    return angles
