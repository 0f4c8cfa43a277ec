"""An editor that debugs programs: the client of another project, over a process's own streams."""

from __future__ import annotations

import queue
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import Any

from dap import DAPClient

LONGEST = 60.0
"""Seconds that an answer may take on a busy machine."""


class Editor:
    """A conversation with the debugger; each request returns the body of its answer."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self.process = process
        self.client = DAPClient(clientID="test", adapterID="robot-assistant")
        self.arrived: queue.Queue[Any] = queue.Queue()
        self.events: list[Any] = []
        threading.Thread(target=self._receive, daemon=True).start()

    def _receive(self) -> None:
        assert self.process.stdout is not None
        while data := self.process.stdout.read1(65536):  # type: ignore[attr-defined]
            for message in self.client.recv(data):
                self.arrived.put(message)
        self.arrived.put(None)

    def _next(self) -> Any:
        message = self.arrived.get(timeout=LONGEST)
        assert message is not None, "the debugger is gone"
        return message

    def flush(self) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(self.client.send())
        self.process.stdin.flush()

    def ask(self, number: int) -> Any:
        """The body of the answer to a request that the client made; fails if it was refused."""
        answer = self.answer(number)
        assert getattr(answer, "success", True), answer.message
        return answer.body["body"]

    def answer(self, number: int) -> Any:
        self.flush()
        while True:
            message = self._next()
            if getattr(message, "request_seq", None) == number:
                return message
            if message.event == "response" and message.body["request_seq"] == number:
                return message
            self.events.append(message)

    def event(self, name: str) -> Any:
        """The next event of that name, one that has come already or one that comes."""
        for place, message in enumerate(self.events):
            if message.event == name:
                return self.events.pop(place).body
        while True:
            message = self._next()
            if message.event == name:
                return message.body
            self.events.append(message)

    def begin(self, program: FilePath, lines: tuple[int, ...] = (), **arguments: Any) -> None:
        """Launches a program with break points."""
        self.flush()
        self.event("initialized")
        self.ask(self.client.launch(str(program), **arguments))
        points = [{"line": line} for line in lines]
        self.ask(self.client.set_breakpoints({"path": str(program)}, points))
        self.ask(self.client.configuration_done())

    def stack(self, thread: int = 1) -> list[tuple[str, int]]:
        """Names and lines of the calls, the innermost first."""
        frames = self.ask(self.client.stack_trace(thread))["stackFrames"]
        return [(frame["name"], frame["line"]) for frame in frames]

    def data(self, scope: str, thread: int = 1) -> dict[str, str]:
        """What a scope of the innermost call holds."""
        frame = self.ask(self.client.stack_trace(thread))["stackFrames"][0]
        scopes = self.ask(self.client.scopes(frame["id"]))["scopes"]
        (reference,) = (s["variablesReference"] for s in scopes if s["name"] == scope)
        found = self.ask(self.client.variables(reference))["variables"]
        return {variable["name"]: variable["value"] for variable in found}


@contextmanager
def editor(*arguments: str) -> Iterator[Editor]:
    """A debugger's process with an editor at its standard streams."""
    command = [sys.executable, "-m", "assistant", "debug", *arguments]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        yield Editor(process)
    finally:
        process.kill()
        process.communicate()
