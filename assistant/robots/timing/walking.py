"""Walks through a program in the order in which it runs, and times what it meets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.base.arrays import Rows
from assistant.base.source_text import lines_of
from assistant.program.expressions import Expression, Name, Number, unknown_effect
from assistant.program.motion import Kind
from assistant.program.program import Procedure, walk
from assistant.program.pseudo.expressions import expression_text
from assistant.program.rewriting import records
from assistant.program.statements import (
    Assign,
    Call,
    For,
    Goto,
    If,
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
from assistant.robots.solved_program import SolvedProgram
from assistant.robots.target_lookup import Names
from assistant.robots.timing import again
from assistant.robots.timing.carrying import with_carried
from assistant.robots.timing.drive import Drive
from assistant.robots.timing.kept import VendorMotion
from assistant.robots.timing.ledger import Ledger
from assistant.robots.timing.passed import MovesWithoutStop
from assistant.robots.timing.pieces import Segment, Segments, label_of
from assistant.robots.timing.plan import Plan, plan_of
from assistant.robots.timing.rows import join_moves
from assistant.robots.timing.state import Duration, History, JointValues, State, merged_state
from assistant.robots.timing.values import (
    KnownValues,
    Values,
    first_values,
    local_values,
    loop_rounds,
)
from assistant.robots.timing.variables import may_read, root_variable

MOST_STATEMENTS: Final = 50_000
"""Statements that are walked through; then each loop is walked once and multiplied. Calls, too,
that are followed: some programs have more calls than anybody could wait for.
"""
STOPPING_TRAITS: Final = ("waits", "calls", "jumps", "ends", "holds", "kept")
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
        self.kept_motion = VendorMotion(solution.program)
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
        """A body that is entered in a state, counted by itself."""
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
        """What does not keep the arm from moving on; None for any other statement."""
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
        standing = trait(statement) in STOPPING_TRAITS or isinstance(statement, Travel)
        return None if standing else state

    def acting(self, statement: Statement, state: State) -> State | None:
        """What the arm stands still for; None if nothing behind it is reached."""
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
        if self.called > MOST_STATEMENTS:
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
        """As many rounds as the text tells, else one; alike ones are walked once."""
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
        while holds and self.statements < MOST_STATEMENTS:
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
        return again.time_one_round(self, statement.body, state, ever=ever)

    def repeats(self, start: State, end: State, alike: bool) -> bool:
        """Whether the rounds to come are as this one; also when there have been too many.

        alike: the count of the loop makes no difference to its rounds.
        """
        if alike and start.same_state(end):
            return True
        if self.statements < MOST_STATEMENTS:
            return False
        self.note("a long loop; its last rounds are taken as the one before them")
        return True

    def reads(self, statement: For, name: str) -> bool:
        """Whether the body of a loop may read its variable."""
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
