"""Contacts between frames: the way between two rows of joints, with nothing left out.

First what is far away is left out, of whole groups of stretches at once (`culling`). A stretch of
what remains is clear if the distances at its two ends add up to more than anything can move from
the one to the other; if not, it is halved. What each joint moves is counted with the largest lever
that a pair has on it (`Model.leverage`), so that no thing is thin enough to be stepped over.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.cell.collision.culling import near
from assistant.cell.collision.model import Model
from assistant.program.arrays import Floats, Rows, Truths

RESOLUTION: Final = 0.1
"""mm that anything moves in the shortest stretch: what comes that near counts as touching."""
TOGETHER: Final = 500_000
"""Stretches times pairs that are looked at together: each takes some hundred bytes at most."""
LONGEST: Final = 65536
"""Stretches of which a chunk has no more."""


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """Rows (n, j) of joints that are gone through, along straight lines of the joints.

    slack: (n - 1, j) how far a joint may be from the line of its stretch; None for not at all.
    """

    rows: Floats
    slack: Floats | None = None


@dataclass(frozen=True, slots=True)
class Hit:
    """Where a way is too near to something.

    at: of the way, the number of its stretch plus the part of it. joints: (j,) there.
    """

    at: float
    pair: int
    distance: float
    joints: Floats


def hits(
    model: Model, way: Way, margin: float | Floats = 0.0, resolution: float = RESOLUTION
) -> list[Hit]:
    """Every place of a way at which a pair begins to be nearer than margin (p,) mm, in order.

    A pair that is so from the start on begins there. resolution: mm, see `RESOLUTION`.
    """
    n = len(way.rows) - 1
    if n < 1 or not len(model):
        return []
    limit = np.broadcast_to(np.asarray(margin, dtype=np.float64), (len(model),))
    found: list[Hit] = []
    for start in range(0, n, LONGEST):
        chunk = _Chunk(model, way, limit, resolution, start, min(start + LONGEST, n))
        for stretch, pair in near(model, chunk.rows, chunk.slack, limit, TOGETHER):
            found += chunk.hits(stretch, pair)
    return _first_of_runs(found)


def clear(model: Model, way: Way, margin: float | Floats = 0.0) -> bool:
    """Whether nothing comes nearer than margin (p,) mm on a way."""
    return not hits(model, way, margin)


@dataclass(frozen=True, slots=True, eq=False)
class _Open:
    """Parts of stretches, from low to high, each for one pair, with its distances at both.

    moved: mm that the pair can come nearer on the whole stretch; slack: off it.
    """

    stretch: Rows
    pair: Rows
    low: Floats
    high: Floats
    at_low: Floats
    at_high: Floats
    moved: Floats
    slack: Floats

    def some(self, which: Truths) -> _Open:
        return _Open(*(getattr(self, name)[which] for name in _Open.__slots__))

    def halves(self, middle: Floats, touching: Truths) -> _Open:
        """Both halves of each; where the middle (distances) touches, only the one before it."""
        half, rest = (self.low + self.high) / 2.0, ~touching
        return _Open(
            np.concatenate([self.stretch, self.stretch[rest]]),
            np.concatenate([self.pair, self.pair[rest]]),
            np.concatenate([self.low, half[rest]]),
            np.concatenate([half, self.high[rest]]),
            np.concatenate([self.at_low, middle[rest]]),
            np.concatenate([middle, self.at_high[rest]]),
            np.concatenate([self.moved, self.moved[rest]]),
            np.concatenate([self.slack, self.slack[rest]]),
        )


class _Chunk:
    """Stretches of a way from start to stop."""

    def __init__(
        self, model: Model, way: Way, limit: Floats, resolution: float, start: int, stop: int
    ) -> None:
        self.model, self.limit, self.resolution, self.start = model, limit, resolution, start
        self.rows = way.rows[start : stop + 1]
        self.step = np.diff(self.rows, axis=0)
        self.slack = None if way.slack is None else np.abs(way.slack[start:stop])

    def hits(self, stretch: Rows, pair: Rows) -> list[Hit]:
        """Of pairs (k,), each on a stretch (k,)."""
        open_ = self._whole(stretch, pair)
        out: list[Hit] = []
        touching = open_.at_low <= self.limit[open_.pair]
        if self.start == 0:
            begun = open_.some(touching & (open_.stretch == 0))
            at_once = zip(begun.pair, begun.at_low, strict=True)
            out += [Hit(0.0, int(p), float(d), self.rows[0]) for p, d in at_once]
        open_ = open_.some(~touching)
        while len(open_.stretch):
            whole = open_.moved * (open_.high - open_.low)
            least = (open_.at_low + open_.at_high - whole) / 2.0 - open_.slack
            close, small = least <= self.limit[open_.pair], whole <= self.resolution
            found = open_.some(close & small)
            if len(found.stretch):
                out += self._found(found)
            open_ = open_.some(close & ~small)
            if len(open_.stretch):
                middle = self._distances(open_.stretch, (open_.low + open_.high) / 2.0, open_.pair)
                open_ = open_.halves(middle, middle <= self.limit[open_.pair])
        return out

    def _whole(self, stretch: Rows, pair: Rows) -> _Open:
        leverage = self.model.leverage.T[pair]
        moved = np.einsum("kj,kj->k", np.abs(self.step)[stretch], leverage)
        none = np.zeros(len(stretch))
        slack = none
        if self.slack is not None:
            slack = np.einsum("kj,kj->k", self.slack[stretch], leverage)
        ends = np.stack([stretch, stretch + 1], axis=1).reshape(-1)
        known, where = np.unique(ends * len(self.model) + np.repeat(pair, 2), return_inverse=True)
        row, pairs = np.divmod(known, len(self.model))
        used, row = np.unique(row, return_inverse=True)
        distance = self.model.exact(self.rows[used], row, pairs)[where].reshape(-1, 2)
        return _Open(stretch, pair, none, none + 1.0, distance[:, 0], distance[:, 1], moved, slack)

    def _distances(self, stretch: Rows, part: Floats, pair: Rows) -> Floats:
        keys, rows = self._rows_at(stretch, part)
        return self.model.exact(rows, keys, pair)

    def _rows_at(self, stretch: Rows, part: Floats) -> tuple[Rows, Floats]:
        """Rows of joints at parts of stretches, each once, and for each (k,) which."""
        places, keys = np.unique(stretch + part, return_inverse=True)
        whole = np.minimum(places.astype(np.intp), len(self.step) - 1)
        return keys, self.rows[whole] + (places - whole)[:, None] * self.step[whole]

    def _found(self, found: _Open) -> list[Hit]:
        middle = (found.low + found.high) / 2.0
        keys, rows = self._rows_at(found.stretch, middle)
        distance = self.model.exact(rows, keys, found.pair)
        return [
            Hit(float(self.start + s + m), int(p), float(d), rows[k])
            for s, m, p, d, k in zip(found.stretch, middle, found.pair, distance, keys, strict=True)
        ]


APART: Final = 1.0
"""Stretches between two hits of a pair from which on they are two."""


def _first_of_runs(found: list[Hit]) -> list[Hit]:
    """Of hits of a pair beside each other the first, in order of the way."""
    last: dict[int, float] = {}
    out = []
    for hit in sorted(found, key=lambda hit: hit.at):
        if hit.at - last.get(hit.pair, -np.inf) > APART:
            out.append(hit)
        last[hit.pair] = hit.at
    return out
