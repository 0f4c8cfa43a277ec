"""A seeded search for inputs that take every branch of two programs, and the runs it compares.

It tries bytes that the other ends of sockets may send, and limits each run to the time of the
proof.
"""

from __future__ import annotations

import math
import re
import struct
import time
from collections import Counter, defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import field, replace
from itertools import product
from random import Random
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.virtual.events import (
    Awaited,
    Branch,
    Branches,
    BranchKey,
    Kept,
    Logged,
    Moved,
    Place,
    Run,
    Stopped,
    Waited,
)
from assistant.virtual.kernel import Board, Kernel
from assistant.virtual.kernel.script import Panel, Script, by_numbers, follow
from assistant.virtual.kernel.task import Ending
from assistant.virtual.proving.compared_programs import STATEMENT_TIME, Side
from assistant.virtual.proving.comparison import Bits, Rounding, Uncompared, Unlike, likeness
from assistant.virtual.proving.driver import (
    PLAIN_ANSWERS,
    POLLS,
    Answers,
    Driver,
    Moment,
    Readings,
    Scenario,
    Wiring,
    answer_rows,
)

MESSAGE_WORDS: Final = 20
"""Numbers in a message; what most protocols of arms send has fewer."""
MOST_MESSAGES: Final = 60
SAID_WORD: Final = 60
"""Texts that come over a line in a run."""
_BYTES: Final = re.compile(r"\brawbytes\b", re.IGNORECASE)
_HIGHEST_FIRST: Final = re.compile(r"\\\s*Network\b", re.IGNORECASE)
_WHOLE: Final = re.compile(r"(?<![\w.#])[0-9]{1,4}(?![\w.])")


def likely_messages(text: str) -> tuple[str, ...]:
    """Messages for a program: their length, and words that are all one number of its text.

    A program continues if it recognises the kind of a message by its number; an unknown message may
    end it. Most numbers have four bytes, with the lowest first unless the text defines another
    order. Characters represent the bytes.
    """
    if _BYTES.search(text) is None:
        return ()
    numbers = dict.fromkeys(int(one) for one in _WHOLE.findall(text))
    orders = "><" if _HIGHEST_FIRST.search(text) else "<"
    return tuple(_built_message(list(numbers), orders))


def _built_message(numbers: list[int], orders: str) -> Iterator[str]:
    for number in sorted(numbers, reverse=True)[:MOST_MESSAGES]:
        for order in orders:
            words = struct.pack(f"{order}{MESSAGE_WORDS}I", *[number] * MESSAGE_WORDS)
            yield (struct.pack(f"{order}I", len(words)) + words).decode("latin-1")


def sent_words(run: int, known: Sequence[str], texts: Sequence[str]) -> tuple[str, ...]:
    """Return the texts that the other ends of lines send in a run, by its number: one of the known
    messages.

    Without known messages, numbers come first, which any variable takes; later runs also send the
    texts of the first program in turn.
    """
    if known:
        return (known[run % len(known)],)
    place = run % len(texts)
    first = [*texts[place:], *texts] if place else ["1", "2", "3"]
    return tuple(first[i % len(first)] for i in range(SAID_WORD))


LATER_SHARE: Final = 3
"""Times as long as the source the written program may take; it has to do as much by then."""
LEAST_SECONDS: Final = 2.0
"""Least seconds of the first run of the source."""
LOOK_PERIOD: Final = 64
"""Statements between two looks at the clock."""
MORE_EVENTS_THAN_SOURCE: Final = (1.25, 4)
"""Events of the written program, as a factor and a number added, relative to a source without
end.
"""
MORE_EFFECTS_THAN_SOURCE: Final = 2
"""Times as many visits and changes as the source has told are far more."""
OVER: Final = "time"
"""Ending of a run that took too long."""
QUIET_STATEMENTS: Final = 250_000
"""Statements without an effect: taking a text apart, letter by letter, takes over 100,000."""
RAN_ON: Final = "it runs on without any effect"
"""Message of a run that was cut off for this reason."""


def first_run_seconds(seconds: float, source: bool) -> float:
    """Return the seconds for the first run of the source, or of the written program, in a proof of
    so many.
    """
    return max(seconds, LEAST_SECONDS) * (1 if source else LATER_SHARE)


