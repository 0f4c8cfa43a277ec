"""Where the arm stands whenever a program comes to one of its travels.

Stricter than timing, which counts a loop of an unknown number of rounds once: here the arm may also
come from the end of the round before, and where nothing tells, a place is not known.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Final

from assistant.program.analysis.dataflow import reachable
from assistant.program.analysis.uses import POSITION, altered, called
from assistant.program.expressions import Apply
from assistant.program.geometry import JointTarget, Pose
from assistant.program.program import Program
from assistant.program.rewriting import head, records
from assistant.program.statements import (
    Assign,
    Call,
    For,
    Goto,
    Interrupt,
    Label,
    Moving,
    Opaque,
    Statement,
    Travel,
    While,
)
from assistant.robots.solved_program import SolvedProgram
from assistant.robots.timing.again import MOST_ROUNDS
from assistant.robots.timing.carrying import Carried
from assistant.robots.timing.drive import drive_of
from assistant.robots.timing.state import JointValues, State, merged_state
from assistant.robots.timing.variables import root_variable
from assistant.robots.timing.walking import Walker


@dataclass(frozen=True, slots=True)
class Doubt:
    """Why it is not known where the arm may stand, and what to do."""

    why: str
    cure: str


JUMPED: Final = Doubt("a jump leads around it", "say it by loops and branches, without jumps")
INTERRUPTED: Final = Doubt(
    "an interrupt may have come before",
    "let interrupts neither move the arm nor end a cycle, nor come where bodies are carried",
)
TOO_LONG: Final = Doubt(
    "a loop goes round too often to be followed", "let each round begin at the same place"
)
RECURSIVE: Final = Doubt("a procedure before it calls itself", "call no procedure out of itself")
CARRIED_UNKNOWN: Final = Doubt(
    "what the arm carries may have been changed by what only its controller knows",
    "say it by statements of the pseudo-program",
)
MOVING_FUNCTION: Final = Doubt(
    "what works a value out before it moves the arm", "move by a procedure that is called"
)


@dataclass(frozen=True, slots=True)
class Arrival:
    """The program comes to a travel.

    number: of the travel among those of the program, from 0, in order of text. places: joints
    where the arm may stand. carried: by it. doubt: why `places` may lack one, None if none does.
    goal: the pose in its frame, or the joints, that its target means then, None if only running the
    program tells. external: it moves external axes. first: nothing moved before it. joints: (a,) of
    the move that stands right behind it, None if they are not known.
    """

    number: int
    places: tuple[JointValues, ...]
    carried: Carried | None
    doubt: Doubt | None
    goal: Pose | JointTarget | None
    external: bool
    first: bool
    joints: JointValues | None = None


def arrivals(solution: SolvedProgram, carried: Carried | None = None) -> tuple[Arrival, ...]:
    """Every arrival at a travel, as a program runs from home, in order of its ways.

    carried: what the arm carries at first, None if that need not be known. What the entry never
    comes to has no arrival. They end with the first one of a travel that leads elsewhere than
    before.
    """
    walker = _ArrivalWalker(solution)
    program = solution.program
    entry = program.procedure(program.entry) if program.entry else None
    if entry is not None:
        place = tuple(map(float, solution.robot.home))
        first = State(places=(place,), known=walker.begin(), carried=carried)
        with suppress(_OtherArrival):
            walker.procedure(entry, first, {})
    return tuple(walker.found)


def _anywhere(program: Program) -> dict[str, Doubt]:
    """Procedures, in lower case, that also begin where no way through the program tells."""
    calls = {one.name.lower(): tuple(called(one)) for one in program.procedures}

    def after(name: str) -> tuple[str, ...]:
        return calls.get(name, ())

    coming = {s.call.procedure.lower() for s in program.statements() if isinstance(s, Interrupt)}
    circles = {name for name in calls if name in reachable(after(name), after)}
    found = dict.fromkeys(reachable(circles, after), RECURSIVE)
    return found | dict.fromkeys(reachable(coming, after), INTERRUPTED)


class _OtherArrival(Exception):
    """A travel leads to another place than before."""


class _ArrivalWalker(Walker):
    """Goes through a program without timing it."""

    def __init__(self, solution: SolvedProgram) -> None:
        super().__init__(solution, drive_of(solution.robot))
        program = solution.program
        travels = [s for s in program.statements() if isinstance(s, Travel)]
        self.numbered = {id(statement): i for i, statement in enumerate(travels)}
        changed = altered(program)
        functions = {one.name.lower() for one in program.procedures if one.result is not None}
        self.movers = {name for name, parts in changed.items() if POSITION in parts}
        self.moving_functions = self.movers & functions
        self.anywhere = _anywhere(program)
        self.found: list[Arrival] = []
        self.goals: dict[int, Pose | JointTarget | None] = {}
        self.doubt: Doubt | None = None
        self.first = True  # nothing has moved yet
        self.open = False  # the move behind a travel comes next

    # ------------------------------------------------------------------------------- moves

    def moving(self, statement: Moving, state: State) -> State:
        self.functions(statement)
        state = super().moving(statement, state)
        if self.open and self.waiting:
            joints = tuple(self.waiting[-1].moves.joints[-1].tolist())
            self.found[-1] = replace(self.found[-1], joints=joints)
        self.first = self.open = False
        if getattr(statement, "until", None) is not None:  # it may stop anywhere on its way
            return replace(self.flush(state), places=())
        return state

    def flush(self, state: State) -> State:
        pieces, self.waiting = self.waiting, []
        if not pieces:
            return state
        return replace(state, places=(tuple(pieces[-1].moves.joints[-1].tolist()),))

    def travel(self, statement: Travel, state: State) -> State:
        place, joints = self.values.place(statement.target), self.names.joints(statement.target)
        target = joints if place is None else place.target
        arrival = Arrival(
            self.numbered[id(statement)],
            state.places,
            state.carried,
            self.doubt or self.anywhere.get(self.calls[-1].lower()),
            joints if place is None else place.pose,
            target is not None and not all(map(math.isnan, target.external)),
            self.first,
        )
        self.found.append(arrival)
        if self.goals.setdefault(arrival.number, arrival.goal) != arrival.goal:
            raise _OtherArrival
        self.open = True
        return state

    # --------------------------------------------------------------------- other statements

    def setting(self, statement: Statement, state: State) -> State | None:
        self.functions(statement)
        match statement:
            case Label():
                self.doubt = JUMPED
            case Interrupt(call=call, ends=ends):
                moves = call.procedure.lower() in self.movers or ends is not None
                if moves or state.carried is not None:
                    self.doubt = INTERRUPTED
        return super().setting(statement, state)

    def functions(self, statement: Statement) -> None:
        """Doubts what stands behind a statement that calls a function which moves the arm."""
        for part in records(head(statement)) if self.moving_functions else ():
            match part:
                case Apply(name) if name.lower() in self.moving_functions:
                    self.doubt = MOVING_FUNCTION

    def acting(self, statement: Statement, state: State) -> State | None:
        match statement:
            case Travel():
                self.names.own = dict(state.known)
                return self.travel(statement, state)
            case Goto():
                self.doubt = JUMPED
            case Opaque() if state.carried is not None:
                self.doubt = CARRIED_UNKNOWN
        return super().acting(statement, state)

    def call(self, statement: Call, state: State) -> State:
        procedure = self.solution.program.procedure(statement.procedure)
        if procedure is None and state.carried is not None:
            self.doubt = CARRIED_UNKNOWN
        elif procedure is not None and procedure.name in self.calls:
            self.doubt = RECURSIVE
        return super().call(statement, state)

    # ------------------------------------------------------------------------------- loops

    def counted(self, statement: For, state: State) -> State | None:
        with self.rounds():
            return super().counted(statement, state)

    def loop(self, statement: While, state: State) -> State | None:
        with self.rounds():
            return super().loop(statement, state)

    @contextmanager
    def rounds(self) -> Iterator[None]:
        """What is doubted in a round, is so in those that come after it as well."""
        first, before = len(self.found), self.doubt
        yield
        if self.doubt != before:
            self.found[first:] = [replace(one, doubt=self.doubt) for one in self.found[first:]]

    def once(self, statement: For | While, state: State, *, ever: bool = False) -> State | None:
        """No round, unless it has no end, one, and more, until they begin as others began."""
        assigned = {
            root_variable(part.target) for part in records(statement) if isinstance(part, Assign)
        }
        begin = state.without(assigned)
        ways, begun = [] if ever else [begin], list[State]()
        while not any(one.same_state(begin) for one in begun):
            if len(begun) == MOST_ROUNDS:
                self.doubt = TOO_LONG
                break
            begun.append(begin)
            end = self.inner(statement.body, begin)
            if end is None:
                break
            known, later = begin.known, end.without(assigned).known
            changed = {name for name in later if later[name] != known.get(name)}
            begin = end.without(assigned | changed)
            ways.append(begin)
        return merged_state(ways)

    def repeats(self, start: State, end: State, alike: bool) -> bool:
        done = super().repeats(start, end, alike)
        if done and not (alike and start.same_state(end)):
            self.doubt = TOO_LONG
        return done
