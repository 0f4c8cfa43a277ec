"""Walk through a program in the order in which it runs, and time its moves.

For a loop with an unknown number of rounds one round is timed. The motions of the further rounds
are passed through as well, for collisions: a round may start where the one before ended, or not
run at all.

Arrivals, the positions of the arm whenever the program comes to a `travel`, are stricter: the arm
may also come from the end of the round before, and a position that nothing states is unknown.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.base.arrays import Rows
from assistant.base.data_classes import dataclass
from assistant.base.source_text import lines_of
from assistant.program.analysis.dataflow import reachable
from assistant.program.analysis.uses import POSITION, altered, called
from assistant.program.expressions import Apply, Effect, Expression, Name, Number, unknown_effect
from assistant.program.geometry import JointTarget, Pose
from assistant.program.motion import Kind
from assistant.program.program import Procedure, Program, walk
from assistant.program.pseudo.expressions import expression_text
from assistant.program.rewriting import Body, head, records
from assistant.program.statements import (
    Assign,
    Call,
    For,
    Goto,
    If,
    Interrupt,
    Label,
    Moving,
    Opaque,
    Return,
    SetAcceleration,
    SetOverride,
    Statement,
    Stop,
    Switch,
    Travel,
    Wait,
    WaitSignal,
    WaitUntil,
    While,
    trait,
)
from assistant.program.vendor_statements import effect_of
from assistant.robots.program_values import (
    KnownValues,
    Names,
    Values,
    first_values,
    local_values,
    loop_rounds,
    may_read,
    root_variable,
)
from assistant.robots.solved_program import SolvedProgram
from assistant.robots.timing.course import join_moves
from assistant.robots.timing.plan import Drive, Plan, drive_of, plan_of
from assistant.robots.timing.segments import (
    Carried,
    Duration,
    History,
    JointValues,
    Segment,
    Segments,
    State,
    label_of,
    merged_state,
    with_carried,
)
from assistant.robots.timing.simulation import Ledger
from assistant.robots.timing.uninterrupted_moves import MovesWithoutStop

_MOST_ROUNDS: Final = 8
"""Largest number of rounds of a loop that may begin in different states."""


def _time_one_round(walker: Walker, body: Body, state: State, *, ever: bool) -> State | None:
    """The state behind a loop that is entered in a state, after the time of one round.

    ever: it has no end, so that it is not left out either.
    """
    assigned = {root_variable(s.target) for s in walk(body) if isinstance(s, Assign)}
    begin = state.without(assigned)
    end = walker.inner(body, begin)
    if end is None:
        return None if ever else begin
    done = state.then(end).without(assigned)
    ends = _further_rounds(walker, body, begin, end, done, assigned)
    others = [*ends] if ever else [*ends, begin]
    return merged_state([done, *(_after_same_time(done, one) for one in others)])


def _further_rounds(
    walker: Walker, body: Body, begin: State, end: State, done: State, assigned: set[str]
) -> list[State]:
    """Return the end states of the rounds after the first, until a round begins like an earlier
    one.
    """
    begun, ends, mark = [begin], list[State](), len(walker.returned)
    with _uncounted(walker):
        for _ in range(_MOST_ROUNDS):
            later = end.without(assigned).known
            changed = {name for name in later if later[name] != begin.known.get(name)}
            begin = end.without(assigned | changed)
            if any(one.same_state(begin) for one in begun):
                break
            begun.append(begin)
            following = walker.inner(body, begin)
            if following is None:
                break
            end = following
            ends.append(end)
        else:
            walker.note("a loop begins at many places; ways of its last rounds are not timed")
    walker.returned[mark:] = [_after_same_time(done, one) for one in walker.returned[mark:]]
    return ends


def _after_same_time(done: State, other: State) -> State:
    """Another state, after the time that one is after."""
    return replace(other, least=done.least, most=done.most, history=done.history)


@contextmanager
def _uncounted(walker: Walker) -> Iterator[None]:
    """Walk statements without counting their time; keep only notes about motions that are not
    timed.
    """
    ledger, procedures = walker.ledger, dict(walker.procedures)
    counts = walker.statements, walker.called
    walker.ledger = Ledger()
    yield
    for (procedure, what), times in walker.ledger.notes.items():
        if "not timed" in what:
            ledger.notes.setdefault((procedure, what), times)
    walker.ledger, walker.procedures = ledger, procedures
    walker.statements, walker.called = counts


class _VendorMotion:
    """Motion in a program's vendor statements, as far as the program holds the routines that they
    call.
    """

    def __init__(self, program: Program) -> None:
        self._program = program
        self._declared: dict[str, list[Effect]] = {}
        for declaration in program.declarations:
            effect = effect_of(declaration)
            for name in effect.writes:
                self._declared.setdefault(name, []).append(effect)
        self._moving: dict[str, bool] = {}

    def possible(self, effect: Effect) -> bool:
        """True if the arm may be elsewhere after a statement with this effect."""
        return effect.moves or any(map(self._moves, sorted(effect.calls)))

    def _moves(self, name: str) -> bool:
        """True if a routine, in lower case, or one that it calls may move the arm."""
        if name not in self._moving:
            reached, pending = {name}, [name]
            while pending and name not in self._moving:
                moves, calls = self._does(pending.pop())
                if moves:
                    self._moving[name] = True
                pending += sorted(calls - reached)
                reached |= calls
            self._moving.setdefault(name, False)
        return self._moving[name]

    def _does(self, name: str) -> tuple[bool, set[str]]:
        """Return whether a routine itself moves the arm, as a missing routine may, and the routines
        that it calls.
        """
        procedure = self._program.procedure(name)
        if procedure is None:
            effects = self._declared.get(name)
            if effects is None:
                return True, set()
            return any(one.moves for one in effects), {c for one in effects for c in one.calls}
        moves, calls = False, set[str]()
        for record in records(procedure.body):
            match record:
                case Call(called):
                    calls.add(called.lower())
                case Opaque():
                    effect = effect_of(record)
                    moves |= effect.moves
                    calls |= effect.calls
            moves |= isinstance(record, Moving)
        return moves, calls


_MOST_STATEMENTS: Final = 50_000
"""Statements that are walked through; then each loop is walked once and multiplied. Calls, too,
that are followed: some programs have more calls than anybody could wait for.
"""
_STOPPING_TRAITS: Final = ("waits", "calls", "jumps", "ends", "holds", "kept")
"""Traits of statements that the moves before them have to end for."""


class Walker:
    """Times procedures of a solved program.

    procedures: name → how long its calls take. ledger: what else is found on the way.
    """

    def __init__(self, solution: SolvedProgram, drive: Drive) -> None:
        self.solution, self.drive = solution, drive
        self.names = Names(solution.program)
        self.values = Values(solution.program, self.names)
        self.pieces = Segments(solution, self.names, self.values)
        self.kept_motion = _VendorMotion(solution.program)
        self.ledger = Ledger()
        self.procedures: dict[str, Duration] = {}
        self.plans: dict[tuple[object, ...], Plan] = {}
        self.passed: list[MovesWithoutStop] = []
        self.calls: list[str] = []
        self.returned: list[State] = []
        self.waiting: list[Segment] = []
        self.statements = self.called = 0
        self.set = {
            root_variable(s.target) for s in solution.program.statements() if isinstance(s, Assign)
        }
        self.shared = {name.lower() for name in solution.program.variables}

    def begin(self) -> KnownValues:
        """The variables of the program as they are at a start from the top."""
        return first_values(self.solution.program.variables, self.set)

    def procedure(self, procedure: Procedure, state: State, given: KnownValues) -> State:
        """A call, from the state before it; given: its arguments by parameter, where known."""
        kept, returned, self.returned = dict(state.known), self.returned, []
        self.calls.append(procedure.name)
        self.names.enter(procedure)
        own: KnownValues = {**self.names.own, **local_values(procedure), **given}
        outer = {name: value for name, value in kept.items() if name in self.shared}
        inside = replace(state.begun(), known={**outer, **own})
        ends = [self.body(procedure.body, inside), *self.returned]
        self.calls.pop()
        self.returned = returned
        done = merged_state([end for end in ends if end is not None]) or inside
        seconds = Duration(done.least, done.most)
        before = self.procedures.get(procedure.name, seconds)
        self.procedures[procedure.name] = Duration(
            min(before.least, seconds.least), max(before.most, seconds.most)
        )
        back = {n: v for n, v in done.known.items() if n in self.shared and n not in own}
        return state.then(replace(done, known={**kept, **back}))

    def body(self, body: Sequence[Statement], state: State | None) -> State | None:
        """From the state before it to its end; None if that is never reached."""
        for statement in body:
            if state is None:
                return None
            self.statements += 1
            self.names.own = dict(state.known)
            if isinstance(statement, Moving):
                state = self.moving(statement, state)
            elif (quick := self.setting(statement, state)) is not None:
                state = quick
            else:
                state = self.acting(statement, self.flush(state))
            if state is not None and state.carried is not None:
                state = with_carried(statement, state, self.waiting, self.values)
        return None if state is None else self.flush(state)

    def inner(self, body: Sequence[Statement], state: State) -> State | None:
        """Walk a body that is entered in a state, with a separate count."""
        mark = len(self.returned)
        end = self.body(body, state.begun())
        self.returned[mark:] = [state.then(one) for one in self.returned[mark:]]
        return end

    # ------------------------------------------------------------------------------- moves

    def moving(self, statement: Moving, state: State) -> State:
        """A motion statement, which waits to be timed together with those that follow it."""
        if id(statement) not in self.pieces.numbers:
            return state  # along a path of no targets
        near = state.places[0] if state.places else None
        if self.waiting:
            near = tuple(self.waiting[-1].moves.joints[-1].tolist())
        piece = self.pieces.piece(statement, self.calls[-1], state.settings, near)
        number, _ = self.pieces.numbers[id(statement)]
        if id(statement) in self.pieces.external:
            self.note(f"move {number}: its external axes are not timed")
        if id(statement) in self.pieces.bare:
            self.note(f"move {number}: its tool or frame is not known; the flange is taken")
        motion = getattr(statement, "motion", None)
        if motion is not None and {motion.tool.lower(), motion.frame.lower()} & self.set:
            self.note(f"move {number}: its tool or frame is set by the program; the first is taken")
        if piece is not None and getattr(statement, "until", None) is not None:
            self.note(f"move {number}: the way from where it is broken off is not timed")
        if piece is not None:
            self.waiting.append(replace(piece, carried=state.carried))
            return state
        self.note(
            f"move {number} to {label_of(statement)}: only running the program tells where that is"
        )
        return replace(self.flush(state), places=())

    def flush(self, state: State) -> State:
        """Times the moves that wait, from every place where the arm may be."""
        pieces, self.waiting = self.waiting, []
        if not pieces:
            return state
        moves = join_moves([piece.moves for piece in pieces])
        if np.isnan(moves.tcp).any():
            self.note("a speed that is not declared is taken as the most")
        if (moves.tcp <= 0.0).any():
            self.note("a speed that is not above 0 takes nearly for ever")
        end = tuple(moves.joints[-1].tolist())
        skipped = 0
        if not state.places:
            skipped = 2 if len(moves) > 1 and moves.kinds[0] == Kind.VIA else 1
            first = pieces[0]
            self.note(f"move {first.number}: where it starts from is not known, so it is not timed")
            if skipped == len(moves):
                return replace(state, places=(end,))
        starts: tuple[JointValues, ...] = state.places
        if not starts:
            starts = (tuple(moves.joints[skipped - 1].tolist()),)
        plans = []
        for start in starts:
            key = (tuple((piece.key, piece.carried) for piece in pieces), start, skipped)
            if key not in self.plans:
                rest = moves.rest(skipped) if skipped else moves
                self.plans[key] = plan_of(rest, np.array(start), self.solution.robot, self.drive)
                self.passed.append(
                    MovesWithoutStop(tuple(pieces), skipped, state.most, self.plans[key])
                )
            self.note_guessed(pieces, self.plans[key].course.knots.guessed + skipped)
            plans.append(self.plans[key])
            self.ledger.moved(pieces, skipped, self.plans[key])
        longest = max(plans, key=lambda plan: plan.seconds)
        return replace(
            state,
            least=state.least + min(plan.seconds for plan in plans),
            most=state.most + longest.seconds,
            places=(end,),
            history=History(state.history, longest),
        )

    def note_guessed(self, pieces: Sequence[Segment], rows: Rows) -> None:
        """rows: of the pieces together, see `Knots.guessed`."""
        ends = np.cumsum([len(piece.moves) for piece in pieces])
        for at in np.unique(np.searchsorted(ends, rows, side="right")):
            self.note(
                f"move {pieces[at].number}: the arm cannot stay in one branch on its way; how fast "
                "its axes must turn there is not known"
            )

    # ---------------------------------------------------------------------- other statements

    def setting(self, statement: Statement, state: State) -> State | None:
        """Apply a statement that does not interrupt the motion; return None for any other
        statement.
        """
        match statement:
            case SetOverride(percent=percent):
                value = self.number(percent, "the override")
                return state if value is None else state.under(override=max(value, 0.0) / 100.0)
            case SetAcceleration(acceleration=up, deceleration=down):
                rise, fall = self.values.number(up), self.values.number(down)
                if rise is None or fall is None:
                    self.note("an acceleration that only running the program tells stays as it was")
                    return state
                return state.under(acceleration=rise / 100.0, deceleration=fall / 100.0)
            case Assign(target=Name(name), value=value):
                return replace(state, known={**state.known, name.lower(): self.values.value(value)})
            case Assign(target=target):
                return state.without({root_variable(target)})
        standing = trait(statement) in _STOPPING_TRAITS or isinstance(statement, Travel)
        return None if standing else state

    def acting(self, statement: Statement, state: State) -> State | None:
        """Apply a statement for which the arm stops; return None if nothing after it is reached."""
        self.names.own = dict(state.known)
        match statement:
            case Wait(seconds=seconds):
                value = self.number(seconds, "a wait")
                return state if value is None else state.waited(value)
            case WaitSignal(signal=signal, value=value_):
                self.note(f"the wait for {signal} = {expression_text(value_)}")
            case WaitUntil(condition=condition):
                self.note(f"the wait until {expression_text(condition)}")
            case Call():
                return self.call(statement, state)
            case If() | Switch():
                return self.branches(statement, state)
            case For():
                return self.counted(statement, state)
            case While():
                return self.loop(statement, state)
            case Return() | Stop(end=True):
                self.returned.append(state)
                return None
            case Stop():
                self.note("a stop, until somebody starts the program again")
            case Goto(label=label):
                self.note(f"the jump to {label} is not followed")
            case Opaque():
                return self.kept(statement, state)
            case Travel(target=target):
                self.note(f"the way to {expression_text(target)} is not planned, nor timed")
                return replace(state, places=())
        return state

    def kept(self, statement: Opaque, state: State) -> State:
        """Vendor text: where it leads to, and for how long, only its own controller knows."""
        text, effect = statement.text, effect_of(statement)
        line = lines_of(text.strip())[0] if text.strip() else text
        state = state.without(set(effect.names))
        if not self.kept_motion.possible(effect):
            self.note(f"`{line}` is taken as neither time nor motion")
            return state
        if effect.moves and effect != unknown_effect(text):
            self.note(f"`{line}` is a motion whose time is not known")
        else:
            self.note(f"`{line}` may move the arm, in a time that is not known")
        return replace(state, places=())

    def call(self, statement: Call, state: State) -> State:
        procedure = self.solution.program.procedure(statement.procedure)
        if procedure is None:
            self.note(f"`{statement.procedure}` is not there")
            return replace(state, places=())
        if procedure.name in self.calls:
            self.note(f"`{procedure.name}` calls itself; that is not followed")
            return replace(state, places=())
        self.called += 1
        if self.called > _MOST_STATEMENTS:
            self.note("there are too many calls; the last of them are not followed")
            return replace(state, places=())
        given = self.values.given(procedure, statement.arguments)
        changed = {
            root_variable(argument)
            for parameter, argument in zip(procedure.parameters, statement.arguments, strict=False)
            if parameter.mode == "inout"
        }
        return self.procedure(procedure, state, given).without(changed)

    def branches(self, statement: If | Switch, state: State) -> State | None:
        """Every way that may be taken, and where they meet."""
        taken: list[State | None] = []
        if isinstance(statement, If):
            for branch in statement.branches:
                self.names.own = dict(state.known)
                holds = self.values.truth(branch.condition)
                if holds is not False:
                    taken.append(self.inner(branch.body, state))
                if holds:
                    break
            else:
                taken.append(self.inner(statement.otherwise, state))
        else:
            inner = (*(case.body for case in statement.cases), statement.otherwise)
            taken += [self.inner(body, state) for body in inner]
        done = merged_state([one for one in taken if one is not None])
        return None if done is None else state.then(done)

    def counted(self, statement: For, state: State) -> State | None:
        """Walk as many rounds as the text states, else one; rounds that are alike are walked
        once.
        """
        first, last = self.values.number(statement.first), self.values.number(statement.last)
        step = None if statement.step is None else self.values.number(statement.step)
        name = statement.variable.lower()
        if first is None or last is None or (statement.step is not None and step is None):
            self.note(f"how often the loop over {statement.variable} goes round; once is counted")
            return self.once(statement, state.without({name}))
        count = loop_rounds(first, last, step)
        by = step if step is not None else (1.0 if last >= first else -1.0)
        alike = not self.reads(statement, name)
        done = 0
        while done < count:
            known: KnownValues = {**state.known, name: Number(first + done * by)}
            start = replace(state, known=known)
            end = self.inner(statement.body, start)
            if end is None:
                return None
            done += 1
            again = count - done if done < count and self.repeats(start, end, alike) else 0
            done += again
            state = state.then(end, 1 + again)
        return state.without({name})

    def loop(self, statement: While, state: State) -> State | None:
        """Rounds until the condition fails, as long as it is known to hold; else one."""
        holds = self.values.truth(statement.condition)
        constant = not any(isinstance(part, Name) for part in records(statement.condition))
        if holds and constant:
            self.note("the loop runs for ever; one round is counted")
            end = self.once(statement, state, ever=True)
            if end is not None:
                self.returned.append(end)
            return None
        while holds and self.statements < _MOST_STATEMENTS:
            end = self.inner(statement.body, state)
            if end is None:
                return None
            if state.same_state(end):
                break
            state = state.then(end)
            self.names.own = dict(state.known)
            holds = self.values.truth(statement.condition)
        if holds is False:
            return state
        text = expression_text(statement.condition)
        self.note(f"how often the loop while {text} goes round; once is counted")
        return self.once(statement, state)

    def once(self, statement: For | While, state: State, *, ever: bool = False) -> State | None:
        """A round of a loop whose rounds are not known, and what is not known after it."""
        return _time_one_round(self, statement.body, state, ever=ever)

    def repeats(self, start: State, end: State, alike: bool) -> bool:
        """True if the remaining rounds equal this one; also if there have been too many.

        alike: the count of the loop makes no difference to its rounds.
        """
        if alike and start.same_state(end):
            return True
        if self.statements < _MOST_STATEMENTS:
            return False
        self.note("a long loop; its last rounds are taken as the one before them")
        return True

    def reads(self, statement: For, name: str) -> bool:
        """True if the body of a loop may read its variable."""
        inner = list(walk(statement.body))
        if name in self.shared and any(isinstance(s, Call | Opaque) for s in inner):
            return True
        return any(may_read(s, name) for s in inner)

    def number(self, expression: Expression, what: str) -> float | None:
        value = self.values.number(expression)
        if value is None:
            text = expression_text(expression)
            self.note(f"{what} of {text}, which only running the program tells")
        return value

    def note(self, what: str) -> None:
        self.ledger.note(self.calls[-1], what)


@dataclass(frozen=True, slots=True)
class Doubt:
    """Why it is not known where the arm may stand, and what to do."""

    why: str
    cure: str


_JUMPED: Final = Doubt("a jump leads around it", "say it by loops and branches, without jumps")
_INTERRUPTED: Final = Doubt(
    "an interrupt may have come before",
    "let interrupts neither move the arm nor end a cycle, nor come where bodies are carried",
)
_TOO_LONG: Final = Doubt(
    "a loop goes round too often to be followed", "let each round begin at the same place"
)
_RECURSIVE: Final = Doubt("a procedure before it calls itself", "call no procedure out of itself")
_CARRIED_UNKNOWN: Final = Doubt(
    "what the arm carries may have been changed by what only its controller knows",
    "say it by statements of the pseudo-program",
)
_MOVING_FUNCTION: Final = Doubt(
    "what works a value out before it moves the arm", "move by a procedure that is called"
)


@dataclass(frozen=True, slots=True)
class Arrival:
    """The program's arrival at a travel.

    number: of the travel among those of the program, from 0, in order of text. places: possible
    joints of the arm. carried: by it. doubt: reason why `places` may be incomplete, None if it is
    complete. goal: the pose in its frame, or the joints, to which its target evaluates then, None
    if it is known only when the program runs. external: it moves external axes. first: nothing
    moved before it. joints: (a,) of the move that follows directly, None if they are not known.
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
    found = dict.fromkeys(reachable(circles, after), _RECURSIVE)
    return found | dict.fromkeys(reachable(coming, after), _INTERRUPTED)


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
                self.doubt = _JUMPED
            case Interrupt(call=call, ends=ends):
                moves = call.procedure.lower() in self.movers or ends is not None
                if moves or state.carried is not None:
                    self.doubt = _INTERRUPTED
        return super().setting(statement, state)

    def functions(self, statement: Statement) -> None:
        """Set the doubt for all after a statement that calls a function which moves the arm."""
        for part in records(head(statement)) if self.moving_functions else ():
            match part:
                case Apply(name) if name.lower() in self.moving_functions:
                    self.doubt = _MOVING_FUNCTION

    def acting(self, statement: Statement, state: State) -> State | None:
        match statement:
            case Travel():
                self.names.own = dict(state.known)
                return self.travel(statement, state)
            case Goto():
                self.doubt = _JUMPED
            case Opaque() if state.carried is not None:
                self.doubt = _CARRIED_UNKNOWN
        return super().acting(statement, state)

    def call(self, statement: Call, state: State) -> State:
        procedure = self.solution.program.procedure(statement.procedure)
        if procedure is None and state.carried is not None:
            self.doubt = _CARRIED_UNKNOWN
        elif procedure is not None and procedure.name in self.calls:
            self.doubt = _RECURSIVE
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
        """Extend a doubt that arises in one round of a loop to all arrivals of its rounds."""
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
            if len(begun) == _MOST_ROUNDS:
                self.doubt = _TOO_LONG
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
            self.doubt = _TOO_LONG
        return done
