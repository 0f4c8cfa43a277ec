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
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import BinaryIO, Final, Generic, TypeVar

from assistant.controllers.credentials import without_passwords

A = TypeVar("A")
B = TypeVar("B")

SERVE: Final = (
    "import sys; sys.path[:] = sys.argv[1:]; from assistant.project.workers import serve; serve()"
)
ENDED: Final = 5.0
"""Seconds for a process to end that was told so."""


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
            one.end()


class _Worker(Generic[A, B]):
    """A process that answers one argument after another."""

    def __init__(self, function: Callable[[A], B], lost: Callable[[A], B]) -> None:
        self._function, self._lost = function, lost
        self._begin()

    def _begin(self) -> None:
        self._process = subprocess.Popen(  # noqa: S603
            [sys.executable, "-c", SERVE, *sys.path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=without_passwords(),
        )

    def answered(self, argument: A) -> B:
        to, answers = self._process.stdin, self._process.stdout
        assert to is not None
        assert answers is not None
        try:
            to.write(pickle.dumps((self._function, argument)))
            to.flush()
            answer: B = pickle.load(answers)  # noqa: S301 (of a process of ours)
        except (OSError, EOFError, pickle.UnpicklingError):
            self.end()
            self._begin()
            return self._lost(argument)
        return answer

    def kill(self) -> None:
        self._process.kill()

    def end(self) -> None:
        """The process ends when nobody asks any more."""
        with contextlib.suppress(OSError):
            self._process.communicate(timeout=ENDED)
        self._process.kill()
        self._process.wait()


def serve() -> None:
    """Answers what comes on standard input until it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who asked ends this process
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    _serve(sys.stdin.buffer, answers)


def _serve(questions: BinaryIO, answers: BinaryIO) -> None:
    while True:
        try:
            function, argument = pickle.load(questions)  # noqa: S301 (of who started this one)
        except EOFError:
            return
        answers.write(pickle.dumps(function(argument)))
        answers.flush()
