"""Dataflow of settings: speed, tool or frame in force at each line, along every path to it.

Settings may be statements above the moves they belong to. Lines pass their settings on to the lines
that may run after them, until nothing changes any more. Within a procedure the settings of its
caller are INHERITED; the effect of a procedure is worked out once and used wherever it is called.
An interrupt that is enabled may change settings between any two lines: its subroutine returns to
the interrupted line with everything that it has set. A language states what its lines do, see
`LineEffects`; lines are known by their indices. `UnknownSettings` explains why a setting is not
known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import reduce
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.languages.line_blocks import EXIT
from assistant.program.analysis.dataflow import Dataflow, postorder, reachable
from assistant.program.expressions import Reason

ELSEWHERE: Final = -1
"""A line of another program."""


@dataclass(frozen=True, slots=True)
class LineSet:
    """Places of lines, and ELSEWHERE. bits: the last one for ELSEWHERE, the next for line 0."""

    bits: int = 0

    @staticmethod
    def of(places: Iterable[int]) -> LineSet:
        marks = bytearray()
        for place in places:
            # ELSEWHERE is -1, so lines are one bit further on.
            byte, bit = divmod(place - ELSEWHERE, 8)
            if byte >= len(marks):
                marks.extend(bytes(byte + 1 - len(marks)))
            marks[byte] |= 1 << bit
        return LineSet(int.from_bytes(marks, "little"))

    def __or__(self, other: LineSet) -> LineSet:
        """Those of both; one of the two if it has them all, so that many lines share one set."""
        bits = self.bits | other.bits
        # States share sets, so that equal ones are found by identity and take no more room.
        if bits == self.bits:
            return self
        return other if bits == other.bits else LineSet(bits)

    def __sub__(self, other: LineSet) -> LineSet:
        return LineSet(self.bits & ~other.bits)

    def __bool__(self) -> bool:
        return bool(self.bits)

    def __iter__(self) -> Iterator[int]:
        """In their order."""
        # Backwards, without the prefix `0b`: the lowest bit comes first.
        said = bin(self.bits)[:1:-1]
        at = said.find("1")
        while at >= 0:
            yield at + ELSEWHERE
            at = said.find("1", at + 1)


_NO_LINES: Final = LineSet()


class Unknown:
    """A setting that is not known, or that differs with the way that leads here."""

    def __repr__(self) -> str:
        return "UNKNOWN"


class _Inherited:
    """A setting as the caller of a procedure has it."""

    def __repr__(self) -> str:
        return "INHERITED"


UNKNOWN: Final = Unknown()
INHERITED: Final = _Inherited()


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
    by: LineSet = _NO_LINES
    interrupts: LineSet = _NO_LINES
    before: LineSet = _NO_LINES

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
        """True if it may be the caller's."""
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
    """A line calls these, in an unknown order.

    called: procedures by their number; for an unknown callee, the settings that it may change.
    inside: true if the unknown callee is lines of the program. A setting is computed from the
    caller's variables: within the callee, and after it, names may denote other variables.
    """

    called: tuple[int | frozenset[int], ...]
    inside: bool = False


@dataclass(frozen=True, slots=True)
class Either:
    """One of these runs."""

    branches: tuple[Steps, ...]


Steps = tuple[Sets | Changes | MaySet | Calls | Either, ...]
"""Effects of a line on settings, in its order."""


def _sets_in(steps: Steps) -> Iterator[Sets]:
    """The values that steps may give, other than in what they call."""
    for step in steps:
        match step:
            case Sets():
                yield step
            case Either(branches):
                for branch in branches:
                    yield from _sets_in(branch)


def calls_in(steps: Steps) -> Iterator[int | frozenset[int]]:
    """Yield the callees of steps."""
    for step in steps:
        match step:
            case Calls(called=called):
                yield from called
            case Either(branches):
                for branch in branches:
                    yield from calls_in(branch)


def _may_set(steps: Steps, setting: int) -> bool:
    if any(one.setting == setting for one in _sets_in(steps)):
        return True
    if any(isinstance(one, frozenset) and setting in one for one in calls_in(steps)):
        return True
    return any(isinstance(one, MaySet) and one.setting == setting for one in steps)


