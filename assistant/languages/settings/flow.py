"""Settings that hold until they are changed, at each line of a program, along every way to it.

Speed, tool or frame may be statements above the moves that they are of. Lines pass their settings
on to those that may run after them, until nothing changes any more. Within a procedure what its
caller has set is INHERITED; a procedure's own effect is worked out once, and used wherever it is
called from. A language says what its lines do, see `Lines`; they are known by their places.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, Final

from assistant.languages.line_graph import EXIT
from assistant.languages.settings.places import ELSEWHERE, NO_LINES, LineSet
from assistant.program.analysis.dataflow import Dataflow, postorder


class Unknown:
    """A setting that is not known, or that differs with the way that leads here."""

    def __repr__(self) -> str:
        return "UNKNOWN"


class Inherited:
    """A setting as the caller of a procedure has it."""

    def __repr__(self) -> str:
        return "INHERITED"


UNKNOWN: Final = Unknown()
INHERITED: Final = Inherited()


@dataclass(frozen=True, slots=True)
class OrInherited:
    """A setting that some ways make, and others leave as the caller of a procedure has it."""

    value: Any


@dataclass(frozen=True, slots=True)
class Held:
    """The value of a setting at a place, and the lines that may have given it.

    interrupts: those of them that interrupts may run at any time, or ELSEWHERE.
    before: lines that may have made it what it is where something unknown comes between: a call
        that may change it, or a jump from nobody knows where.
    """

    value: Any
    by: LineSet = NO_LINES
    interrupts: LineSet = NO_LINES
    before: LineSet = NO_LINES

    def met(self, other: Held, value: Any) -> Held:
        """Either of two, with what is certain of both."""
        return Held(
            value,
            self.by | other.by,
            self.interrupts | other.interrupts,
            self.before | other.before,
        )

    @property
    def needed(self) -> LineSet:
        """The lines without which it might be another."""
        return self.by | self.before

    @property
    def is_inherited(self) -> bool:
        """Whether it may be the caller's."""
        return self.value is INHERITED or isinstance(self.value, OrInherited)


_ELSEWHERE: Final = LineSet.of([ELSEWHERE])

State = tuple[Held, ...]
"""By the numbers of the settings."""


@dataclass(frozen=True, slots=True)
class Sets:
    """A line gives a setting a value, UNKNOWN if the program works it out."""

    setting: int
    value: Any


@dataclass(frozen=True, slots=True)
class Computed:
    """A value that the program works out, and that is the same as long as nothing it names changes.

    value: an expression of the language. names: of the variables in it.
    """

    value: Any
    names: frozenset[str]


@dataclass(frozen=True, slots=True)
class Changes:
    """A line changes variables. names: None for any that there are but for some."""

    names: frozenset[str] | None
    but: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class MaySet:
    """Interrupts may give a setting any value while a line runs. by: lines of theirs."""

    setting: int
    by: LineSet


@dataclass(frozen=True, slots=True)
class Calls:
    """A line calls these, in an order that nobody knows.

    called: procedures by their number; of what is not known, the settings that it may change.
    inside: whether what is not known is lines of the program. What a setting is worked out of is
    the caller's: within what is called, and behind it, names may stand for other variables.
    """

    called: tuple[int | frozenset[int], ...]
    inside: bool = False


@dataclass(frozen=True, slots=True)
class Either:
    """One of these runs."""

    branches: tuple[Steps, ...]


Steps = tuple[Sets | Changes | MaySet | Calls | Either, ...]
"""What a line does to settings, in its order."""


def sets_in(steps: Steps) -> Iterator[Sets]:
    """The values that steps may give, other than in what they call."""
    for step in steps:
        match step:
            case Sets():
                yield step
            case Either(branches):
                for branch in branches:
                    yield from sets_in(branch)


def calls_in(steps: Steps) -> Iterator[int | frozenset[int]]:
    """What steps may call."""
    for step in steps:
        match step:
            case Calls(called=called):
                yield from called
            case Either(branches):
                for branch in branches:
                    yield from calls_in(branch)


def _may_set(steps: Steps, setting: int) -> bool:
    if any(one.setting == setting for one in sets_in(steps)):
        return True
    if any(isinstance(one, frozenset) and setting in one for one in calls_in(steps)):
        return True
    return any(isinstance(one, MaySet) and one.setting == setting for one in steps)


