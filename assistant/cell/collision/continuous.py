"""Continuous collision detection along rows of joints, without a gap between them.

Joints of a group of stretches lie in a box of joints. From its middle a pair comes nearer by no
more than half of the edges of that box times its levers, so one bound clears the whole group; a
group that is not clear is divided.

A part of a remaining stretch is clear if the distances at its two ends add up to more than anything
can move from one end to the other; if not, it is halved. The motion of each joint counts with the
largest lever that a pair has on it (`Model.leverage`), so that no body is thin enough to be stepped
over. Joints that do not move along straight lines are computed at the ends and in the middle of
each part, so that their deviation from the line shrinks as the part does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.cell.collision.model import Model

_COARSE_GROUPS: Final = (4096, 1024, 256, 64)
_FINE_GROUPS: Final = (16, 4, 1)
"""Stretches of a group, each size a part of the one before it."""
_LEAST_MEASURED_GROUP: Final = 16
"""Smallest group for which distances are measured as well, which clear more than boxes do."""
_GROUP_PAIRS_AT_ONCE: Final = 100_000
"""Pairs of groups and items that are processed together."""


def _near_pairs(
    model: Model, rows: Floats, slack: Floats | None, limit: Floats, together: int
) -> Iterator[tuple[Rows, Rows]]:
    """Stretches (k,) of rows (n + 1, j) and pairs (k,) that may be nearer there than limit (p,) mm.

    slack: (n, j) how far a joint may be from the line of its stretch, no less than 0. together:
    of one answer at most, unless a single group of the coarse ones has more.
    """
    low, high = np.minimum(rows[:-1], rows[1:]), np.maximum(rows[:-1], rows[1:])
    if slack is not None:
        low, high = low - slack, high + slack
    within = _Within(model, low, high, limit)
    count = -(-len(low) // _COARSE_GROUPS[0])
    group = np.repeat(np.arange(count), len(model))
    pair = np.tile(np.arange(len(model)), count)
    group, pair = within.parts(group, pair, _COARSE_GROUPS[0], _COARSE_GROUPS)
    size = max(together // _COARSE_GROUPS[-1], 1)
    for start in range(0, len(group), size):
        some = slice(start, start + size)
        yield within.parts(group[some], pair[some], _COARSE_GROUPS[-1], _FINE_GROUPS)


class _Within:
    """Boxes of joints from low to high (n, j), one for each stretch."""

    def __init__(self, model: Model, low: Floats, high: Floats, limit: Floats) -> None:
        self.model, self.low, self.high, self.limit = model, low, high, limit

    def parts(self, group: Rows, pair: Rows, size: int, sizes: Sequence[int]) -> tuple[Rows, Rows]:
        """Return the groups of the last of sizes that are not clear, from groups (k,) of a size
        with pairs (k,).
        """
        for smaller in sizes:
            parts = size // smaller
            group = (group[:, None] * parts + np.arange(parts)).reshape(-1)
            pair = np.repeat(pair, parts)
            inside = group * smaller < len(self.low)
            group, pair = self._open(group[inside], pair[inside], smaller)
            size = smaller
        order = np.lexsort((pair, group))
        return group[order], pair[order]

    def _open(self, group: Rows, pair: Rows, size: int) -> tuple[Rows, Rows]:
        """Return the groups (k,) with pairs (k,) that are not far apart."""
        starts = np.arange(0, len(self.low), size)
        low = np.minimum.reduceat(self.low, starts)
        high = np.maximum.reduceat(self.high, starts)
        middle, half, leverage = (low + high) / 2.0, (high - low) / 2.0, self.model.leverage.T
        measures = [self.model.least_of, self.model.exact]
        for measure in measures[: 2 if size >= _LEAST_MEASURED_GROUP else 1]:
            found = [np.zeros(0, dtype=np.intp)]
            for start in range(0, len(group), _GROUP_PAIRS_AT_ONCE):
                g, p = (
                    group[start : start + _GROUP_PAIRS_AT_ONCE],
                    pair[start : start + _GROUP_PAIRS_AT_ONCE],
                )
                used, where = np.unique(g, return_inverse=True)
                least = measure(middle[used], where, p)
                least -= np.einsum("kj,kj->k", half[g], leverage[p])
                found.append(start + np.flatnonzero(least <= self.limit[p]))
            open_ = np.concatenate(found)
            group, pair = group[open_], pair[open_]
        return group, pair


RESOLUTION: Final = 0.1
"""mm that anything moves in the shortest part: what comes that near counts as touching."""
_SHORTEST_PART: Final = 2.0**-30
"""Smallest part of a stretch that is divided: joints that still differ at its ends jump."""
_PAIRS_AT_ONCE: Final = 500_000
"""Stretches times pairs that are processed together: each takes some hundred bytes at most."""
_MOST_STRETCHES: Final = 65536
"""Stretches of which a chunk has no more."""
_CURVE_TOLERANCE: Final = 0.1
"""degrees (mm) that curved joints may be off the line of their stretch beyond its slack."""
_CURVE_SAFETY: Final = 1.5
"""By how much more than in the middle of a part joints may be off its straight line elsewhere."""
_LEAST_RESOLUTION: Final = 0.05
"""mm to which a least distance is found."""
MOST_DISTANCES: Final = 400_000
"""Distances that are computed for least ones at most; what is found then is a bound."""

Curve = Callable[[Rows, Floats], tuple[Floats, Truths]]
"""Numbers of stretches (k,) and parts of them (k,) → joints (k, j), and whether they are exact."""


@dataclass(frozen=True, slots=True, eq=False)
class JointPath:
    """Rows (n, j) of joints that are passed in order, along straight lines of the joints.

    slack: (n - 1, j) largest deviation of a joint from the line of its stretch; None for no
    deviation. curve: the exact joints in between, None if only the slack is known.
    """

    rows: Floats
    slack: Floats | None = None
    curve: Curve | None = None


@dataclass(frozen=True, slots=True)
class Hit:
    """Point of a path at which a pair is closer than its margin.

    at: position on the path, the number of the stretch plus the fraction of it. joints: (j,) there.
    """

    at: float
    pair: int
    distance: float
    joints: Floats


@dataclass(frozen=True, slots=True)
class ClosestApproach:
    """Closest approach of a pair in a group of stretches.

    distance: mm, the least that was found. bound: mm that it is not less than.
    """

    group: int
    pair: int
    distance: float
    bound: float

    @property
    def exact(self) -> bool:
        return self.distance - self.bound <= RESOLUTION


def hits(
    model: Model, way: JointPath, margin: float | Floats = 0.0, resolution: float = RESOLUTION
) -> list[Hit]:
    """Every place of a way at which a pair begins to be nearer than margin (p,) mm, in order.

    A pair that is so from the start on begins there. resolution: mm, see `RESOLUTION`.
    """
    if len(way.rows) < 2 or not len(model):
        return []
    limit = np.broadcast_to(np.asarray(margin, dtype=np.float64), (len(model),))
    found: list[Hit] = []
    for chunk, stretch, pair in _chunks(model, way, limit):
        begun = stretch + chunk.start == 0
        found += chunk.hits(stretch, pair, limit, begun, resolution)
    return _first_of_runs(found)


def clear(model: Model, way: JointPath, margin: float | Floats = 0.0) -> bool:
    """True if no pair comes closer than margin (p,) mm on a path."""
    return not hits(model, way, margin)


def closest_approaches(
    model: Model, way: JointPath, limit: Floats, group: Rows
) -> list[ClosestApproach]:
    """Return the closest approach of each pair in each group, where it may be below limit (p,).

    group: (n - 1,) numbers that do not descend.
    """
    found: dict[tuple[int, int], ClosestApproach] = {}
    if len(way.rows) < 2 or not len(model):
        return []
    for chunk, stretch, pair in _chunks(model, way, limit):
        for one in chunk.leasts(stretch, pair, limit, group):
            key = one.group, one.pair
            other = found.get(key, one)  # of a group that lies in two chunks
            distance, bound = (min(one.distance, other.distance), min(one.bound, other.bound))
            found[key] = ClosestApproach(*key, distance, bound)
    return list(found.values())


def firsts(
    model: Model, way: JointPath, limit: Floats, group: Rows, wanted: Sequence[ClosestApproach]
) -> dict[tuple[int, int], Hit]:
    """Return the first place where a pair is closer than limit (p,), by group and pair."""
    out: dict[tuple[int, int], Hit] = {}
    count = len(model)
    keys = np.array([one.group * count + one.pair for one in wanted], dtype=np.intp)
    stretch = np.flatnonzero(np.isin(group, [one.group for one in wanted]))
    for start in range(0, len(stretch), _MOST_STRETCHES):
        some = stretch[start : start + _MOST_STRETCHES]
        at, pair = (
            x.reshape(-1) for x in np.meshgrid(some, np.unique(keys % count), indexing="ij")
        )
        of = np.isin(group[at] * count + pair, keys)
        at, pair = at[of], pair[of]
        for part in range(0, len(at), _PAIRS_AT_ONCE):
            chunk = _Chunk(model, way, 0, len(way.rows) - 1)
            s, p = at[part : part + _PAIRS_AT_ONCE], pair[part : part + _PAIRS_AT_ONCE]
            begun = (s == 0) | (group[s] != group[np.maximum(s - 1, 0)])
            for hit in chunk.hits(s, p, limit, begun, RESOLUTION):
                key = int(group[min(int(hit.at), len(group) - 1)]), hit.pair
                if key not in out or hit.at < out[key].at:
                    out[key] = hit
    return out


def _chunks(model: Model, way: JointPath, limit: Floats) -> Iterator[tuple[_Chunk, Rows, Rows]]:
    """Parts of a way, with the stretches (k,) of each and pairs (k,) that may be nearer there."""
    for start in range(0, len(way.rows) - 1, _MOST_STRETCHES):
        chunk = _Chunk(model, way, start, min(start + _MOST_STRETCHES, len(way.rows) - 1))
        slack = chunk.slack
        if slack is not None and way.curve is not None:
            slack = slack + _CURVE_TOLERANCE * (slack > 0.0)
        for stretch, pair in _near_pairs(model, chunk.rows, slack, limit, _PAIRS_AT_ONCE):
            yield chunk, stretch, pair


@dataclass(frozen=True, slots=True, eq=False)
class _Parts:
    """u parts of stretches, each as long as the others, with their joints (u, j) at the low end, in
    the middle and at the high end.

    off: (u, j) how far joints are from the straight line. fixed: (u,) whether that does not shrink.
    """

    stretch: Rows
    low: Floats
    size: float
    joints: tuple[Floats, Floats, Floats]
    off: Floats
    fixed: Truths

    def moved(self) -> Floats:
        """(u, j) how far joints move from the low end to the high one."""
        return np.abs(self.joints[2] - self.joints[0])


class _Chunk:
    """Stretches of a way from start to stop."""

    def __init__(self, model: Model, way: JointPath, start: int, stop: int) -> None:
        self.model, self.start, self.curve = model, start, way.curve
        self.rows = way.rows[start : stop + 1]
        self.step = np.diff(self.rows, axis=0)
        self.slack = None if way.slack is None else np.abs(way.slack[start:stop])

    def hits(
        self, stretch: Rows, pair: Rows, limit: Floats, begun: Truths, resolution: float
    ) -> list[Hit]:
        """Search pairs (k,), each on a stretch (k,). begun: (k,) true where its start counts."""
        out: list[Hit] = []
        if not len(stretch):
            return out
        parts, which = self._whole(stretch)
        at_low, at_high = self._at_ends(parts, which, pair)
        touching = at_low <= limit[pair]
        some = np.flatnonzero(touching & begun)
        for k in some.tolist():
            at = float(self.start + parts.stretch[which[k]])
            row = parts.joints[0][which[k]]
            out.append(Hit(at, int(pair[k]), float(at_low[k]), row))
        kept = ~touching
        which, pair, at_low, at_high = which[kept], pair[kept], at_low[kept], at_high[kept]
        while len(which):
            whole, off, fixed = self._reach(parts, which, pair)
            least = (at_low + at_high - whole) / 2.0 - off
            close = least <= limit[pair]
            small = (whole <= resolution) & ((2.0 * off <= resolution) | fixed)
            small |= parts.size <= _SHORTEST_PART
            found, on = np.flatnonzero(close & small), np.flatnonzero(close & ~small)
            out += self._found(parts, which[found], pair[found])
            which, pair, at_low, at_high = which[on], pair[on], at_low[on], at_high[on]
            if not len(which):
                break
            middle = self._in_middle(parts, which, pair)
            before = middle <= limit[pair]  # then it begins before the middle
            parts, low, high = self._halved(parts, which)
            which = np.concatenate([low, high[~before]])
            pair = np.concatenate([pair, pair[~before]])
            at_low, at_high = (
                np.concatenate([at_low, middle[~before]]),
                np.concatenate([middle, at_high[~before]]),
            )
        return out

    def leasts(
        self, stretch: Rows, pair: Rows, limit: Floats, group: Rows
    ) -> Iterator[ClosestApproach]:
        """The least distances of pairs (k,) on stretches (k,) by groups."""
        if not len(stretch):
            return
        count = len(self.model)
        keys = group[stretch + self.start] * count + pair
        jobs, job = np.unique(keys, return_inverse=True)
        best, bound = np.full(len(jobs), np.inf), np.full(len(jobs), np.inf)
        parts, which = self._whole(stretch)
        at_low, at_high = self._at_ends(parts, which, pair)
        done = 0
        while len(which):
            np.minimum.at(best, job, np.minimum(at_low, at_high))
            whole, off, fixed = self._reach(parts, which, pair)
            least = (at_low + at_high - whole) / 2.0 - off
            open_ = (least < best[job] - _LEAST_RESOLUTION) & (least <= limit[pair])
            small = (whole <= _LEAST_RESOLUTION) & (2.0 * off <= _LEAST_RESOLUTION)
            small |= fixed & (
                whole <= np.maximum(_LEAST_RESOLUTION, off)
            )  # halves would be no surer
            small |= parts.size <= _SHORTEST_PART
            if done > MOST_DISTANCES:  # contacts are found all the same, but not how deep they are
                small |= (least > 0.0) | (best[job] <= 0.0)
            ends, on = np.flatnonzero(open_ & small), np.flatnonzero(open_ & ~small)
            np.minimum.at(bound, job[ends], least[ends])
            which, pair, job = which[on], pair[on], job[on]
            at_low, at_high = at_low[on], at_high[on]
            if not len(which):
                break
            middle = self._in_middle(parts, which, pair)
            done += len(which)
            parts, low, high = self._halved(parts, which)
            which = np.concatenate([low, high])
            pair, job = np.concatenate([pair, pair]), np.concatenate([job, job])
            at_low, at_high = np.concatenate([at_low, middle]), np.concatenate([middle, at_high])
        for key, distance, lower in zip(jobs.tolist(), best, bound, strict=True):
            number, one = divmod(int(key), count)
            if min(distance, lower) <= limit[one]:
                exact = max(distance - _LEAST_RESOLUTION, -np.inf)
                yield ClosestApproach(number, one, float(distance), float(min(exact, lower)))

    # ------------------------------------------------------------------------------- parts

    def _whole(self, stretch: Rows) -> tuple[_Parts, Rows]:
        """Stretches (k,) as parts, each once, and for each (k,) which."""
        used, which = np.unique(stretch, return_inverse=True)
        none = np.zeros(len(used))
        return self._parts(used, none, 1.0, self._at(used, none), self._at(used, none + 1.0)), which

    def _parts(self, stretch: Rows, low: Floats, size: float, first: _At, last: _At) -> _Parts:
        straight = (first.rows + last.rows) / 2.0
        fixed = ~(first.exact & last.exact)
        if self.slack is None:
            return self._made(stretch, low, size, first.rows, straight, last.rows, None, fixed)
        middle = _At(straight, fixed)
        if self.curve is not None:
            middle = self._at(stretch, low + size / 2.0)
        fixed = fixed | ~middle.exact
        off = _CURVE_SAFETY * np.abs(middle.rows - straight)
        off = np.where(fixed[:, None], np.maximum(off, self.slack[stretch]), off)
        return self._made(stretch, low, size, first.rows, middle.rows, last.rows, off, fixed)

    @staticmethod
    def _made(
        stretch: Rows,
        low: Floats,
        size: float,
        first: Floats,
        middle: Floats,
        last: Floats,
        off: Floats | None,
        fixed: Truths,
    ) -> _Parts:
        nothing = np.zeros_like(first) if off is None else off
        return _Parts(stretch, low, size, (first, middle, last), nothing, fixed)

    def _at(self, stretch: Rows, part: Floats) -> _At:
        if self.curve is not None:
            return _At(*self.curve(stretch + self.start, part))
        rows = self.rows[stretch] + part[:, None] * self.step[stretch]
        return _At(rows, np.full(len(rows), self.slack is None))

    def _halved(self, parts: _Parts, which: Rows) -> tuple[_Parts, Rows, Rows]:
        """Both halves of some parts (k,), each once, and for each (k,) which they are."""
        used, where = np.unique(which, return_inverse=True)
        first, middle, last = (rows[used] for rows in parts.joints)
        solved = ~parts.fixed[used]
        size, stretch, low = parts.size / 2.0, parts.stretch[used], parts.low[used]
        both = self._parts(
            np.concatenate([stretch, stretch]),
            np.concatenate([low, low + size]),
            size,
            _At(np.concatenate([first, middle]), np.concatenate([solved, solved])),
            _At(np.concatenate([middle, last]), np.concatenate([solved, solved])),
        )
        return both, where, where + len(used)

    # --------------------------------------------------------------------------- distances

    def _reach(self, parts: _Parts, which: Rows, pair: Rows) -> tuple[Floats, Floats, Truths]:
        """(k,) mm that pairs come nearer on parts at most, mm that they may besides, as the joints
        are off the line, and whether that does not shrink.
        """
        leverage = self.model.leverage.T[pair]
        whole = np.einsum("kj,kj->k", parts.moved()[which], leverage)
        if self.slack is None:
            return whole, np.zeros(len(which)), parts.fixed[which]
        off = np.einsum("kj,kj->k", parts.off[which], leverage)
        return whole, off, parts.fixed[which]

    def _at_ends(self, parts: _Parts, which: Rows, pair: Rows) -> tuple[Floats, Floats]:
        """Distances (k,) of pairs at the low ends of parts, and at the high ones."""
        rows = np.concatenate([parts.joints[0], parts.joints[2]])
        count, pairs = len(parts.stretch), len(self.model)
        # The high end of a stretch is often the low end of the next one.
        follows = np.append(np.diff(parts.stretch) == 1, False)
        follows[:-1] &= (parts.joints[2][:-1] == parts.joints[0][1:]).all(axis=1)
        high = np.where(follows[which], which + 1, which + count)
        keys = np.concatenate([which, high]) * pairs + np.tile(pair, 2)
        known, where = np.unique(keys, return_inverse=True)
        distance = self.model.exact(rows, *np.divmod(known, pairs))[where]
        return distance[: len(which)], distance[len(which) :]

    def _in_middle(self, parts: _Parts, which: Rows, pair: Rows) -> Floats:
        used, row = np.unique(which, return_inverse=True)
        return self.model.exact(parts.joints[1][used], row, pair)

    def _found(self, parts: _Parts, which: Rows, pair: Rows) -> list[Hit]:
        if not len(which):
            return []
        distance = self._in_middle(parts, which, pair)
        at = self.start + parts.stretch[which] + parts.low[which] + parts.size / 2.0
        rows = parts.joints[1][which]
        return [
            Hit(float(a), int(p), float(d), row)
            for a, p, d, row in zip(at, pair, distance, rows, strict=True)
        ]


@dataclass(frozen=True, slots=True, eq=False)
class _At:
    """Joints (k, j), and whether they are exact (k,)."""

    rows: Floats
    exact: Truths


_HIT_SEPARATION: Final = 1.0
"""Stretches between two hits of a pair from which on they are two."""


def _first_of_runs(found: list[Hit]) -> list[Hit]:
    """Return the first of adjacent hits of each pair, in order along the path."""
    last: dict[int, float] = {}
    out = []
    for hit in sorted(found, key=lambda hit: hit.at):
        if hit.at - last.get(hit.pair, -np.inf) > _HIT_SEPARATION:
            out.append(hit)
        last[hit.pair] = hit.at
    return out
