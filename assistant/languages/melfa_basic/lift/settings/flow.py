"""What settings hold at each line, along every way that leads there.

Lines pass their settings on to those that may run after them, until nothing changes any more.
Within a procedure what its caller has set is INHERITED; a procedure's own effect is worked out
once, and used wherever it is called from.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from copy import copy
from dataclasses import dataclass
from typing import Any, Final

from assistant.languages.line_blocks import Blocks
from assistant.languages.line_graph import EXIT
from assistant.languages.melfa_basic.lift.settings.held import UNKNOWN, Held, State
from assistant.languages.melfa_basic.lift.structure.blocks import Code
from assistant.languages.melfa_basic.lift.structure.regions import Region, odd_entries
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import is_word, statement_of
from assistant.languages.melfa_basic.tree.targets import exits_of, graph_of, labels_of
from assistant.program.analysis.dataflow import Dataflow, postorder

Effect = Callable[[s.Statement | None], tuple[int, Any] | None]
Calls = Callable[[s.Statement], Iterable[int | frozenset[int]]]
"""Procedures (by number) that a statement calls, or settings that a call may change."""


class Inherited:
    """A setting as the caller of a procedure has it."""

    def __repr__(self) -> str:
        return "INHERITED"


INHERITED: Final = Inherited()


@dataclass(frozen=True, slots=True)
class OrInherited:
    """A setting that some ways make, and others leave as the caller of a procedure has it."""

    value: Any


_ENTRY: Final[State] = (Held(INHERITED),) * 5
LOST: Final[State] = (Held(UNKNOWN),) * 5


def joined(one: State | None, two: State) -> State:
    """What is certain where two ways meet."""
    if one is None or one is two or one == two:
        return two
    return tuple(
        a if a == b else Held(_met(a.value, b.value), a.by | b.by)
        for a, b in zip(one, two, strict=True)
    )


def _met(one: Any, two: Any) -> Any:
    """What two ways agree on, for one caller or for all."""
    if one == two:
        return one
    if not is_inherited(one) and not is_inherited(two):
        return UNKNOWN
    made = {part for part in map(_made, (one, two)) if part is not INHERITED}
    return OrInherited(*made) if len(made) == 1 and UNKNOWN not in made else UNKNOWN


def is_inherited(value: Any) -> bool:
    """Whether a setting may be the caller's."""
    return value is INHERITED or isinstance(value, OrInherited)


def _made(value: Any) -> Any:
    return value.value if isinstance(value, OrInherited) else value


def resolved(state: State, inherited: State) -> State:
    """The state with what the caller has in the places that are inherited."""
    if not any(is_inherited(h.value) for h in state):
        return state
    return tuple(
        Held(_resolved(h.value, up.value), h.by | up.by) if is_inherited(h.value) else h
        for h, up in zip(state, inherited, strict=True)
    )


def _resolved(value: Any, given: Any) -> Any:
    return given if value is INHERITED else _met(value.value, given)