@dataclass(frozen=True, slots=True)
class LineEffects:
    """What is to be known of the lines of a program, by place.

    settings: how many there are. procedures: the places of the lines of each. after: by procedure,
    the places that may follow a line. steps: of the lines that do anything to settings. uses: the
    settings that a line depends on. runs_on: whether control may go on below a line without a
    jump. labels: lines that jumps lead to. inner: lines inside of something that is read whole.
    lost: lines that are come to in ways that nobody knows.
    """

    settings: int
    procedures: Sequence[Sequence[int]]
    after: Sequence[Mapping[int, Sequence[int]]]
    steps: Mapping[int, Steps]
    uses: Callable[[int], frozenset[int]]
    runs_on: Callable[[int], bool]
    labels: frozenset[int]
    inner: frozenset[int]
    lost: frozenset[int]

    def called(self, at: int) -> list[int]:
        """The procedures that a line calls, each once."""
        called = calls_in(self.steps.get(at, ()))
        return list(dict.fromkeys(one for one in called if isinstance(one, int)))


def joined_states(one: State | None, two: State) -> State:
    """What is certain where two ways meet."""
    if one is None or one is two or one == two:
        return two
    return tuple(
        a if a == b else a.met(b, _agreed_value(a.value, b.value))
        for a, b in zip(one, two, strict=True)
    )


def _agreed_value(one: Any, two: Any) -> Any:
    """What two ways agree on, for one caller or for all."""
    if one == two:
        return one
    if not any(value is INHERITED or isinstance(value, OrInherited) for value in (one, two)):
        return UNKNOWN
    made = {value.value if isinstance(value, OrInherited) else value for value in (one, two)}
    made.discard(INHERITED)
    return OrInherited(*made) if len(made) == 1 and UNKNOWN not in made else UNKNOWN


def resolved_state(state: State, inherited: State) -> State:
    """The state with what the caller has in the places that are inherited."""
    if not any(held.is_inherited for held in state):
        return state
    return tuple(
        held.met(up, _resolved_value(held.value, up.value)) if held.is_inherited else held
        for held, up in zip(state, inherited, strict=True)
    )


def _resolved_value(value: Any, given: Any) -> Any:
    return given if value is INHERITED else _agreed_value(value.value, given)


