"""What settings hold at each line, along every way that leads there.

Lines pass their settings on to those that may run after them, until nothing changes any more.
Within a procedure what its caller has set is INHERITED; a procedure's own effect is worked out
once, and used wherever it is called from.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping
from copy import copy
from dataclasses import dataclass
from typing import Any, Final

from assistant.languages.melfa_basic.lift.settings.held import UNKNOWN, Held, State
from assistant.languages.melfa_basic.lift.structure.blocks import Code, innermost_ends
from assistant.languages.melfa_basic.lift.structure.regions import Region, odd_entries, place_name
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import is_word

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
_LOST: Final[State] = (Held(UNKNOWN),) * 5


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
        self,
        code: Code,
        regions: list[Region],
        blocks: Mapping[int, list[int]],
        effect: Effect,
        calls: Calls,
    ) -> None:
        self.code, self.regions, self.effect, self.calls = code, regions, effect, calls
        self.labels = {
            item.label.upper(): at
            for at, item in reversed(list(enumerate(code)))
            if isinstance(item, s.Line) and item.label is not None
        }
        self._take_blocks(blocks)
        odd = odd_entries(code, regions)
        self.odd = sorted(self.loose | {self.labels[name] for name in odd if name in self.labels})
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
        for number, region in enumerate(self.regions):
            made._run(number, region)
            made._dead(number, region)
        return made

    def _take_blocks(self, blocks: Mapping[int, list[int]]) -> None:
        """tests: a middle word → the next one. redirect: a middle word → the end of its block."""
        self.tests: dict[int, int] = {}
        self.redirect: dict[int, int] = {}
        self.places: dict[int, list[int]] = {}
        self.first: dict[int, list[int]] = {}
        known: set[int] = set()
        for first, places in blocks.items():
            if not is_word(self._statement(first)):
                continue  # an `If` made of jumps, which say themselves where they go
            known.update(places)
            self.places[first] = places
            self.first.setdefault(places[-1], []).append(first)
            for here, after in itertools.pairwise(places):
                self.tests[here] = after
            for middle in places[1:-1]:
                self.redirect[middle] = places[-1]
        self.ends = innermost_ends(len(self.code), self.places)
        self.loose = {
            at for at in range(len(self.code)) if at not in known and is_word(self._statement(at))
        }

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
        match self._statement(at):
            case s.Jump(keyword="GoTo"):
                return False
            case s.If(then=then, otherwise=otherwise) if then is not None:
                branches = (_destination(then), _destination(otherwise))
                return not all(isinstance(branch, s.Target) for branch in branches)
        return True

    def is_label(self, at: int) -> bool:
        item = self.code[at] if at < len(self.code) else None
        return isinstance(item, s.Line) and item.label is not None

    def _statement(self, at: int) -> s.Statement | None:
        item = self.code[at]
        return item.statement if isinstance(item, s.Line) else None

    # ------------------------------------------------------------------------ the fixpoint

    def _settle(self) -> None:
        order = self._callees_first()
        for _ in range(2 * len(self.regions) + 3):
            before, self.before = list(self.exits), {}
            for number in order:
                self._run(number, self.regions[number])
            if self.exits == before:
                break
        for number, region in enumerate(self.regions):
            self._dead(number, region)

    def _callees_first(self) -> list[int]:
        """All procedures, what they call before them, so that few rounds settle."""
        called = [
            {
                callee
                for at in region.places()
                if (statement := self._statement(at)) is not None
                for callee in self.all_calls(statement)
                if isinstance(callee, int)
            }
            for region in self.regions
        ]
        order: dict[int, None] = {}
        met: set[int] = set()
        for first in range(len(self.regions)):
            left = [(first, False)]
            while left:
                number, done = left.pop()
                if done:
                    order[number] = None
                elif number not in met:
                    met.add(number)
                    left.append((number, True))
                    left += [(callee, False) for callee in called[number]]
        return list(order)

    def _run(self, number: int, region: Region) -> None:
        places = region.places()
        if not places:
            self.exits[number] = _ENTRY
            return
        for at in sorted({places[0], *(at for at in self.cuts if region.holds(at))}):
            self._spread(number, region, at, _ENTRY)
        for at in self.odd:
            if region.holds(at):
                self._spread(number, region, at, _LOST)

    def _dead(self, number: int, region: Region) -> None:
        """Lines that no way leads to hold what stands above them."""
        last: State = _ENTRY
        for at in region.places():
            if at not in self.before:
                self._spread(number, region, at, last)
            state = self.before[at]
            last = self.after(at, state) or state

    def _spread(self, number: int, region: Region, start: int, state: State) -> None:
        """Passes a state on from a line until nothing changes."""
        queue, waiting = [start], {start}
        self.before[start] = joined(self.before.get(start), state)
        while queue:
            at = heapq.heappop(queue)
            waiting.discard(at)
            after = self.after(at, self.before[at])
            if after is None:
                continue
            for following in self.following(at, region):
                if following == region.high:  # the way out, not the line there
                    if not self.cuts:
                        self.exits[number] = joined(self.exits[number], after)
                    continue
                if following in self.cuts:
                    self.edges.setdefault(at, {})[following] = after
                    continue
                known = self.before.get(following)
                made = joined(known, after)
                if known is None or made != known:
                    self.before[following] = made
                    if following not in waiting:
                        waiting.add(following)
                        heapq.heappush(queue, following)

    # -------------------------------------------------------------------------- one line

    def after(self, at: int, state: State) -> State | None:
        """What holds behind a line; None if it never ends."""
        statement = self._statement(at)
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

    def following(self, at: int, region: Region) -> Iterator[int]:
        """Lines that may run after one; the end of the region where it is left."""
        statement = self._statement(at)
        match statement:
            case s.Jump(keyword="GoTo", target=target):
                yield from self._goes([target], region)
                return
            case s.Command(keyword="End"):
                return
            case s.Command(keyword="Return" | "Exit Function"):
                yield region.high
                return
            case s.Command(keyword="Break") if at in self.ends:
                yield from self._sequel(self.ends[at], region)
                return
            case s.If(then=then, otherwise=otherwise) if then is not None:
                branches = [_destination(branch) for branch in (then, otherwise)]
                yield from self._goes(branches, region)
                yield from self._leaves(then, otherwise, at, region)
                if all(isinstance(branch, s.Target) for branch in branches):
                    return
            case s.OnJump(keyword="GoTo", targets=targets):
                yield from self._goes(targets, region)
            case s.Select() if at in self.places:
                yield from self.places[at][1:]
                return
            case s.If() | s.ElseIf() if at in self.tests:
                yield self.tests[at]
            case s.For() | s.Command(keyword="While") if at in self.places:
                yield from self._sequel(self.tests[at], region)
            case s.Next() | s.Command(keyword="WEnd") if at in self.first:
                yield from self.first[at]
                return
        yield from self._sequel(at, region)

    def _leaves(self, then: Any, otherwise: Any, at: int, region: Region) -> Iterator[int]:
        """Where the statements of a one-line `If` go that leave a procedure or a block."""
        for branch in (then, otherwise):
            word = branch.keyword if isinstance(branch, s.Command) else ""
            if word in ("Return", "Exit Function"):
                yield region.high
            elif word == "Break" and at in self.ends:
                yield from self._sequel(self.ends[at], region)

    def _sequel(self, at: int, region: Region) -> Iterator[int]:
        """The line below one, or the end of the block if that is another branch of it."""
        following = at + 1
        if following == region.before[1] and at < region.before[1]:
            following = region.low
        while following in self.redirect:
            following = self.redirect[following]
        yield min(following, region.high) if at < region.high else region.high

    def _goes(self, targets: Iterable[Any], region: Region) -> Iterator[int]:
        for target in targets:
            if isinstance(target, s.Target):
                at = self.labels.get(place_name(target.place))
                if at is not None and region.holds(at):
                    yield at


def _destination(branch: object) -> object:
    """Where a branch of a one-line `If` goes without coming back, else the branch itself."""
    if isinstance(branch, s.Jump) and branch.keyword == "GoTo":
        return branch.target
    return branch