def limit_run(
    kernel: Kernel,
    seconds: float,
    after: Run | None = None,
    most: float = math.inf,
    ample: float = math.inf,
) -> None:
    """Has the run of a kernel end after so many seconds of the real clock.

    after: the run that it is compared with. Where that was broken off by its statements, what it
    has told is all that can be compared. most: events that the run may tell. ample: statements
    after which it ends where it has done far more, or nothing for a long time.
    """
    # Time of this thread: other work of the computer does not shorten a proof.
    until = time.thread_time() + seconds
    counted = told = effects = latest = 0
    endless = after is not None and after.ended == "steps"
    enough = (
        MORE_EVENTS_THAN_SOURCE[0] * len(after.events) + MORE_EVENTS_THAN_SOURCE[1]
        if after and endless
        else most
    )
    far_more = MORE_EFFECTS_THAN_SOURCE * (_effect_count(after.log) + 1) if after else math.inf

    def limit() -> Ending | None:
        nonlocal counted, told, effects, latest
        counted += 1
        # Reading the clock at each statement would cost more than the statements.
        if counted % LOOK_PERIOD:
            return None
        if new := _effect_count(kernel.log[told:]):
            effects, latest = effects + new, counted
        told = len(kernel.log)
        if time.thread_time() > until:
            return Ending(OVER, f"it takes more than {seconds:.3g} s")
        # A run compared with one that was cut off needs no more events than that.
        if told > enough:
            return Ending("steps", "it has told as much as the run before")
        if counted > ample and effects > far_more:
            return Ending("steps", "it has done far more than the run before")
        if counted > ample and counted - latest > QUIET_STATEMENTS:
            return Ending("steps", RAN_ON)
        return None

    kernel.limit = limit


def _effect_count(log: Sequence[Logged]) -> int:
    return sum(not isinstance(row.what, Awaited | Waited) for row in log)


MOST_RUNS: Final = 200
SECONDS: Final = 10.0
STEPS: Final = 20_000
"""Statements of a run beside four for each line of its text: a program without end has shown
enough by then."""
SLOWER: Final = 2.0
"""Times as long a statement takes in a second run, which tells what timers end from what a program
counts."""
MORE_STEPS: Final = 20
"""Factor of the written program's statements: one statement may have become several."""
LOOKS: Final = 2
"""Times as many statements as the time of a wait holds."""
LEAST_STEPS: Final = 500
"""Statements that a run of the source counts as having at least."""
MOST_IN_VAIN: Final = 10
"""Runs with inputs at random that take no new branch before the search gives up."""
FEW_RUNS: Final = 2
"""For each such number of runs, one may be impossible to judge, with inputs that the manuals define
less.
"""
MOST_SILENT: Final = 5
"""Times that a wait which is tried again and again gets no answer."""
MOST_FOLLOWED: Final = 5
"""Runs whose inputs are varied for the other ways of one statement."""
TOGETHER: Final = 3
"""Scenarios in which all inputs that a branch may hang on are others, at random."""
BELOW: Final = 12
"""Lines below a choice that may contain its cases."""
FIRST_EVENTS: Final = 2000
"""Events that the first run may tell, beside four for each line of its text."""
MORE_EVENTS: Final = 200
"""Beside twice those of the longest run that came to an end: a run that tells more has none."""
COMBINED: Final = 3
"""Inputs of a statement that are tried in all combinations; of more they change one by one."""
TRIED_VALUES: Final = 6
"""Values tried for a group of signals, for each branch that depends on it."""
SMALL: Final = (1, 2)
"""Numbers that places of pallets, elements of arrays and cases begin with: what a program may
want of inputs that it ends in an error with."""


@dataclass(frozen=True, slots=True)
class Budget:
    """seed: of what is drawn. runs, seconds, differences: after which the search is over."""

    seed: int = 0
    runs: int = MOST_RUNS
    seconds: float = SECONDS
    differences: int = 1


@dataclass(frozen=True, slots=True)
class Stop:
    """A run without a usable result. side: 0 for the source, 1 for the written program."""

    side: int
    run: Run
    scenario: Scenario


@dataclass(frozen=True, slots=True)
class Difference:
    """A difference between two runs, and the scenario that shows it.

    behind: the last branch that either took before that.
    """

    unlike: Unlike
    scenario: Scenario
    behind: tuple[Branch | None, Branch | None]