@dataclass(frozen=True, slots=True)
class LineEffects:
    """Effects and control flow of the lines of a program, by position.

    settings: their number. procedures: the positions of the lines of each. after: by procedure, the
    positions that may follow a line. steps: of the lines that affect settings. uses: the settings
    that a line depends on. runs_on: true if control may continue below a line without a jump.
    labels: lines that jumps lead to. inner: lines inside an item that is read as a unit. lost:
    lines that are reached in unknown ways.
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
    """Return the state that is certain where two branches join."""
    # Most lines join equal states, which are found without comparing the settings.
    if one is None or one is two or one == two:
        return two
    return tuple(
        a if a == b else a.met(b, _agreed_value(a.value, b.value))
        for a, b in zip(one, two, strict=True)
    )


def _agreed_value(one: Any, two: Any) -> Any:
    """Return the value on which two branches agree, for one caller or for all."""
    if one == two:
        return one
    if not any(value is INHERITED or isinstance(value, OrInherited) for value in (one, two)):
        return UNKNOWN
    made = {value.value if isinstance(value, OrInherited) else value for value in (one, two)}
    # Ways that agree but for the caller's value are that value, or the caller's.
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
    """State of the settings at each line of a program.

    before: by line, the state at its beginning. exits: by procedure, the state at its end, None if
    it never ends. cuts: lines at which procedures are divided: the state there is INHERITED from
    the line that leads there. divided: the numbers of those procedures. parts: by procedure, the
    positions of each part of it. edges: the state at the end of lines that lead to a cut, by line,
    then by position.
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
        # The end of a procedure may depend on itself where it calls itself, so the rounds repeat
        # until no end changes.
        while known != self.exits:  # what a procedure calls is run through before it
            known = list(self.exits)
            for number in postorder(called):
                # Exits of callees have changed, so what was found with the old ones does not hold.
                flows[number].found = {}
                self._spread(number, flows[number])
                end = flows[number].found.get(EXIT) if lines.procedures[number] else self.entry
                if end is not None:
                    # Joined, not replaced: states only grow, so the rounds end.
                    self.exits[number] = joined_states(self.exits[number], end)
        for number, flow in enumerate(flows):
            self._note(number, flow)

    def cut(self, cuts: frozenset[int]) -> Flow:
        """The same with procedures divided; the effect of a whole procedure stays known."""
        # The exits of whole procedures are shared, as they do not depend on the cuts.
        made = copy(self)
        made.cuts, made.edges, made.before, made.parts = cuts, {}, {}, list(self.parts)
        numbered = list(enumerate(self.lines.procedures))
        made.divided = frozenset(k for k, places in numbered if not cuts.isdisjoint(places))
        for number, places in numbered:
            after = self.lines.after[number]
            # Nothing passes a cut: what leads there is noted as an edge.
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
        """Record that state; lines that cannot be reached have the state of the line above."""
        places, last = self.lines.procedures[number], self.entry
        for at in places:
            # A line that no way leads to is read under the settings above it, as a reader would.
            if at not in flow.found:
                flow.spread([(at, last)])
            state = flow.found[at]
            last = self.after(at, state) or state
        self.before.update((at, flow.found[at]) for at in places)

    def _made_anywhere(self, setting: int) -> Held:
        """A setting that any of the lines may have made that make it."""
        steps = self.lines.steps.items()
        by = (at for at, made in steps if any(one.setting == setting for one in _sets_in(made)))
        return Held(UNKNOWN, LineSet.of(by))

    def _is_set(self, setting: int) -> bool:
        """True if anything may make a setting: a line, an interrupt, or an unknown effect."""
        return any(_may_set(made, setting) for made in self.lines.steps.values())

    # -------------------------------------------------------------------------- one line

    def after(self, at: int, state: State) -> State | None:
        """Return the state after a line; None if it never ends."""
        steps = self.lines.steps.get(at)
        return state if steps is None else self._ran(at, steps, state, [])

    def calls(self, at: int, state: State) -> dict[int, State]:
        """Return the possible state at the calls in a line, by procedure."""
        met: list[tuple[int, State]] = []
        self._ran(at, self.lines.steps.get(at, ()), state, met)
        found: dict[int, State] = {}
        for number, before in met:
            found[number] = joined_states(found.get(number), before)
        return {number: found.get(number, state) for number in self.lines.called(at)}

    def _ran(
        self, at: int, steps: Steps, state: State, met: list[tuple[int, State]]
    ) -> State | None:
        """Return the state after some steps. met: collects callees with the state at each call."""
        behind: State | None = state
        for step in steps:
            # A call before it never returns.
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
                    # Inherited values are known only where the caller is: any line may have made
                    # them here.
                    held = self._by_any_line[setting] if held.is_inherited else held
                    made = held.met(Held(UNKNOWN, by - _ELSEWHERE, by), UNKNOWN)
                    behind = (*behind[:setting], made, *behind[setting + 1 :])
                case Calls(called, inside):
                    # In an unknown order, each call may follow any of the others.
                    before = self._between(called, behind)
                    # Names may denote other variables inside what is called.
                    inner = tuple(_after_changes(held, None) for held in before)
                    met += [(one, inner) for one in called if isinstance(one, int)]
                    left = [self._left_by(one, before, inside) for one in called]
                    behind = _any_of(left, every=True)
                case Either(branches):
                    behind = _any_of([self._ran(at, branch, behind, met) for branch in branches])
        return behind

    def _between(self, called: Sequence[int | frozenset[int]], state: State) -> State:
        """Return the possible state before each of several calls, made in any order."""
        known: State | None = None
        # Each call may be repeated after the others until nothing is added.
        while len(called) > 1 and known != state:
            known = state
            made = _any_of([self._left_by(one, known) for one in called])
            state = known if made is None else joined_states(known, made)
        return state

    def _left_by(
        self, called: int | frozenset[int], state: State, inside: bool = False
    ) -> State | None:
        """Return the state after a call; an unknown callee may leave the values of earlier lines.

        inside: or the values of any line of the program.
        """
        if isinstance(called, int):
            end = self.exits[called]
            if end is None:
                return None
            return resolved_state(tuple(_after_changes(held, None) for held in end), state)
        return tuple(
            Held(UNKNOWN, before=held.needed | (self.lost[k].before if inside else _NO_LINES))
            if k in called
            else held
            for k, held in enumerate(state)
        )


