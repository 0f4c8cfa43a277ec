"""The debug adapter: answer the requests of an editor, hold and run the program as they ask.

A `_View` shows the editor a program that is held: its tasks, calls, data and signals.
"""

from __future__ import annotations

import queue
import re
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from io import RawIOBase
from typing import BinaryIO, Final

from assistant.base.diagnostics import Refused
from assistant.virtual.debugging import messages
from assistant.virtual.debugging.break_points import Holding, Lines, Points, Reason, Step, Stride
from assistant.virtual.debugging.expressions import Evaluate, Read, is_true, read_expression, shown
from assistant.virtual.debugging.messages import NoMessage, Object, inner, number, several, text
from assistant.virtual.events import Place, Run, event_text
from assistant.virtual.kernel import Ending, Kernel, Signals, Task
from assistant.virtual.kernel.task import Level, Shown
from assistant.virtual.tasks import SignalNames

_SIGNAL_BIT: Final = re.compile(r"m_(in|out)\((\d+)\)")
"""A bit of the inputs or outputs in MELFA-BASIC."""


class _View:
    """Numbers stand for calls and for data with parts, from one stop of the run to the next.

    names: of signals, as people read them.
    """

    def __init__(self, kernel: Kernel, names: SignalNames) -> None:
        self.kernel, self.names = kernel, names
        self._threads: dict[str, int] = {}
        self.begin()

    def begin(self) -> None:
        """The run is held anew: what was numbered before is no more."""
        self._levels: list[Level] = []
        self._shown: list[Callable[[], Sequence[Shown]]] = []
        self._inputs: set[int] = set()

    def thread(self, task: Task) -> int:
        return self._threads.setdefault(task.name, len(self._threads) + 1)

    def threads(self, _: Object) -> Object:
        tasks = self.kernel.tasks
        return {"threads": [{"id": self.thread(task), "name": task.name} for task in tasks]}

    def stack(self, arguments: Object) -> Object:
        wanted = number(arguments, "threadId")
        tasks = self.kernel.tasks
        levels = [x for task in tasks if self.thread(task) == wanted for x in task.levels()]
        frames = [self._frame(level) for level in levels]
        return {"stackFrames": frames, "totalFrames": len(frames)}

    def _frame(self, level: Level) -> Object:
        self._levels.append(level)
        frame: Object = {"id": len(self._levels), "name": level.name, "line": 0, "column": 1}
        if level.place is not None:
            path, line = level.place
            name = path.replace("\\", "/").rpartition("/")[2]
            frame |= {"source": {"name": name, "path": path}, "line": line}
        return frame

    def scopes(self, arguments: Object) -> Object:
        level = self._level(number(arguments, "frameId"))
        scopes = [self._scope(name, shown) for name, shown in level.groups.items()]
        for title, signals in self._signals():
            scopes.append(self._scope(title, signals))
            if title == "Inputs":
                # The reference that the inputs have just got: only these can be set.
                self._inputs.add(len(self._shown))
        return {"scopes": scopes}

    def _signals(self) -> tuple[tuple[str, Callable[[], Sequence[Shown]]], ...]:
        board, names = self.kernel.board, self.names
        return (
            ("Inputs", partial(_shown_signals, board.inputs, names.inputs)),
            ("Outputs", partial(_shown_signals, board.outputs, names.outputs)),
        )

    def _level(self, frame: int) -> Level:
        if not 1 <= frame <= len(self._levels):
            raise LookupError("there is no such call")
        return self._levels[frame - 1]

    def _scope(self, name: str, shown: Callable[[], Sequence[Shown]]) -> Object:
        return {"name": name, "variablesReference": self._reference(shown), "expensive": False}

    def _reference(self, shown: Callable[[], Sequence[Shown]] | None) -> int:
        if shown is None:
            return 0
        self._shown.append(shown)
        return len(self._shown)

    def variables(self, arguments: Object) -> Object:
        reference = number(arguments, "variablesReference")
        if not 1 <= reference <= len(self._shown):
            raise LookupError("there are no such data")
        return {"variables": [self._variable(one) for one in self._shown[reference - 1]()]}

    def _variable(self, one: Shown) -> Object:
        reference = self._reference(one.parts)
        return {
            "name": one.name, "value": one.value, "type": one.type, "variablesReference": reference,
        }  # fmt: skip

    def set_variable(self, arguments: Object) -> Object:
        """Set an input; raises LookupError for other variables, as the program's data is not
        changed.
        """
        if number(arguments, "variablesReference") not in self._inputs:
            raise LookupError("only inputs can be set")
        try:
            value = float(text(arguments, "value"))
        except ValueError:
            raise LookupError("the value of a signal is a number") from None
        self.kernel.board.inputs.set(self.names.input_key(text(arguments, "name")), value)
        return {"value": f"{value:g}"}

    def evaluate(self, arguments: Object) -> Object:
        """A name, with components and elements after it, or an expression of such names."""
        wanted = text(arguments, "expression").strip()
        frame = number(arguments, "frameId")
        # Without a frame, as from the console, the innermost call counts.
        levels = [self._level(frame)] if frame else self._levels[:1]
        for level in levels:
            for group in level.groups.values():
                found = _find_shown(group(), wanted.lower())
                if found is not None:
                    variable = self._variable(found)
                    return {"result": variable.pop("value"), **variable}
        value = read_expression(wanted)(partial(self._read_name, levels))
        return {"result": shown(value), "variablesReference": 0}

    def read(self, task: Task, name: str) -> str:
        """The value of data that a task knows, as it is shown; raises LookupError."""
        return self._read_name(task.levels()[:1], name)

    def _read_name(self, levels: Sequence[Level], name: str) -> str:
        wanted, board = name.lower(), self.kernel.board
        for level in levels:
            for group in level.groups.values():
                found = _find_shown(group(), wanted)
                if found is not None:
                    return found.value
        if (port := _SIGNAL_BIT.fullmatch(wanted)) is not None:
            return f"{(board.inputs if port[1] == 'in' else board.outputs).read(port[2]):g}"
        for _, signals in self._signals():
            for one in signals():
                if one.name.lower() == wanted:
                    return one.value
        raise LookupError(f"`{name}` is no data that is known here")


