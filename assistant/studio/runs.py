"""A run of a program while a window is open: started, held, stepped, asked and ended.

The run is in a thread; commands from the window are carried out between two statements. The window
is sent signals, calls and data of the run, at most once every `_REPORT_PERIOD` seconds.
"""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import field
from typing import TYPE_CHECKING, Any, Final, Literal, TypeVar

import numpy as np

from assistant.base.budgets import Reached, internal_error
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.compiler.simulated_run import unknown_visits
from assistant.studio import rules
from assistant.studio.route_answers import finding_records, plain_value
from assistant.studio.studio import Notify
from assistant.virtual.debugging.break_points import (
    Holding,
    Step,
    Stride,
    moved_to_statements,
    statement_lines,
)
from assistant.virtual.events import Logged, Place, Run, Stopped
from assistant.virtual.kernel import Board, Ending, Kernel, Signals, Task
from assistant.virtual.kernel.script import InputChange, Script, follow
from assistant.virtual.program_run import Settings, prepared
from assistant.virtual.run_log import (
    NOTED,
    end_finding,
    event_words,
    json_record,
    log_rows,
    summary,
)
from assistant.virtual.tasks import Programs

if TYPE_CHECKING:
    from assistant.robots import Robot


_MOST_VALUES: Final = 200
"""Data, or signals, that are shown at once."""
_WIDEST_VALUE: Final = 200
"""Characters of a value that are shown."""


class WatchedInputs(dict[str, float]):
    """Inputs that the user has not set, as `Settings` has them. read: those that a program read."""

    def __init__(self, known: dict[str, float]) -> None:
        super().__init__(known)
        self.read: dict[str, None] = dict.fromkeys(known)

    def get(self, name: str, other: Any = 0.0) -> Any:
        self.read[name] = None
        return super().get(name, other)


def _signal_records(board: Board) -> dict[str, Any]:
    """Inputs that were set or looked at, and outputs that were set, with what they are."""
    return {"inputs": _signal_rows(board.inputs), "outputs": _signal_rows(board.outputs)}


def _signal_rows(signals: Signals) -> list[dict[str, Any]]:
    source = signals.source
    looked_at = source.read if isinstance(source, WatchedInputs) else ()
    names = sorted({*signals.values, *looked_at}, key=_number_order)[:_MOST_VALUES]
    return [{"name": name, "value": plain_value(signals.read(name))} for name in names]


def _number_order(name: str) -> tuple[int, str]:
    return (int(name), "") if name.isascii() and name.isdecimal() else (-1, name)


def _data_records(task: Task) -> dict[str, Any]:
    """The calls that run, the innermost first, and the data that it knows."""
    levels = task.levels()
    stack = [
        {
            "name": level.name,
            "path": level.place and level.place[0],
            "line": level.place and level.place[1],
        }
        for level in levels[:_MOST_VALUES]
    ]
    groups = levels[0].groups if levels else {}
    data = [
        {
            "title": title,
            "rows": [
                {"name": one.name, "type": one.type, "value": one.value[:_WIDEST_VALUE]}
                for one in shown()[:_MOST_VALUES]
            ],
        }
        for title, shown in groups.items()
    ]
    return {"stack": stack, "data": data}


