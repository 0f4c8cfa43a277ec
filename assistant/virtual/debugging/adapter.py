"""The adapter: answers the requests of an editor, and holds and runs the program as they say."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from io import RawIOBase
from typing import BinaryIO, Final

from assistant.base.diagnostics import Refused
from assistant.virtual.debugging import messages
from assistant.virtual.debugging.expressions import Evaluate, Read, is_true, shown
from assistant.virtual.debugging.holding import Holding, Reason, Step, Stride
from assistant.virtual.debugging.messages import NoMessage, Object, inner, number, several, text
from assistant.virtual.debugging.points import Lines, Points
from assistant.virtual.debugging.view import View
from assistant.virtual.events import Place, Run, event_text
from assistant.virtual.kernel import Ending, Kernel, Task

Launch = Callable[[Object], tuple[Kernel, Lines]]
"""Makes the run that a launch request asks for; raises Refused for what cannot be run."""

CAPABILITIES: Final[Object] = {
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
        self.view: View | None = None
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
        does = REQUESTS.get(command)
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
        if command == "launch":
            self._event("initialized")
        elif command == "configurationDone" and not self._ends:
            self._run()

    # ------------------------------------------------------------------------------ running

    def _initialize(self, _: Object) -> Object:
        return CAPABILITIES

    def _launch(self, arguments: Object) -> None:
        if self.kernel is not None:
            raise LookupError("a program is running already")
        self.kernel, self.points.lines = self.start(arguments)
        self.view = View(self.kernel)
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
        assert self.kernel is not None
        self.kernel.catch_up()
        for row in self.kernel.log[self._logged :]:
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

    def _look(self, does: Callable[[View, Object], Object], arguments: Object) -> Object:
        """What is asked of a program that is held."""
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


def _view_request(does: Callable[[View, Object], Object]) -> Callable[[Adapter, Object], Object]:
    return lambda adapter, arguments: adapter._look(does, arguments)


REQUESTS: Final[Mapping[str, Callable[[Adapter, Object], Object | None]]] = {
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
    "threads": _view_request(View.threads),
    "stackTrace": _view_request(View.stack),
    "scopes": _view_request(View.scopes),
    "variables": _view_request(View.variables),
    "setVariable": _view_request(View.set_variable),
    "evaluate": _view_request(View.evaluate),
}
"""What an editor may ask, by the names of the protocol."""
