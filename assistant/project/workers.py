"""One function for many arguments, in several processes at once.

Each is a Python of its own that imports nothing of who asked: a script or notebook that builds a
project needs no guard, as `multiprocessing` would have it.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import BinaryIO, Final, Generic, TypeVar

from assistant.controllers.address import without_passwords

A = TypeVar("A")
B = TypeVar("B")

WORKER_SCRIPT: Final = (
    "import sys; sys.path[:] = sys.argv[1:]; from assistant.project.workers import serve; serve()"
)
ENDED: Final = 5.0
"""Seconds in which all processes have to end after their last answer; then they are killed."""


def at_once(
    function: Callable[[A], B], arguments: Sequence[A], count: int, lost: Callable[[A], B]
) -> list[B]:
    """What it gives for each, in as many processes. function: of a module, found by its name.

    lost: answers in place of a process that died; only the argument that it was at is lost.
    """
    workers: queue.SimpleQueue[_Worker[A, B]] = queue.SimpleQueue()
    there = [_Worker(function, lost) for _ in range(count)]
    for one in there:
        workers.put(one)

    def answered(argument: A) -> B:
        worker = workers.get()
        try:
            return worker.answered(argument)
        finally:
            workers.put(worker)

    try:
        with ThreadPoolExecutor(count) as threads:
            try:
                return list(threads.map(answered, arguments))
            except BaseException:  # Ctrl-C as well: threads wait for their answers
                threads.shutdown(wait=False, cancel_futures=True)
                for one in there:
                    one.kill()
                raise
    finally:
        for one in there:
            one.dismiss()
        deadline = time.monotonic() + ENDED
        for one in there:
            one.end(deadline)


class _Worker(Generic[A, B]):
    """A process that answers one argument after another; a new one replaces it if it dies."""

    def __init__(self, function: Callable[[A], B], lost: Callable[[A], B]) -> None:
        self._function, self._lost = function, lost
        self._process: subprocess.Popen[bytes] | None = None

    def _begin(self) -> subprocess.Popen[bytes]:
        return subprocess.Popen(  # noqa: S603
            [sys.executable, "-c", WORKER_SCRIPT, *sys.path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=without_passwords(),
        )

    def answered(self, argument: A) -> B:
        asked = pickle.dumps((self._function, argument))
        try:
            self._process = self._process or self._begin()
            to, answers = self._process.stdin, self._process.stdout
            assert to is not None
            assert answers is not None
            to.write(asked)
            to.flush()
            answer: B = pickle.load(answers)  # noqa: S301 (of a process of ours)
        except (OSError, EOFError, pickle.UnpicklingError):
            self.kill()
            self.end(time.monotonic() + ENDED)
            self._process = None
            return self._lost(argument)
        return answer

    def kill(self) -> None:
        if self._process is not None:
            self._process.kill()

    def dismiss(self) -> None:
        """Close the questions of the process, at which it ends."""
        if self._process is not None and self._process.stdin is not None:
            with contextlib.suppress(OSError):
                self._process.stdin.close()

    def end(self, deadline: float) -> None:
        """Wait for the process to end; kill it at the deadline, which loses no answer."""
        if self._process is None:
            return
        self.dismiss()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(max(0.0, deadline - time.monotonic()))
        self._process.kill()
        self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()


def serve() -> None:
    """Answers what comes on standard input until it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who asked ends this process
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    _answer_requests(sys.stdin.buffer, answers)


def _answer_requests(questions: BinaryIO, answers: BinaryIO) -> None:
    while True:
        try:
            function, argument = pickle.load(questions)  # noqa: S301 (of who started this one)
        except EOFError:
            return
        answers.write(pickle.dumps(function(argument)))
        answers.flush()
