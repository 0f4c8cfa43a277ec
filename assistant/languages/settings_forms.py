"""Forms of procedures: one for each set of settings that a procedure is called with.

In a program whose settings are statements, see `flow`, a procedure moves with the settings of its
caller. Where each move states its settings, the procedure is written once for each set. Procedures
are also divided at labels that are reached with different settings from above and by a jump: what
follows such a label is read once for each.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.languages.settings_flow import (
    UNKNOWN,
    Flow,
    Held,
    State,
    joined_states,
    resolved_state,
)
from assistant.program.program import TakenNames, identifier

MOST_FORMS: Final = 8
"""Forms of one procedure; called in more ways, its settings count as unknown."""

_MOST_LINES: Final = 4000
"""Lines of all the passes of one file; what would take more is read once."""


@dataclass(slots=True, eq=False)
class Form:
    """A procedure as called with one set of settings: the lines at some positions.

    A divided procedure is read in several passes, each under the settings of one path to it; this
    form is the first of its `passes`, which all of them share. number: among the forms of the
    procedure, or the passes of the same part. key: distinguishes it from the others. name: name of
    the procedure in this form, once that is decided.
    """

    procedure: int
    part: int
    places: Sequence[int]
    number: int
    key: Any
    state: State
    passes: dict[Any, Form]
    called: dict[int, dict[int, Form]] = field(default_factory=dict)
    """Forms that a line calls, by line, then by procedure."""
    goes: dict[int, dict[int, Form]] = field(default_factory=dict)
    """Passes that a line leads to, by line, then by place."""
    falls: Form | None = None
    """The pass that is written below this one."""
    name: str = ""

    def in_order(self) -> list[Form]:
        """Return the passes; each precedes the one that it falls through to if possible."""
        left = sorted(self.passes.values(), key=lambda one: (one.number, one.part))
        made: list[Form] = []
        following: Form | None = self
        while left:
            one = following if following is not None and following in left else left[0]
            left.remove(one)
            made.append(one)
            following = one.falls
        return made


class PassLabels:
    """Names of the labels in the passes of a procedure: `top`, `top_2` for the second one.

    spelled: the names as they are written in a pass, by their key. taken: all that there are.
    """

    def __init__(
        self, passes: Sequence[Form], spelled: Callable[[Form], Mapping[str, str]]
    ) -> None:
        self.taken = TakenNames()
        self._names: dict[int, dict[str, str]] = {}
        for one in sorted(passes, key=lambda one: (one.number, one.part)):
            own = self._names[id(one)] = {}
            for key, written in spelled(one).items():
                given = written if one.number == 1 else f"{written}_{one.number}"
                own[key] = identifier(given, self.taken)
                self.taken.add(own[key])

    def of(self, one: Form) -> dict[str, str]:
        return self._names[id(one)]


class CalledForms:
    """The forms of all procedures of a program.

    forms: by procedure, in the order in which calls are met from the first procedure on.
    single: procedures that have one form for all ways of calling them. alone: procedures that
    only the program itself can call: if it does not, they are read as where a program starts.
    """

    def __init__(
        self,
        flow: Flow,
        initial: State,
        single: frozenset[int] = frozenset(),
        alone: frozenset[int] = frozenset(),
    ) -> None:
        self.flow, self.single = flow, single
        self._part_at = {
            places[0]: part
            for number in flow.divided
            for part, places in enumerate(flow.parts[number])
        }
        procedures = flow.lines.procedures
        self._calls = {at: made for at in flow.lines.steps if (made := flow.lines.called(at))}
        self._needs = self._all_needs()
        self.forms: list[dict[Any, Form]] = [{} for _ in procedures]
        lost = resolved_state(flow.lost, initial)
        self._lines = 0
        self._pending: list[Form] = []
        if procedures:
            self._form(0, initial)
        while self._pending and not self.too_long:
            self._follow(self._pending.pop(0))
            if not self._pending:  # what nothing calls may be called from elsewhere
                left = next((k for k, found in enumerate(self.forms) if not found), None)
                if left is not None:
                    self._form(left, initial if left in alone else lost)

    @property
    def too_long(self) -> bool:
        # A long program may double; a short one has room for its forms in any case.
        most = max(_MOST_LINES, 2 * len(self.flow.before))
        return bool(self.flow.cuts) and self._lines > most

    @property
    def unread(self) -> frozenset[int]:
        """Divided procedures with a part that no way leads to, by their number."""
        return frozenset(
            number
            for number in self.flow.divided
            for form in self.forms[number].values()
            if len({one.part for one in form.passes.values()}) < len(self.flow.parts[number])
        )

    def at(self, at: int, form: Form) -> State:
        """Return the state at the beginning of a line."""
        before = self.flow.before.get(at)  # none where no way leads
        return form.state if before is None else resolved_state(before, form.state)

    def _follow(self, form: Form) -> None:
        """Notes what a form calls, and where it goes."""
        for at in form.places:
            if at in self._calls:
                met = self.flow.calls(at, self.at(at, form))
                form.called[at] = {
                    callee: self._form(callee, state) for callee, state in met.items()
                }
        below: State | None = None
        for at in form.places if form.passes else ():
            for to, state in self.flow.edges.get(at, {}).items():
                given = resolved_state(state, form.state)
                form.goes.setdefault(at, {})[to] = self._pass(form, self._part_at[to], given)
                if self._part_at[to] == form.part + 1 and self.flow.lines.runs_on(at):
                    below = joined_states(below, given)
        # Only what runs on below needs to be written next; jumps find their label anywhere.
        if below is not None:
            form.falls = self._pass(form, form.part + 1, below)

    def _form(self, procedure: int, state: State) -> Form:
        """The form of a procedure for what its caller has set."""
        made = self._met(self.forms[procedure], procedure, 0, state, {})
        if procedure in self.flow.divided:
            made.passes.setdefault(made.key, made)
        return made

    def _pass(self, form: Form, part: int, state: State) -> Form:
        """The pass of a divided procedure that begins with a part in a state."""
        return self._met(form.passes, form.procedure, part, state, form.passes)

    def _met(
        self,
        known: dict[Any, Form],
        procedure: int,
        part: int,
        state: State,
        passes: dict[Any, Form],
    ) -> Form:
        """Return the form or pass, among the known ones, that begins with a part in a state.

        It is followed, or followed again, if it is new or if its settings have changed.
        """
        count = sum(1 for one in known.values() if one.part == part)
        needs = self._needs[procedure, part]
        # Settings that the part does not take from before do not make another form of it.
        key: Any = (part, *(held.value if k in needs else None for k, held in enumerate(state)))
        if known is self.forms[procedure] and procedure in self.single:
            key = part, UNKNOWN
        elif key not in known and count >= MOST_FORMS:
            key = part, UNKNOWN  # the same for all if there are too many
            state = tuple(Held(UNKNOWN, held.by, before=held.before) for held in state)
        if key not in known:
            places = self.flow.parts[procedure][part]
            known[key] = Form(procedure, part, places, count + 1, key, state, passes)
            self._lines += len(places)
            self._pending.append(known[key])
            return known[key]
        # A form that is reached again may get more lines that its settings come from.
        made = known[key]
        both = joined_states(made.state, state)
        if both != made.state:
            made.state = both
            self._pending.append(made)
        return made

    def _all_needs(self) -> dict[tuple[int, int], set[int]]:
        """By procedure and part, the settings that it takes from before."""
        flow = self.flow
        needs: dict[tuple[int, int], set[int]] = {}
        passed: list[tuple[tuple[int, int], set[int], tuple[int, int]]] = []
        for number, parts in enumerate(flow.parts):
            for part, places in enumerate(parts):
                here = number, part
                mine = needs[here] = set()
                for at in places:
                    inherited = _inherited(flow.before[at])
                    mine |= flow.lines.uses(at) & inherited
                    passed += [(here, inherited, (callee, 0)) for callee in self._calls.get(at, ())]
                    for to, state in flow.edges.get(at, {}).items():
                        passed.append((here, _inherited(state), (number, self._part_at[to])))
        # Needs pass on through calls and edges until nothing is added.
        while True:
            before = sum(map(len, needs.values()))
            for here, inherited, there in passed:
                needs[here] |= needs[there] & inherited
            if sum(map(len, needs.values())) == before:
                return needs


def _inherited(state: State) -> set[int]:
    return {k for k, held in enumerate(state) if held.is_inherited}


def divided_flow(flow: Flow, whole: frozenset[int]) -> Flow:
    """The flow with procedures divided at labels; the same one if there is nothing to divide.

    whole: numbers of procedures that stay as they are.
    """
    refused = set(whole)
    made = flow
    while True:
        cuts = set(made.cuts)
        for number, places in enumerate(flow.lines.procedures):
            more = set() if number in refused else _division_labels(made, number)
            if more and not flow.lines.lost.union(more & flow.lines.inner).isdisjoint(places):
                refused.add(number)  # what is read whole would have to be divided
                cuts.difference_update(places)
            else:
                cuts |= more
        if cuts == made.cuts:
            return made
        # Dividing may show new ways that differ, so labels are looked for again.
        made = flow.cut(frozenset(cuts)) if cuts else flow


def _division_labels(flow: Flow, number: int) -> set[int]:
    """More labels to divide a procedure at: where ways differ, and where parts lead into others."""
    lines = flow.lines
    places, after = lines.procedures[number], lines.after[number]
    ways: dict[int, list[State]] = {at: [flow.entry] for at in places[:1]}
    for at in places:
        behind = flow.after(at, flow.before[at])
        if behind is None:
            continue
        for following in lines.labels.intersection(after[at]):
            ways.setdefault(following, []).append(behind)
    found = {at for at, states in ways.items() if at not in lines.inner and _differ(states)}
    if number in flow.divided:
        parts = flow.parts[number]
        part = {at: k for k, inside in enumerate(parts) for at in inside}
        # A way into the middle of another part needs a cut where it arrives.
        led = {to for at in places for to in after[at] if part.get(to, part[at]) != part[at]}
        found |= led.difference(inside[0] for inside in parts)
    return found - flow.cuts


def _differ(states: list[State]) -> bool:
    return any(len({held.value for held in slot}) > 1 for slot in zip(*states, strict=True))
