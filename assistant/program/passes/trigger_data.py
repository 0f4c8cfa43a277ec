"""Trigger data: outputs set during moves, in a language whose moves take data set up before.

If it is certain which statement set up the data of a move, and nothing else names them, the move
itself states its outputs and their positions; the data and their set-up are left out. If several
statements may have set them up, each of them stores its number, and that number selects the move.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import ControlFlowGraph, Dataflow
from assistant.program.analysis.uses import along_calls, declared, locals_of
from assistant.program.program import (
    Procedure,
    Program,
    Signal,
    TakenNames,
    Variable,
    identifier,
    walk,
)
from assistant.program.rewriting import Body, map_bodies, records
from assistant.program.vendor_statements import VendorText, effect_of


@dataclass(frozen=True, slots=True)
class TriggerData:
    """Data that moves take. plain: one variable. own: no other module sees it."""

    name: str
    plain: bool
    own: bool


@dataclass(frozen=True, slots=True)
class TriggerSetUp:
    """A statement that sets up trigger data.

    trigger, signal: the output that a move with these data sets, None if the pseudo-program cannot
    express it. fixed: True if its numbers are the same everywhere.
    """

    name: str
    trigger: p.Trigger | None = None
    signal: Signal | None = None
    fixed: bool = False


@dataclass(frozen=True, slots=True)
class TriggeredMove:
    """A move that takes data. move: the move without them, None if the pseudo-program cannot
    express it.
    """

    names: tuple[str, ...]
    move: p.MoveStatement | None


Told = TriggerData | TriggerSetUp | TriggeredMove
"""Role of a vendor text for outputs during moves; names are in lower case."""


@dataclass(frozen=True, slots=True)
class Reasons:
    """Why texts stay: what is set up there or taken; which way leads there; another option."""

    special: e.Reason
    uncertain: e.Reason
    move: e.Reason


def with_triggers(
    program: Program,
    told: Callable[[VendorText], Told | None],
    library: Callable[[str], bool],
    reasons: Reasons,
    *,
    chosen: bool = False,
) -> tuple[Program, list[tuple[str, Signal]]]:
    """Return the program whose moves state the outputs that they set, and the signals of these
    outputs.

    told: returns the role of a vendor text. library: True for the lower-case name of a function of
    the language. chosen: True to also choose among several statements that may have set data up,
    and to leave out set-ups that no move takes.
    """
    texts: tuple[VendorText, ...] = (*program.declarations, *_opaque(program))
    found = {id(text): one for text in texts if (one := told(text)) is not None}
    if not any(isinstance(one, TriggerData) for one in found.values()):
        return program, []
    return _SetUpsAlongPaths(program, found, library, reasons, chosen).settled()


def _opaque(program: Program) -> Iterator[p.Opaque]:
    return (node for node in program.statements() if isinstance(node, p.Opaque))


_MOST_CHOICES: Final = 16
"""Ways in which the data that one move takes may be set up."""
State = Mapping[str, TriggerSetUp]
"""By name of data, what set them up on every way to a place."""


_STILL: Final = (p.Move, p.MoveCircular, p.MoveJoints, p.Follow, p.SetSignal, p.Wait)
"""Statements that change no variable."""


class _SetUpsAlongPaths:
    """Set-ups along the control flow. told, becomes: by identity of vendor texts, the role of each,
    and its replacement.

    single: the only set-ups of their data, with the same numbers everywhere.
    """

    def __init__(
        self,
        program: Program,
        told: Mapping[int, Told],
        library: Callable[[str], bool],
        reasons: Reasons,
        chosen: bool,
    ) -> None:
        self.program, self.told, self.reasons = program, told, reasons
        self.chosen = chosen
        self.library = library
        self.procedures = {q.name.lower() for q in program.procedures}
        # Procedures of this program, and what vendor declarations define, have known effects.
        written = (effect_of(d).writes for d in program.declarations)
        self.known = self.procedures.union(*written)
        own = {q.name.lower(): frozenset(self._set_up(q)) for q in program.procedures}
        self.sets = along_calls(program, own)
        self.setups: dict[str, list[tuple[p.Opaque, TriggerSetUp]]] = {}
        self.takings: list[tuple[p.Opaque, TriggeredMove, State]] = []
        for node in _opaque(program):
            one = told.get(id(node))
            if isinstance(one, TriggerSetUp):
                self.setups.setdefault(one.name, []).append((node, one))
        found = ((name, [one for _, one in every]) for name, every in self.setups.items())
        # Set up by one statement with constant numbers: the data are the same wherever they are
        # used.
        self.single = {name: x[0] for name, x in found if len(x) == 1 and x[0].fixed}
        for procedure in program.procedures:
            self._follow(procedure)
        self.becomes: dict[int, p.Statement | None] = {}
        self.numbers: dict[str, str] = {}
        self.taken_names = TakenNames(declared(program))

    def _set_up(self, procedure: Procedure) -> Iterator[str]:
        found = (self.told.get(id(node)) for node in walk(procedure.body))
        return (one.name for one in found if isinstance(one, TriggerSetUp))

    # -------------------------------------------------------------------------------- ways

    def _follow(self, procedure: Procedure) -> None:
        """Notes what the moves of a procedure take, along the ways through it."""
        graph = ControlFlowGraph(procedure.body)

        def behind(node: int, state: State) -> State:
            for part in graph.runs[node]:
                state = self._ran(part, state)
            return state

        flow = Dataflow(graph.after, behind, _merged_set_ups)
        flow.spread([(graph.start, {})])
        for node, parts in enumerate(graph.runs):
            state = flow.found.get(node, {})
            for part in parts:
                one = self.told.get(id(part))
                if isinstance(one, TriggeredMove):
                    # Calls in the arguments of the move run before it takes its data.
                    self.takings.append((part, one, self._left(part, state)))
                state = self._ran(part, state)

    def _ran(self, part: Any, state: State) -> State:
        """Behind a statement or a value; what may change holds up to what may change it."""
        if isinstance(part, p.Comment):
            return state
        state = self._left(part, state)
        one = self.told.get(id(part))
        if isinstance(one, TriggerSetUp):
            return {**state, one.name: one}
        if isinstance(part, _STILL):
            return state
        # A set-up with computed numbers holds only until its variables may change.
        return {name: setup for name, setup in state.items() if setup.fixed}

    def _left(self, part: Any, state: State) -> State:
        """Return the set-ups that are unchanged after the calls in a statement or a value."""
        calls = set(_called_names(part)) if state else set()
        # An unknown procedure may set up any data.
        if any(map(self._is_foreign, calls)):
            return {}
        changed = frozenset().union(*(self.sets.get(name, ()) for name in calls))
        return {name: setup for name, setup in state.items() if name not in changed}

    def _is_foreign(self, name: str) -> bool:
        """True if the effect of a call of that name is unknown."""
        return not (name in self.known or name in e.FUNCTIONS or self.library(name))

    # ------------------------------------------------------------------------ what is said

    def settled(self) -> tuple[Program, list[tuple[str, Signal]]]:
        """Return the program, and the signals, with the moves that need none of the remaining
        data.
        """
        declared = self._declared()
        said = [
            (node, taking, self._said(node, taking, state)) for node, taking, state in self.takings
        ]
        gone = self._gone(declared, said)
        # A number is needed only for data that are left out.
        self.numbers = {name: number for name, number in self.numbers.items() if name in gone}
        used: list[tuple[str, Signal]] = []
        for name, found in self.setups.items():
            for place, (node, one) in enumerate(found, 1):
                if name in gone and one.trigger is not None and one.signal is not None:
                    self.becomes[id(node)] = self._noted(name, place, node)
                    used.append((one.trigger.signal, one.signal))
                else:
                    sayable = one.trigger is not None
                    self._stay(node, self.reasons.uncertain if sayable else self.reasons.special)
        for node, taking, what in said:
            if isinstance(what, e.Reason):
                self._stay(node, what)
            elif gone.issuperset(taking.names):
                self.becomes[id(node)] = replace(what, span=node.span)
            else:
                seen = declared.issuperset(taking.names)
                self._stay(node, self.reasons.special if seen else self.reasons.uncertain)
        return self._without(gone), used

    def _without(self, gone: set[str]) -> Program:
        """The program with what its statements become, and without some of its data."""

        def is_gone(text: VendorText) -> bool:
            one = self.told.get(id(text))
            return isinstance(one, TriggerData) and one.name in gone

        for node in _opaque(self.program):
            one = self.told.get(id(node))
            if isinstance(one, TriggerData) and one.name in gone:
                self.becomes[id(node)] = self._noted(one.name, 0, node)
        counted = {name: Variable("number", e.Number(0)) for name in self.numbers.values()}
        return replace(
            self.program,
            variables={**counted, **self.program.variables},
            procedures=tuple(replace(q, body=self._body(q.body)) for q in self.program.procedures),
            declarations=tuple(d for d in self.program.declarations if not is_gone(d)),
        )

    def _stay(self, node: p.Opaque, reason: e.Reason) -> None:
        self.becomes[id(node)] = replace(node, reason=reason)

    def _body(self, body: Body) -> Body:
        made = (self.becomes.get(id(node), node) for node in body)
        return tuple(map_bodies(node, self._body) for node in made if node is not None)

    def _noted(self, name: str, number: int, node: p.Opaque) -> p.Statement | None:
        """Notes which statement has set data up, 0 for none; nothing where no move asks."""
        if name not in self.numbers:
            return None
        return p.Assign(e.Name(self.numbers[name]), e.Number(number), span=node.span)

    def _said(
        self, node: p.Opaque, taking: TriggeredMove, state: State
    ) -> p.MoveStatement | p.Switch | e.Reason:
        """A move with its outputs; data that one statement alone sets up are so everywhere."""
        if taking.move is None:
            return self.reasons.move
        found = [self._may_be(name, state, node) for name in taking.names]
        # Choices multiply: too many are no program that a person reads.
        if not all(found) or math.prod(map(len, found)) > _MOST_CHOICES:
            return self.reasons.uncertain
        move = replace(taking.move, span=node.span)
        return self._chosen(move, list(zip(taking.names, found, strict=True)))

    def _may_be(self, name: str, state: State, node: p.Opaque) -> Sequence[tuple[int, p.Trigger]]:
        """Possible set-ups of data, with the numbers of the statements; empty if unknown.

        node: the move; what it calls sets nothing up before the choice.
        """
        one = self.single.get(name) or state.get(name)
        if one is not None and one.trigger is not None:
            return ((0, one.trigger),)
        every = [setup for _, setup in self.setups.get(name, ())]
        calls = set(_called_names(node))
        # A procedure that the move itself calls may set the data up after the choice.
        late = any(name in self.sets.get(one, ()) or self._is_foreign(one) for one in calls)
        if late or not self.chosen or not all(setup.fixed for setup in every):
            return ()
        return [(n, x.trigger) for n, x in enumerate(every, 1) if x.trigger is not None]

    def _chosen(
        self,
        move: p.MoveStatement,
        left: Sequence[tuple[str, Sequence[tuple[int, p.Trigger]]]],
        triggers: tuple[p.Trigger, ...] = (),
    ) -> p.MoveStatement | p.Switch:
        """The move, or a choice by the numbers of the statements that have set its data up."""
        if not left:
            return replace(move, triggers=triggers)
        (name, found), *rest = left
        made = {n: self._chosen(move, rest, (*triggers, one)) for n, one in found}
        if list(made) == [0]:
            return made[0]
        if name not in self.numbers:
            self.numbers[name] = identifier(f"{name}_set", self.taken_names)
            self.taken_names.add(self.numbers[name].lower())
        cases = tuple(p.Case((e.Number(n),), (one,)) for n, one in made.items())
        # Without a set-up the move cannot be made: the program ends.
        return p.Switch(e.Name(self.numbers[name]), cases, (p.Stop(end=True),))

    def _gone(self, declared: set[str], said: list[_Said]) -> set[str]:
        """Names of the data that nothing needs once moves say what they mean."""
        used = {name for _, taking, _ in said for name in taking.names}  # others may be another's
        if self.chosen and self.program.entry is not None:
            used |= self.setups.keys()
        unsaid = {n for n, found in self.setups.items() if any(x.trigger is None for _, x in found)}
        gone = (declared & used) - unsaid - self._elsewhere()
        # Data of a move that stays are needed, which may keep further moves: until none is added.
        while True:
            left = {
                name
                for _, taking, what in said
                if isinstance(what, e.Reason) or not gone.issuperset(taking.names)
                for name in taking.names
            }
            if gone.isdisjoint(left):
                return gone
            gone -= left

    def _declared(self) -> set[str]:
        """Names of the data that are declared once, where no other module may set them up."""
        parts = (q.body for q in self.program.procedures)
        texts = (
            _called_names(tuple(parts)),
            *(effect_of(d).calls for d in self.program.declarations),
        )
        whole = not any(self._is_foreign(name) for names in texts for name in names)
        count: Counter[str] = Counter()
        for one in self.told.values():
            if isinstance(one, TriggerData):
                # Data that another module may set up count twice, so as not to be declared once.
                count[one.name] += 1 if one.plain and (whole or one.own) else 2
        return {name for name, declarations in count.items() if declarations == 1}

    def _elsewhere(self) -> set[str]:
        """Return names that anything else has, and data that a vendor text may set up anew by a
        call.
        """
        names = {name for q in self.program.procedures for name in locals_of(q)}
        kept: list[VendorText] = list(self.program.declarations)
        for record in records(tuple(q.body for q in self.program.procedures)):
            match record:
                case e.Name(name) | p.For(name):
                    names.add(name.lower())
                case p.Opaque() | e.Verbatim():
                    kept.append(record)
        for text in kept:
            if id(text) not in self.told:
                mentioned = effect_of(text).names
                anew = frozenset().union(*(self.sets.get(name, ()) for name in mentioned))
                names |= mentioned | (anew - self.single.keys())
        return names


_Said = tuple[p.Opaque, TriggeredMove, p.MoveStatement | p.Switch | e.Reason]


def _merged_set_ups(one: State, other: State) -> State:
    return {name: setup for name, setup in one.items() if other.get(name) == setup}


def _called_names(value: Any) -> Iterator[str]:
    """Yield lower-case names of the procedures that statements or values call, vendor texts
    included.
    """
    for record in records(value):
        match record:
            case p.Call(name) | e.Apply(name):
                yield name.lower()
            case p.Opaque() | e.Verbatim():
                yield from effect_of(record).calls
