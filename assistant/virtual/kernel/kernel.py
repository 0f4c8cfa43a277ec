"""The kernel: tasks that take turns on one simulated clock, its timers, signals, motion and log.

Time is in seconds from the start; `date_at` gives the date and time of day that the clock shows.
`Signals` are inputs that the world sets or outputs that programs set; a `Board` holds both.
`Motion` is what follows the motions that programs command; `Instant` makes them without any time.
"""

from __future__ import annotations

import heapq
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from datetime import datetime, timedelta
from itertools import count
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol

from greenlet import getcurrent

from assistant.base.budgets import RUNNING, within
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose
from assistant.virtual.events import Called, Event, Kept, Logged, Moved, Place, Run, Switched
from assistant.virtual.kernel.script import Person
from assistant.virtual.kernel.task import Body, Broken, Ending, Task

if TYPE_CHECKING:
    from assistant.virtual.kernel.kernel_thread import Live


@dataclass(slots=True, order=True)
class Timer:
    """An action at a time; it is left out if it is cancelled by then."""

    time: float
    # Timers of the same time fire in the order in which they were set.
    number: int
    action: Callable[[], None] = field(compare=False)
    cancelled: bool = field(default=False, compare=False)


class _Timers:
    """Timers in order of their times. due: the time of the first one, infinite if there are no
    timers.
    """

    def __init__(self) -> None:
        self.due = math.inf
        self._heap: list[Timer] = []
        self._numbers = count()

    def add(self, moment: float, action: Callable[[], None]) -> Timer:
        timer = Timer(moment, next(self._numbers), action)
        heapq.heappush(self._heap, timer)
        self.due = self._heap[0].time
        return timer

    def fire(self, clock: float) -> None:
        """Has those act whose time has come."""
        while self._heap and self._heap[0].time <= clock:
            timer = heapq.heappop(self._heap)
            # A cancelled timer stays in the heap: removing it there would cost a search.
            if not timer.cancelled:
                timer.action()
        self.due = self._heap[0].time if self._heap else math.inf


Source = Mapping[str, float] | Callable[[str], float]
"""Values of the signals that nothing has set, by name in lower case. A table leaves out 0."""
Listener = Callable[[str, float, float], None]
"""Function that gets a signal's name, and its value before and now."""


@dataclass(slots=True, eq=False)
class Signals:
    """Signals of one direction by their name in lower case, or their number as text.

    source: what those read that nothing has set. watched: those that interrupts listen to.
    """

    source: Source = field(default_factory=dict)
    values: dict[str, float] = field(default_factory=dict)
    listeners: list[Listener] = field(default_factory=list)
    watched: list[str] = field(default_factory=list)

    def read(self, name: str) -> float:
        if name in self.values:
            return self.values[name]
        source = self.source
        return float(source(name) if callable(source) else source.get(name, 0.0))

    def set(self, name: str, value: float) -> None:
        """Set a signal; calls the listeners if its value changes."""
        before = self.read(name)
        self.values[name] = value
        if before != value:
            # A copy: a listener may end itself.
            for listener in tuple(self.listeners):
                listener(name, before, value)


@dataclass(slots=True, eq=False)
class Board:
    """inputs: set from outside, by a script or by what is connected. outputs: set by programs."""

    inputs: Signals = field(default_factory=Signals)
    outputs: Signals = field(default_factory=Signals)


class Progress(NamedTuple):
    """Progress of a motion: mm that are left, the percent that is done, and mm/s of the tool."""

    left: float = 0.0
    done: float = 100.0
    speed: float = 0.0


Standing = tuple[Pose, tuple[float, ...]]
"""The flange in the base, and the joints J1, J2, … in degrees."""


