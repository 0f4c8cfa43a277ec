"""Inputs of programs that are compared: a scenario that both read, and what ends their waits.

Time differs between two languages, what programs do does not: an input changes when a number of
motions, delays and stops have been reported (beats), or when the program has waited for so long
that only an input can help it (idle). So both programs read the same. `Wiring` names the signals
that both have, whatever each calls them.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field
from random import Random
from typing import Final, Protocol

from assistant.base.data_classes import dataclass
from assistant.virtual.events import Awaited, BranchKey, Logged, Moved, Stopped, Switched, Waited
from assistant.virtual.kernel import Ending, Kernel, Signals, Task
from assistant.virtual.kernel.kernel import NEVER

Wires = tuple[str, ...]
"""Bits of a signal, the lowest first; a signal without numbers is one wire of the same name."""

_GROUP_BITS: Final = 16
"""Bits of a group of signals of unknown width: those of a controller's word."""


@dataclass(frozen=True, slots=True)
class Wiring:
    """Wires of the names that a program reads. named: wires by names in lower case.

    wide: names of wires that hold numbers of more than a bit. Any other name is a wire itself.
    """

    named: Mapping[str, Wires] = field(default_factory=dict)
    wide: frozenset[str] = frozenset()

    def wires(self, name: str) -> Wires:
        return self.named.get(name, (name,))

    def bits(self, name: str) -> int:
        """Return the number of bits of the number that a name reads."""
        count = len(self.wires(name))
        return _GROUP_BITS if count == 1 and name in self.wide else count

    def value(self, name: str, state: Mapping[str, float]) -> float:
        """Return the value that a name reads from wires; missing ones are 0."""
        wires = self.wires(name)
        if len(wires) == 1:
            return state.get(wires[0], 0.0)
        return float(sum(int(state.get(wire, 0.0)) << at for at, wire in enumerate(wires)))

    def spread(self, name: str, value: float) -> dict[str, float]:
        """Return the values of the wires of a name that reads a value."""
        wires = self.wires(name)
        if len(wires) == 1:
            return {wires[0]: value}
        return {wire: float(int(value) >> at & 1) for at, wire in enumerate(wires)}


POLLS: Final = 50
"""Readings at one beat and one position after which a program counts as waiting in a loop."""
_MOST_ANSWERS: Final = 60
"""Waits that are answered in one run: a program of an endless cycle has seen enough by then."""
_MOST_SAID: Final = 5
"""Changes of inputs that a finding names."""
_MOST_ITERATIONS: Final = 5
"""Evaluations of one condition that are recorded; in a loop a counter may depend on them."""
_TIMED: Final = 10
"""Evaluations of a condition with a timer, all with one outcome, that are a wait for its time."""
_READ_BEFORE: Final = 3
"""Statements before a condition in which what it compares may be read from a timer."""
_MANY_EVALUATIONS: Final = 1000
"""Evaluations of a wait for a timer after which its time passes faster, so that a long one ends."""
_HASTE: Final = 0.01
"""Part of the time of a wait by which each further evaluation lengthens it."""
LONG: Final = 1e5
"""Seconds after which such a wait is one for ever."""
_RECENT: Final = 12
"""Readings before a branch that it may hang on."""


@dataclass(frozen=True, slots=True)
class Moment:
    """When an input changes: after a beat, at once or when the program idles for the nth time."""

    beat: int = 0
    idle: int = 0

    @property
    def order(self) -> tuple[int, int]:
        return self.beat, self.idle


State = tuple[tuple[str, float], ...]
"""Wires and what they are from then on, in order of their names."""


