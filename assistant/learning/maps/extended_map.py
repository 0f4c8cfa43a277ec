"""The extended Kohonen map of Ritter, Martinetz and Schulten: from what is seen to joints.

Each unit of a lattice has a place w among the pictures, joints θ for it, and a matrix A of how the
joints change with the picture. For a picture u the unit s whose place is nearest answers

    coarse   θ_i = θ_s + A_s (u − w_s)        the arm goes there and is seen at v_i
    fine     θ_f = θ_i + A_s (u − v_i)        and at v_f

What was seen tells better ones, θ* = θ_s + A_s (u − v_i) and A* = A_s + (Δθ − A_s Δv) Δvᵀ / |Δv|²
with the differences of both movements, and the units about the winner learn a share of them.
Sources: Ritter, Martinetz and Schulten, Topology-conserving maps for learning visuo-motor-
coordination (Neural Networks 2, 1989); Neural Computation and Self-Organizing Maps (1992).

Two things are added. Pictures are counted in spreads along their own axes, as a rule of least
squares for A hardly learns along directions in which little is seen to change: those of a tool that
turns. And a unit that moves by Δw takes θ along by A Δw, so that its line stays where it was.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.learning.maps.lattice import LatticeBox, Neighbourhood

RANDOM_SIGMA: Final = 0.1
"""Standard deviation of the numbers in A before anything is learnt, in spreads of both sides."""
JOINTS_OF_POINTS: Final = {1: 3, 2: 5}
"""Number of joints that so many seen points determine; three points determine six."""
LEAST_SPREAD: Final = 0.15
"""Of the largest spread: along axes of less, pictures curve more than they tell."""


@dataclass(frozen=True, slots=True, eq=False)
class MapScale:
    """What the net counts in: pictures in spreads about their middle, joints in halves of ranges.

    middle: (d,) pixels. frame: (d, d) axes of the pictures as columns, each a spread long inverted.
    low, high: (a,) between which joints are answered.
    """

    middle: Floats
    frame: Floats
    low: Floats
    high: Floats

    def pictures(self, pixels: Floats) -> Floats:
        return np.asarray((pixels - self.middle) @ self.frame)

    def pixels(self, pictures: Floats) -> Floats:
        return np.asarray(np.linalg.solve(self.frame.T, pictures.T).T + self.middle)

    def angles(self, joints: Floats) -> Floats:
        return np.asarray((2.0 * joints - self.high - self.low) / (self.high - self.low))

    def joints(self, angles: Floats) -> Floats:
        """Joints (n, a) inside their ranges, to the last bit."""
        wide = (angles * (self.high - self.low) + self.high + self.low) / 2.0
        return np.asarray(np.clip(wide, self.low, self.high))

    def clipped(self, angles: Floats) -> Floats:
        """(n, a) degrees (mm) by which angles leave the ranges, with their sign."""
        wide = (angles * (self.high - self.low) + self.high + self.low) / 2.0
        return np.asarray(wide - np.clip(wide, self.low, self.high))

    @property
    def pixel(self) -> float:
        """How long the picture of a noise of one pixel in each number is."""
        return float(np.sqrt((self.frame**2).sum()))


@dataclass(frozen=True, slots=True)
class LearningRates:
    """How much is learnt now: shares of the winner, and widths in units of the lattice.

    place, place_width: of w. answer, answer_width: of θ and A. noise: pixels; movements that are
    seen to be as small tell nothing of A.
    """

    place: float
    place_width: float
    answer: float
    answer_width: float
    noise: float = 0.0


@dataclass(frozen=True, slots=True)
class MapTask:
    """What a map is of: robot and the names of its joints that move, cameras, and how many points
    of the tool each of them sees. A picture is u, v of each camera, point by point.
    """

    robot: str
    axes: tuple[str, ...]
    cameras: tuple[str, ...]
    points: int

    @property
    def seen(self) -> int:
        """Numbers of a picture."""
        return 2 * len(self.cameras) * self.points

    @property
    def determined(self) -> int:
        """Number of joints that the points determine, at most all that move."""
        return min(JOINTS_OF_POINTS.get(self.points, 6), len(self.axes))

    @property
    def free(self) -> bool:
        """True if the points leave joints open: the posture nearest to the middle is learnt."""
        return self.determined < len(self.axes)


@dataclass(slots=True, eq=False)
class ExtendedMap:
    """shape: of the lattice of n units. places: (n, d) w. answers: (n, a + a·d) θ and A, row by
    row; all in what `scale` counts in. wins: (n,) how often a unit has won. missed: (n,) pixels by
    which its fine movements were seen to miss lately, root mean square; NaN for a unit that never
    won. steps: trials that were learnt from.
    """

    task: MapTask
    shape: tuple[int, ...]
    scale: MapScale
    places: Floats
    answers: Floats
    wins: Floats
    missed: Floats
    steps: int = 0
    _half_squares: Floats = field(init=False)
    _work: Floats = field(init=False)

    def __post_init__(self) -> None:
        self._half_squares = 0.5 * np.einsum("nd,nd->n", self.places, self.places)
        self._work = np.empty(max(self.places.size, self.answers.size))

    @property
    def units(self) -> int:
        return len(self.places)

    @property
    def axes(self) -> int:
        return len(self.scale.low)

    @property
    def angles(self) -> Floats:
        """(n, a) θ."""
        return self.answers[:, : self.axes]

    @property
    def slopes(self) -> Floats:
        """(n, a, d) A."""
        return self.answers[:, self.axes :].reshape(self.units, self.axes, -1)

    def winners(self, pictures: Floats) -> Rows:
        """(m,) the units nearest to pictures (m, d)."""
        return np.asarray((self._half_squares - pictures @ self.places.T).argmin(axis=1))

    def learn_places(self, winners: Rows, pictures: Floats, pace: LearningRates) -> None:
        """Draws units towards pictures (m, d), one after the other; their lines stay."""
        about = Neighbourhood(self.shape, pace.place_width)
        if about.alone and _all_different(winners):
            moved = pace.place * (pictures - self.places[winners])
            self.answers[winners, : self.axes] += np.einsum(
                "mad,md->ma", self.slopes[winners], moved
            )
            self.places[winners] = now = self.places[winners] + moved
            self._half_squares[winners] = 0.5 * np.einsum("md,md->m", now, now)
            return
        for place, picture in zip(self._at(winners), pictures, strict=True):
            box, shares = about.about(place)
            self._draw_places(box, picture, pace.place * shares)

    def learn_answers(self, winners: Rows, better: Floats, pace: LearningRates) -> None:
        """Draws θ and A of units towards better ones (m, a + a·d), one after the other."""
        about = Neighbourhood(self.shape, pace.answer_width)
        if about.alone and _all_different(winners):
            self.answers[winners] += pace.answer * (better - self.answers[winners])
            return
        grid = self.answers.reshape(*self.shape, -1)
        for place, answer in zip(self._at(winners), better, strict=True):
            box, shares = about.about(place)
            near = grid[box]
            work = self._work[: near.size].reshape(near.shape)
            np.subtract(answer, near, out=work)
            work *= pace.answer * shares[..., None]
            near += work

    def _draw_places(self, box: LatticeBox, picture: Floats, shares: Floats) -> None:
        near = self.places.reshape(*self.shape, -1)[box]
        lines = self.answers.reshape(*self.shape, -1)[box]
        moved = self._work[: near.size].reshape(near.shape)
        np.subtract(picture, near, out=moved)
        moved *= shares[..., None]
        near += moved
        for axis, slope in enumerate(range(self.axes, lines.shape[-1], near.shape[-1])):
            row = lines[..., slope : slope + near.shape[-1]]
            lines[..., axis] += np.einsum("...d,...d->...", row, moved)
        self._half_squares.reshape(self.shape)[box] = 0.5 * np.einsum("...d,...d->...", near, near)

    def _at(self, units: Rows) -> list[tuple[int, ...]]:
        return list(
            zip(*(row.tolist() for row in np.unravel_index(units, self.shape)), strict=True)
        )


def random_map(
    task: MapTask, shape: tuple[int, ...], pictures: Floats, ranges: Floats, seed: int = 0
) -> ExtendedMap:
    """A map that has learnt nothing: all of it is drawn at random.

    pictures: (m, d) pixels of what is seen, of which only middle and spreads are kept; at least two
    that differ. ranges: (a, 2) between which joints are answered.
    """
    draw = np.random.default_rng(seed)
    units, seen, axes = int(np.prod(shape)), pictures.shape[1], len(ranges)
    middle = pictures.mean(axis=0)
    squares, frame = np.linalg.eigh(np.cov((pictures - middle).T))
    spreads = np.sqrt(np.maximum(squares, LEAST_SPREAD**2 * squares[-1]))
    low, high = np.array(ranges, dtype=np.float64).T.copy()
    answers = draw.normal(0.0, RANDOM_SIGMA, (units, axes + axes * seen))
    answers[:, :axes] = draw.uniform(-1.0, 1.0, (units, axes))
    places = draw.uniform(-1.0, 1.0, (units, seen))
    scale = MapScale(middle, frame / spreads, low, high)
    none = np.full(units, np.nan)
    return ExtendedMap(task, shape, scale, places, answers, np.zeros(units), none)


def _all_different(winners: Rows) -> bool:
    return len(set(winners.tolist())) == len(winners)
