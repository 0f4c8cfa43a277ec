"""Ways through a program: how long each takes, where it leads, and what was done on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from assistant.program.expressions import Expression
from assistant.robots.timing.plan import Plan
from assistant.robots.timing.rows import Settings

Joints = tuple[float, ...]

MOST_PLACES: Final = 4
"""Places where the arm may be, each timed, before it counts as not known."""


@dataclass(frozen=True, slots=True)
class Duration:
    """Seconds at least and at most; branches of a program make them differ."""

    least: float
    most: float


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """What was done, the last thing first: a plan, seconds of waiting, or another trace as
    often as its count says.

    start: seconds of all before it. seconds: of all with it. last: the last plan of all.
    """

    before: Trace | None
    done: Plan | float | tuple[Trace, int]
    start: float = field(init=False)
    seconds: float = field(init=False)
    last: Plan | None = field(init=False)

    def __post_init__(self) -> None:
        start, last = (
            (0.0, None) if self.before is None else (self.before.seconds, self.before.last)
        )
        if isinstance(self.done, Plan):
            took, last = self.done.seconds, self.done
        elif isinstance(self.done, tuple):
            took, last = self.done[0].seconds * self.done[1], self.done[0].last or last
        else:
            took = self.done
        object.__setattr__(self, "start", start)
        object.__setattr__(self, "seconds", start + took)
        object.__setattr__(self, "last", last)

    def chain(self) -> list[Trace]:
        """What was done, the first thing first."""
        nodes = []
        node: Trace | None = self
        while node is not None:
            nodes.append(node)
            node = node.before
        return nodes[::-1]


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """One way, or several that met again.

    places: joints where the arm may be; none if that is not known. known: values of variables
    in lower case, None for one that is not known. trace: of the way that takes the longest.
    """

    least: float = 0.0
    most: float = 0.0
    places: tuple[Joints, ...] = ()
    settings: Settings = field(default_factory=Settings)
    known: Mapping[str, Expression | None] = field(default_factory=dict)
    trace: Trace | None = None

    def waited(self, seconds: float) -> Way:
        if seconds <= 0.0:
            return self
        trace = Trace(self.trace, seconds)
        return replace(self, least=self.least + seconds, most=self.most + seconds, trace=trace)

    def under(self, **settings: float) -> Way:
        """The way with other settings from here on."""
        return replace(self, settings=replace(self.settings, **settings))

    def without(self, names: set[str]) -> Way:
        """The way with the values of some variables, in lower case, not known."""
        changed = {name: None for name in names if self.known.get(name) is not None}
        return replace(self, known={**self.known, **changed}) if changed else self

    def begun(self) -> Way:
        """A way of its own that starts where this one is."""
        return replace(self, least=0.0, most=0.0, trace=None)

    def then(self, other: Way, times: int = 1) -> Way:
        """On from here, so often, by a way that has begun here."""
        trace = self.trace
        if other.trace is not None and times > 0:
            trace = Trace(trace, (other.trace, times))
        return replace(
            other,
            least=self.least + times * other.least,
            most=self.most + times * other.most,
            trace=trace,
        )

    def same_state(self, other: Way) -> bool:
        """Whether the arm, the settings and the variables are as on another way."""
        return (
            self.places == other.places
            and self.settings == other.settings
            and self.known == other.known
        )


def met(ways: Sequence[Way]) -> Way | None:
    """The ways where they meet again; None if there are none."""
    if len(ways) < 2:
        return ways[0] if ways else None
    longest = max(ways, key=lambda way: way.most)
    places = tuple(dict.fromkeys(place for way in ways for place in way.places))
    if len(places) > MOST_PLACES or not all(way.places for way in ways):
        places = ()
    names = {name for way in ways for name in way.known}
    known = {
        name: longest.known.get(name)
        if all(way.known.get(name) == longest.known.get(name) for way in ways)
        else None
        for name in names
    }
    return replace(longest, least=min(way.least for way in ways), places=places, known=known)