class Motion(Protocol):
    """The arm of a controller.

    A motion that takes time may let a program run ahead as long as nobody asks for the time: the
    times of what is logged meanwhile are put right by `catch_up`. behind: whether they are to be.
    """

    @property
    def behind(self) -> bool: ...

    def go(self, task: Task, moved: Moved, changes: Sequence[Switched] = ()) -> None:
        """Commands a motion, and waits as the controller does before the next statement.

        changes: outputs that are set on its way.
        """

    def settle(self, task: Task) -> None:
        """Waits until the arm stands at its latest target, whatever corner the motion states."""

    def stands(self) -> bool:
        """True if the arm is at the end of its latest motion."""

    def where(self) -> Standing | None:
        """Return the arm's present position; None if it only follows from the motions, which take
        no time.
        """

    def progress(self) -> Progress | None:
        """Return the progress of the current or last motion; None if motions take no time."""

    def catch_up(self, kernel: Kernel) -> None:
        """Somebody asks for the time: it is as late as the program is."""

    def rest(self) -> float:
        """The time from which on the arm stands, if nothing more is commanded."""

    def store(self, kernel: Kernel) -> None:
        """Stops the arm, and keeps what it was to do until `restore`; other motions may come."""

    def restore(self, task: Task) -> None:
        """Restore the stored motions; the arm stays where it is until `resume`."""

    def cut(self, task: Task) -> Standing | None:
        """Ends all motions where the arm is, and tells where that is."""

    def lead(self, kernel: Kernel, joints: Sequence[float]) -> None:
        """The arm, which stood, is at these joints in degrees, where no motion led it."""

    def hold(self, kernel: Kernel) -> None:
        """Stops the arm on its way."""

    def resume(self, kernel: Kernel) -> None:
        """Lets the arm go on."""

    def forget(self) -> None:
        """Nobody will ask for what is over."""


class Instant:
    """Motions take no time: the arm is where it is sent."""

    behind = False

    def go(self, task: Task, moved: Moved, changes: Sequence[Switched] = ()) -> None:
        task.tell(moved)
        for change in changes:
            task.kernel.change(task, change)

    def settle(self, task: Task) -> None:
        """The latest motion was one that ends at its target."""
        task.kernel.stop_latest()

    def stands(self) -> bool:
        return True

    def where(self) -> None:
        return None

    def progress(self) -> None:
        return None

    def catch_up(self, kernel: Kernel) -> None:
        """There is nothing behind."""

    def rest(self) -> float:
        return -math.inf

    def store(self, kernel: Kernel) -> None:
        """Nothing is left to do."""

    def restore(self, task: Task) -> None:
        """Nothing was left to do."""

    def cut(self, task: Task) -> None:
        """The latest motion has come to its end."""

    def lead(self, kernel: Kernel, joints: Sequence[float]) -> None:
        """Who leads it knows."""

    def hold(self, kernel: Kernel) -> None:
        """The arm stands."""

    def resume(self, kernel: Kernel) -> None:
        """The arm stands."""

    def forget(self) -> None:
        """There is nothing to forget."""


MOST_STEPS: Final = 100_000
_BUSY: Final = 1000
"""Statements that take no time before one takes `busy_time`."""
NEVER: Final = "a wait for what never comes"
_SLICE: Final = 0.002
"""Seconds of real time after which a task that waits for the outside looks again."""


class _OutOfSteps(Exception):
    """More happened than the run may take."""