@dataclass(frozen=True, slots=True)
class Visit:
    """A motion of the written program, at a place of the source, and inputs that lead there."""

    moved: Moved
    place: Place | None
    scenario: Scenario


@dataclass(slots=True)
class Found:
    """Result of all runs together.

    cut: runs of the source that were cut off because they did not end. failing: runs that end with
    an error of the program itself. idling: runs that wait for ever before anything is compared,
    idle the first of them. stalled: runs that wait for ever after the compared events, because the
    script ends or no run continues, one for each wait. stalling: number of such runs without a
    script. visited: motions of the written program in runs without a difference, by what determines
    whether an arm can end them. differences: one for each position. unknown: a statement that an
    interpreter could not run, unjudged: the same after runs that were compared. unfinished: a first
    run that took all the time. never: branches of either program that no run took. total: number of
    its branches.
    """

    runs: int = 0
    cut: int = 0
    visits: int = 0
    changes: int = 0
    waits: int = 0
    values: int = 0
    left: frozenset[Uncompared] = frozenset()
    apart: float = 0.0
    turned: float = 0.0
    differences: list[Difference] = field(default_factory=list)
    unknown: Stop | None = None
    unjudged: Stop | None = None
    unfinished: Stop | None = None
    failed: Stop | None = None
    failing: int = 0
    idle: Stop | None = None
    idling: int = 0
    stalled: list[Stop] = field(default_factory=list)
    stalling: int = 0
    visited: dict[tuple[object, ...], Visit] = field(default_factory=dict)
    total: tuple[int, int] = (0, 0)
    never: tuple[tuple[Branch, ...], tuple[Branch, ...]] = ((), ())


def compared(
    first: Side,
    second: Side,
    signals: Bits,
    rounding: Rounding,
    budget: Budget,
    script: Script | None = None,
) -> Found:
    """Runs two programs against the same signals, until no branch is left or the budget is over.

    script: what becomes of the signals, in the names of the first; then there is one run.
    """
    return _Search(first, second, signals, rounding, budget, script).run()


