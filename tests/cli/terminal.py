"""A command in a terminal of its own: what it shows, and keys that are pressed."""

from __future__ import annotations

import os
import pty
import select
import signal
import time
from pathlib import Path

from tests.cli.processes import Command
from tests.forks import Forks

PATIENCE = 30.0
"""Seconds to wait for what is to be shown."""


class Terminal:
    """A process whose input, output and errors are one terminal; a context manager."""

    def __init__(self, forks: Forks, *arguments: object, folder: Path) -> None:
        self.ours, theirs = pty.openpty()
        environment = {**os.environ, "TERM": "xterm", "COLUMNS": "200", "LINES": "50"}
        streams = dict.fromkeys(("stdin", "stdout", "stderr"), theirs)
        self.process = Command(forks, *arguments, cwd=folder, env=environment, **streams)
        os.close(theirs)
        self.said = ""

    def __enter__(self) -> Terminal:
        return self

    def __exit__(self, *error: object) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        os.close(self.ours)

    def until(self, text: str) -> str:
        """What is shown up to this text, which is then left behind."""
        end = time.monotonic() + PATIENCE
        while text not in self.said:
            assert self._more(end), f"`{text}` is not in:\n{self.said}"
        before, _, self.said = self.said.partition(text)
        return before

    def type(self, keys: str) -> None:
        os.write(self.ours, keys.encode())

    def interrupt(self) -> None:
        """What Ctrl-C sends."""
        self.process.send_signal(signal.SIGINT)

    def end(self) -> tuple[int, str]:
        """Exit status, and the rest of what is shown."""
        end = time.monotonic() + PATIENCE
        while self._more(end):
            pass
        assert "Traceback" not in self.said
        return self.process.wait(PATIENCE), self.said

    def _more(self, end: float) -> bool:
        """Whether anything more came."""
        ready, _, _ = select.select([self.ours], [], [], max(0.0, end - time.monotonic()))
        assert ready, f"nothing more came after:\n{self.said}"
        try:
            data = os.read(self.ours, 65536)
        except OSError:  # the other side is closed
            return False
        self.said += data.decode(errors="replace")
        return bool(data)
