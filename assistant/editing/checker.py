"""Whole programs looked at in a process apart, so that no request of an editor waits for that.

A check of a long program takes seconds of Python, in which a thread would keep all others from
running.
"""

from __future__ import annotations

import os
import subprocess
import threading
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path as FilePath
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.worker_processes import Worker, WorkerDied
from assistant.editing.live_findings import Seen, Unseen
from assistant.editing.workspace import Document, Workspace

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
        self._worker = Worker(errors=subprocess.DEVNULL)

    def look(self, document: Document, unseen: Unseen) -> Seen | None:
        """Return the findings; None if no process can be started: then the caller checks."""
        workspace = document.workspace
        _, *others = workspace.task(document)
        texts = [(one.path, one.text, one.language) for one in others]
        request = Request(workspace.root, document.path, document.language, texts, unseen)
        with self._lock:
            for _ in range(2):  # one that has died is started anew, once
                with suppress(WorkerDied):
                    return self._worker.answer(looked, request)
        return None

    def close(self) -> None:
        """Ends the process for good, also in the midst of a look."""
        self._worker.close()


def looked(request: Request) -> Seen:
    """Check a whole program in a workspace that holds nothing else."""
    with suppress(OSError, AttributeError):
        os.nice(max(0, _NICE - os.nice(0)))
    workspace = Workspace(request.root)
    for path, text, language in request.others:
        workspace.open(path, text, language=language)
    document = workspace.open(request.path, request.unseen.text, language=request.language)
    return workspace.seen(document, request.unseen)