@dataclass(frozen=True, slots=True)
class Scenario:
    """Values of the inputs over a run; inputs without a name here are 0."""

    changes: tuple[tuple[Moment, State], ...] = ()

    def at(self, moment: Moment) -> State | None:
        """Return the changes of inputs at a moment: empty for no change, None if not defined."""
        return next((state for when, state in self.changes if when == moment), None)

    def changed(self, moment: Moment, state: Mapping[str, float]) -> Scenario:
        """The same with other inputs from a moment on."""
        then = {**dict(self.at(moment) or ()), **state}
        now = dict(self.changes) | {moment: tuple(sorted(then.items()))}
        return Scenario(tuple(sorted(now.items(), key=lambda one: one[0].order)))

    def silent(self, moment: Moment) -> Scenario:
        """The same up to a moment, at which nothing becomes of inputs."""
        before = tuple(one for one in self.changes if one[0].order < moment.order)
        return Scenario((*before, (moment, ())))

    def until(self, moment: Moment) -> Scenario:
        """The same up to a moment, and what becomes of inputs then."""
        return Scenario(tuple(one for one in self.changes if one[0].order <= moment.order))

    def said(self, names: Mapping[str, str]) -> str:
        """For people. names: of wires, as they know them."""
        told = [
            ", ".join(f"{names.get(wire, wire)}={value:g}" for wire, value in state)
            for _, state in self.changes
            if state
        ]
        more = "" if len(told) <= _MOST_SAID else f", and {len(told) - _MOST_SAID} changes more"
        return (", then ".join(told[:_MOST_SAID]) or "all inputs 0") + more


Readings = tuple[tuple[str, Moment], ...]
"""Inputs that were read, and when."""


@dataclass(frozen=True, slots=True)
class Taken:
    """A way that was gone, and the inputs that were read shortly before. own: by the statement."""

    way: BranchKey
    read: Readings
    own: Readings = ()


class Answering(Protocol):
    """Says what a wait is for."""

    def answer(self, driver: Driver, task: Task, read: tuple[str, ...]) -> Mapping[str, float]:
        """Return the new values of wires that let a program continue; empty for none.

        read: the names that it reads while it waits.
        """