class Flow:
    """What holds at each line of a program.

    before: by line, what holds where it begins. exits: by procedure, what holds where it ends, None
    if it never does. cuts: lines at which procedures are divided: what holds there is INHERITED
    from the line that leads there. divided: the numbers of those procedures. parts: by procedure,
    the places of each part of it. edges: what holds at the end of lines that lead to a cut, by
    line, then by place.
    """

    def __init__(self, lines: LineEffects) -> None:
        self.lines = lines
        self.entry: State = (Held(INHERITED),) * lines.settings
        self._by_any_line = tuple(map(self._made_anywhere, range(lines.settings)))
        self.lost: State = tuple(
            Held(UNKNOWN, before=held.by) if self._is_set(k) else self.entry[k]
            for k, held in enumerate(self._by_any_line)
        )
        self.cuts: frozenset[int] = frozenset()
        self.edges: dict[int, dict[int, State]] = {}
        self.before: dict[int, State] = {}
        self.parts: list[Sequence[Sequence[int]]] = [[places] for places in lines.procedures]
        self.divided: frozenset[int] = frozenset()
        self.exits: list[State | None] = [None] * len(lines.procedures)
        flows = [Dataflow(after, self.after, joined_states) for after in lines.after]
        called = {
            number: [callee for at in places for callee in lines.called(at)]
            for number, places in enumerate(lines.procedures)
        }
        known: list[State | None] | None = None
        while known != self.exits:  # what a procedure calls is run through before it
            known = list(self.exits)
            for number in postorder(called):
                flows[number].found = {}
                self._spread(number, flows[number])
                end = flows[number].found.get(EXIT) if lines.procedures[number] else self.entry
                if end is not None:
                    self.exits[number] = joined_states(self.exits[number], end)
        for number, flow in enumerate(flows):
            self._note(number, flow)

    def cut(self, cuts: frozenset[int]) -> Flow:
        """The same with procedures divided; the effect of a whole procedure stays known."""
        made = copy(self)
        made.cuts, made.edges, made.before, made.parts = cuts, {}, {}, list(self.parts)
        numbered = list(enumerate(self.lines.procedures))
        made.divided = frozenset(k for k, places in numbered if not cuts.isdisjoint(places))
        for number, places in numbered:
            after = self.lines.after[number]
            inside = {at: [to for to in ways if to not in cuts] for at, ways in after.items()}
            flow = Dataflow(inside, made.after, joined_states)
            made._spread(number, flow)
            made._note(number, flow)
            if number in made.divided:
                made._divide(number, places)
        return made

    def _divide(self, number: int, places: Sequence[int]) -> None:
        """Notes the parts of a procedure, and what they hand on to one another."""
        parts: list[list[int]] = [[]]
        for at in places:
            if at in self.cuts and parts[-1]:
                parts.append([])
            parts[-1].append(at)
            behind = self.after(at, self.before[at])
            into = self.cuts.intersection(self.lines.after[number][at])
            if behind is not None and into:
                self.edges[at] = dict.fromkeys(into, behind)
        self.parts[number] = parts

    def _spread(self, number: int, flow: Dataflow[int, State]) -> None:
        """Works out what holds in a procedure."""
        places = self.lines.procedures[number]
        starts = sorted({*places[:1], *self.cuts.intersection(places)})
        lost = sorted(self.lines.lost.intersection(places))
        flow.spread([*((at, self.entry) for at in starts), *((at, self.lost) for at in lost)])

    def _note(self, number: int, flow: Dataflow[int, State]) -> None:
        """Notes that; lines that no way leads to have what stands above them."""
        places, last = self.lines.procedures[number], self.entry
        for at in places:
            if at not in flow.found:
                flow.spread([(at, last)])
            state = flow.found[at]
            last = self.after(at, state) or state
        self.before.update((at, flow.found[at]) for at in places)

    def _made_anywhere(self, setting: int) -> Held:
        """A setting that any of the lines may have made that make it."""
        steps = self.lines.steps.items()
        by = (at for at, made in steps if any(one.setting == setting for one in sets_in(made)))
        return Held(UNKNOWN, LineSet.of(by))

    def _is_set(self, setting: int) -> bool:
        """True if anything may make a setting: a line, an interrupt, or an unknown effect."""
        return any(_may_set(made, setting) for made in self.lines.steps.values())

    # -------------------------------------------------------------------------- one line

    def after(self, at: int, state: State) -> State | None:
        """What holds behind a line; None if it never ends."""
        steps = self.lines.steps.get(at)
        return state if steps is None else self._ran(at, steps, state, [])

    def calls(self, at: int, state: State) -> dict[int, State]:
        """What may hold at the calls in a line, by procedure."""
        met: list[tuple[int, State]] = []
        self._ran(at, self.lines.steps.get(at, ()), state, met)
        found: dict[int, State] = {}
        for number, before in met:
            found[number] = joined_states(found.get(number), before)
        return {number: found.get(number, state) for number in self.lines.called(at)}

    def _ran(
        self, at: int, steps: Steps, state: State, met: list[tuple[int, State]]
    ) -> State | None:
        """What holds behind some steps. met: takes what is called, and what holds there."""
        behind: State | None = state
        for step in steps:
            if behind is None:
                break
            match step:
                case Sets(setting, value):
                    made = Held(value, LineSet.of((at,)))
                    behind = (*behind[:setting], made, *behind[setting + 1 :])
                case Changes(names, but):
                    behind = tuple(_after_changes(held, names, but) for held in behind)
                case MaySet(setting, by):
                    held = behind[setting]
                    held = self._by_any_line[setting] if held.is_inherited else held
                    made = held.met(Held(UNKNOWN, by - _ELSEWHERE, by), UNKNOWN)
                    behind = (*behind[:setting], made, *behind[setting + 1 :])
                case Calls(called, inside):
                    before = self._between(called, behind)
                    inner = tuple(_after_changes(held, None) for held in before)
                    met += [(one, inner) for one in called if isinstance(one, int)]
                    left = [self._left_by(one, before, inside) for one in called]
                    behind = _any_of(left, every=True)
                case Either(branches):
                    behind = _any_of([self._ran(at, branch, behind, met) for branch in branches])
        return behind

    def _between(self, called: Sequence[int | frozenset[int]], state: State) -> State:
        """What may hold before each of several calls, whichever of them have been made."""
        known: State | None = None
        while len(called) > 1 and known != state:
            known = state
            made = _any_of([self._left_by(one, known) for one in called])
            state = known if made is None else joined_states(known, made)
        return state

    def _left_by(
        self, called: int | frozenset[int], state: State, inside: bool = False
    ) -> State | None:
        """What holds behind a call; one that nobody knows may leave what lines before it made.

        inside: or what any line of the program makes.
        """
        if isinstance(called, int):
            end = self.exits[called]
            if end is None:
                return None
            return resolved_state(tuple(_after_changes(held, None) for held in end), state)
        return tuple(
            Held(UNKNOWN, before=held.needed | (self.lost[k].before if inside else NO_LINES))
            if k in called
            else held
            for k, held in enumerate(state)
        )


def _after_changes(
    held: Held, names: frozenset[str] | None, but: frozenset[str] = frozenset()
) -> Held:
    """What is left of a setting where variables change: what was worked out of them is unknown."""
    value = held.value.value if isinstance(held.value, OrInherited) else held.value
    if not isinstance(value, Computed) or value.names <= but:
        return held
    if names is None or not value.names.isdisjoint(names):
        return replace(held, value=UNKNOWN)
    return held


def _any_of(ways: Sequence[State | None], every: bool = False) -> State | None:
    """What is certain behind ways that end, one of which was taken. every: all have to end."""
    ending = [way for way in ways if way is not None]
    return reduce(joined_states, ending) if ending and not (every and None in ways) else None