_RunState = Literal["running", "held", "waits", "asks", "ended"]
"""`waits`: for what never comes unless somebody switches it. `asks`: a person for an answer."""
_COMMAND_TIMEOUT: Final = 5.0
"""Seconds that a command waits for its turn; a turn takes as long as a motion's planning."""
_REPORT_PERIOD: Final = 0.2
"""Seconds between two reports of a run that goes on."""
_LOCKSTEP_PERIOD: Final = 0.05
"""Seconds between two checks for requests, for a run in step with real time."""
_STEP_WAIT: Final = 0.3
"""Seconds in which a step is waited for, so that the answer tells where it led."""
_END_TIMEOUT: Final = 2.0
"""Seconds in which a run that is ended is waited for."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class RunRequest:
    """Request for a run. real_time: as fast as the arm would be, else as fast as possible.

    path: of the requested file. at_once: it is held before its first statement.
    """

    programs: Programs
    robot: Robot | None = None
    script: Script = field(default_factory=Script)
    entry: str | None = None
    path: str = ""
    real_time: bool = False
    at_once: bool = False


class StudioRun:
    """One run. points: lines with a break point by file. tell: receives its state."""

    def __init__(self, wanted: RunRequest, points: Mapping[str, list[int]], tell: Notify) -> None:
        self.wanted, self._told = wanted, tell
        self.holding = Holding(pause="entry" if wanted.at_once else None)
        self._lines = statement_lines(wanted.programs)
        for path, lines in points.items():
            self.set_points(path, lines)
        self.sources = wanted.programs.sources()
        self.given: list[InputChange] = []
        self.log: list[dict[str, Any]] = []
        self.findings: list[Diagnostic] = []
        self.run: Run | None = None
        self.state: _RunState = "running"
        self.over = False
        self._reason = self._question = self._waits = ""
        self._answer: str | None = None
        self._held: Task | None = None
        self._looked = 0
        self._reported = 0.0
        self._stands = threading.Event()
        self._commands: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._ready: Future[None] = Future()
        self._snapshot: dict[str, Any] = {}
        self._thread = threading.Thread(target=self._work, name="run", daemon=True)

    # ----------------------------------------------------------------- for other threads

    def set_points(self, path: str, lines: Sequence[int]) -> list[int]:
        """The break points of a file, each at the next statement; where they are."""
        found = moved_to_statements(self._lines, path, lines)
        self.holding.set_points(path, found)
        return found

    def start(self) -> None:
        """Lets it run, and waits a little for where it stands; raises Refused for what cannot."""
        self._thread.start()
        self._ready.result()
        self._stands.wait(_STEP_WAIT)

    def end(self) -> None:
        """Ends it before its next statement, wherever it is."""
        self.over = True
        self._commands.put(lambda: None)
        if self._thread.is_alive() and threading.current_thread() is not self._thread:
            self._thread.join(_END_TIMEOUT)

    def now(self) -> Mapping[str, Any]:
        """Last reported state of the run."""
        return self._snapshot

    def ask(self, does: Callable[[Kernel], T]) -> T:
        """Return the result of a command that runs between two statements; raise its exceptions.

        Raises Refused if the run does not get to it in time.
        """
        future: Future[T] = Future()

        def act() -> None:
            try:
                future.set_result(does(self.kernel))
            except Exception as wrong:  # noqa: BLE001 (it is the caller's, who gets it)
                future.set_exception(wrong)

        if not self._thread.is_alive():
            return does(self.kernel)
        self._commands.put(act)
        try:
            return future.result(_COMMAND_TIMEOUT)
        except TimeoutError:
            if not self._thread.is_alive() and not future.done():
                return does(self.kernel)
            raise Refused(rules.RUN_BUSY(seconds=_COMMAND_TIMEOUT)) from None

    def pause(self) -> None:
        if self.state in ("running", "waits"):
            self.holding.pause = "pause"

    def go_on(self, stride: Stride | None = None) -> None:
        """To whatever holds it next, or a step, and waits a little for that.

        Raises Refused if it is not held.
        """

        def go(_: Kernel) -> None:
            task = self._held
            if task is None:
                raise Refused(rules.RUN_NOT_HELD())
            step = None if stride is None else Step(task, stride, len(task.levels()))
            self.holding.go(step)
            self._held = None
            self._stands.clear()

        self.ask(go)
        self._stands.wait(_STEP_WAIT)

    def answer(self, text: str) -> None:
        """Answer the question of the run; raise Refused if it asks nothing."""

        def say(_: Kernel) -> None:
            if self.state != "asks":
                raise Refused(rules.RUN_ASKS_NOTHING())
            self._answer = text
            self._stands.clear()

        self.ask(say)
        self._stands.wait(_STEP_WAIT)

    def switch(self, name: str, value: float) -> None:
        """Gives an input a value, as a hand does; raises Refused of a run that is over."""

        def put(kernel: Kernel) -> None:
            if self.run is not None:
                raise Refused(rules.NO_RUN())
            if kernel.board.inputs.read(name) != value:
                given = InputChange(kernel.now, name, value, len(kernel.log))
                self.given.append(given)
                self.log.append(_event_row(given))
            kernel.board.inputs.set(name, value)
            if self.state == "waits":
                self._waits = ""
                self._stands.clear()
            self._report()

        self.ask(put)
        self._stands.wait(_STEP_WAIT)

    def told(self) -> Run:
        """The run as far as it has come, to be asked for in its thread while it goes on."""
        return self.run or Run(log=tuple(self.kernel.log), seconds=self.kernel.clock)

    # ------------------------------------------------------------------------ its thread

    def _work(self) -> None:
        try:
            self.kernel = self._made()
        except BaseException as wrong:  # noqa: BLE001 (`start` raises it)
            self._ready.set_exception(wrong)
            return
        self._report()
        self._ready.set_result(None)
        try:
            self._finish(self.kernel.run())
        except Refused as refused:
            self.findings += refused.findings
        except (Exception, Reached) as wrong:  # noqa: BLE001 (the studio goes on, and says so)
            self.findings.append(internal_error(wrong))
        self.state = "ended"
        self._held = None
        self._report()
        self._stands.set()
        self._take_all()

    def _made(self) -> Kernel:
        wanted = self.wanted
        settings = Settings(
            robot=wanted.robot,
            entry=wanted.entry,
            inputs=WatchedInputs({one.name: 0.0 for one in wanted.script.changes}),
            pace=1.0 if wanted.real_time else None,
            options=wanted.script.options,
        )
        kernel = prepared(wanted.programs, settings)
        self.findings += wanted.programs.findings
        self.findings += unknown_visits(wanted.script, self.sources)
        if wanted.robot is None:
            self.findings.append(rules.RUN_WITHOUT_ARM())
        self.given = follow(kernel, wanted.script, self.sources)
        kernel.watch, kernel.stuck = self._watch, self._stuck
        kernel.told.append(self._hear)
        kernel.person.console = self._asked
        if wanted.real_time:
            kernel.at(_LOCKSTEP_PERIOD, self._tick)
        return kernel

    def _finish(self, run: Run) -> None:
        self.run = run
        self.log = [_event_row(row) for row in log_rows(run.log, self.given)]
        wrong = end_finding(run, self.sources)
        self.findings += [NOTED(what=note) for note in run.notes]
        if wrong is not None:
            self.findings.append(wrong)

    def _hear(self, row: Logged) -> None:
        self.log.append(_event_row(row))

    def _watch(self, task: Task) -> None:
        """Before each statement."""
        self._take_all()
        reason = self.holding.reason(task) or self._stop()
        if reason and not self.over:
            self._hold(task, reason)
        if self.over:
            self.kernel.halt(task, Ending("until"))
        if time.monotonic() - self._reported > _REPORT_PERIOD:
            self._report()

    def _tick(self) -> None:
        """Now and then, of a run in step with real time, also on the way of a motion."""
        kernel = self.kernel
        self._take_all()
        if self.over:
            kernel.end(Ending("until"))
            return
        waits = next((t.waits_for for t in kernel.tasks if t.waiting and t.until is not None), "")
        self._waits = waits if kernel.motion.stands() else ""
        self.state = "waits" if self._waits else "running"
        if self.holding.pause is not None and kernel.tasks:
            self._hold(kernel.tasks[0], self.holding.pause)
        if time.monotonic() - self._reported > _REPORT_PERIOD:
            self._report()
        kernel.at(kernel.clock + _LOCKSTEP_PERIOD, self._tick)

    def _stop(self) -> str:
        """Return "stop" if the program has stopped since the last check, else ""."""
        first, self._looked = self._looked, len(self.kernel.log)
        new = self.kernel.log[first:]
        return "stop" if any(row.what == Stopped() for row in new) else ""

    def _hold(self, task: Task, reason: str) -> None:
        self.kernel.catch_up()
        self._held, self._reason, self.state = task, reason, "held"
        self._wait(lambda: self._held is None)
        self._reason = ""
        self.kernel.pace_anew()

    def _stuck(self, waiting: Task) -> bool:
        """A task waits: for what only a hand brings, if there is no end of that wait."""
        self._take_all()
        if waiting.wakes < math.inf:
            return False
        self._waits, self.state = waiting.waits_for or "…", "waits"
        self._wait(lambda: not self._waits)
        if self.over:
            self.kernel.end(Ending("until"))
        return True

    def _asked(self, question: str) -> str | None:
        """Return the answer of the user in the window; the run may end meanwhile."""
        self._question, self._answer, self.state = question, None, "asks"
        self._wait(lambda: self._answer is not None)
        self._question = ""
        self.kernel.pace_anew()
        if self.over:
            self.kernel.end(Ending("until"))
            self.kernel.hub.switch()
        return self._answer

    def _wait(self, done: Callable[[], bool]) -> None:
        """Carry out commands until the condition holds, or until the run must end."""
        self._report()
        self._stands.set()
        while not done() and not self.over:
            self._commands.get()()
        self._stands.clear()
        self.state = "running"
        self._report()

    def _take_all(self) -> None:
        while not self._commands.empty():
            self._commands.get()()

    # ------------------------------------------------------------------------- reporting

    def _report(self) -> None:
        self._reported = time.monotonic()
        self._snapshot = self._seen()
        if not self.over or self.state == "ended":
            self._told({"kind": "run", **self._snapshot})

    def _seen(self) -> dict[str, Any]:
        kernel, run = self.kernel, self.run
        over = self.state == "ended"
        task = self._held or (None if over else next(iter(kernel.tasks), None))
        place = (run.place if run else None) if task is None else task.where()
        held = self.state in ("held", "waits", "asks")
        return {
            "state": self.state,
            "title": self.wanted.programs.title,
            "program": self.wanted.path,
            "robot": None if self.wanted.robot is None else self.wanted.robot.name,
            "time": kernel.clock,
            "task": "" if task is None else task.name,
            **_place_record(place),
            "reason": self._reason,
            "question": self._question,
            "waits": self._waits,
            "logged": len(self.log),
            "chain": self._chain(),
            **_signal_records(kernel.board),
            **(_data_records(task) if held and task is not None else {"stack": [], "data": []}),
            "findings": finding_records(self.findings),
            "ended": "" if run is None else run.ended,
            "message": "" if run is None else run.message,
            "summary": "" if run is None else summary(run),
        }

    def _chain(self) -> list[float] | None:
        """(a,) of the arm's chain as the scene poses it; None without an arm, or while a program is
        ahead of it.
        """
        robot, motion = self.wanted.robot, self.kernel.motion
        standing = None if robot is None or motion.behind else motion.where()
        if robot is None or standing is None:
            return None
        joints = np.array([robot.own_joints(standing[1])], dtype=np.float64)
        return list(robot.chained(joints)[0].tolist())


def _event_row(row: Logged | InputChange) -> dict[str, Any]:
    place: Place | None = row.place if isinstance(row, Logged) else None
    what = row.what if isinstance(row, Logged) else row
    event = json_record(row)["event"]
    return {"time": row.time, **_place_record(place), "event": event, "what": event_words(what)}


def _place_record(place: Place | None) -> dict[str, Any]:
    return {"path": None, "line": None} if place is None else {"path": place[0], "line": place[1]}
