"""Worker processes: each answers one request after another; a pool asks several at once.

A worker imports nothing of the process that asks, so that a script or notebook needs no guard; it
gets no password, and ends with the process that asks. `concurrent.futures` promises none of these:
it imports the script, hands on the environment, and loses all that is unfinished if a worker dies.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from contextvars import ContextVar
from typing import Any, Final, Protocol, TypeVar

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, error

A = TypeVar("A")
B = TypeVar("B")

VARIABLE_PREFIX: Final = "ROBOT_ASSISTANT_"
"""Beginning of the environment variables of this program."""
_SCRIPT: Final = (
    "import sys; sys.path[:] = sys.argv[1:]; "
    "from assistant.base.worker_processes import serve; serve()"
)


def without_passwords(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """The environment for another process, which has no business with controllers."""
    return {
        name: value
        for name, value in environment.items()
        if not (name.upper().startswith(VARIABLE_PREFIX) and name.upper().endswith("PASSWORD"))
    }


DIED: Final = error(
    "LM008",
    "the process that worked on it ended without an answer, twice: {reason}",
    "look whether there is memory enough, or use `--jobs 1`",
)
_LAST_WAIT: Final = 1.0
"""Seconds that a process without an answer has to end, so that its exit status is known."""


class WorkerDied(Exception):
    """The process died at a request, or cannot be started; its text says how.

    exit_status: of a command whose program has no answer for that.
    """

    exit_status = 2

    def finding(self, **place: Any) -> Diagnostic:
        """The finding about what has no answer. place: where."""
        return DIED(reason=str(self), **place)


@dataclass(frozen=True, slots=True)
class _Failed:
    """The answer of a function that raised an error."""

    error: OSError


class Worker:
    """A process that starts with the first request, and anew after it died.

    errors: its standard error, as `subprocess` takes it. What functions print goes there, too.
    """

    def __init__(self, errors: int | None = None) -> None:
        self._errors = errors
        self._closed = False
        self._process: subprocess.Popen[bytes] | None = None

    def answer(self, function: Callable[[A], B], argument: A) -> B:
        """Return the result of a module's function; raise WorkerDied if the process dies at it, and
        an OSError that the function raised.

        One request at a time.
        """
        # Not in the `try`: an argument that cannot be pickled is no death of the process.
        request = pickle.dumps((function, argument))
        try:
            process = self._started()
            assert process.stdin is not None
            assert process.stdout is not None
            process.stdin.write(request)
            process.stdin.flush()
            result: B | _Failed = pickle.load(process.stdout)  # noqa: S301 (of a process of ours)
        except (OSError, EOFError, ValueError, pickle.UnpicklingError) as error:
            why = _end_of(self._process) or str(error) or "it was closed"
            self._end()
            raise WorkerDied(why) from error
        if isinstance(result, _Failed):
            raise result.error
        return result

    def close(self) -> None:
        """Kill the process for good, from any thread; a pending request raises WorkerDied."""
        self._closed = True
        self._end()

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is None and not self._closed:
            self._process = subprocess.Popen(  # noqa: S603 (ourselves)
                [sys.executable, "-c", _SCRIPT, *sys.path],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                env=without_passwords(),
            )
        if self._process is None or self._closed:  # perhaps while the process started
            raise EOFError
        return self._process

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            # Leaving the context of the process closes its pipes and reaps it.
            with contextlib.suppress(OSError), process:
                process.kill()


def ended_by(status: int) -> str:
    """How a process ended, by its `returncode`."""
    if status >= 0:
        return f"exit status {status}"
    names = {one.value: one.name for one in signal.Signals}
    return f"signal {names.get(-status, -status)}"


def _end_of(process: subprocess.Popen[bytes] | None) -> str:
    """How a process ended, empty if it was not there or does not end."""
    if process is not None:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return ended_by(process.wait(_LAST_WAIT))
    return ""


MANY: Final = 20
"""Items above which all processors are used without being asked: processes take time to start."""


def process_count(items: int, jobs: int | None) -> int:
    """Return how many processes carry out so many items. jobs: that the user asked for, if any."""
    if jobs is None:
        jobs = (os.cpu_count() or 1) if items > MANY else 1
    return max(1, min(items, jobs))


class Pool(Protocol):
    """Workers that share calls: processes of this computer, or of others."""

    def answers(
        self,
        function: Callable[[A], B],
        arguments: Sequence[A],
        lost: Callable[[A, WorkerDied], B],
    ) -> list[B]:
        """Return the results of a module's function, in order.

        An argument at which a process dies is tried once more when all others are done, alone:
        perhaps there was no memory for several. lost: answers in place of a process that died
        again. Raises the first OSError of the function.
        """


IN_USE: Final[ContextVar[Pool | None]] = ContextVar("pool", default=None)
"""The pool of this context, if one was chosen."""


def pool_of(items: int, jobs: int | None) -> Pool | None:
    """Return the pool for so many items, None if this process does the work.

    jobs: processes that the user asked for, if any; one is this.
    """
    other = IN_USE.get()
    if other is not None and items and jobs != 1:
        return other
    count = process_count(items, jobs)
    return Processes(count) if count > 1 else None


@dataclass(frozen=True, slots=True)
class Processes:
    """Processes of this computer, started for the work."""

    count: int

    def answers(
        self,
        function: Callable[[A], B],
        arguments: Sequence[A],
        lost: Callable[[A, WorkerDied], B],
    ) -> list[B]:
        """See `Pool.answers`."""
        from concurrent.futures import ThreadPoolExecutor

        workers = [Worker() for _ in range(self.count)]
        idle = queue.SimpleQueue[Worker]()
        for one in workers:
            idle.put(one)

        def answer(argument: A) -> B | WorkerDied:
            worker = idle.get()
            try:
                return worker.answer(function, argument)
            except WorkerDied as died:
                return died
            finally:
                idle.put(worker)

        def answer_alone(argument: A) -> B:
            found = answer(argument)
            return lost(argument, found) if isinstance(found, WorkerDied) else found

        with ThreadPoolExecutor(self.count) as threads:
            try:
                first = list(threads.map(answer, arguments))
                return [
                    answer_alone(argument) if isinstance(found, WorkerDied) else found
                    for argument, found in zip(arguments, first, strict=True)
                ]
            finally:  # after Ctrl-C, threads still wait for answers
                threads.shutdown(wait=False, cancel_futures=True)
                for one in workers:
                    one.close()


def serve() -> None:
    """Answer requests on standard input until it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who asked ends this process
    requests, answers = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no answer
    while True:
        try:
            function, argument = pickle.load(requests)  # noqa: S301 (of who started this one)
        except (EOFError, OSError):
            return  # who asked has ended
        try:
            result = function(argument)
        except OSError as error:
            result = _Failed(error)
        answer = pickle.dumps(result)
        with contextlib.suppress(OSError):  # the next reading ends the loop
            answers.write(answer)
            answers.flush()