@dataclass(eq=False)
class Driver(Mapping[str, float]):
    """Plays a scenario to a program: the inputs of its board, as a table by its names.

    answering: ends waits that the scenario does not end; None to leave them. played: the scenario
    with these answers. taken: each branch that was taken, by its first time. reads: names ever
    read. ended: moment of the answer to a wait that may end without one, by its position. watched:
    beats at which an input was checked for an interrupt, by its name. met: readings of waits that
    came to their end, by their positions and whether these had to wait. unanswered: position of the
    wait that the run ends at, as no input ends it. iterations: the inputs that a condition read
    each time, at different moments, by its position. last: the branch that was taken last before so
    many events. timing: conditions that may depend on a timer since the last event: when each was
    first evaluated, its outcome, and how often it had that outcome, by its position.
    ended_by_timer: whether such a condition has ended a loop. behind_input: whether a timer has
    ended a wait that began with an input.
    """

    kernel: Kernel
    wiring: Wiring
    scenario: Scenario
    answering: Answering | None = None
    state: dict[str, float] = field(default_factory=dict)
    taken: dict[BranchKey, Taken] = field(default_factory=dict)
    reads: set[str] = field(default_factory=set)
    ended: dict[object, Moment] = field(default_factory=dict)
    watched: dict[str, dict[Moment, None]] = field(default_factory=dict)
    met: dict[tuple[object, bool], Readings] = field(default_factory=dict)
    unanswered: object = None
    iterations: dict[tuple[str, int], list[Readings]] = field(default_factory=dict)
    last: dict[int, BranchKey] = field(default_factory=dict)
    timing: dict[tuple[str, int], tuple[float, int, int]] = field(default_factory=dict)
    answers: int = 0
    ended_by_timer: bool = False
    behind_input: bool = False

    def __post_init__(self) -> None:
        self.beat = self.idles = 0
        self.played = self.scenario
        self._recent: deque[tuple[str, Moment]] = deque(maxlen=_RECENT)
        self._polled: dict[tuple[object, str], int] = {}
        self._since = 0.0
        self._polling: dict[str, None] = {}
        self._asking = False
        self._looks = 0
        self._step, self._here = -1, dict[str, Moment]()
        self._seen: set[object] = set()
        self._waiting: set[object] = set()
        self._silent: set[object] = set()
        self._apply(dict(self.scenario.at(Moment()) or ()))
        self.kernel.board.inputs = _Inputs(self)
        self.kernel.told.append(self._told)
        self.kernel.stuck = self._stuck
        self.kernel.branch, self.kernel.timed = self._branch, self._still
        self.kernel.met, self.kernel.looked = self._met, self._looked

    # ------------------------------------------------------------------------ what is read

    @property
    def recent(self) -> Readings:
        """The last readings, which what happens now may hang on."""
        return tuple(self._recent)

    def __getitem__(self, name: str) -> float:
        """Return the present value of an input, and count it as a reading."""
        self.reads.add(name)
        self._recent.append((name, Moment(self.beat, self.idles)))
        # Readings since the last statement are those that a branch of this statement hangs on.
        if self.kernel.steps != self._step:
            self._step = self.kernel.steps
            self._here.clear()
        self._here[name] = Moment(self.beat, self.idles)
        # Read for an interrupt, not by the program: no loop that waits for an answer.
        if self.kernel.looking:
            self.watched.setdefault(name, {})[Moment(self.beat)] = None
        elif self._asking:
            self._polling[name] = None
        elif self.kernel.tasks:
            self._poll(name)
        return self.wiring.value(name, self.state)

    def __contains__(self, name: object) -> bool:
        return name in self.wiring.named

    def __iter__(self) -> Iterator[str]:
        return iter(self.wiring.named)

    def __len__(self) -> int:
        return len(self.wiring.named)

    def _poll(self, name: str) -> None:
        """A loop that only reads does what a wait does."""
        place = self.kernel.tasks[0].where()
        if not self._polled:
            self._since = self.kernel.clock
        self._polled[place, name] = count = self._polled.get((place, name), 0) + 1
        if count == POLLS:
            # All names that were read nearly as often belong to the same loop.
            again = [key for key, c in self._polled.items() if 2 * c >= POLLS]
            names = tuple(dict.fromkeys(name for _, name in again))
            if not self._idle(self.kernel.tasks[0], names, place, self._since):
                self._polled |= dict.fromkeys(again, POLLS)  # it has been asked for all of them

    # --------------------------------------------------------------------- what is told of it

    def _told(self, row: Logged) -> None:
        self.timing.clear()
        self._looks = 0
        match row.what:
            case Moved() | Stopped():
                self._next()
            # Waits of no time and longest times differ between languages, and are no beats.
            case Waited(seconds=seconds, limit=False) if seconds > 0.0:
                self._next()
            case Switched() | Waited(limit=True):
                self._still()
        for name in self.kernel.board.inputs.watched:
            self.watched.setdefault(name, {})[Moment(self.beat)] = None

    def _next(self) -> None:
        self.beat, self.idles = self.beat + 1, 0
        self._still()
        self._seen.clear()
        self._waiting.clear()
        self._silent.clear()
        self._apply(dict(self.scenario.at(Moment(self.beat)) or ()))

    def _still(self) -> None:
        """Nothing has been read since."""
        self._polled.clear()

    def _branch(self, file: str, at: int, way: int) -> None:
        self.last[len(self.kernel.log)] = file, at, way
        here = tuple(self._here.items()) if self.kernel.steps == self._step else ()
        iterations = self.iterations.setdefault((file, at), [])
        if here and len(iterations) < _MOST_ITERATIONS and here not in iterations:
            iterations.append(here)
        if (file, at, way) not in self.taken:
            self.taken[file, at, way] = Taken((file, at, way), self.recent, here)
        # Only a condition that shortly follows a reading of the time may hang on a timer.
        if self.kernel.steps - self.kernel.clocked <= _READ_BEFORE:
            self._evaluated((file, at), way)

    def _evaluated(self, place: tuple[str, int], way: int) -> None:
        """A loop that looks at a timer does what a wait with a longest time does."""
        kernel = self.kernel
        since, before, count = self.timing.pop(place, (kernel.clock, way, 0))
        if way == before:
            self.timing[place] = since, way, count + 1
            self._hasten(kernel.tasks[0], since, count)
        # A change after a few evaluations is a plain branch; after many it is the end of a wait.
        elif count >= _TIMED:
            self.ended_by_timer = True
            self._lasted(kernel.tasks[0], since, count)

    def _looked(self, task: Task, since: float, over: bool) -> None:
        looks, self._looks = self._looks, 0 if over else self._looks + 1
        if over:
            self._lasted(task, since, looks)
        else:
            self._hasten(task, since, self._looks)

    def _hasten(self, task: Task, since: float, count: int) -> None:
        """Let time pass faster in a wait for a timer after many checks."""
        if count < _MANY_EVALUATIONS:
            return
        # Longer the longer it lasts: a wait of hours ends after some hundreds of evaluations more.
        waited = self.kernel.clock - since
        if waited > LONG:
            self.kernel.halt(task, Ending("stopped", task.waits_for or NEVER))
        self.kernel.clock += _HASTE * waited

    def _lasted(self, task: Task, since: float, count: int) -> None:
        """Only what has passed since the event before can be compared; nothing where that is an
        input, which the driver gives to either program at another time.

        count: evaluations since that event that did not end the wait.
        """
        last = self.kernel.log[-1] if self.kernel.log else None
        if last is None or not isinstance(last.what, Awaited):
            began = since if last is None else max(since, last.time)
            self.kernel.tell(task, Waited(self.kernel.clock - began, limit=True))
        elif count:
            self.behind_input = True

    def _met(self, task: Task, until: Callable[[], bool]) -> None:
        place = task.where(), task.where() in self._waiting
        if place not in self.met:
            # Evaluating the condition once more reads its
            # inputs again, which is no reading of the program.
            before = self._recent.copy()
            moment = Moment(self.beat, self.idles)
            self.met[place] = tuple((name, moment) for name in self._looked_at(until))
            self._recent = before

    def _looked_at(self, until: Callable[[], bool]) -> tuple[str, ...]:
        """Names of inputs that a condition reads."""
        self._polling.clear()
        self._asking = True
        until()
        self._asking = False
        return tuple(self._polling)

    def _stuck(self, task: Task) -> bool:
        ends = task.wakes < math.inf
        moment = Moment(self.beat, self.idles + 1)
        given = self.scenario.at(moment)
        if task.until is None or task.until in self._silent:
            return False
        # A limited wait is met a second time: no input came for it, and its time is to run out.
        if given is None and ends and task.until in self._seen:
            given = ()  # whoever plays this again is to leave this wait alone from here on
            self.scenario = self.scenario.changed(moment, {})
            self.played = self.played.changed(moment, {})
        self._seen.add(task.until)
        self._waiting.add(task.where())
        read = self._looked_at(task.until)
        helps = read or self.kernel.board.inputs.watched
        answered = bool(helps) and self._idle(task, read, task.where() if ends else None)
        if given == ():
            self._silent.add(task.until)
            # its next checks are no loop that waits for an answer
            self._polled |= {(self.kernel.tasks[0].where(), name): POLLS for name in read}
        elif not answered and not ends:
            self.unanswered = task.where()
        return answered

    def would(self, change: Mapping[str, float], until: Callable[[], bool]) -> bool:
        """True if a condition would be met with other inputs."""
        # The inputs are put back: this only asks, and must not wake listeners.
        before = dict(self.state)
        self.state.update(change)
        self._asking = True
        try:
            return until()
        finally:
            self._asking = False
            self.state = before

    def _idle(
        self, task: Task, read: tuple[str, ...], ends: object, since: float | None = None
    ) -> bool:
        """Handle a wait of the program; True if an input has changed for it.

        read: the names that it reads. ends: the position of a wait that may end without an input,
        None for another one. since: when a loop began to read; an input comes then, so that it
        takes as little time as an awaited one.
        """
        self.idles += 1
        moment = Moment(self.beat, self.idles)
        given = self.scenario.at(moment)
        change = dict(given or ())
        for name in self.kernel.board.inputs.watched:
            self.watched.setdefault(name, {})[moment] = None
        if given is None and self.answering is not None and self.answers >= _MOST_ANSWERS:
            self.kernel.end(Ending("steps", f"more than {_MOST_ANSWERS} waits"))
            return True
        if given is None and self.answering is not None and read:
            change = dict(self.answering.answer(self, task, read))
            if change:
                self.answers += 1
                self.played = self.played.changed(moment, change)
                if ends is not None:
                    self.ended.setdefault(ends, moment)
        if change:
            self._still()
            # The polls of a loop took time of the simulated
            # clock, which the awaited input would not take.
            if since is not None:
                self.kernel.clock = since
            self.kernel.tell(task, Awaited(tuple(sorted(change.items()))))
        self._apply(change)
        return bool(change)

    def put(self, name: str, value: float) -> None:
        """An input gets a value from elsewhere."""
        self._apply(self.wiring.spread(name, value))

    def _apply(self, change: Mapping[str, float]) -> None:
        """Change inputs and call the listeners of each."""
        changed = {wire for wire, value in change.items() if self.state.get(wire, 0.0) != value}
        if not changed:
            return
        # A copy: a listener may end itself.
        listeners = tuple(self.kernel.board.inputs.listeners)
        names = [n for n in (*self.wiring.named, *changed) if changed & set(self.wiring.wires(n))]
        # A name may be a group of several wires: its value is compared as a complete number.
        before = {name: self.wiring.value(name, self.state) for name in names} if listeners else {}
        self.state.update(change)
        for name, value in before.items():
            for listener in listeners:
                listener(name, value, self.wiring.value(name, self.state))