def _shown_signals(signals: Signals, names: Mapping[str, str]) -> Sequence[Shown]:
    """The signals that a run knows, by the names that people read. names: these, by key."""
    source = signals.source
    keys = set(signals.values) | (set() if callable(source) else set(source))
    return [Shown(names.get(key, key), f"{signals.read(key):g}") for key in sorted(keys)]


def _find_shown(shown: Sequence[Shown], wanted: str) -> Shown | None:
    """The data of a name in lower case; components follow a point, elements in their brackets."""
    for one in shown:
        name = one.name.lower()
        if wanted == name:
            return one
        rest = wanted[len(name) :]
        if wanted.startswith(name) and rest[:1] in (".", "{", "(") and one.parts is not None:
            return _find_shown(one.parts(), rest.removeprefix("."))
    return None


Launch = Callable[[Object], tuple[Kernel, Lines, SignalNames]]
"""Makes the run that a launch request asks for; raises Refused for what cannot be run."""

_CAPABILITIES: Final[Object] = {
    "supportsConfigurationDoneRequest": True,
    "supportsTerminateRequest": True,
    "supportsEvaluateForHovers": True,
    "supportsSetVariable": True,
    "supportsConditionalBreakpoints": True,
    "supportsHitConditionalBreakpoints": True,
    "supportsLogPoints": True,
}


