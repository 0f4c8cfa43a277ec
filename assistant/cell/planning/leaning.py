"""Ways on which the tool stays in a cone, however narrow.

Joints drawn at random are brought into the cone by the least turn of the axes, and so is the middle
of each move that leaves it, until all of the way stays inside (Berenson, Srinivasa, Ferguson and
Kuffner, 2009). Trees of such moves grow from the start and from all goals until they meet.
"""

from __future__ import annotations

import time
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Truths, norms
from assistant.cell.planning.space import Cone, Space

CONE_INSIDE: Final = 10.0
"""degrees that joints are brought inside the edge of a cone: moves between them bulge outwards."""
CONE_ROUNDS: Final = 12
"""Of bringing joints into the cone."""
MOST_TURN_A_ROUND: Final = 45.0
"""degrees that the tool is turned in a round."""
CONE_TOLERANCE: Final = 0.02
"""degrees that joints which were brought into the cone may be off."""
DIFFERENCE_STEP: Final = 0.01
"""degrees (mm) that joints are moved by to see how the tool turns."""
WEAKEST_TURN: Final = 1e-2
"""Of the strongest, how weakly joints may turn the tool to be used for it."""
MOST_HALVINGS: Final = 7
"""Times that a move is halved until its parts stay in the cone."""
MOST_DETOUR: Final = 2.5
"""Of a move, how long the two may be that lead by way of its middle in the cone."""
LONGEST_STEP: Final = 0.15
"""Of the way from one corner of the limits to the other, the longest step towards a place."""


DRAWN_AT_ONCE: Final = 64
"""Joints that are drawn at random together."""


class ConeMoves:
    """The cone of a space, and what is brought into it. low, high: (a,) of joints."""

    def __init__(self, space: Space, cone: Cone, low: Floats, high: Floats) -> None:
        self.space, self.cone, self.low, self.high = space, cone, low, high
        self.inner = max(cone.angle - CONE_INSIDE, 0.0)
        self.direction = np.array(cone.direction) / np.linalg.norm(cone.direction)

    def brought(self, rows: Floats) -> tuple[Floats, Truths]:
        """Joints (n, a) brought into the cone and the limits; (n,) whether that was possible."""
        out = np.clip(rows, self.low, self.high)
        good = np.zeros(len(out), dtype=bool)
        some = np.arange(len(out))
        for _ in range(CONE_ROUNDS):
            axes = self._axes(out[some])
            along = axes[:, 0] @ self.direction
            across = norms(np.cross(axes[:, 0], self.direction))
            off = np.degrees(np.arctan2(across, along)) - self.inner
            good[some] = off <= CONE_TOLERANCE
            axes, off, some = (
                axes[off > CONE_TOLERANCE],
                off[off > CONE_TOLERANCE],
                some[off > CONE_TOLERANCE],
            )
            if not len(some):
                break
            out[some] = np.clip(out[some] + self._back(axes, off), self.low, self.high)
        return out, good

    def _axes(self, rows: Floats) -> Floats:
        """(n, a + 1, 3) the axis of the tool at joints (n, a), and with each of them moved."""
        n, a = rows.shape
        near = rows[:, None] + DIFFERENCE_STEP * np.vstack([np.zeros(a), np.eye(a)])
        return self.cone.axes(self.space.tip(near.reshape(-1, a))[1]).reshape(n, a + 1, 3)

    def _back(self, axes: Floats, angles: Floats) -> Floats:
        """(n, a) the least motion, by the time it takes, that turns the tool towards the cone."""
        axis = axes[:, 0]
        to = self.direction - (axis @ self.direction)[:, None] * axis
        flat = norms(to) < 1e-6  # upside down: any way round
        to[flat] = np.cross(axis[flat], np.eye(3)[np.abs(axis[flat]).argmin(axis=1)])
        to *= (np.radians(np.minimum(angles, MOST_TURN_A_ROUND)) / np.maximum(norms(to), 1e-9))[
            :, None
        ]
        rates = (
            (axes[:, 1:] - axis[:, None]).transpose(0, 2, 1)
            / DIFFERENCE_STEP
            * self.space.robot.speeds
        )
        motion = np.linalg.pinv(rates, rcond=WEAKEST_TURN) @ to[..., None]
        return np.asarray(motion[..., 0] * self.space.robot.speeds)

    def chain(self, start: Floats, end: Floats) -> Floats:
        """(k, a) joints by which straight moves in the cone lead from joints (a,) to others.

        The start first. Where that cannot be, it ends before.
        """
        rows, proven = np.stack([start, end]), np.zeros(1, dtype=bool)
        for _ in range(MOST_HALVINGS):
            proven[~proven] = self.space.upright(rows[:-1][~proven], rows[1:][~proven])
            open_ = np.flatnonzero(~proven)
            if not len(open_):
                return rows
            one, other = rows[open_], rows[open_ + 1]
            middle, good = self.brought((one + other) / 2.0)
            both = self.space.length(one, middle) + self.space.length(middle, other)
            good &= both <= MOST_DETOUR * self.space.length(one, other)
            if not good.all():
                bad = int(np.argmin(good))
                rows, proven = rows[: open_[bad] + 1], proven[: open_[bad]]
                open_, middle = open_[:bad], middle[:bad]
            rows = np.insert(rows, open_ + 1, middle, axis=0)
            proven = np.insert(proven, open_, False)
            if len(rows) < 2:
                return rows
        proven[~proven] = self.space.upright(rows[:-1][~proven], rows[1:][~proven])
        return rows if proven.all() else rows[: int(np.argmin(proven)) + 1]

    def clear_chain(self, start: Floats, end: Floats) -> Floats:
        """As `chain`, up to where a body is in the way."""
        rows = self.chain(start, end)
        free = self.space.clear(rows[:-1], rows[1:])
        return rows if free.all() else rows[: int(np.argmin(free)) + 1]