def _after_changes(
    held: Held, names: frozenset[str] | None, but: frozenset[str] = frozenset()
) -> Held:
    """Return a setting after variables change: a value computed from them becomes unknown."""
    value = held.value.value if isinstance(held.value, OrInherited) else held.value
    if not isinstance(value, Computed) or value.names <= but:
        return held
    if names is None or not value.names.isdisjoint(names):
        return replace(held, value=UNKNOWN)
    return held


def _any_of(ways: Sequence[State | None], every: bool = False) -> State | None:
    """Return the state that is certain after one of several branches. every: all must end."""
    ending = [way for way in ways if way is not None]
    return reduce(joined_states, ending) if ending and not (every and None in ways) else None


@dataclass(frozen=True, slots=True)
class Interrupt:
    """Lines, by place: where what it calls begins, those that may switch it on, and that switch
    it off for sure. answer: the procedure that it alone calls, if that is one.
    """

    called: frozenset[int]
    on: frozenset[int]
    off: frozenset[int]
    answer: int | None = None


def with_interrupts(
    lines: LineEffects, interrupts: Sequence[Interrupt], elsewhere: frozenset[int]
) -> LineEffects:
    """The lines with what interrupts may set while each of them runs.

    All that interrupts call is among `lost`. elsewhere: settings that interrupts of other programs
    may set at any line.
    """
    if not interrupts and not elsewhere:
        return lines
    ways = _ProgramGraph(lines)
    may_set: dict[int, dict[int, LineSet]] = {}
    may_call: dict[int, list[int]] = {}
    for at in ways.all if elsewhere else ():
        may_set[at] = dict.fromkeys(elsewhere, LineSet.of([ELSEWHERE]))
    for interrupt in interrupts:
        if interrupt.answer is not None:
            own = frozenset(lines.procedures[interrupt.answer])
            for at in frozenset(ways.running(interrupt)) - own:
                may_call.setdefault(at, []).append(interrupt.answer)
            continue
        changed = ways.settings(interrupt.called)
        for at in ways.running(interrupt) if changed else ():
            here = may_set.setdefault(at, {})
            for setting, by in changed.items():
                here[setting] = here.get(setting, _NO_LINES) | by
    steps = dict(lines.steps)
    for at, here in may_set.items():
        interrupted: Steps = tuple(MaySet(*one) for one in here.items())
        steps[at] = (*steps.get(at, ()), *interrupted)
    for at, called in may_call.items():
        # The interrupt may come or not.
        answered: Steps = tuple(Either(((Calls((one,)),), ())) for one in called)
        steps[at] = (*steps.get(at, ()), *answered)
    return replace(lines, steps=steps)


