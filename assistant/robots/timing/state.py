"""States of a program as it runs: how long it took, where the arm is, and what was done."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from assistant.program.expressions import Expression
from assistant.robots.timing.plan import Plan
from assistant.robots.timing.rows import Settings

if TYPE_CHECKING:
    from assistant.robots.timing.carrying import Carried

JointValues = tuple[float, ...]

MOST_PLACES: Final = 4
"""Places where the arm may be, each timed, before it counts as not known."""


@dataclass(frozen=True, slots=True)
class Duration:
    """Seconds at least and at most; branches of a program make them differ."""

    least: float
    most: float


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """What was done, the last thing first: a plan, seconds of waiting, or another history as
    often as its count says.

    start: seconds of all before it. seconds: of all with it. last: the last plan of all.
    """

    before: History | None
    done: Plan | float | tuple[History, int]
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

    def chain(self) -> list[History]:
        """What was done, the first thing first."""
        nodes = []
        node: History | None = self
        while node is not None:
            nodes.append(node)
            node = node.before
        return nodes[::-1]


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Where a program is after one way through it, or after several that met again.

    places: joints where the arm may be; none if that is not known. known: values of variables
    in lower case, None for one that is not known. history: of the way that takes the longest.
    carried: what the arm carries, None if nobody wants to know.
    """

    least: float = 0.0
    most: float = 0.0
    places: tuple[JointValues, ...] = ()
    settings: Settings = field(default_factory=Settings)
    known: Mapping[str, Expression | None] = field(default_factory=dict)
    history: History | None = None
    carried: Carried | None = None

    def waited(self, seconds: float) -> State:
        if seconds <= 0.0:
            return self
        history = History(self.history, seconds)
        return replace(self, least=self.least + seconds, most=self.most + seconds, history=history)

    def under(self, **settings: float) -> State:
        """The state with other settings from here on."""
        return replace(self, settings=replace(self.settings, **settings))

    def without(self, names: set[str]) -> State:
        """The state with the values of some variables, in lower case, not known."""
        changed = {name: None for name in names if self.known.get(name) is not None}
        return replace(self, known={**self.known, **changed}) if changed else self

    def begun(self) -> State:
        """A state from which a way of its own begins."""
        return replace(self, least=0.0, most=0.0, history=None)

    def then(self, other: State, times: int = 1) -> State:
        """On from here, so often, by what has begun here."""
        history = self.history
        if other.history is not None and times > 0:
            history = History(history, (other.history, times))
        return replace(
            other,
            least=self.least + times * other.least,
            most=self.most + times * other.most,
            history=history,
        )

    def same_state(self, other: State) -> bool:
        """Whether the arm, the settings and the variables are as in another state."""
        return (
            self.places == other.places
            and self.settings == other.settings
            and self.known == other.known
            and self.carried == other.carried
        )


def merged_state(states: Sequence[State]) -> State | None:
    """The state where ways meet again; None if there are none."""
    if len(states) < 2:
        return states[0] if states else None
    longest = max(states, key=lambda state: state.most)
    places = tuple(dict.fromkeys(place for state in states for place in state.places))
    if len(places) > MOST_PLACES or not all(state.places for state in states):
        places = ()
    names = {name for state in states for name in state.known}
    known = {
        name: longest.known.get(name)
        if all(state.known.get(name) == longest.known.get(name) for state in states)
        else None
        for name in names
    }
    carried = longest.carried
    for state in states:
        if carried is not None and state.carried is not None and state.carried != carried:
            carried = carried.met(state.carried)
    least = min(state.least for state in states)
    return replace(longest, least=least, places=places, known=known, carried=carried)
