"""The extended Kohonen map of Ritter, Martinetz and Schulten: from pictures to joints.

Each unit of a lattice has a place w among the pictures, joints θ for it, and a matrix A of how the
joints change with the picture. For a picture u the unit s whose place is nearest answers

    coarse   θ_i = θ_s + A_s (u − w_s)        the arm goes there and is seen at v_i
    fine     θ_f = θ_i + A_s (u − v_i)        and at v_f

The pictures give better values, θ* = θ_s + A_s (u − v_i) and A* = A_s + (Δθ − A_s Δv) Δvᵀ / |Δv|²
with the differences of both movements, and the units about the winner learn a share of them.
Sources: Ritter, Martinetz and Schulten, Topology-conserving maps for learning visuo-motor-
coordination (Neural Networks 2, 1989); Neural Computation and Self-Organizing Maps (1992).

Two things are added. Pictures are counted in spreads along their own axes, as a rule of least
squares for A hardly learns along directions in which little changes: those of a tool that turns.
And a unit that moves by Δw takes θ along by A Δw, so its line stays where it was.

A trial shows a target, moves the arm twice and teaches the map. Learning rates and widths of the
neighbourhood cool down from step to step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.learning.rules import BAD_PICTURE_SHAPE

LEAST_SHARE: Final = 2e-3
"""Shares of a Gaussian below which a unit learns nothing from its neighbour."""
_WIDEST_GAUSSIAN: Final = 1e3
"""Units; a wider Gaussian is flat over every lattice."""

LatticeBox = tuple[slice, ...]
"""A part of a lattice."""


@dataclass(slots=True, eq=False)
class Neighbourhood:
    """A Gaussian over a lattice, cut off where it is below `LEAST_SHARE`.

    Made once for many winners: what is about each of them is a part of one array of shares.
    """

    shape: tuple[int, ...]
    width: float
    reaches: tuple[int, ...] = field(init=False)
    shares: Floats = field(init=False)

    def __post_init__(self) -> None:
        width = min(self.width, _WIDEST_GAUSSIAN)
        reach = int(width * np.sqrt(-2.0 * np.log(LEAST_SHARE)))
        self.reaches = tuple(min(reach, count - 1) for count in self.shape)
        self.shares = np.ones(())
        for reach in self.reaches:
            away = np.arange(-reach, reach + 1)
            line = np.exp(-(away**2) / (2.0 * width**2)) if reach else np.ones(1)
            self.shares = self.shares[..., None] * line
        self.shares[self.shares < LEAST_SHARE] = 0.0

    @property
    def alone(self) -> bool:
        """True if the winner has no neighbours any more."""
        return not any(self.reaches)

    def about(self, place: tuple[int, ...]) -> tuple[LatticeBox, Floats]:
        """The box of units near to one, and their shares."""
        box, part = [], []
        for at, reach, count in zip(place, self.reaches, self.shape, strict=True):
            low, high = max(at - reach, 0), min(at + reach + 1, count)
            box.append(slice(low, high))
            part.append(slice(low - at + reach, high - at + reach))
        return tuple(box), self.shares[tuple(part)]


def neighbour_pairs(shape: tuple[int, ...]) -> Rows:
    """(m, 2) units that are neighbours in a lattice, each pair once."""
    numbers = np.arange(int(np.prod(shape))).reshape(shape)
    found = [np.zeros((0, 2), dtype=np.intp)]
    for axis, count in enumerate(shape):
        first = np.take(numbers, np.arange(count - 1), axis).ravel()
        last = np.take(numbers, np.arange(1, count), axis).ravel()
        found.append(np.column_stack([first, last]))
    return np.concatenate(found)


_RANDOM_SIGMA: Final = 0.1
"""Standard deviation of the numbers in A before anything is learnt, in spreads of both sides."""
JOINTS_OF_POINTS: Final = {1: 3, 2: 5}
"""Number of joints that so many seen points determine; three points determine six."""
_LEAST_SPREAD: Final = 0.15
"""Share of the largest spread: along axes with less, curvature of the pictures outweighs their
information.
"""


@dataclass(frozen=True, slots=True, eq=False)
class MapScale:
    """Units of the net: pictures in spreads about their middle, joints in halves of ranges.

    middle: (d,) pixels. frame: (d, d) axes of the pictures as columns, each with the length of an
    inverse spread. low, high: (a,) limits of the joints in answers.
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
        """Length of the picture of a noise of one pixel in each number."""
        return float(np.sqrt((self.frame**2).sum()))