class Adapter:
    """A conversation with an editor. start: makes the run."""

    def __init__(self, source: RawIOBase, sink: BinaryIO, start: Launch) -> None:
        self.source, self.sink, self.start = source, sink, start
        self.requests: queue.SimpleQueue[Object | None] = queue.SimpleQueue()
        self.kernel: Kernel | None = None
        self.view: _View | None = None
        self.holding = Holding()
        self.points = Points()
        self.held: Task | None = None
        self.over = False
        """The editor has left."""
        self.ended = False
        """The run is over, or is to end."""
        self._sent = 0
        self._logged = 0
        self.broken = ""

    def serve(self) -> int:
        """Speaks until the editor leaves; 0, or 1 if what it said was no message."""
        # A thread reads, since a running program takes requests only between two statements.
        threading.Thread(target=self._read, daemon=True).start()
        while not self.over and (request := self.requests.get()) is not None:
            self._answer(request)
        return 1 if self.broken else 0

    def _read(self) -> None:
        """Takes in what the editor says, also while the program runs."""
        try:
            while (message := messages.read(self.source)) is not None:
                self.requests.put(message)
        except (NoMessage, OSError, ValueError) as error:
            self.broken = str(error)
        # None ends the conversation, however the reading ended.
        self.requests.put(None)

    # ----------------------------------------------------------------------------- speaking

    def _send(self, kind: str, **content: object) -> None:
        self._sent += 1
        with suppress(OSError):  # An editor that is gone is told nothing; the reader ends the run.
            messages.write(self.sink, {"seq": self._sent, "type": kind, **content})

    def _event(self, name: str, **body: object) -> None:
        self._send("event", event=name, body=body)

    def _answer(self, request: Object) -> None:
        """Answers one request; a failure is an answer too."""
        command = text(request, "command")
        does = _REQUESTS.get(command)
        about: Object = {"request_seq": number(request, "seq"), "command": command}
        if does is None:
            self._send("response", success=False, message=f"`{command}` is not known", **about)
            return
        try:
            body = does(self, inner(request, "arguments"))
        except Refused as refused:
            message = str(refused)
            self._send("response", success=False, message=message, **about)
            return
        except LookupError as error:
            self._send("response", success=False, message=str(error.args[0]), **about)
            return
        self._send("response", success=True, body=body or {}, **about)
        # The protocol wants both after the answer: the editor sets break points in between.
        if command == "launch":
            self._event("initialized")
        elif command == "configurationDone" and not self._ends:
            self._run()

    # ------------------------------------------------------------------------------ running

    def _initialize(self, _: Object) -> Object:
        return _CAPABILITIES

    def _launch(self, arguments: Object) -> None:
        if self.kernel is not None:
            raise LookupError("a program is running already")
        self.kernel, self.points.lines, names = self.start(arguments)
        self.view = _View(self.kernel, names)
        self.kernel.watch = self._watch
        if arguments.get("stopOnEntry") is True:
            self.holding.pause = "entry"

    def _configured(self, _: Object) -> None:
        if self.kernel is None:
            raise LookupError("nothing was launched")

    def _run(self) -> None:
        assert self.kernel is not None
        run = self.kernel.run()
        self._tell_log()
        if not self.over and not self.ended:
            self.ended = True
            self._finished(run)

    def _finished(self, run: Run) -> None:
        if run.ended != "end" and run.message:
            self._event("output", category="stderr", output=f"{run.ended}: {run.message}\n")
        self._event("exited", exitCode=0 if run.ended == "end" else 1)
        self._event("terminated")

    def _watch(self, task: Task) -> None:
        """Before each statement: takes in requests, and holds the run where it is to be held."""
        while not self.requests.empty() and not self._ends:
            self._take(self.requests.get())
        reason: Reason | None = None
        if not self._ends:
            met = self._meets(task)
            reason = self.holding.reason(task) or ("breakpoint" if met else None)
        if reason is not None:
            self._hold(task, reason)
        # The run ends here, before the statement at hand is executed.
        if self._ends:
            task.kernel.end(Ending("stopped", "the debugger has ended the run"))
            task.kernel.hub.switch()

    def _meets(self, task: Task) -> bool:
        """True if a break point holds the task before its next statement."""
        place = task.where() if self.points.set else None
        if place is None:
            return False
        assert self.view is not None
        read, held = partial(self.view.read, task), False
        for point in self.points.at(*place):
            try:
                if point.condition is not None and not is_true(point.condition(read)):
                    continue
            # The break point then holds: one that never holds would go unnoticed.
            except LookupError as error:
                self._say(place, f"the condition of the break point: {error.args[0]}")
            point.count += 1
            if point.hits is not None and not point.hits(point.count):
                continue
            if point.log is None:
                held = True
                continue
            self._tell_log()
            self._say(place, "".join(map(partial(_logged_text, read), point.log)))
        return held

    def _say(self, place: Place, what: str) -> None:
        """A line in the console of the editor."""
        path, line = place
        where: Object = {"source": {"path": path}, "line": line}
        self._event("output", category="console", output=f"{what}\n", **where)

    def _take(self, request: Object | None) -> None:
        if request is None:
            self.over = True
        else:
            self._answer(request)

    def _hold(self, task: Task, reason: Reason) -> None:
        self._tell_log()
        self.held = task
        assert self.view is not None
        self.view.begin()
        thread = self.view.thread(task)
        self._event("stopped", reason=reason, threadId=thread, allThreadsStopped=True)
        while self.held is not None and not self._ends:
            self._take(self.requests.get())

    def _resume(self, step: Step | None = None) -> None:
        self.holding.go(step)
        self.held = None

    def _tell_log(self) -> None:
        assert self.kernel is not None and self.view is not None
        # Times in the log are right only once the arm has caught up with the program.
        self.kernel.catch_up()
        for row in map(self.view.names.logged, self.kernel.log[self._logged :]):
            body: Object = {
                "category": "stdout",
                "output": f"{row.time:.3f} {event_text(row.what)}\n",
            }
            if row.place is not None:
                body |= {"source": {"path": row.place[0]}, "line": row.place[1]}
            self._event("output", **body)
        self._logged = len(self.kernel.log)

    def _set_points(self, arguments: Object) -> Object:
        if self.kernel is None:
            raise LookupError("nothing was launched")
        path = text(inner(arguments, "source"), "path")
        return {"breakpoints": self.points.place(path, several(arguments, "breakpoints"))}

    def _nothing(self, _: Object) -> None:
        """An error ends the run: there is nothing to choose."""

    def _go_on(self, _: Object) -> Object:
        self._resume()
        return {"allThreadsContinued": True}

    def _pause(self, _: Object) -> None:
        if self.held is None:
            self.holding.pause = "pause"

    def _step_over(self, _: Object) -> None:
        self._step("over")

    def _step_in(self, _: Object) -> None:
        self._step("in")

    def _step_out(self, _: Object) -> None:
        self._step("out")

    def _step(self, stride: Stride) -> None:
        task = self.held
        if task is None:
            raise LookupError("the program is not held")
        self._resume(Step(task, stride, len(task.levels())))

    def _leave(self, _: Object) -> None:
        self.over = True

    def _terminate(self, _: Object) -> None:
        """The run ends; the editor is answered until it leaves."""
        if not self.ended:
            self.ended = True
            self._event("terminated")

    @property
    def _ends(self) -> bool:
        return self.over or self.ended

    def _look(self, does: Callable[[_View, Object], Object], arguments: Object) -> Object:
        """Answer a request about a program that is held; raises LookupError if nothing was
        launched.
        """
        if self.view is None:
            raise LookupError("nothing was launched")
        return does(self.view, arguments)


