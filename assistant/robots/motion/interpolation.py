"""Interpolation of linear and circular moves: arcs, poses on them, and their joints.

All users look between targets with the same geometry: reach and turns (`between_targets`), rules
(`checks.extremes`), times (`timing.course`) and pictures (`report.track`). How densely each of them
samples is stated here in one place, as a density for one would be too coarse or too slow for
another. A move to a via point and the one after it lie on one circle.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows
from assistant.base.data_classes import dataclass
from assistant.program.motion import Kind
from assistant.robots.motion.run import Mounting
from assistant.robots.robot import Robot

_COLLINEAR: Final = 1e-6
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
    round_ = square > _COLLINEAR * _COLLINEAR * aa * bb
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
        """Return points of some of the moves (k,), each at its parts (k,) or (k, s): (k, 3) or (k,
        s, 3) mm.
        """
        many = (slice(None), *[None] * (part.ndim - 1))
        return self.circles.of(at).points(self.first[at][many] + part * self.angles[at][many])


def vias_of(kinds: NDArray[np.uint8]) -> Rows:
    """Return the rows of the via points, each followed by the end of its arc."""
    return np.flatnonzero((kinds[:-1] == Kind.VIA) & (kinds[1:] == Kind.END))


def arcs_of(via_rows: Rows, starts: Floats, vias: Floats, ends: Floats) -> Arcs | None:
    """Return the arcs with via points in some rows (k,) and points (k, 3) each; None if no row is
    an arc.

    Rows that are not arcs, and those with a point that is not finite, are straight.
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


Poses = tuple[Floats, Floats]
"""Positions (..., 3) mm and unit quaternions (..., 4)."""


@dataclass(frozen=True, slots=True, eq=False)
class ToolPaths:
    """k ways of a tool, on which it goes and turns evenly.

    starts, ends: (k, 3), (k, 4). rows: (k,) what they are called in arcs. arcs: those that are
    round; the others are straight.
    """

    starts: Poses
    ends: Poses
    rows: Rows
    arcs: Arcs | None

    def at(self, part: Floats) -> Poses:
        """At parts (k, s) of each way: (k, s, 3), (k, s, 4)."""
        (p0, q0), (p1, q1) = self.starts, self.ends
        p = p0[:, None] + part[..., None] * (p1 - p0)[:, None]
        if self.arcs is not None:
            at, on = self.arcs.among(self.rows)
            p[on] = self.arcs.points(at, part[on])
        return p, rotations.between(q0[:, None], q1[:, None], part)


def flange_along(mounting: Mounting, rows: Rows, tool: Poses) -> Poses:
    """Poses (k, s, 3), (k, s, 4) on the ways to rows (k,) of a run → of the flange."""
    p, q = tool
    each = np.repeat(rows, p.shape[1])
    flat = mounting.to_flange(p.reshape(-1, 3), q.reshape(-1, 4), each)
    return flat[0].reshape(p.shape), flat[1].reshape(q.shape)


def joints_along(robot: Robot, before: Floats | None, branches: Rows, flange: Poses) -> Poses:
    """Joints (k, s, a) deg, whole turns left open, and mm out of reach (k, s), on k ways.

    branches: (k,) that an arm whose branches have names stays in. before: (k, a) deg where the ways
    begin, from which another one is followed; else not needed. flange: (k, s, 3), (k, s, 4).
    """
    p, q = flange
    if not robot.arm.named and before is not None:
        return robot.follow(before, p, q)
    joints, excess = np.empty((*p.shape[:2], len(robot.axes))), np.empty(p.shape[:2])
    for branch in np.unique(branches):
        some = branches == branch
        found, over = robot.solve(p[some].reshape(-1, 3), q[some].reshape(-1, 4), (int(branch),))
        joints[some] = found[:, 0].T.reshape(-1, p.shape[1], len(robot.axes))
        excess[some] = over[0].reshape(-1, p.shape[1])
    return joints, excess


class TurnSampling:
    """`between_targets`: how often the axes turn between targets, within reach and limits or not.

    Every program asks this of all its moves, so that most are answered by their ends.
    """

    WIDE: Final = 20.0
    """Least movement of an axis in one move, in degrees or mm, from which its path is sampled."""
    LONG: Final = 50.0
    """Least length of a move in mm from which its path is sampled in any case."""
    BULGE: Final = 1.0
    """Least mm of an arc off the straight line from which its path is sampled in any case."""
    SAMPLES: Final = np.array([3, 12, 40])
    """Poses on a way: the second for a line, and for an arc as few as leave bulges of about
    `BULGE` between them."""
    FINE: Final = 240
    """Parts of a path that is sampled again, since its poses leave a doubt."""
    LEAP: Final = 45.0
    """Least step of an axis from pose to pose, in degrees or mm, from which more poses are
    sampled.
    """
    NEAR: Final = 2.0
    """Distance from a limit in degrees or mm, beyond the largest step, within which more poses are
    sampled.
    """
    STRETCHED: Final = 0.3
    """Sine of the elbow within which the end of the reach may be between two poses."""
    SPLIT: Final = 8
    """Parts of each stretch on which an axis still leaps, looked at again."""
    SPLITS: Final = 6
    """Number of times that stretches are divided, for a tool that passes axis 1 at a micrometre."""
    PEAK: Final = 64
    """Parts between the poses beside a peak, where an axis turns back near to a limit."""


class PeakSampling:
    """`checks.extremes`: how fast the axes would have to be, and how near a singularity is.

    A finding tells the worst place, which beside a singularity is short; so there are more places
    the further the axes go.
    """

    STRAIGHT: Final = 5.0
    """Largest movement of every axis, in degrees or mm, for which only the ends of a move are
    sampled.
    """
    PARTS: Final = ((30.0, 24), (90.0, 64), (float("inf"), 192))
    """Number of parts in which a move is sampled, by the largest movement of an axis in degrees."""
    MOST_PLACES: Final = 1_000_000
    """Places on the ways of a run; longer runs get fewer on each move."""
    MOST_FOLLOWED: Final = 20_000
    """The same for an arm without a closed form, which is solved by numbers, place by place."""
    LEAST_PARTS: Final = 4
    """Parts of a move in the longest runs."""
    UNEVEN: Final = 1.5
    """Least ratio of a joint's greatest to average speed in a move from which it is sampled
    again.
    """
    MOST_PARTS: Final = 1500
    """Largest number of parts of a move that is sampled again."""
    CLOSER: Final = 6
    """Largest number of times that the fastest step of such a move is divided again."""
    CLOSER_PARTS: Final = 24
    """Parts that its fastest step is divided into."""
    FASTER: Final = 1.01
    """By how much that has to find it faster to be done once more."""


class TimeSampling:
    """`timing.course`: how long a move takes, with the joints linear from knot to knot."""

    APART: Final = 10.0
    """mm between knots at most."""
    TURNED: Final = 1.5
    """degrees (or mm) that the tool or an axis turns between knots at most."""
    MOST: Final = 400
    """Steps of a move, and of a corner."""
    MOST_KNOTS: Final = 2_000_000
    """Steps of a way from which on long moves get fewer of them: about 300 bytes each."""
    SPANS: Final = 21
    """Parabolas of a corner at least; odd, so that its moves meet in the middle of one."""


class DrawingSampling:
    """`report.track`: pictures, in which nobody sees less than a few degrees of an arc."""

    ARC: Final = 24
    """Chords an arc is drawn with at least."""
    OFF: Final = 0.05
    """mm that they are off at most."""
    MOST: Final = 1000
    """Chords of an arc that is larger than any work."""