@dataclass
class _Search:
    first: Side
    second: Side
    signals: Bits
    rounding: Rounding
    budget: Budget
    script: Script | None = None
    found: Found = field(default_factory=Found)

    def __post_init__(self) -> None:
        self.random = Random(f"proof {self.budget.seed}")  # noqa: S311 - the same for a seed
        self.known: tuple[Branches, Branches] = self.first.branches(), self.second.branches()
        self.taken: tuple[dict[BranchKey, None], dict[BranchKey, None]] = {}, {}
        self.numbers = _number_values(self.first.text())
        texts = re.findall(r'"([^",\\\n]{1,40})"', self.first.text())
        self.messages = likely_messages(self.first.text())
        self.texts = ["1", *dict.fromkeys(text for text in texts if text.isascii()), "2"]
        self.tried: set[Scenario] = set()
        self.aimed: set[Scenario] = set()
        self.followed: Counter[tuple[str, int]] = Counter()
        self.ended: set[object] = set()
        self.silent: dict[Scenario, tuple[object, Moment, int]] = {}
        self.watched: set[tuple[int, str]] = set()
        self.pending: deque[Scenario] = deque([Scenario()])
        self.later: deque[Scenario] = deque()
        self.kept: set[Scenario] = set()  # those that no branch hangs on
        self.weighed: set[object] = set()
        self.left_early: set[object] = set()
        # Long programs report and run more before they come to an end.
        lines = max(side.text().count("\n") for side in (self.first, self.second))
        self.most = FIRST_EVENTS + 4 * lines
        self.longest = 0
        self.steps = STEPS + 4 * lines
        self.differing: set[object] = set()
        self.measured: Set[str] = frozenset()
        self.reads = False
        self.missed = 0
        self.passed: set[object] = set()
        self.unanswered: dict[object, list[Stop]] = {}
        self.late = False  # whether the time was over in the middle of a run

    def run(self) -> Found:
        self.until = time.thread_time() + self.budget.seconds
        played: list[Scenario] = []
        vain = 0
        while self.found.runs < self.budget.runs and vain < MOST_IN_VAIN:
            # As long as every message ends the program, no scenario of inputs can tell more.
            scenario = Scenario() if self._begins() else self._next(played)
            if scenario is None or (self.found.runs and time.thread_time() > self.until):
                break
            aimed = scenario in self.aimed
            new, done = self._both(scenario)
            played.append(done)
            if self.late or self._differ() or self.found.unknown is not None:
                break
            # A program that always ends in an error has not begun: that is no vain run.
            if self._begins():
                continue
            # Aimed scenarios have a reason of their own; only random ones count as in vain.
            vain = 0 if new else vain + (not aimed)
            if self.script is not None or not self.reads:
                break
            # All branches are taken: of the pending scenarios
            # only those remain that test something else.
            if any(self.known) and not self._open():
                self.pending = deque(one for one in self.pending if one in self.kept)
        for place, stops in self.unanswered.items():
            if place not in self.passed:
                self.found.stalled.append(stops[0])
                self.found.stalling += len(stops)
        if FEW_RUNS * self.missed > self.found.runs:
            self.found.unknown = self.found.unjudged
        self.found.total = len(self.known[0]), len(self.known[1])
        left = [
            tuple(one for way, one in known.items() if way not in taken)
            for known, taken in zip(self.known, self.taken, strict=True)
        ]
        self.found.never = left[0], left[1]
        return self.found

    def _differ(self) -> bool:
        """True if the requested number of differences is found."""
        return len(self.found.differences) >= self.budget.differences

    def _begins(self) -> bool:
        """True if all messages so far have ended the first program, and others are left."""
        return bool(self.found.failing == self.found.runs < len(self.messages))

    def _open(self) -> bool:
        """True if a branch is left that no run has taken."""
        return any(
            any(way not in taken for way in known)
            for known, taken in zip(self.known, self.taken, strict=True)
        )

    def _next(self, played: list[Scenario]) -> Scenario | None:
        # Aimed scenarios before random ones; those that only weigh conditions last.
        for aimed in (self.pending, self.later):
            while aimed:
                scenario = aimed.popleft()
                if scenario not in self.tried:
                    self.tried.add(scenario)
                    self.aimed.add(scenario)
                    return scenario
        for _ in range(MOST_IN_VAIN if self._open() else 0):
            scenario = self._drawn(self.random.choice(played))
            if scenario not in self.tried:
                self.tried.add(scenario)
                return scenario
        return None

    # --------------------------------------------------------------------------- one scenario

    def _both(self, scenario: Scenario) -> tuple[bool, Scenario]:
        """Run both programs; return whether they took a new branch, and the scenario with the
        needed answers.
        """
        one, ours = self._play(self.first, scenario, self.steps)
        if one.ended == OVER:
            if self.found.runs:
                self.late = True
                return False, ours.played
            self.found.unfinished = Stop(0, one, ours.played)
            one = replace(one, ended="steps")  # what it did by then is compared
        if one.ended == "error" and self.first.repeats:
            cycle, _ = self._play(replace(self.first, repeats=False), ours.played, self.steps)
            if cycle.ended != "error":  # nor does what was written stop where a later one does
                one = replace(one, ended="steps")
        if one.ended == "unknown":
            self._not_judged(Stop(0, one, ours.played))
            return False, ours.played
        two, theirs = self._play(self.second, ours.played, MORE_STEPS * self.steps, one)
        if two.ended == OVER:
            self.late = bool(self.found.runs)
            if one.ended == "steps" and self._as_much(one, two):
                two = replace(two, ended="steps")
        if two.ended == OVER or (two.ended == "unknown" and one.ended != "error"):
            self._not_judged(Stop(1, two, ours.played))
            return False, ours.played
        if two.ended == "error" and self.first.lenient and self.first.family == self.second.family:
            strict, _ = self._play(replace(self.first, lenient=False), ours.played, self.steps)
            if strict.ended == "error":  # what nothing was given stops both of them
                one = strict
        self._compare(one, two, ours, theirs)
        if one.ended in ("end", "steps") and len(one.log) < self.most:
            self.longest = max(self.longest, len(one.log))
            # Runs that end show how much a program without end may be expected to do.
            self.most = MORE_EVENTS + 2 * self.longest
        new = False
        for at, driver in enumerate((ours, theirs)):
            self.reads |= bool(driver.reads or driver.watched)
            new |= any(w in self.known[at] and w not in self.taken[at] for w in driver.taken)
            self.taken[at].update(dict.fromkeys(driver.taken))
        for at, driver in enumerate((ours, theirs)):
            self._follow(at, driver, ours.played)
        # A program that only ends in errors may want small numbers: try these first.
        if one.ended == "error" and self.found.failing == self.found.runs <= MOST_FOLLOWED:
            self.pending.extend(self._varied(ours.wiring, ours.recent, ours.played, [*SMALL]))
        silent = dict(self._silent(scenario, ours))
        self.silent |= silent
        self.kept.update(silent)
        self.pending.extend(silent)
        return new, ours.played

    def _silent(
        self, scenario: Scenario, driver: Driver
    ) -> Iterator[tuple[Scenario, tuple[object, Moment, int]]]:
        """Scenarios in which a wait that may end without an answer gets no answer, once for each
        position.

        A wait that is tried again gets no answer either, up to `MOST_SILENT` times. With each: the
        position, the moment, and how often it got no answer.
        """
        again, since, times = self.silent.get(scenario, (None, Moment(), 0))
        after = (
            when for when, state in driver.played.changes if when.order > since.order and state
        )
        answered = next(after, None)
        for place, moment in driver.ended.items():
            tried_again = place == again and moment == answered and times < MOST_SILENT
            if place not in self.ended or tried_again:
                self.ended.add(place)
                now = times + 1 if tried_again else 1
                yield driver.played.silent(moment), (place, moment, now)

    def _not_judged(self, stop: Stop) -> None:
        """Record a run that cannot be judged: it ends the search if nothing was compared yet; later
        ones only count as missed.
        """
        if self.found.runs > self.found.failing:
            self.found.unjudged = self.found.unjudged or stop
            self.missed += 1
        else:
            self.found.unknown = stop

    def _ample(self, one: Run) -> int:
        """Statements in which most written programs do what a run of the source has done.

        One that looks again and again where the source waits takes as many as that time holds, and
        looks for an input until the driver sees that it waits.
        """
        waits = POLLS * sum(isinstance(event, Awaited) for event in one.events)
        looks = math.ceil(LOOKS * one.seconds / STATEMENT_TIME)
        return MORE_STEPS * (max(one.steps, LEAST_STEPS) + waits) + looks

    def _as_much(self, one: Run, two: Run) -> bool:
        """True if a run that was cut off did all that the first one did."""
        runs = one, replace(two, ended="steps")
        done = [likeness(one, run, self.signals, self.rounding) for run in runs]
        return len({(like.visits, like.changes) for like in done}) == 1

    def _play(
        self, side: Side, scenario: Scenario, steps: int, after: Run | None = None
    ) -> tuple[Run, Driver]:
        """Run a program through a scenario. after: the run of the source, for the written program;
        None for the source.
        """
        run, driver = self._run_through(side, scenario, steps, after, STATEMENT_TIME)
        # Longer statements show if a timer or a counter ended a loop.
        if driver.ended_by_timer:
            slower, _ = self._run_through(
                side, driver.played, steps, after, SLOWER * STATEMENT_TIME
            )
            run = replace(run, log=tuple(_by_timers(run.log, slower.log)))
        return run, driver

    def _run_through(
        self, side: Side, scenario: Scenario, steps: int, after: Run | None, statement_time: float
    ) -> tuple[Run, Driver]:
        answered = after is None
        kernel = Kernel(Board(), most_steps=steps, statement_time=statement_time)
        answers = Answers(self.random, self.numbers) if answered and not self.script else None
        driver = Driver(kernel, side.wiring, scenario, answers)
        if self.script is not None:
            script, first = self.script, self.first.sources()
            if after is not None:
                script = by_numbers(script, after.log, first)
            follow(kernel, side.scripted(script), first)
        if side.answers:
            kernel.person.panel = Panel(lambda name: driver[name])
        kernel.peers = sent_words(self.found.runs, self.messages, self.texts)
        side.begin(kernel)
        left = self.until - time.thread_time()
        # The first run has to come to an end to be of any use. A later one of the written program
        # may be one without end, which is a difference: the end of the search does not cut it off.
        if not (self.found.runs and answered):
            left = first_run_seconds(self.budget.seconds, answered)
        ample = math.inf if after is None else self._ample(after)
        limit_run(kernel, left, after, self.most if answered else math.inf, ample)
        return kernel.run(), driver

    def _compare(self, one: Run, two: Run, ours: Driver, theirs: Driver) -> None:
        found, scenario = self.found, ours.played
        left = self.budget.differences - len(found.differences)
        like = likeness(one, two, self.signals, self.rounding, left, self.measured)
        if like.differences and any(isinstance(event, Kept) for event in one.events):
            measured = self.measured | self._measured(one, scenario)
            if measured != self.measured:
                self.measured = measured
                like = likeness(one, two, self.signals, self.rounding, left, measured)
        differences = list(like.differences)
        if not differences and two.ended == "steps" and one.ended == "end":
            if Stopped(end=True) not in one.events:
                differences.append(
                    Unlike(
                        0,
                        f"the first program ended, the second went on for {two.steps:,} statements",
                    )
                )
        if not differences and two.message == RAN_ON and not self._as_much(one, two):
            less = f"does less in {two.steps:,} statements"
            differences.append(Unlike(0, f"the first program continues, the second {less}"))
        if not differences:
            self._note_visits(one, two, scenario)
        found.runs += 1
        found.cut += one.ended == "steps"
        found.visits += like.visits
        found.changes += like.changes
        found.waits += like.waits
        found.values += like.values
        found.left |= like.left
        if ours.watched or theirs.watched:
            # Moments between those tried are not compared, and are listed as such.
            found.left |= {"stops for interrupts", "other moments of interrupts"}
        if ours.behind_input or theirs.behind_input:
            found.left |= {"waits for timers behind inputs"}
        found.apart, found.turned = max(found.apart, like.apart), max(found.turned, like.turned)
        if one.ended == "error":
            found.failing += 1
            found.failed = found.failed or Stop(0, one, scenario)
        if one.ended == "stopped" and not like.visits and not like.changes:
            found.idling += 1
            found.idle = found.idle or Stop(0, one, scenario)
        elif self.script is not None and one.ended == "stopped":
            found.stalled.append(Stop(0, one, scenario))
        elif ours.unanswered is not None:
            self.unanswered.setdefault(ours.unanswered, []).append(Stop(0, one, scenario))
        self.passed.update(place for place, _ in ours.met)
        # One finding for each pair of places: the same fault shows in many runs.
        for unlike in differences:
            if unlike.places not in self.differing:
                self.differing.add(unlike.places)
                behind = self._behind(0, one, ours, unlike), self._behind(1, two, theirs, unlike)
                found.differences.append(Difference(unlike, scenario, behind))

    def _note_visits(self, one: Run, two: Run, scenario: Scenario) -> None:
        ours, theirs = (
            [row for row in run.log if isinstance(row.what, Moved)] for run in (one, two)
        )
        # Of two runs of unlike length only the beginning that both have was compared.
        for own, row in zip(ours, theirs, strict=False):
            assert isinstance(row.what, Moved)
            moved = row.what
            key = moved.flange, moved.via, moved.joints, moved.how.configuration
            self.found.visited.setdefault(key, Visit(moved, own.place, scenario))

    def _measured(self, one: Run, scenario: Scenario) -> set[str]:
        """Shared data that the source gives other values where its statements take longer."""
        slower, _ = self._run_through(
            self.first, scenario, self.steps, None, SLOWER * STATEMENT_TIME
        )
        before, after = _kept_values(one), _kept_values(slower)
        # A run that was broken off sooner has fewer values: that makes them no other ones.
        return {
            name
            for name, values in before.items()
            if any(a != b for a, b in zip(values, after.get(name, ()), strict=False))
        }

    def _behind(self, at: int, run: Run, driver: Driver, unlike: Unlike) -> Branch | None:
        """The branch that a run took last before what it does otherwise."""
        row = (unlike.first, unlike.second)[at]
        told = len(run.log)
        if row is not None:
            # Only branches before the event can have led to it.
            told = next((n for n, one in enumerate(run.log) if one.time >= row.time), told)
        before = [count for count in driver.last if count <= told]
        return self.known[at].get(driver.last[max(before)]) if before else None

    # ------------------------------------------------------------------------- more scenarios

    def _follow(self, at: int, driver: Driver, played: Scenario) -> None:
        """Scenarios that may take the other ways of the statements that this one came by."""
        known, gone = self.known[at], self.taken[at]
        interrupted = [*self._interrupted(at, driver, played)]
        self.kept.update(interrupted)
        self.pending.extend(interrupted)
        for taken in driver.taken.values():
            others = [way for way in known if way[:2] == taken.way[:2] and way not in gone]
            # A statement that many runs come by would fill the queue with its variations.
            if others and taken.read and self.followed[taken.way[:2]] < MOST_FOLLOWED:
                self.followed[taken.way[:2]] += 1
                numbers = self._near(at, known[others[0]].line)
                self.pending.extend(self._varied(driver.wiring, taken.read, played, numbers))
        self.later.extend(self._weighed(at, driver, played))
        self.later.extend(self._early_exits(at, driver, played))

    def _weighed(self, at: int, driver: Driver, played: Scenario) -> Iterator[Scenario]:
        """Scenarios that tell each input of a condition apart, once for each statement.

        A wait whose condition holds as it begins lacks an input there, so that it has to wait.
        """
        read: dict[object, Readings] = {(at, place): n for place, n in driver.met.items()}
        read |= {(at, *one.way[:2]): one.own for one in driver.taken.values()}
        for place, names in read.items():
            if names and place not in self.weighed:
                self.weighed.add(place)
                yield from self._combined(driver.wiring, dict(names), played)

    def _early_exits(self, at: int, driver: Driver, played: Scenario) -> Iterator[Scenario]:
        """Scenarios that change the inputs of a condition at its second and later evaluations, once
        for each: a loop ends early, and its counter stays below its limit.
        """
        for place, iterations in driver.iterations.items():
            for number, names in enumerate(iterations[1:], 1):
                if (at, place, number) not in self.left_early:
                    self.left_early.add((at, place, number))
                    for one in names:
                        yield from self._changed(driver.wiring, *one, played, self.numbers)

    def _changed(
        self, wiring: Wiring, name: str, moment: Moment, played: Scenario, numbers: list[int]
    ) -> Iterator[Scenario]:
        """The scenario up to a moment, with each other value of an input from then on."""
        before = played.until(moment)
        value = wiring.value(name, dict(_driver_state(before)))
        for other in self._others(wiring, name, value, numbers):
            yield before.changed(moment, wiring.spread(name, other))

    def _combined(
        self, wiring: Wiring, names: Mapping[str, Moment], played: Scenario
    ) -> Iterator[Scenario]:
        """Every combination of a few inputs where they are read; of more, each one changed."""
        # Inputs change from the last reading on; earlier values stay as they were.
        moment = max(names.values(), key=lambda one: one.order)
        before = played.until(moment)
        state = dict(_driver_state(before))
        values = {name: wiring.value(name, state) for name in names}
        others = {
            name: [value, *self._others(wiring, name, value, self.numbers)]
            for name, value in values.items()
        }
        made: Iterable[tuple[float, ...]] = product(*others.values())
        if len(names) > COMBINED:
            made = (
                tuple(other if n == name else v for n, v in values.items())
                for name in names
                for other in others[name][1:]
            )
        for combined in made:
            bits: dict[str, float] = {}
            for name, value in zip(names, combined, strict=True):
                bits |= wiring.spread(name, value)
            yield before.changed(moment, bits)

    def _interrupted(self, at: int, driver: Driver, played: Scenario) -> Iterator[Scenario]:
        """Scenarios in which an input that interrupts changes where it is watched, once for each
        program: at the first and at the last moments of that.
        """
        for name, moments in driver.watched.items():
            if (at, name) in self.watched:
                continue
            self.watched.add((at, name))
            most = MOST_FOLLOWED
            tried = [*dict.fromkeys([*[*moments][:most], *[*moments][-most:]])]
            for moment in tried:
                yield from self._changed(driver.wiring, name, moment, played, [1])
            if driver.wiring.bits(name) == 1:
                self.later.extend(_comes_and_goes(driver.wiring, name, tried, played))

    def _near(self, at: int, line: int) -> list[int]:
        """Numbers that a statement compares with: of its line, else of those below it."""
        lines = (self.first, self.second)[at].text().split("\n")
        below = "\n".join(lines[line : line + BELOW])
        return (_number_values(lines[line - 1]) if line <= len(lines) else []) or _number_values(
            below
        )

    def _varied(
        self, wiring: Wiring, read: Readings, played: Scenario, numbers: list[int]
    ) -> Iterator[Scenario]:
        """The scenario up to what a branch hangs on, with another value of each of its inputs."""
        # reversed(): of several readings of an input the latest moment stays.
        names = dict(reversed(read))
        for name, moment in names.items():
            yield from self._changed(wiring, name, moment, played, numbers)
        if len(names) > 1:
            for _ in range(TOGETHER):
                yield self._together(wiring, names, played, numbers)
        for wires, moment in answer_rows(wiring, names):
            for number in self._some(numbers, len(wires)):
                bits = {wire: float(number >> i & 1) for i, wire in enumerate(wires)}
                yield played.until(moment).changed(moment, bits)

    def _together(
        self, wiring: Wiring, names: Mapping[str, Moment], played: Scenario, numbers: list[int]
    ) -> Scenario:
        """Any value for each of some inputs where it is read, as far as the run is the same."""
        made = played.until(max(names.values(), key=lambda moment: moment.order))
        for name, moment in names.items():
            bits = wiring.bits(name)
            made = made.changed(
                moment, wiring.spread(name, float(self.random.choice(self._some(numbers, bits))))
            )
        return made

    def _others(self, wiring: Wiring, name: str, value: float, numbers: list[int]) -> list[float]:
        bits = wiring.bits(name)
        if bits == 1:
            return [1.0 - value]
        return [float(number) for number in self._some(numbers, bits) if number != value]

    def _some(self, numbers: list[int], bits: int) -> list[int]:
        """Numbers of so many bits: those of the text, one more or less, none at all, and any."""
        most = 1 << bits
        # Boundaries of comparisons lie at the numbers of the text and beside them.
        near = {n + by for n in numbers for by in (-1, 0, 1) if 0 <= n + by < most}
        plain = 1 << min(bits, PLAIN_ANSWERS)
        near |= {0, plain - 1, self.random.randrange(plain)}
        listed = sorted(near)
        return self.random.sample(listed, min(TRIED_VALUES, len(listed)))

    def _drawn(self, played: Scenario) -> Scenario:
        """A scenario that was played, with inputs of some moment at random."""
        wiring = self.first.wiring
        moments = [when for when, _ in played.changes] or [Moment()]
        moment = self.random.choice([Moment(), *moments, Moment(self.random.randrange(12))])
        names = [n for n in wiring.named if self.random.random() < 0.5]
        state: dict[str, float] = {}
        for name in names:
            bits = wiring.bits(name)
            state |= wiring.spread(name, float(self.random.choice(self._some(self.numbers, bits))))
        return played.until(moment).changed(moment, state)


