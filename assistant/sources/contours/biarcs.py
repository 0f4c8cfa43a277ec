"""Free curves as arcs and lines, within a tolerance that is checked on the curve itself.

Every interval of the parameter gets a biarc: two arcs that leave the curve's end points in the
curve's own directions and meet in one direction, so that the fit has no corner where the curve has
none. An interval that a biarc does not fit is halved; neighbours that one biarc fits are joined
again. Straight parts become exact lines. All intervals of one round are computed in columns.

Biarc: with end points p, q, unit tangents s, t, v = q - p and equal tangent lengths d, 2 d² (1 -
s·t) + 2 d v·(s + t) - v·v = 0, and the arcs meet in the middle of p + d s and q - d t. The
construction holds in space as in the plane.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.data_classes import dataclass
from assistant.sources.contours.curves import Arc, FreeCurve, Line, Points, vector

_INTERVAL_SAMPLES: Final = 33
"""Points of the curve that an interval is checked at, its ends included."""
_MOST_ROUNDS: Final = 26
"""Halvings of an interval before it is given up."""
_MOST_PIECES: Final = 20_000
"""Intervals that do not fit, over which the curve is given up: it is noise, not a shape."""
_WIDEST_BIARC: Final = np.radians(100.0)
"""Sweep of one arc of a biarc."""
_SHARPEST_TURN: Final = np.radians(20.0)
"""Turn between two samples, over which the curve is not known well enough."""
_STRAIGHT_PART: Final = 1e-3
"""Part of the tolerance within which a part counts as straight, and circles as one."""
_CONTROLLER_SWEEP: Final = 240.0
"""Degrees up to which arcs of one circle are joined."""

_EVEN: Final = np.arange(_INTERVAL_SAMPLES) / (_INTERVAL_SAMPLES - 1)
_ASIDE: Final = (0.618034 * np.arange(_INTERVAL_SAMPLES) % 1.0 - 0.5) * (
    0.6 / (_INTERVAL_SAMPLES - 1)
)
_SAMPLE_PARTS: Final = np.where((_EVEN > 0) & (_EVEN < 1), _EVEN + _ASIDE, _EVEN)
"""Positions of the samples in an interval: uneven, so that a curve that repeats does not look
straight.
"""
_END_DIRECTION_PARTS: Final = np.array([1e-4, 2e-4, 1 - 1e-4, 1 - 2e-4])
"""Positions in an interval at which the directions at the ends are computed."""

_Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Fit:
    """Lines and arcs, end to end, that follow a curve.

    deviation: mm, the largest distance of a checked point of the curve from them.
    within: False, without any pieces, if the curve cannot be followed within the tolerance.
    """

    pieces: tuple[Line | Arc, ...]
    deviation: float
    within: bool = True


_NO_FIT: Final = Fit((), math.inf, False)


def fit_curve(curve: FreeCurve, tolerance: float) -> Fit:
    """Lines and arcs within `tolerance` mm of the curve; they carry its layer and handle."""
    with np.errstate(invalid="ignore", over="ignore"):
        return _fit_intervals(curve, tolerance)


def _fit_intervals(curve: FreeCurve, tolerance: float) -> Fit:
    todo = _first_intervals(curve.breaks)
    done: list[_Biarcs] = []
    for _ in range(_MOST_ROUNDS):
        tried = _Biarcs.of(curve, todo, tolerance)
        if not tried.finite:
            return _NO_FIT
        # Keep the part that fits and halve the rest.
        done.append(tried.where(tried.fits))
        rest = todo[~tried.fits]
        if not len(rest):
            break
        if len(rest) > _MOST_PIECES:
            return _NO_FIT
        middle = rest.mean(axis=1)
        todo = np.stack([np.c_[rest[:, 0], middle], np.c_[middle, rest[:, 1]]], 1).reshape(-1, 2)
    else:
        return _NO_FIT
    fitted = _joined_neighbours(curve, _Biarcs.concatenated(done), tolerance)
    deviation = float(fitted.deviation.max(initial=0.0))
    pieces = [replace(p, layer=curve.layer, handle=curve.handle) for p in fitted.pieces()]
    if pieces and curve.closed:
        # The end is computed: rounding must not leave a closed curve open.
        pieces[-1] = replace(pieces[-1], end=pieces[0].start)
    return Fit(tuple(_joined_arcs(pieces, tolerance * _STRAIGHT_PART * 10)), deviation)


def _first_intervals(breaks: tuple[float, ...]) -> Points:
    """Each smooth part halved once or twice, so that a loop is not taken for a point."""
    each = 4 if len(breaks) < 16 else 2
    marks = np.asarray(breaks, dtype=np.float64)
    cuts = marks[:-1, None] + np.diff(marks)[:, None] * np.arange(each) / each
    edges = np.append(cuts.ravel(), marks[-1])
    intervals = np.stack([edges[:-1], edges[1:]], axis=1)
    return intervals[intervals[:, 1] > intervals[:, 0]]


@dataclass(frozen=True, slots=True)
class _Biarcs:
    """k intervals with the biarc of each.

    intervals: (k, 2) parameters. first, last: (k, 3) ends. joint: (k, 3), where the arcs
    meet. via: (k, 2, 3) middles of the arcs. flat: (k, 2) arcs that are lines. line: (k,)
    one line for both. fits: within the tolerance. deviation: (k,) mm.
    """

    intervals: Points
    first: Points
    last: Points
    joint: Points
    via: Points
    flat: _Flags
    line: _Flags
    fits: _Flags
    deviation: Points

    @staticmethod
    def of(curve: FreeCurve, intervals: Points, tolerance: float) -> _Biarcs:
        k = len(intervals)
        span = np.diff(intervals, axis=1)
        steps = np.concatenate([_SAMPLE_PARTS, _END_DIRECTION_PARTS])
        points = curve.at(intervals[:, :1] + span * steps).reshape(k, -1, 3)
        points, near = points[:, :_INTERVAL_SAMPLES], points[:, _INTERVAL_SAMPLES:]
        p, q = points[:, 0], points[:, -1]
        v = q - p
        # One-sided differences of second order: a corner may stand right behind the end.
        s = _unit(4.0 * near[:, 0] - near[:, 1] - 3.0 * p, v)
        t = _unit(3.0 * q - 4.0 * near[:, 2] + near[:, 3], v)
        size = _dot(v, v)
        bend = 1.0 - _dot(s, t)
        reach = _dot(v, s + t)
        root = np.sqrt(np.maximum(reach**2 + 2.0 * bend * size, 0.0))
        # The positive root in the form that stays exact as the tangents become parallel.
        with np.errstate(divide="ignore", invalid="ignore"):
            d = np.where(reach >= 0, size / (reach + root), (root - reach) / (2.0 * bend))
        known = np.isfinite(d) & (d > 0)
        d = np.where(known, d, 0.0)[:, None]
        joint = 0.5 * (p + q + d * (s - t))
        arcs = _Arcs.of(p, s, joint), _Arcs.of(q, -t, joint)
        distance = np.minimum(*(a.distance(points) for a in arcs)).max(axis=1)
        straight = _distances_to_segments(points, p, q).max(axis=1)
        spread = np.linalg.norm(points - points[:, :1], axis=2).max(axis=1)
        # A part within half of the tolerance is a point: a line is near enough.
        line = (straight <= tolerance * _STRAIGHT_PART) | (spread <= 0.5 * tolerance)
        narrow = np.maximum(arcs[0].sweep, arcs[1].sweep) <= _WIDEST_BIARC
        round_ = (
            known & narrow & (distance <= tolerance) & (_sharpest_turn(points) <= _SHARPEST_TURN)
        )
        return _Biarcs(
            intervals,
            p,
            q,
            joint,
            np.stack([a.via for a in arcs], axis=1),
            np.stack([a.flat for a in arcs], axis=1),
            line,
            line | round_,
            np.where(line, straight, distance),
        )

    @property
    def finite(self) -> bool:
        return bool(np.isfinite(self.first).all() and np.isfinite(self.deviation).all())

    def where(self, chosen: _Flags) -> _Biarcs:
        return _Biarcs(*(column[chosen] for column in self._columns()))

    @staticmethod
    def concatenated(parts: list[_Biarcs]) -> _Biarcs:
        """All of them in order of their parameters."""
        columns = zip(*(part._columns() for part in parts), strict=True)
        whole = _Biarcs(*(np.concatenate(column) for column in columns))
        # The parts of later rounds lie between those of earlier ones.
        return _Biarcs(*(c[np.argsort(whole.intervals[:, 0])] for c in whole._columns()))

    def pieces(self) -> list[Line | Arc]:
        """Lines and arcs in order, those without length left out."""
        made: list[Line | Arc] = []
        for i, line in enumerate(self.line.tolist()):
            first, joint, last = self.first[i], self.joint[i], self.last[i]
            parts = [(first, None, last)] if line else [
                (first, None if self.flat[i, 0] else self.via[i, 0], joint),
                (joint, None if self.flat[i, 1] else self.via[i, 1], last),
            ]  # fmt: skip
            for start, via, end in parts:
                arc = None if via is None else Arc.through(start, via, end)
                if arc is not None:
                    made.append(arc)
                elif (start != end).any():
                    made.append(Line(vector(start), vector(end)))
        return made

    def _columns(self) -> tuple[NDArray[Any], ...]:
        return (
            self.intervals,
            self.first,
            self.last,
            self.joint,
            self.via,
            self.flat,
            self.line,
            self.fits,
            self.deviation,
        )


@dataclass(frozen=True, slots=True)
class _Arcs:
    """k arcs by start, unit tangent there, and end; sweep in radians, flat ones are lines."""

    start: Points
    end: Points
    tangent: Points
    inward: Points
    radius: Points
    sweep: Points
    flat: _Flags

    @staticmethod
    def of(start: Points, tangent: Points, end: Points) -> _Arcs:
        chord = end - start
        along = _dot(chord, tangent)
        across = chord - along[:, None] * tangent
        height = np.sqrt(_dot(across, across))
        square = _dot(chord, chord)
        sweep = 2.0 * np.arctan2(height, along)
        # Flat by the sine of the angle between tangent and chord.
        flat = height <= 1e-7 * np.sqrt(square)
        safe = np.where(flat, 1.0, height)
        inward, radius = across / safe[:, None], square / (2.0 * safe)
        return _Arcs(start, end, tangent, inward, radius, np.where(flat, 0.0, sweep), flat)

    @property
    def via(self) -> Points:
        half = 0.5 * self.sweep[:, None]
        radius = self.radius[:, None]
        return np.asarray(
            self.start
            + radius * np.sin(half) * self.tangent
            + 2.0 * radius * np.sin(0.5 * half) ** 2 * self.inward
        )

    def distance(self, points: Points) -> Points:
        """From points (k, m, 3) to each one's arc, (k, m)."""
        # Coordinates in the plane of the arc, about its centre; the rest is off that plane.
        from_start = points - self.start[:, None]
        x = np.einsum("kmc,kc->km", from_start, self.tangent)
        y = self.radius[:, None] - np.einsum("kmc,kc->km", from_start, self.inward)
        out = np.sqrt(np.maximum(_dot(from_start, from_start) - x**2, 0.0))
        across = np.einsum("kmc,kc->km", from_start, self.inward)
        off_plane = np.maximum(out**2 - across**2, 0.0)
        angle = np.arctan2(x, y)
        beside = np.sqrt((np.hypot(x, y) - self.radius[:, None]) ** 2 + off_plane)
        inside = (angle >= 0.0) & (angle <= self.sweep[:, None])
        to_end = np.linalg.norm(points - self.end[:, None], axis=2)
        ends = np.minimum(np.linalg.norm(from_start, axis=2), to_end)
        straight = _distances_to_segments(points, self.start, self.end)
        return np.asarray(np.where(self.flat[:, None], straight, np.where(inside, beside, ends)))