class Flow:
    """before: by line, what holds where it begins.

    cuts: lines at which procedures are divided: what holds there is INHERITED from the line that
    leads there. edges: what holds at the end of such lines, by line, then by place.
    """

    entry: Final = _ENTRY

    def __init__(
        self, code: Code, regions: list[Region], blocks: Blocks, effect: Effect, calls: Calls
    ) -> None:
        self.code, self.regions, self.effect, self.calls = code, regions, effect, calls
        self.labels = labels_of(code)
        self.ways = [graph_of(code, region.places(), blocks).after for region in regions]
        loose = {
            at for at, item in enumerate(code)
            if is_word(statement_of(item)) and at not in blocks.words
        }  # fmt: skip
        odd = odd_entries(code, regions)
        self.odd = sorted(loose | {self.labels[name] for name in odd if name in self.labels})
        self._known_calls: dict[int, tuple[int | frozenset[int], ...]] = {}
        self.cuts: frozenset[int] = frozenset()
        self.edges: dict[int, dict[int, State]] = {}
        self.before: dict[int, State] = {}
        self.exits: list[State | None] = [None] * len(regions)
        self._settle()

    def cut(self, cuts: frozenset[int]) -> Flow:
        """The same with procedures divided; the effect of a whole procedure stays known."""
        made = copy(self)
        made.cuts, made.edges, made.before = cuts, {}, {}
        for number, region in enumerate(made.regions):
            ways = {
                at: [to for to in after if to not in cuts]
                for at, after in made.ways[number].items()
            }
            made._spread(number, region, Dataflow(ways, made.after, joined), dead=True)
            for at in region.places():
                after = made.after(at, made.before[at])
                into = cuts.intersection(made.ways[number][at])
                if after is not None and into:
                    made.edges[at] = dict.fromkeys(into, after)
        return made

    def parts(self, number: int) -> list[tuple[int, int]]:
        """Where the parts of a procedure begin and end."""
        region = self.regions[number]
        inside = (at for at in self.cuts if region.low < at < region.high)
        edges = [region.low, *sorted(inside), region.high]
        return list(itertools.pairwise(edges))

    def is_divided(self, number: int) -> bool:
        return any(self.regions[number].holds(at) for at in self.cuts)

    def goes_below(self, at: int) -> bool:
        """Whether control may go on below a line without a jump."""
        return exits_of(statement_of(self.code[at])).on

    def is_label(self, at: int) -> bool:
        item = self.code[at] if 0 <= at < len(self.code) else None
        return isinstance(item, s.Line) and item.label is not None

    # ------------------------------------------------------------------------ the fixpoint

    def _settle(self) -> None:
        """Runs through all procedures, what they call before them, until nothing changes."""
        called = {
            number: [
                callee
                for at in region.places()
                if (statement := statement_of(self.code[at])) is not None
                for callee in self.all_calls(statement)
                if isinstance(callee, int)
            ]
            for number, region in enumerate(self.regions)
        }
        flows = [Dataflow(ways, self.after, joined) for ways in self.ways]
        known: list[State | None] | None = None
        while known != self.exits:
            known = list(self.exits)
            for number in postorder(called):
                flows[number].found = {}
                self._spread(number, self.regions[number], flows[number])
        for number, region in enumerate(self.regions):
            self._spread(number, region, flows[number], dead=True)

    def _spread(
        self, number: int, region: Region, flow: Dataflow[int, State], dead: bool = False
    ) -> None:
        """Works out what holds in a procedure, and behind it if it is not divided.

        dead: also in lines that no way leads to, which have what stands above them.
        """
        places = region.places()
        starts = {*places[:1], *(at for at in self.cuts if region.holds(at))}
        odd = ((at, LOST) for at in self.odd if region.holds(at))
        flow.spread([*((at, _ENTRY) for at in sorted(starts)), *odd])
        last = _ENTRY
        for at in places if dead else ():
            if at not in flow.found:
                flow.spread([(at, last)])
            state = flow.found[at]
            last = self.after(at, state) or state
        end = flow.found.get(EXIT) if places else _ENTRY
        if end is not None and not self.cuts:
            self.exits[number] = joined(self.exits[number], end)
        self.before.update((at, flow.found[at]) for at in places if at in flow.found)

    # -------------------------------------------------------------------------- one line

    def after(self, at: int, state: State) -> State | None:
        """What holds behind a line; None if it never ends."""
        statement = None if at == EXIT else statement_of(self.code[at])
        return state if statement is None else self._passed(at, statement, state)

    def _passed(self, at: int, statement: s.Statement, state: State) -> State | None:
        """What holds after a statement; None if it never ends."""
        effect = self.effect(statement)
        if effect is not None:
            slot, value = effect
            return (*state[:slot], Held(value, frozenset((at,))), *state[slot + 1 :])
        after: State | None = state
        for called in self.direct_calls(statement):
            if after is None:
                return None
            if isinstance(called, frozenset):
                after = tuple(Held(UNKNOWN) if k in called else h for k, h in enumerate(after))
                continue
            end = self.exits[called]
            made = None if end is None else resolved(end, after)
            if isinstance(statement, s.OnJump):
                made = after if made is None else joined(after, made)
            after = made
        if not isinstance(statement, s.If) or statement.then is None or after is None:
            return after
        branches = (statement.then, statement.otherwise)
        return self._either([self._branch(at, branch, after) for branch in branches], state)

    def direct_calls(self, statement: s.Statement) -> tuple[int | frozenset[int], ...]:
        """What a statement calls; what the branches of an `If` call is theirs."""
        if id(statement) not in self._known_calls:
            self._known_calls[id(statement)] = tuple(self.calls(statement))
        return self._known_calls[id(statement)]

    def all_calls(self, statement: s.Statement) -> Iterator[int | frozenset[int]]:
        yield from self.direct_calls(statement)
        if isinstance(statement, s.If):
            for branch in (statement.then, statement.otherwise):
                if branch is not None and not isinstance(branch, s.Target):
                    yield from self.all_calls(branch)

    def _branch(self, at: int, branch: Any, state: State) -> State | None:
        if branch is None or isinstance(branch, s.Target):
            return state
        return self._passed(at, branch, state)

    @staticmethod
    def _either(ways: list[State | None], state: State) -> State:
        """What holds after one of several; jumps away keep what held before."""
        made: State | None = None
        for way in ways:
            if way is not None:
                made = joined(made, way)
        return state if made is None else made
