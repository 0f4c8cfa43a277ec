"""Circles in columns: a move to a via point and the one after it lie on one of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows
from assistant.program.motion import Kind

COLLINEAR: Final = 1e-6
"""Sine of the angle at the start between via point and end up to which the three lie on a line."""


@dataclass(frozen=True, slots=True, eq=False)
class Circles:
    """k circles through three points each, counted from the first of them towards the second.

    centres, across, along: (k, 3) mm; a point at an angle is centre + cos · across + sin · along.
    vias, ends: (k,) radians at which the second and the third are, within a turn; 0, both of
    them, where the three lie on a line.
    """

    centres: Floats
    across: Floats
    along: Floats
    vias: Floats
    ends: Floats

    @property
    def radii(self) -> Floats:
        return np.asarray(np.linalg.norm(self.across, axis=1))

    def of(self, at: Rows) -> Circles:
        """Some of them."""
        return Circles(
            self.centres[at], self.across[at], self.along[at], self.vias[at], self.ends[at]
        )

    def points(self, angles: Floats) -> Floats:
        """(k, 3) at angles (k,), or (k, s, 3) at angles (k, s)."""
        turn, many = angles[..., None], (slice(None), *[None] * (angles.ndim - 1))
        return np.asarray(
            self.centres[many] + np.cos(turn) * self.across[many] + np.sin(turn) * self.along[many]
        )

    def directions(self, angles: Floats) -> Floats:
        """(k, 3) in which they go on at angles (k,), as long as the radius."""
        turn = angles[:, None]
        return np.asarray(np.cos(turn) * self.along - np.sin(turn) * self.across)


def circles(starts: Floats, vias: Floats, ends: Floats) -> Circles:
    """Those through points (k, 3), (k, 3) and (k, 3)."""
    a, b = vias - starts, ends - starts
    normal = np.cross(a, b)
    square = np.einsum("ij,ij->i", normal, normal)
    aa, bb = np.einsum("ij,ij->i", a, a), np.einsum("ij,ij->i", b, b)
    round_ = square > COLLINEAR * COLLINEAR * aa * bb
    safe = np.where(round_, square, 1.0)[:, None]
    centre = starts + np.cross(aa[:, None] * b - bb[:, None] * a, normal) / (2.0 * safe)
    across = starts - centre
    along = np.cross(normal / np.sqrt(safe), across)
    via, end = (
        np.where(round_, _angle(points - centre, across, along), 0.0) for points in (vias, ends)
    )
    return Circles(centre, across, along, via, end)


@dataclass(frozen=True, slots=True, eq=False)
class Arcs:
    """m moves on circles, two of each arc: up to its via point, and on to its end.

    rows: (m,) of the moves, ascending. circles: m of them. first, angles: (m,) radians where the
    move begins, and how far it goes round.
    """

    rows: Rows
    circles: Circles
    first: Floats
    angles: Floats

    @property
    def lengths(self) -> Floats:
        """(m,) mm."""
        return np.asarray(self.angles * self.circles.radii)

    @property
    def bulges(self) -> Floats:
        """(m,) mm that the way is off the straight line in its middle."""
        return np.asarray((1.0 - np.cos(self.angles / 2.0)) * self.circles.radii)

    def among(self, rows: Rows) -> tuple[Rows, Rows]:
        """Which of its moves are among rows (k,), and which of the k these are."""
        at = np.minimum(np.searchsorted(self.rows, rows), len(self.rows) - 1)
        on = np.flatnonzero(self.rows[at] == rows)
        return at[on], on

    def points(self, at: Rows, part: Floats) -> Floats:
        """Of some of the moves (k,), each at its parts (k,) or (k, s): (k, 3) or (k, s, 3) mm."""
        many = (slice(None), *[None] * (part.ndim - 1))
        return self.circles.of(at).points(self.first[at][many] + part * self.angles[at][many])


def vias_of(kinds: NDArray[np.uint8]) -> Rows:
    """Rows of the via points, each with the end of its arc behind it."""
    return np.flatnonzero((kinds[:-1] == Kind.VIA) & (kinds[1:] == Kind.END))


def arcs_of(via_rows: Rows, starts: Floats, vias: Floats, ends: Floats) -> Arcs | None:
    """The arcs with via points in some rows (k,) and points (k, 3) each; None if there are none.

    Those that are no arcs, and those of a point that is no number, go straight.
    """
    on = circles(starts, vias, ends)
    at = np.flatnonzero(on.ends > 0.0)
    if not len(at):
        return None
    twice = np.repeat(at, 2)
    rows = via_rows[twice]
    rows[1::2] += 1
    second = np.arange(len(rows)) % 2 == 1
    first = np.where(second, on.vias[twice], 0.0)
    last = np.where(second, on.ends[twice], on.vias[twice])
    return Arcs(rows, on.of(twice), first, last - first)


def _angle(away: Floats, across: Floats, along: Floats) -> Floats:
    """(k,) radians of points away from the centre, within a turn."""
    y, x = (np.einsum("ij,ij->i", away, axis) for axis in (along, across))
    return np.asarray(np.arctan2(y, x) % (2.0 * np.pi))