def _joined_neighbours(curve: FreeCurve, biarcs: _Biarcs, tolerance: float) -> _Biarcs:
    """Neighbours that one line or biarc fits as one; straight and round parts stay apart."""
    for _ in range(4):
        here = biarcs.intervals
        if len(here) < 2:
            return biarcs
        tried = _Biarcs.of(curve, np.stack([here[:-1, 0], here[1:, 1]], axis=1), tolerance)
        alike = (biarcs.line[:-1] == biarcs.line[1:]) & (tried.line == biarcs.line[1:])
        open_ = tried.fits & alike
        chosen = np.zeros(len(open_), dtype=bool)
        # No interval joins both of its neighbours at once.
        for i in np.flatnonzero(open_).tolist():
            chosen[i] = i == 0 or not chosen[i - 1]
        if not chosen.any():
            return biarcs
        replaced = np.r_[chosen, False] | np.r_[False, chosen]
        biarcs = _Biarcs.concatenated([biarcs.where(~replaced), tried.where(chosen)])
    return biarcs


def _joined_arcs(pieces: list[Line | Arc], near: float) -> list[Line | Arc]:
    """Neighbouring arcs of one circle as one arc."""
    united: list[Line | Arc] = []
    for piece in pieces:
        last = united[-1] if united else None
        if (
            isinstance(last, Arc)
            and isinstance(piece, Arc)
            and _are_on_one_circle(last, piece, near)
        ):
            sweep = last.sweep + piece.sweep
            # The via is the middle of the joined arc, which determines its circle best.
            via = Arc.about(last.centre, last.normal, last.start, 0.5 * sweep).end
            whole = Arc.through(last.start, via, piece.end, last.layer, last.handle)
            if whole is not None:
                united[-1] = whole
                continue
        united.append(piece)
    return united


