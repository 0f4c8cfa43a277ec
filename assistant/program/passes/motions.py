"""Speeds and blends of moves: by value or by name, and corners whose size is left open."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final, Generic, TypeVar

import numpy as np

from assistant.program import expressions as e
from assistant.program.motion import MAXIMUM_SPEED, Blend, Speed
from assistant.program.passes.legalising import Corners, Legalising
from assistant.program.path import Path
from assistant.program.program import identifier

T = TypeVar("T")

OF_AXES: Final = {
    "rotation": "deg/s of reorientation",
    "external_linear": "mm/s of external axes",
    "external_rotary": "deg/s of external axes",
}
"""Parts of a speed beside that of the tool's tip and of joint moves → what they state."""


def meant(value: T | e.Name, declared: Mapping[str, T]) -> T | e.Name:
    """A value, or what its name stands for; the name itself if that is nothing."""
    if not isinstance(value, e.Name):
        return value
    return next((v for n, v in declared.items() if n.lower() == value.name.lower()), value)


def without_axes(speed: Speed) -> tuple[Speed, list[str]]:
    """The speed's tcp and joint parts, and what the others state that is not usual."""
    usual = MAXIMUM_SPEED
    parts = [text for name, text in OF_AXES.items() if getattr(speed, name) != getattr(usual, name)]
    return Speed(speed.tcp, joint=speed.joint), parts


def joint_percent(tcp: float, most: float) -> float:
    """Whole percent of joint speed for a speed in mm/s, rounded down, at least 1.

    most: mm/s that are taken for 100 percent.
    """
    if math.isinf(tcp):
        return 100.0
    return float(math.floor(min(100.0, max(1.0, 100.0 * tcp / most))))


@dataclass(frozen=True, slots=True)
class Words(Generic[T]):
    """How a language calls speeds, or blends, that it declares.

    kind: what they are. predefined: by name. name: of a value, predefined or to be declared.
    """

    kind: str
    predefined: Mapping[str, T]
    name: Callable[[T], str]

    def meant(self, name: str, declared: Mapping[str, T]) -> T | None:
        """The value that stands for a name: one that is called so; None for a name of its own.

        declared: by lower-case name.
        """
        value = declared.get(name.lower())
        if value is None:
            return self.predefined.get(name.lower())
        return value if self.name(value) == name.lower() else None

    def named(self, declared: Mapping[str, T]) -> dict[str, T]:
        """Those with names of their own."""
        return {n: v for n, v in declared.items() if n.lower() != self.name(v)}


class Named(Generic[T]):
    """The speeds of a program by name, or its blends; filled as moves ask for them.

    sayable: what the language can say of a value; given its name, None for one that has none.
    longest: characters of a name.
    """

    def __init__(
        self,
        words: Words[T],
        given: Mapping[str, T],
        sayable: Callable[[T, str | None], T],
        longest: int,
    ) -> None:
        self._words, self._sayable, self._longest = words, sayable, longest
        self._values = {n: sayable(v, n) for n, v in given.items()}

    def table(self) -> dict[str, T]:
        """Those with names of their own: one that is called as its own value would be is that."""
        return self._words.named(self._values)

    def said(self, value: T | e.Name) -> T | e.Name:
        """A value, or a name where it has one of its own or its own would be too long."""
        if isinstance(value, e.Name):
            known = {n.lower(): v for n, v in self._values.items()}
            return self._words.meant(value.name, known) or value
        said = self._sayable(value, None)
        if len(self._words.name(said)) <= self._longest:
            return said
        for name, known_value in self._values.items():
            if known_value == said:
                return e.Name(name)
        name = identifier(f"{self._words.kind}_1", {*self._values})
        self._values[name] = said
        return e.Name(name)


class Sizing:
    """A size for each corner that the controller is to choose: what it has at a move's speed."""

    def __init__(self, job: Legalising, can: Corners) -> None:
        self.job, self.can = job, can

    def is_open(self, blend: Blend | e.Name) -> bool:
        known = meant(blend, self.job.program.blends)
        return isinstance(known, Blend) and known.radius is not None and math.isinf(known.radius)

    def blend(self, blend: Blend | e.Name, speed: Speed | e.Name) -> Blend | e.Name:
        known, fast = meant(blend, self.job.program.blends), meant(speed, self.job.program.speeds)
        if not (self.is_open(blend) and isinstance(known, Blend) and isinstance(fast, Speed)):
            return blend
        said = Blend(min(self.can.size(fast), math.inf if known.exit is None else known.exit))
        self.job.changed("a corner without size", self.can.name(said), "state one radius in mm")
        return said

    def path(self, path: Path) -> Path:
        """A path whose corners without a size have that of their row's speed."""
        open_ = np.array([self.is_open(blend) for blend in path.blends], dtype=bool)
        rows = np.flatnonzero(open_[path.blend]) if open_.any() else ()
        if not len(rows):
            return path
        pairs, at = np.unique(
            np.stack([path.blend[rows], path.speed[rows]], axis=1), axis=0, return_inverse=True
        )
        more = tuple(self.blend(path.blends[b], path.speeds[s]) for b, s in pairs)
        blend = path.blend.copy()
        blend[rows] = len(path.blends) + at.reshape(-1)
        kept = (more[0] if o else b for o, b in zip(open_, path.blends, strict=True))
        return replace(path, blend=blend, blends=(*kept, *more))