class _ConeTree:
    """Joints (a,) with, for each, the number of the one before it; -1 for a root."""

    def __init__(self) -> None:
        self.rows: list[Floats] = []
        self.before: list[int] = []

    def add(self, row: Floats, before: int) -> int:
        self.rows.append(row)
        self.before.append(before)
        return len(self.rows) - 1

    def back(self, number: int) -> list[Floats]:
        """From a place to its root."""
        out = []
        while number >= 0:
            out.append(self.rows[number])
            number = self.before[number]
        return out


class ConeTrees:
    """Two trees of moves in a cone, from joints (a,) and from goals (k, a)."""

    def __init__(self, leaning: ConeMoves, start: Floats, goals: Floats) -> None:
        self.leaning, self.space = leaning, leaning.space
        self.here, self.there = _ConeTree(), _ConeTree()
        self.goals = goals
        for tree, roots in ((self.here, start[None]), (self.there, goals)):
            for root in roots:
                number = tree.add(root, -1)
                inside, good = leaning.brought(root[None])
                moved = float(np.abs(inside[0] - root).max()) > 0.0
                if moved and good[0] and self.space.clear(root[None], inside)[0]:
                    tree.add(inside[0], number)

    def grow(self, end: float, seed: int) -> Floats | None:
        """(n, a) joints from the start to a goal, None if the trees did not meet in time.

        end: of the time, by `time.monotonic`. seed: of what is random.
        """
        draw = np.random.default_rng(seed)
        low, high = self.leaning.low, self.leaning.high
        reach = LONGEST_STEP * float(self.space.length(low, high))
        for goal in range(len(self.there.rows)):
            if time.monotonic() > end:
                return None
            if (met := self._extended(self.here, 0, self.there.rows[goal])) is not None:
                return self._whole(met, goal)
        one, other = self.here, self.there
        drawn: list[Floats] = []
        while time.monotonic() < end:
            if not drawn:
                some, good = self.leaning.brought(
                    draw.uniform(low, high, (DRAWN_AT_ONCE, len(low)))
                )
                drawn = list(some[good])
                continue
            wanted = drawn.pop()
            near = self._nearest(one, wanted)
            way = wanted - one.rows[near]
            part = min(1.0, reach / max(float(self.space.length(0.0 * way, way)), 1e-9))
            to, good = self.leaning.brought((one.rows[near] + part * way)[None])
            count = len(one.rows)
            if good[0]:
                self._extended(one, near, to[0])
            if len(one.rows) > count:
                new = len(one.rows) - 1
                met = self._extended(other, self._nearest(other, one.rows[new]), one.rows[new])
                if met is not None:
                    return self._whole(new, met) if one is self.here else self._whole(met, new)
            one, other = other, one
        return None

    def _extended(self, tree: _ConeTree, number: int, to: Floats) -> int | None:
        """Goes from a place of a tree towards joints (a,); the place there if they are reached."""
        rows = self.leaning.clear_chain(tree.rows[number], to)
        for row in rows[1:]:
            number = tree.add(row, number)
        return number if np.array_equal(rows[-1], to) else None

    def _nearest(self, tree: _ConeTree, row: Floats) -> int:
        return int(np.argmin(self.space.length(np.array(tree.rows), row)))

    def _whole(self, here: int, there: int) -> Floats:
        """The way through a place that both trees have, under its numbers in them."""
        return np.array([*self.here.back(here)[::-1], *self.there.back(there)[1:]])

    def nearest(self) -> Floats:
        """Of all that moves lead to from the start, what is nearest to a goal."""
        rows = np.array(self.here.rows)
        return np.asarray(rows[int(np.argmin(self.space.length(rows[:, None], self.goals).min(1)))])
