"""Regions as grids of points, and directions that a tool is to have there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell.reach.rules import NO_DIRECTION, NO_REGION, NO_TURNS, TOO_MANY_POINTS
from assistant.robots.arms.chain import rotation_from_z

MOST_POINTS: Final = 200_000
"""Points, or places, that are looked at."""
MOST_TURNS: Final = 360
CONE_DIRECTIONS: Final = 8
"""Directions about the middle of a cone."""
NAMED_DIRECTIONS: Final = {"down": (0.0, 0.0, -1.0), "up": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, slots=True)
class NumberRange:
    """Numbers from low to high: low, low + step … as far as high. step 0: low alone."""

    low: float
    high: float
    step: float

    def values(self) -> Floats:
        if self.step == 0.0:
            return np.array([self.low])
        return np.asarray(self.low + self.step * np.arange(self.count))

    @property
    def count(self) -> int:
        """A little rounding does not lose the last one."""
        return 1 if self.step == 0.0 else int((self.high - self.low) / self.step + 1e-9) + 1


def parse_range(text: str, what: str) -> NumberRange:
    """`LOW:HIGH:STEP`, or one number; raises Refused."""
    parts = text.split(":")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) == 1 and np.isfinite(numbers).all():
        return NumberRange(numbers[0], numbers[0], 0.0)
    if len(numbers) == 3 and np.isfinite(numbers).all():
        low, high, step = numbers
        if high >= low and step > 0.0 and np.isfinite((high - low) / step):
            if (high - low) / step > MOST_POINTS:
                raise Refused(
                    TOO_MANY_POINTS(
                        count=int((high - low) / step), what=f"steps of {what}", most=MOST_POINTS
                    ),
                    exit_status=2,
                )
            return NumberRange(low, high, step)
    raise Refused(NO_REGION(what=f"no region with {what} = `{text}`"), exit_status=2)


def grid(ranges: Sequence[NumberRange]) -> Floats:
    """(n, c) the points of c ranges, the last one changing first. Raises Refused for too many."""
    count = int(np.prod([float(one.count) for one in ranges]))
    if count > MOST_POINTS:
        raise Refused(TOO_MANY_POINTS(count=count, what="points", most=MOST_POINTS), exit_status=2)
    axes = np.meshgrid(*(one.values() for one in ranges), indexing="ij")
    return np.stack([axis.reshape(-1) for axis in axes], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Directions:
    """Directions (d, 3) of the z axis of a tool, each with t orientations (d, t, 4) about it."""

    names: tuple[str, ...]
    axes: Floats
    quaternions: Floats


def parse_directions(given: Sequence[str], turns: int) -> Directions:
    """What is written for directions: `down`, `up`, `x,y,z`, or one of them with `/DEGREES`.

    turns: of the tool about each that are tried, from the shortest turn of the base's frame on.
    Raises Refused for what is none.
    """
    check_turns(turns)
    names, axes = [], []
    for text in given:
        for name, axis in _cone(text):
            names.append(name)
            axes.append(axis)
    columns = np.array(axes).reshape(-1, 3)
    about = rotations.about([0.0, 0.0, 1.0], np.arange(turns) * (360.0 / turns))
    onto = [rotation_from_z((float(x), float(y), float(z))) for x, y, z in columns]
    turned = [rotations.canonical(rotations.multiply(np.array(one), about)) for one in onto]
    return Directions(tuple(names), columns, np.array(turned).reshape(len(columns), turns, 4))


def check_turns(turns: int) -> None:
    """Raises Refused for a number of turns that is none, or more than are tried."""
    if not 1 <= turns <= MOST_TURNS:
        raise Refused(NO_TURNS(count=turns, most=MOST_TURNS), exit_status=2)


def _cone(text: str) -> list[tuple[str, Floats]]:
    """The middle of a cone and, if it is one, `AROUND` directions on it."""
    middle, slash, angle = text.strip().partition("/")
    axis = _axis(middle, text)
    if not slash:
        return [(middle, axis)]
    tilt = _numbers(angle, 1, text)[0]
    if not 0.0 < tilt <= 180.0:
        raise Refused(NO_DIRECTION(given=text), exit_status=2)
    x, y, z = axis.tolist()
    onto = np.array(rotation_from_z((x, y, z)))
    around = np.arange(CONE_DIRECTIONS) * (360.0 / CONE_DIRECTIONS)
    sine, cosine = np.sin(np.radians(tilt)), np.cos(np.radians(tilt))
    a = np.radians(around)
    circle = np.stack(
        [sine * np.cos(a), sine * np.sin(a), np.full(CONE_DIRECTIONS, cosine)], axis=1
    )
    names = [f"{middle}/{tilt:g}@{one:g}" for one in around]
    return [(middle, axis), *zip(names, rotations.rotate(onto, circle), strict=True)]


def _axis(name: str, text: str) -> Floats:
    found = NAMED_DIRECTIONS.get(name.strip())
    axis = np.array(found) if found else _numbers(name, 3, text)
    length = float(np.linalg.norm(axis))
    if not length > 0.0:
        raise Refused(NO_DIRECTION(given=text), exit_status=2)
    return axis / length


def _numbers(text: str, count: int, whole: str) -> Floats:
    try:
        values = np.array([float(part) for part in text.split(",")])
    except ValueError:
        values = np.zeros(0)
    if len(values) != count or not np.isfinite(values).all():
        raise Refused(NO_DIRECTION(given=whole), exit_status=2)
    return values