def _are_on_one_circle(a: Arc, b: Arc, near: float) -> bool:
    return (
        math.dist(a.centre, b.centre) <= near
        and abs(a.radius - b.radius) <= near
        and math.dist(a.normal, b.normal) <= 1e-4
        and a.sweep + b.sweep <= _CONTROLLER_SWEEP
    )


def _sharpest_turn(points: Points) -> Points:
    """Largest turn between consecutive chords of points (k, m, 3), radians."""
    chords = np.diff(points, axis=1)
    turns = np.arctan2(
        np.linalg.norm(np.cross(chords[:, :-1], chords[:, 1:]), axis=2),
        _dot(chords[:, :-1], chords[:, 1:]),
    )
    return np.asarray(turns.max(axis=1))


def _distances_to_segments(points: Points, start: Points, end: Points) -> Points:
    """Distances of points (k, m, 3) from segments (k, 3), (k, m)."""
    v = end - start
    size = np.maximum(_dot(v, v), 1e-300)
    share = np.clip(np.einsum("kmc,kc->km", points - start[:, None], v) / size[:, None], 0, 1)
    foot = start[:, None] + share[..., None] * v[:, None]
    return np.asarray(np.linalg.norm(points - foot, axis=2))


def _dot(a: Points, b: Points) -> Points:
    return np.asarray((a * b).sum(axis=-1))


def _unit(v: Points, otherwise: Points) -> Points:
    """Unit vectors (k, 3); of `otherwise` where v has no length."""
    size = np.linalg.norm(v, axis=1, keepdims=True)
    chosen = np.where(size > 1e-12, v, otherwise)
    size = np.linalg.norm(chosen, axis=1, keepdims=True)
    return np.asarray(chosen / np.where(size > 0, size, 1.0))