def _logged_text(read: Read, part: str | Evaluate) -> str:
    """A part of a log point; an expression that cannot be worked out says why."""
    if isinstance(part, str):
        return part
    try:
        return shown(part(read))
    except LookupError as error:
        return f"<{error.args[0]}>"


def _view_request(does: Callable[[_View, Object], Object]) -> Callable[[Adapter, Object], Object]:
    return lambda adapter, arguments: adapter._look(does, arguments)


_REQUESTS: Final[Mapping[str, Callable[[Adapter, Object], Object | None]]] = {
    "initialize": Adapter._initialize,
    "launch": Adapter._launch,
    "configurationDone": Adapter._configured,
    "setBreakpoints": Adapter._set_points,
    "setExceptionBreakpoints": Adapter._nothing,
    "continue": Adapter._go_on,
    "pause": Adapter._pause,
    "next": Adapter._step_over,
    "stepIn": Adapter._step_in,
    "stepOut": Adapter._step_out,
    "disconnect": Adapter._leave,
    "terminate": Adapter._terminate,
    "threads": _view_request(_View.threads),
    "stackTrace": _view_request(_View.stack),
    "scopes": _view_request(_View.scopes),
    "variables": _view_request(_View.variables),
    "setVariable": _view_request(_View.set_variable),
    "evaluate": _view_request(_View.evaluate),
}
"""Requests of an editor, by the names of the protocol."""