def _by_timers(log: Sequence[Logged], slower: Sequence[Logged]) -> Iterator[Logged]:
    """Drop the timed waits whose length grows with the time of a statement: a counter ended them,
    not a timer.
    """
    others: dict[Place | None, deque[float]] = defaultdict(deque)
    for row in slower:
        if isinstance(row.what, Waited) and row.what.limit:
            others[row.place].append(row.what.seconds)
    for row in log:
        if isinstance(row.what, Waited) and row.what.limit:
            seconds = others[row.place].popleft() if others[row.place] else 0.0
            # Halfway between no growth and full growth, whatever waits lie in between.
            if seconds > (1.0 + SLOWER) / 2.0 * row.what.seconds:
                continue
        yield row


def _comes_and_goes(
    wiring: Wiring, name: str, moments: Sequence[Moment], played: Scenario
) -> Iterator[Scenario]:
    """Scenarios in which an input of one bit changes at three moments, one after the other."""
    for start in range(max(len(moments) - 2, 1)):
        three = moments[start : start + 3]
        made = played.until(three[0])
        value = wiring.value(name, dict(_driver_state(made)))
        for moment in three:
            value = 1.0 - value
            made = made.changed(moment, wiring.spread(name, value))
        yield made


def _kept_values(run: Run) -> Mapping[str, list[float | str]]:
    """The values that shared data had one after the other, by its name."""
    found: dict[str, list[float | str]] = defaultdict(list)
    for event in run.events:
        if isinstance(event, Kept):
            found[event.name].append(event.value)
    return found


def _driver_state(scenario: Scenario) -> Iterator[tuple[str, float]]:
    """Values of the wires at the end of a scenario."""
    for _, state in scenario.changes:
        yield from state


def _number_values(text: str) -> list[int]:
    """Whole numbers of a text, each once."""
    return sorted({int(digits) for digits in re.findall(r"\b\d{1,5}\b", text)})
