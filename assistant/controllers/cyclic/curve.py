"""A curve through points that never leaves the range between two neighbours, column by column.

Cubic pieces with the slopes of Fritsch and Carlson (SIAM J. Numer. Anal. 17, 1980): of one tangent
at each point, and level where a column turns round, so that no joint overshoots a point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assistant.base.arrays import Floats, Rows


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """at: (n,) increasing. rows, slopes: (n, c), slopes by `at`."""

    at: Floats
    rows: Floats
    slopes: Floats

    @staticmethod
    def through(at: Floats, rows: Floats) -> Curve:
        step = np.diff(at)[:, None]
        chord = np.diff(rows, axis=0) / step
        slopes = np.zeros_like(rows)
        if len(rows) == 2:
            slopes[:] = chord
            return Curve(at, rows, slopes)
        before, after = chord[:-1], chord[1:]
        one, two = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
        same = before * after > 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            mean = (one + two) / (one / before + two / after)
        slopes[1:-1] = np.where(same, mean, 0.0)
        slopes[0], slopes[-1] = chord[0], chord[-1]
        return Curve(at, rows, slopes)

    def piece(self, s: Floats) -> Rows:
        """The piece (m,) in which each place lies."""
        return np.clip(np.searchsorted(self.at, s, side="right") - 1, 0, len(self.at) - 2)

    def values(self, s: Floats) -> Floats:
        """The rows (m, c) at places (m,)."""
        i = self.piece(s)
        step = (self.at[i + 1] - self.at[i])[:, None]
        t = ((s - self.at[i])[:, None]) / step
        a, b = self.rows[i], self.rows[i + 1]
        u, v = self.slopes[i] * step, self.slopes[i + 1] * step
        rise = b - a
        return np.asarray(a + t * (u + t * (3.0 * rise - 2.0 * u - v + t * (u + v - 2.0 * rise))))

    def changes(self, i: Rows, s: Floats) -> tuple[Floats, Floats]:
        """First and second derivatives (m, c) at places (m,) of the pieces i (m,)."""
        step = (self.at[i + 1] - self.at[i])[:, None]
        t = ((s - self.at[i])[:, None]) / step
        u, v = self.slopes[i] * step, self.slopes[i + 1] * step
        rise = self.rows[i + 1] - self.rows[i]
        two, three = 3.0 * rise - 2.0 * u - v, u + v - 2.0 * rise
        return (u + t * (2.0 * two + 3.0 * t * three)) / step, (
            2.0 * two + 6.0 * t * three
        ) / step**2