@dataclass(frozen=True, slots=True)
class LearningRates:
    """Present learning rates: shares of the winner, and widths in units of the lattice.

    place, place_width: of w. answer, answer_width: of θ and A. noise: pixels; smaller seen
    movements give no information about A.
    """

    place: float
    place_width: float
    answer: float
    answer_width: float
    noise: float = 0.0


@dataclass(frozen=True, slots=True)
class MapTask:
    """Task of a map: robot and the names of its joints that move, cameras, and number of tool
    points that each of them sees. A picture is u, v of each camera, point by point.
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
    spreads = np.sqrt(np.maximum(squares, _LEAST_SPREAD**2 * squares[-1]))
    low, high = np.array(ranges, dtype=np.float64).T.copy()
    answers = draw.normal(0.0, _RANDOM_SIGMA, (units, axes + axes * seen))
    answers[:, :axes] = draw.uniform(-1.0, 1.0, (units, axes))
    places = draw.uniform(-1.0, 1.0, (units, seen))
    scale = MapScale(middle, frame / spreads, low, high)
    none = np.full(units, np.nan)
    return ExtendedMap(task, shape, scale, places, answers, np.zeros(units), none)


def _all_different(winners: Rows) -> bool:
    return len(set(winners.tolist())) == len(winners)


ArmFunction = Callable[[Floats], Floats]
"""Joints (n, a) to which an arm is moved one after the other → pixels (n, d) at which its tool is
seen there; a row that some camera does not see holds NaN."""
_NEWEST_SHARE: Final = 0.1
"""Share of the newest trial in what a unit misses by."""


@dataclass(frozen=True, slots=True, eq=False)
class Trials:
    """Results for m targets: winners (m,), joints (m, a) and pixels (m, d) of both movements."""

    winners: Rows
    coarse: Floats
    coarse_seen: Floats
    fine: Floats
    fine_seen: Floats


def try_targets(
    net: ExtendedMap, arm: ArmFunction, targets: Floats, more: Floats | float = 0.0
) -> Trials:
    """Move the arm to targets (m, d) pixels, each by a coarse and a fine movement.

    more: (m, a) in angles of the map, added to the fine movements of an arm that tries others. An
    arm that is out of sight after the coarse movement stays there. Raises Refused for an arm that
    does not answer pixels (m, d).
    """
    scale = net.scale
    wanted = scale.pictures(targets)
    winners = net.winners(wanted)
    slopes = net.slopes[winners]
    coarse = scale.joints(net.angles[winners] + apply_slopes(slopes, wanted - net.places[winners]))
    coarse_seen = observe_arm(arm, coarse, targets.shape[1])
    off = np.nan_to_num(wanted - scale.pictures(coarse_seen))
    fine = scale.joints(scale.angles(coarse) + apply_slopes(slopes, off) + more)
    return Trials(winners, coarse, coarse_seen, fine, observe_arm(arm, fine, targets.shape[1]))


def learn_trials(net: ExtendedMap, targets: Floats, done: Trials, pace: LearningRates) -> None:
    """Learns from trials; from those that were out of sight only where targets are."""
    scale, winners = net.scale, done.winners
    wanted = scale.pictures(targets)
    net.learn_places(winners, wanted, pace)
    net.steps += len(winners)
    there = np.isfinite(done.coarse_seen).all(axis=1) & np.isfinite(done.fine_seen).all(axis=1)
    wanted, winners = wanted[there], winners[there]
    first, last = scale.pictures(done.coarse_seen[there]), scale.pictures(done.fine_seen[there])
    slopes, moved = net.slopes[winners], last - first
    turned = scale.angles(done.fine[there]) - scale.angles(done.coarse[there])
    angles = net.angles[winners] + apply_slopes(slopes, wanted - first)
    if net.task.free:
        pull = _null_motion(slopes, -net.angles[winners], net.task.determined)
        angles += _POSTURE_PULL * pace.answer_width * pull
    missed = np.sqrt(((targets[there] - done.fine_seen[there]) ** 2).mean(axis=1))
    teach_units(net, winners, angles, turned, moved, missed, pace)


def teach_units(
    net: ExtendedMap,
    winners: Rows,
    angles: Floats,
    turned: Floats,
    moved: Floats,
    missed: Floats,
    pace: LearningRates,
) -> None:
    """Teach the units (m,) that won what their answers are.

    angles: (m, a) that θ becomes. turned, moved: a movement of the joints (m, a) and of the picture
    (m, d), by which A is corrected. missed: (m,) pixels by which the answers so far are off.
    """
    slopes, axes = net.slopes[winners], net.axes
    size = np.einsum("md,md->m", moved, moved) + max(
        (pace.noise * net.scale.pixel) ** 2, _UNSEEN_MOVEMENT
    )
    wrong = (turned - apply_slopes(slopes, moved)) / size[:, None]
    right = slopes + wrong[:, :, None] * moved[:, None, :]
    corrected = right.reshape(len(winners), net.answers.shape[1] - axes)
    better = np.concatenate([angles, corrected], axis=1)
    net.learn_answers(winners, better, pace)
    before = net.missed[winners]
    lately = np.where(np.isfinite(before), before + _NEWEST_SHARE * (missed - before), missed)
    net.missed[winners] = lately
    np.add.at(net.wins, winners, 1.0)


_POSTURE_PULL: Final = 0.1
"""Share of the way to its preferred posture, times the width of learning, that a free arm takes in
each trial."""


def _null_motion(slopes: Floats, angles: Floats, count: int) -> Floats:
    """Return the part of angles (m, a) that does not change the picture.

    slopes: (m, a, d), whose `count` strongest directions matter: where A is the pseudoinverse of
    the Jacobian of the picture, all visible movements are among these.
    """
    strong = np.linalg.svd(slopes, full_matrices=False)[0][:, :, :count]
    seen = np.einsum("mat,mt->ma", strong, np.einsum("mat,ma->mt", strong, angles))
    return np.asarray(angles - seen)


_UNSEEN_MOVEMENT: Final = 1e-12
"""Squared spread below which a movement is not seen."""


def observe_arm(arm: ArmFunction, joints: Floats, count: int) -> Floats:
    """Return the pixels at which the arm is seen; raises Refused unless they are pixels (m,
    count).
    """
    seen = np.asarray(arm(joints), dtype=np.float64)
    if seen.shape != (len(joints), count):
        raise Refused(
            BAD_PICTURE_SHAPE(shape=seen.shape, wanted=(len(joints), count)), exit_status=2
        )
    return seen


def apply_slopes(slopes: Floats, offsets: Floats) -> Floats:
    """(m, a, d) times (m, d)."""
    return np.asarray(np.matmul(slopes, offsets[..., None])[..., 0])


@dataclass(frozen=True, slots=True)
class Cooling:
    """From the first pace to the last one in so many steps, and the last one from there on.

    Each number goes down by the same part of itself at each step, as in the source of the map.
    """

    first: LearningRates
    last: LearningRates
    steps: int

    def at(self, step: int) -> LearningRates:
        part = min(step / self.steps, 1.0) if self.steps else 1.0

        def now(name: str) -> float:
            begin, end = float(getattr(self.first, name)), float(getattr(self.last, name))
            return begin * (end / begin) ** part if begin else end

        return LearningRates(
            now("place"),
            now("place_width"),
            now("answer"),
            now("answer_width"),
            now("noise"),
        )


_FIRST_RATES: Final = LearningRates(1.0, 1.5, 0.9, 1.2)
_LAST_RATES: Final = LearningRates(0.02, 0.15, 0.3, 0.15)
"""By trial on three and five joints: other widths do as well, shares that stay large do not."""
_RELEARNING_RATES: Final = LearningRates(0.02, 0.15, 0.9, 0.5)
"""From which a map cools that goes on learning after something has changed."""


def first_cooling(steps: int, noise: float = 0.0) -> Cooling:
    """Return the cooling of a new map. noise: pixels."""
    return _cooling_with_noise(_FIRST_RATES, _LAST_RATES, steps, noise)


def relearning_cooling(steps: int, noise: float = 0.0) -> Cooling:
    """Return the cooling of a trained map whose arm or cameras have changed."""
    return _cooling_with_noise(_RELEARNING_RATES, _LAST_RATES, steps, noise)


def rates_in_use(noise: float = 0.0) -> LearningRates:
    """Return the rates of a map that learns during use."""
    return _cooling_with_noise(_RELEARNING_RATES, _LAST_RATES, 0, noise).last


def _cooling_with_noise(
    first: LearningRates, last: LearningRates, steps: int, noise: float
) -> Cooling:
    def with_noise(pace: LearningRates) -> LearningRates:
        return LearningRates(pace.place, pace.place_width, pace.answer, pace.answer_width, noise)

    return Cooling(with_noise(first), with_noise(last), steps)