@dataclass(eq=False)
class Kernel:
    """Runs tasks on one simulated clock. most_steps: statements of all tasks. most_time: simulated
    seconds.

    statement_time: seconds that a statement takes. busy_time: seconds of each statement after many
    that took none, so that a program that polls an input comes to see it. pace: simulated seconds
    for each real one, None for as fast as possible. watch: is called before each statement, to
    trace it or to hold the run. limit: is called at each statement, and at each check of a wait;
    returns how the run ends, or None. branch: is called for each branch that a statement takes: its
    file, its position there, and which branch, counted from 0. stuck: is called where a task waits,
    before its time is over or the run ends; True if it has caused the awaited change. told: are
    called with each event. met: is called for each wait that its condition ends, with that
    condition. kept: returns the values of shared data by name, which are reported before the next
    event. timed: is called when a program sets a timer, which begins a separate wait. looked: is
    called at each check of a wait for a timer, with the start of the wait and whether it is over.
    clock: simulated seconds, but earlier than `now` while a program runs ahead of its arm. person:
    answers questions of programs. peers: texts that the other end of each line sends in a run
    without outside connections; None if lines lead to real ends. shared: whether several tasks run.
    reacts: whether a script reacts to motions, so that no program runs ahead of its arm. live:
    owner of a run that continues when all tasks have ended.
    """

    board: Board = field(default_factory=Board)
    motion: Motion = field(default_factory=Instant)
    most_steps: int = MOST_STEPS
    most_time: float = math.inf
    statement_time: float = 0.0
    busy_time: float = 0.0
    pace: float | None = None
    watch: Callable[[Task], None] | None = None
    limit: Callable[[], Ending | None] | None = None
    branch: Callable[[str, int, int], None] | None = None
    stuck: Callable[[Task], bool] | None = None
    told: list[Callable[[Logged], None]] = field(default_factory=list)
    timed: Callable[[], None] | None = None
    looked: Callable[[Task, float, bool], None] | None = None
    met: Callable[[Task, Callable[[], bool]], None] | None = None
    kept: Callable[[], Mapping[str, float | str]] | None = None
    clock: float = 0.0
    steps: int = 0
    person: Person = field(default_factory=Person)
    peers: tuple[str, ...] | None = None
    shared: bool = False
    reacts: bool = False
    live: Live | None = None
    tasks: list[Task] = field(default_factory=list)
    log: list[Logged] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.hub = getcurrent()
        self.ending: Ending | None = None
        self.stirred = False
        """True if a task has begun to wait, or an interrupt has run, since the round began."""
        self.clocked = 0
        """Statements that had run when the time was last read."""
        self.attached = 0
        """Number of things outside the run that may act on it at any time."""
        self.looking = False
        """True while values are read for an interrupt, which checks whenever anything runs."""
        self.ended_in: tuple[str, Place | None] = "", None
        self.leaving: list[Callable[[], None]] = []
        """Functions to call when the run is over."""
        self._held: dict[str, float | str] = {}
        self._timers = _Timers()
        self._handed = 0
        self._handing = False
        self._began: float | None = None
        self._idle, self._moved = 0, 0.0
        self._since: tuple[float, float] | None = None

    # ----------------------------------------------------------------------------- tasks

    def task(self, name: str, body: Body, lines: int = 1, essential: bool = True) -> Task:
        """A program that runs beside those that there are; it begins at its next turn."""
        # The new task begins now, not when the program that runs ahead thinks it does.
        self.catch_up()
        made = Task(self, name, body, lines, essential)
        self.tasks.append(made)
        self._share()
        return made

    def _share(self) -> None:
        """One that goes on only as long as others do has to let the kernel see that they ended,
        and one of a kernel that lives on has to let commands through.
        """
        alone = len(self.tasks) < 2 and all(task.essential for task in self.tasks)
        self.shared = self.live is not None or not alone

    def drop(self, task: Task) -> None:
        """Ends a task where it is, on behalf of another one."""
        # The coroutine dies into its parent: into the caller, not into the kernel's loop.
        task.coroutine.parent = getcurrent()
        task.kill()
        task.ended = task.ended or Ending()
        self.tasks.remove(task)
        self._share()

    def end(self, ending: Ending, task: Task | None = None) -> None:
        """Ends the run: all tasks stop where they are. task: the one that it ends in."""
        if self.ending is None:
            self.ending = ending
            if task is not None:
                self.ended_in = task.name, ending.place or task.where()

    def halt(self, task: Task, ending: Ending) -> None:
        """Ends the run out of a task, between two statements; it does not come back."""
        self.end(ending, task)
        # The task never gets another turn, so that no statement follows.
        self.hub.switch()

    def run(self) -> Run:
        """Runs the tasks until every essential one has ended, or one has gone wrong.

        Raises Refused where that takes more than the budget of its statements; what lives on for
        servers has none.
        """
        if self.live is not None:
            return self._run()
        with within(RUNNING, None, self.most_steps):
            return self._run()

    def _run(self) -> Run:
        self.hub = getcurrent()
        try:
            while self.ending is None:
                self._turns()
            if self.kept is not None and self.ending.ended == "end":
                self._keep(self.ended_in[0], self.kept())
        except _OutOfSteps:
            self.end(self._too_many())
        finally:
            for task in self.tasks:
                task.kill()
            self.catch_up()
            for leave in self.leaving:
                leave()
        ending, (name, place) = self.ending or Ending(), self.ended_in
        events = tuple(row.what for row in self.log)
        log, notes = tuple(self.log), tuple(self.notes)
        done = Run(events, ending.ended, ending.message, log, name, place, self.clock, self.steps)
        return replace(done, notes=notes)

    def _too_many(self) -> Ending:
        return Ending("steps", f"more than {self.most_steps} statements")

    def _turns(self) -> None:
        """A turn of each task that can go on; time passes if none can."""
        if self.live is not None:
            self.live.attend()
            if self.ending is not None:
                return
        before = self.steps
        went = self.stirred = False
        for task in tuple(self.tasks):
            if task.ended is not None:
                continue
            # The task returns to the greenlet that runs the
            # kernel, whichever dropped or woke it before.
            task.coroutine.parent = self.hub
            task.coroutine.switch()
            if task.ended is not None:
                self._ended(task)
            went |= not task.waiting
            if self.ending is not None:
                return
        # Before the clock is allowed to advance: real time has to come up first.
        self._keep_pace_with_outside()
        if self.live is not None:
            if not went and not self.stirred and before == self.steps and self.ending is None:
                self._advance()
        # Only others are left: the run ends as soon as the arm stands.
        elif not any(task.essential for task in self.tasks):
            rest = self.motion.rest()
            if rest <= self.clock:
                self.end(Ending())
            elif not went and not self.stirred and not self._advance(rest):
                self.end(Ending("stopped", "the arm is held on its way"))
        # No task ran a statement, began to wait or was interrupted: only time can help now.
        elif not went and not self.stirred and before == self.steps:
            if not self._helped() and not self._advance():
                self._stuck()

    def _ended(self, task: Task) -> None:
        self.tasks.remove(task)
        self._share()
        if self.live is not None and task.ended is not None:
            self.live.ended(task, task.ended)
            return
        if not any(other.essential for other in self.tasks):
            for other in self.tasks:  # What it did last may be what another one waited for.
                other.prompt()
        if task.ended is not None and task.ended.ended != "end":
            self.end(task.ended, task)

    def _helped(self) -> bool:
        """True if `stuck` causes the change that a task with a limited wait needs."""
        if self.stuck is None:
            return False
        waiting = [task for task in self.tasks if task.waiting and task.wakes < math.inf]
        return any(self.stuck(task) for task in waiting if task.until is not None)

    def _stuck(self) -> None:
        """Nothing that could still happen ends the wait of any task."""
        waiting = next(task for task in self.tasks if task.essential)
        if self.stuck is not None and self.stuck(waiting):
            return
        what = waiting.waits_for or NEVER
        self.end(Ending("stopped", what), waiting)

    # ------------------------------------------------------------------------------ time

    @property
    def now(self) -> float:
        """Simulated seconds, including those of the arm's commanded motions."""
        self.clocked = self.steps
        # Asking for the time ends the lead of a program over its arm.
        if self.motion.behind:
            self.catch_up()
        return self.clock

    def catch_up(self) -> None:
        """A program that runs ahead of its arm is in time again."""
        self.motion.catch_up(self)
        self._hand_on()

    @property
    def alone(self) -> bool:
        """True if nothing but the single running program can see or make a change."""
        board = self.board
        return not (
            self.shared
            or self.reacts
            or self._timers.due < math.inf
            or self.pace is not None
            or self._since is not None
            or self.live is not None
            or board.inputs.listeners
            or board.outputs.listeners
            or any(task.looks is not None for task in self.tasks)
        )

    def fail(self, task: Task, place: Place | None, ending: Ending) -> None:
        """End the run for an error that came before anything else; no task continues.

        In a live run it ends the task alone, and raises Broken.
        """
        if self.live is not None:
            # In a live run the arm's fault may come from
            # another task's turn than the one it belongs to.
            if task.coroutine is not getcurrent() and task in self.tasks:
                task.kill()
                task.ended = ending
                self._ended(task)
            raise Broken(replace(ending, place=place))
        self.ending, self.ended_in = ending, (task.name, place)
        if getcurrent() is not self.hub:
            self.hub.switch()

    def at(self, moment: float, action: Callable[[], None]) -> Timer:
        """Has an action run at a simulated time, between two statements."""
        self.catch_up()
        return self._timers.add(moment, action)

    def spend(self) -> None:
        """Something happens that a run must not do for ever; raises OutOfSteps."""
        self.steps += 1
        if self.steps > self.most_steps:
            raise _OutOfSteps
        if self.limit is not None and (ending := self.limit()) is not None:
            self.end(ending)
            raise _OutOfSteps

    def count(self, task: Task) -> None:
        """A statement of a task is about to run; it does not if there were too many."""
        if self.steps >= self.most_steps:
            self.halt(task, self._too_many())
        self.steps += 1
        self.clock += self.statement_time
        if self.busy_time:
            self._pass_while_busy()
        if self.pace is not None:
            self._pass_to(self.clock)
        if self.clock >= self._timers.due:
            self._timers.fire(self.clock)
            if self.ending is not None:  # a timer may have ended the run
                self.hub.switch()
        if self.clock > self.most_time:
            self.halt(task, Ending("time", f"more than {self.most_time:g} s"))
        if self.limit is not None and (ending := self.limit()) is not None:
            self.halt(task, ending)
        if self.watch is not None:
            self.watch(task)

    def _pass_while_busy(self) -> None:
        """Another statement runs: time passes if it did not for many of them."""
        # Time passed by itself: the program is not polling without end.
        if self.clock != self._moved or self.motion.behind:
            self._idle = 0
        elif self._idle < _BUSY:
            self._idle += 1
        else:
            self.clock += self.busy_time
        self._moved = self.clock

    def _advance(self, latest: float = math.inf) -> bool:
        """Lets time pass until something happens; False if nothing ever will."""
        self.catch_up()
        wakes = [task.wakes for task in self.tasks if task.waiting]
        following = min([self._timers.due, latest, *wakes])
        if self._since is not None:
            real, then = self._since
            # Not later than real time: what comes from outside must not find the clock ahead of it.
            passed = max(self.clock + _SLICE, then + time.monotonic() - real)
            following = min(following, passed)
        if self.live is not None and self._looks_outside():
            following = min(following, max(self.clock + _SLICE, self.live.now()))
        if math.isinf(following) and self.live is None:
            return False
        if following > self.most_time:
            waiting = next((task for task in self.tasks if task.essential), None)
            what = waiting.waits_for if waiting is not None and waiting.waits_for else ""
            told = f"more than {self.most_time:g} s" + (f", in a wait for {what}" if what else "")
            self.end(Ending("time", told), waiting)
            return True
        self._pass_to(max(self.clock, following))
        self._timers.fire(self.clock)
        return True

    def _pass_to(self, moment: float) -> None:
        if self.live is not None:
            self.clock = self.live.reach(self.clock, moment)
            return
        if self.pace is not None:
            began = self._began = (
                time.monotonic() - self.clock / self.pace if (self._began is None) else self._began
            )
            time.sleep(max(0.0, began + moment / self.pace - time.monotonic()))
        self.clock = moment
        self._hold()

    def pace_anew(self) -> None:
        """Real time counts from here on, for a run in step with it that was held."""
        self._began = None
        if self._since is not None:
            self._since = time.monotonic(), self.clock

    def _keep_pace_with_outside(self) -> None:
        """While a task waits for the outside, or something there may act on the run, simulated time
        is never ahead of real time.
        """
        if self.live is not None:
            self.live.hold(self.clock)
        elif not self._looks_outside():
            self._since = None
        elif self._since is None:
            self._since = time.monotonic(), self.clock
        self._hold()

    def _looks_outside(self) -> bool:
        return self.attached > 0 or any(task.outside for task in self.tasks)

    def _hold(self) -> None:
        if self._since is not None:
            real, then = self._since
            time.sleep(max(0.0, real + self.clock - then - time.monotonic()))

    # ------------------------------------------------------------------------------- log

    def tell(self, task: Task, event: Event, place: Place | None = None) -> None:
        """place: of the statement; None for the one at hand."""
        if self.kept is not None:
            self._keep(task.name, self.kept(), place or task.where())
        row = Logged(self.clock, task.name, place or task.where(), event)
        self.log.append(row)
        if self.told and not self.motion.behind:
            self._hand_on()

    def _keep(self, task: str, held: Mapping[str, float | str], place: Place | None = None) -> None:
        """Tell what shared data has changed, and all of it at first."""
        for name, value in sorted(held.items()):
            if self._held.get(name) != value:
                self._held[name] = value
                self.log.append(Logged(self.clock, task, place, Kept(name, value)))

    def change(self, task: Task, what: Switched, place: Place | None = None) -> None:
        """Perform an action on the path of a motion: set an output, or raise an interrupt."""
        if isinstance(what, Called):
            what.act()
        else:
            self.tell(task, what, place)
            self.board.outputs.set(what.signal, what.value)

    def _hand_on(self) -> None:
        """Report the events whose times are known by now."""
        if not self.told or self._handing:
            return
        self._handing = True  # what a listener does may end here again: rows are told in order
        try:
            while self._handed < len(self.log):
                self._handed += 1
                row = self.log[self._handed - 1]
                for hear in self.told:
                    hear(row)
        finally:
            self._handing = False

    def forget(self) -> None:
        """Forget past events, while the arm is at rest; the listeners have received them."""
        self._hand_on()
        self.log.clear()
        self._handed = 0
        self.motion.forget()

    def note(self, what: str) -> None:
        """Says of what a program asks for that it is taken without any effect; once for a run."""
        if what not in self.notes:
            self.notes.append(what)

    def latest_motion(self) -> Moved | None:
        """Return the motion that was commanded last."""
        rows = (row.what for row in reversed(self.log))
        return next((what for what in rows if isinstance(what, Moved)), None)

    def stop_latest(self) -> None:
        """The latest motion ends at its target, whatever corner it states."""
        for row in reversed(self.log):
            if isinstance(row.what, Moved):
                row.what = replace(row.what, blend=0.0)
                return


CLOCK_START: Final = datetime(2026, 1, 1)
"""A time of no place, so that a run always tells the same."""


def date_at(seconds: float, began: datetime = CLOCK_START) -> datetime:
    """The moment when a simulated clock that started at `began` shows so many seconds."""
    return began + timedelta(seconds=seconds)