class _Inputs(Signals):
    """Inputs of a board that a driver has."""

    def __init__(self, driver: Driver) -> None:
        super().__init__(driver)
        self._driver = driver

    def set(self, name: str, value: float) -> None:
        self._driver.put(name, value)


PLAIN_ANSWERS: Final = 15
"""Bits of the largest number that is tried: with one more it may have a sign, or be too large for a
variable, and the manuals do not tell what becomes of it."""


@dataclass
class Answers:
    """Ends waits: with the values that let a program go on."""

    random: Random
    numbers: list[int]

    def answer(self, driver: Driver, task: Task, read: tuple[str, ...]) -> Mapping[str, float]:
        wiring, state = driver.wiring, driver.state
        tries = [*self._singly(wiring, state, read), *self._jointly(wiring, read)]
        if not tries:
            return {}
        until = task.until if task.waiting else None
        if until is None:  # a loop that only reads: one of what may help
            return self.random.choice(tries)
        for change in tries:
            if driver.would(change, until):
                return change
        return {}

    def _singly(
        self, wiring: Wiring, state: Mapping[str, float], read: tuple[str, ...]
    ) -> Iterator[Mapping[str, float]]:
        """Another value of one input."""
        for name in read:
            bits = wiring.bits(name)
            if bits == 1:
                yield wiring.spread(name, 1.0 - wiring.value(name, state))
                continue
            # Numbers of the program and their neighbours:
            # these tell apart <, <= and = of a comparison.
            near = {n + by for n in self.numbers for by in (0, 1, -1)} | {
                0,
                (1 << min(bits, PLAIN_ANSWERS)) - 1,
            }
            values = sorted(value for value in near if 0 <= value < 1 << bits)
            yield from (wiring.spread(name, float(value)) for value in values)

    def _jointly(self, wiring: Wiring, read: tuple[str, ...]) -> Iterator[Mapping[str, float]]:
        """All inputs that are read at once, and numbers that are read bit by bit."""
        if len(read) > 1:
            for value in (1.0, 0.0):
                yield {wire: value for name in read for wire in wiring.wires(name)}
        for wires, _ in answer_rows(wiring, dict.fromkeys(read, Moment())):
            for number in self.numbers:
                if number < 1 << len(wires):
                    yield {wire: float(number >> i & 1) for i, wire in enumerate(wires)}


def answer_rows(wiring: Wiring, names: Mapping[str, Moment]) -> list[tuple[list[str], Moment]]:
    """Wires with numbers that follow each other: bits that are read as one number."""
    single = {
        int(n): when for n, when in names.items() if n.isdecimal() and not wiring.named.get(n)
    }
    found: list[tuple[list[str], Moment]] = []
    for number in sorted(single):
        if found and int(found[-1][0][-1]) == number - 1:
            found[-1][0].append(str(number))
        else:
            found.append(([str(number)], single[number]))
    return [(wires, when) for wires, when in found if len(wires) > 1]
