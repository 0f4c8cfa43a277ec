"""Whole programs looked at in a process apart, so that no request of an editor waits for that.

A check of a long program takes seconds of Python, in which a thread would keep all others from
running. The process takes one request after the other on its standard input, and ends with it.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import IO, Any, Final

from assistant.editing.live_findings import Seen, Unseen
from assistant.editing.workspace import Document, Workspace

COMMAND: Final = (sys.executable, "-m", "assistant.editing.checker")
_NICE: Final = 5
"""Nice value of the process that checks, so that the one that answers comes first."""


@dataclass(frozen=True, slots=True)
class Request:
    """root: of the workspace. others: the other texts of the same task, with path and language."""

    root: FilePath | None
    path: str
    language: str
    others: Sequence[tuple[str, str, str]]
    unseen: Unseen


class Checker:
    """The process, which is started when it is first asked; used from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._closed = False
        self._process: subprocess.Popen[bytes] | None = None

    def look(self, document: Document, unseen: Unseen) -> Seen | None:
        """Return the findings; None if no process can be started: then the caller checks."""
        workspace = document.workspace
        _, *others = workspace.task(document)
        texts = [(one.path, one.text, one.language) for one in others]
        return self._ask(Request(workspace.root, document.path, document.language, texts, unseen))

    def _ask(self, request: Request) -> Seen | None:
        data = pickle.dumps(request)
        with self._lock:
            for _ in range(2):  # one that has died is started anew, once
                if self._closed:
                    break
                with suppress(OSError, EOFError, ValueError, pickle.UnpicklingError):
                    process = self._started()
                    assert process.stdin is not None and process.stdout is not None
                    _write(process.stdin, data)
                    seen: Seen = pickle.loads(_read(process.stdout))  # noqa: S301 - our own
                    return seen
                self._end()
        return None

    def close(self) -> None:
        """Ends the process for good, also in the midst of a look."""
        self._closed = True
        self._end()

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            with suppress(OSError):
                process.kill()
            process.wait()
            for stream in (process.stdin, process.stdout):
                if stream is not None:
                    with suppress(OSError, ValueError):
                        stream.close()

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            self._process = subprocess.Popen(  # noqa: S603 - ourselves
                COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
            )
        return self._process


def _write(stream: IO[bytes], data: bytes) -> None:
    stream.write(len(data).to_bytes(8, "big") + data)
    stream.flush()


def _read(stream: IO[bytes]) -> bytes:
    """One message; raises EOFError at the end."""
    head = stream.read(8)
    data = stream.read(int.from_bytes(head, "big")) if len(head) == 8 else b""
    if len(head) < 8 or len(data) < int.from_bytes(head, "big"):
        raise EOFError
    return data


def looked(request: Request) -> Seen:
    """Check a whole program in a workspace that holds nothing else."""
    workspace = Workspace(request.root)
    for path, text, language in request.others:
        workspace.open(path, text, language=language)
    document = workspace.open(request.path, request.unseen.text, language=request.language)
    return workspace.seen(document, request.unseen)


def main() -> None:
    """Answers until the end of the input."""
    source: Any = os.fdopen(os.dup(sys.stdin.fileno()), "rb")
    sink: Any = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what else is printed
    with suppress(OSError, AttributeError):
        os.nice(_NICE)
    with suppress(EOFError, OSError, KeyboardInterrupt):
        while True:
            _write(sink, pickle.dumps(looked(pickle.loads(_read(source)))))  # noqa: S301


if __name__ == "__main__":
    main()
