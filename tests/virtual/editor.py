"""An editor that debugs programs, over the standard streams of the debugger's process."""

from __future__ import annotations

import json
import queue
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import Any

LONGEST = 60.0
"""Seconds that an answer may take on a busy machine."""


class Editor:
    """A conversation with the debugger. heard: all that it said."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self.process = process
        self.arrived: queue.Queue[Any] = queue.Queue()
        self.events: list[Any] = []
        self.count = 0
        self.heard = b""
        threading.Thread(target=self._receive, daemon=True).start()

    def _receive(self) -> None:
        stream = self.process.stdout
        assert stream is not None
        while header := stream.readline():
            length = int(header.removeprefix(b"Content-Length: "))
            data = stream.readline() + stream.read(length)
            self.heard += header + data
            self.arrived.put(json.loads(data))
        self.arrived.put(None)

    def _next(self) -> Any:
        message = self.arrived.get(timeout=LONGEST)
        assert message is not None, "the debugger is gone"
        return message

    def send(self, command: str, **arguments: Any) -> int:
        """Sends a request; its number."""
        self.count += 1
        request = {"seq": self.count, "type": "request", "command": command}
        data = json.dumps({**request, "arguments": arguments}).encode()
        assert self.process.stdin is not None
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%b" % (len(data), data))
        self.process.stdin.flush()
        return self.count

    def ask(self, command: str, **arguments: Any) -> Any:
        """The body of the answer to a request; fails if it was refused."""
        answer = self.answer(command, **arguments)
        assert answer["success"], answer
        return answer["body"]

    def answer(self, command: str, **arguments: Any) -> Any:
        number = self.send(command, **arguments)
        while True:
            message = self._next()
            if message.get("request_seq") == number:
                assert (message["type"], message["command"]) == ("response", command)
                return message
            self.events.append(message)

    def event(self, name: str) -> Any:
        """The next event of that name, one that has come already or one that comes."""
        for place, message in enumerate(self.events):
            if message["event"] == name:
                return self.events.pop(place)["body"]
        while True:
            message = self._next()
            if message["event"] == name:
                return message["body"]
            self.events.append(message)

    def begin(self, program: FilePath, lines: tuple[int, ...] = (), **arguments: Any) -> None:
        """Launches a program with break points."""
        self.ask("initialize", adapterID="robot-assistant")
        self.ask("launch", program=str(program), **arguments)
        self.event("initialized")
        points = [{"line": line} for line in lines]
        self.ask("setBreakpoints", source={"path": str(program)}, breakpoints=points)
        self.ask("configurationDone")

    def stack(self, thread: int = 1) -> list[tuple[str, int]]:
        """Names and lines of the calls, the innermost first."""
        frames = self.ask("stackTrace", threadId=thread)["stackFrames"]
        return [(frame["name"], frame["line"]) for frame in frames]

    def data(self, scope: str, thread: int = 1) -> dict[str, str]:
        """What a scope of the innermost call holds."""
        frame = self.ask("stackTrace", threadId=thread)["stackFrames"][0]
        scopes = self.ask("scopes", frameId=frame["id"])["scopes"]
        (reference,) = (s["variablesReference"] for s in scopes if s["name"] == scope)
        found = self.ask("variables", variablesReference=reference)["variables"]
        return {variable["name"]: variable["value"] for variable in found}


@contextmanager
def editing(python: str) -> Iterator[Editor]:
    """A debugger's process with an editor at its standard streams."""
    command = [python, "-m", "assistant", "debug"]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        yield Editor(process)
    finally:
        process.kill()
        process.communicate()