class _ProgramGraph:
    """The ways through all procedures, from calls into what they call as well."""

    def __init__(self, lines: LineEffects) -> None:
        self.lines = lines
        self.all = [at for places in lines.procedures for at in places]
        self._after: Mapping[int, Sequence[int]] = {
            at: [to for to in ways if to != EXIT]
            for following in lines.after
            for at, ways in following.items()
        }
        self._before: dict[int, list[int]] = {}
        for at in self._after:
            for to in self._next(at):
                self._before.setdefault(to, []).append(at)

    def settings(self, starts: Iterable[int]) -> dict[int, LineSet]:
        """Return settings that may be set from some lines on, each with the lines that set it."""
        found: dict[int, set[int]] = {}
        for at in reachable(starts, self._next):
            steps = self.lines.steps.get(at, ())
            unknown = (one for one in calls_in(steps) if isinstance(one, frozenset))
            for setting in {one.setting for one in _sets_in(steps)}.union(*unknown):
                found.setdefault(setting, set()).add(at)
        return {setting: LineSet.of(lines) for setting, lines in found.items()}

    def running(self, interrupt: Interrupt) -> Iterable[int]:
        """Return the lines that may run while an interrupt is on, and those that switch it on.

        A line that is reached in unknown ways may run at any time; if such a line switches the
        interrupt on, all may run.
        """
        if not interrupt.on:
            return ()
        if self._come_to(interrupt.on, self.lines.lost):
            return self.all
        # A call that leads to switching it on may return with the interrupt on.
        leading = reachable(interrupt.on, lambda at: self._before.get(at, ()))
        on = {
            at for at in self.all if at in interrupt.on or not leading.isdisjoint(self._callees(at))
        }
        starts = {to for at in on for to in self._after[at]} | self.lines.lost
        # A line that may do both leaves it on.
        off = interrupt.off - interrupt.on
        return on | reachable(starts, lambda at: () if at in off else self._next(at))

    def _come_to(self, places: frozenset[int], starts: Iterable[int]) -> bool:
        """True if control can reach any of the positions from the starts."""
        found: set[int] = reachable(starts, self._next)
        return not places.isdisjoint(found)

    def _next(self, at: int) -> Iterator[int]:
        yield from self._after.get(at, ())
        yield from self._callees(at)

    def _callees(self, at: int) -> Iterator[int]:
        for number in self.lines.called(at):
            yield from self.lines.procedures[number][:1]


_MOST_NAMED_LINES: Final = 4
"""Lines that a reason names; the rest is counted."""


@dataclass(frozen=True, slots=True)
class SettingText:
    """name: in a sentence. word: what sets it. say: its values in words."""

    name: str
    word: str
    say: Callable[[Any], str]


class UnknownSettings:
    """Tells why settings are not known.

    settings: by their numbers. where: what a line is called.
    """

    def __init__(
        self, lines: LineEffects, settings: Sequence[SettingText], where: Callable[[int], str]
    ) -> None:
        self._lines, self._settings, self._where = lines, settings, where

    def reason(self, state: State, used: Iterable[int]) -> Reason | None:
        """Why the first unknown one of those that are used is not known; None if all are."""
        for number in sorted(used):
            if state[number].value is UNKNOWN:
                return self._of_setting(number, state[number])
        return None

    def _of_setting(self, number: int, held: Held) -> Reason:
        name, word = self._settings[number].name, self._settings[number].word
        if held.interrupts:
            own = [at for at in held.interrupts if at != ELSEWHERE]
            by = f"by {self._list(own)}" if own else "in another program"
            return Reason(
                f"an interrupt may set the {name} at any time, {by}",
                f"leave {word} out of what the interrupt calls, or switch the interrupt off and "
                f"set {word} above the move",
            )
        lines = list(held.by)
        made = {at: self._value(number, at) for at in lines}
        computed = [at for at, value in made.items() if value is UNKNOWN]
        if computed:
            return Reason(
                f"the {name} is worked out by the program, {self._list(computed)}",
                f"give {word} a plain value",
            )
        values = list(dict.fromkeys(map(self._settings[number].say, made.values())))
        if not values:
            return Reason(
                f"the {name} is what the caller has set, or another program",
                f"set {word} above the move",
            )
        # One value alone cannot differ: the other way leaves what was set before.
        values += ["what was set before"] if len(values) == 1 else []
        return Reason(
            f"the {name} may be {' or '.join(values)} here, by {self._list(lines)}",
            f"set {word} where the ways meet, below the label or the end of the block",
        )

    def _value(self, number: int, at: int) -> Any:
        """Return the value that a line gives a setting."""
        made = (one.value for one in _sets_in(self._lines.steps[at]) if one.setting == number)
        return next(made, UNKNOWN)

    def _list(self, lines: Sequence[int]) -> str:
        given = [self._where(at) for at in lines]
        if len(given) > _MOST_NAMED_LINES:
            given = [*given[:_MOST_NAMED_LINES], f"{len(given) - _MOST_NAMED_LINES} more"]
        return " and ".join([", ".join(given[:-1]), given[-1]]) if len(given) > 1 else given[0]
