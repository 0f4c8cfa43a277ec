"""A cluster of computers: the same answers as from processes here, by the library Dask.

    with on(client):
        check_files(paths)

Each worker of the cluster starts processes for the work, so that a process that dies is no lost
worker, and nothing that the work does touches the worker. The files stay here:
workers get those that are read, see `mirrored_files`. A call travels as bytes that only processes
of the same version open.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import logging
import os
import platform
import queue
import secrets
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import field, replace
from functools import cache
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final, TypeVar
from weakref import WeakValueDictionary

from assistant import __version__
from assistant.base import mirrored_files
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error
from assistant.base.installation import missing_extra
from assistant.base.mirrored_files import Answered, Call, NotMirrored, Packed, Part, SentFiles
from assistant.base.worker_processes import IN_USE, Worker, WorkerDied

if TYPE_CHECKING:
    from distributed import Client, Future

A = TypeVar("A")
B = TypeVar("B")

NO_DASK: Final = missing_extra(
    "LM009", "work on a cluster needs dask.distributed: {reason}", "cluster"
)
NO_SCHEDULER: Final = error(
    "LM010",
    "no scheduler of Dask answers at {address}: {reason}",
    "look whether it runs and can be reached; for TLS, Dask's own configuration names the files",
)
NO_WORKERS: Final = error(
    "LM011", "the cluster has no worker", "start some, such as `dask worker HOST:PORT`"
)
OTHER_VERSION: Final = error(
    "LM012",
    "the {part} has another version than here: {differences}",
    "install the same there as here, and start it again",
)
CLUSTER_LOST: Final = error(
    "LM013",
    "the cluster was lost before this was done: {reason}",
    "give the command once more when the cluster is back, or use `--jobs`",
)
NOT_ON_WINDOWS: Final = error(
    "LM014", "a cluster cannot be used from Windows", "use `--jobs` to share the work"
)
SCHEME: Final = "dask://"
_CONNECT_WITHIN: Final = 10.0
"""Seconds for a scheduler to answer."""
_LOOK: Final = 1.0
"""Seconds between two looks at the cluster while nothing comes from it."""
_WORKERS_WITHIN: Final = 30.0
"""Seconds without any worker after which none is waited for."""
_AHEAD: Final = 2
"""Calls for each thread of the cluster that are sent before others are answered."""
_MOST_TRIES: Final = 100
"""Times that a call is sent, each time with more files; then it is done here."""
_MOST_CHECKS: Final = 3
"""Times that all workers may die while they are asked for their versions."""
_MOST_LOSSES: Final = 5
"""Times that an answer may be lost on its way."""
_IDLE: Final = 60.0
"""Seconds after which a process on a worker that is asked nothing ends."""
_NO_ANSWER: Final = "its scheduler does not answer any more"
_LOGGERS: Final = ("distributed", "distributed.client", "tornado", "tornado.application")
"""Loggers to which Dask gives handlers."""
_LIBRARIES: Final = ("ezdxf", "numpy", "shapely")
"""Libraries whose versions show in what is computed."""


class ClusterLost(WorkerDied):
    """The cluster is gone; what it has answered is kept."""

    exit_status = 1

    def finding(self, **place: Any) -> Diagnostic:
        return CLUSTER_LOST(reason=str(self), **place)


@cache
def versions() -> dict[str, str]:
    """Versions that two computers must share to give the same bytes."""
    found = {"robot-assistant": f"{__version__} ({_digest()})"}
    found["Python"] = ".".join(map(str, sys.version_info[:2]))
    found["system"] = f"{platform.system()} {platform.machine()}"
    for name in _LIBRARIES:
        with suppress(importlib.metadata.PackageNotFoundError):
            found[name] = importlib.metadata.version(name)
    return found


def _digest() -> str:
    """A digest of the program's own files: copies of one version may differ."""
    package = FilePath(__file__).parent.parent
    files = sorted(one for suffix in ("py", "toml") for one in package.rglob(f"*.{suffix}"))
    total = hashlib.sha256()
    for file in files:
        name = file.relative_to(package).as_posix()
        if not name.startswith(("grammars/", "templates/", "samples/")):
            total.update(f"{name}\0".encode() + file.read_bytes() + b"\0")
    return total.hexdigest()[:8]


def differences(other: Mapping[str, str]) -> str:
    """Name the versions that differ on another computer; empty if none do."""
    here = versions()
    names = [name for name in here if other.get(name) != here[name]]
    return ", ".join(f"{name} {other.get(name, 'is missing')}, here {here[name]}" for name in names)


@contextmanager
def on(client: Client) -> Iterator[None]:
    """Have a cluster of Dask check the files that `check` is given inside.

    client: of `dask.distributed`. Files that are read are sent to the workers. Raises Refused if
    scheduler or workers have another version of this package, of Python or of its libraries.
    """
    _require_posix()
    cluster = Cluster(client)
    cluster.check()
    before = IN_USE.set(cluster)
    try:
        yield
    finally:
        IN_USE.reset(before)


@contextmanager
def on_address(address: str, jobs: int | None = None) -> Iterator[None]:
    """The same for a scheduler's address, `dask://HOST:PORT`; `dask` is a cluster in this process.

    jobs: workers of a cluster in this process, default one for each processor. Raises Refused if
    there is none, if Dask is not installed, and if the versions differ.
    """
    _require_posix()
    try:
        import dask
        import distributed
    except ImportError as missing:
        raise Refused(NO_DASK(reason=missing), exit_status=2) from None
    with ExitStack() as held:
        held.enter_context(_quiet())
        if address.startswith(SCHEME):
            client = held.enter_context(_connected(address))
        else:
            # Messages stay within this process; Dask's ports on 127.0.0.1 have no pages.
            routes: dict[str, Any] = {
                f"distributed.{one}.http.routes": [] for one in ("scheduler", "worker")
            }
            held.enter_context(dask.config.set(routes))
            cluster = distributed.LocalCluster(
                n_workers=jobs or os.cpu_count() or 1,
                threads_per_worker=1,
                processes=False,
                memory_limit=0,
                dashboard_address="127.0.0.1:0",
                scheduler_kwargs={"dashboard": False},
                worker_dashboard_address="127.0.0.1:0",
            )
            held.enter_context(cluster)
            client = held.enter_context(distributed.Client(cluster, set_as_default=False))
        held.enter_context(on(client))
        yield


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence the logs of the libraries inside: findings report what goes wrong."""
    handlers = [one for name in _LOGGERS for one in logging.getLogger(name).handlers]
    levels = [one.level for one in handlers]
    try:
        for one in handlers:
            one.setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for one, level in zip(handlers, levels, strict=True):
            one.setLevel(level)


def _require_posix() -> None:
    if os.name == "nt":
        raise Refused(NOT_ON_WINDOWS(), exit_status=2)


def _connected(address: str) -> Client:
    from distributed import Client
    from distributed.security import Security

    place = address.removeprefix(SCHEME)
    try:
        secured = Security().get_connection_args("client").get("ssl_context")
        return Client(
            f"{'tls' if secured else 'tcp'}://{place}",
            timeout=_CONNECT_WITHIN,
            set_as_default=False,
        )
    except (OSError, ValueError, TypeError, RuntimeError) as fault:
        reason = str(fault).partition("\n")[0] or type(fault).__name__
        raise Refused(NO_SCHEDULER(address=place, reason=reason), exit_status=2) from None


@dataclass(slots=True, eq=False)
class _Sent:
    """A call that is on its way, and how often it went.

    held: what it depends on, which the cluster keeps as long.
    """

    number: int
    packed: Packed
    tries: int = 0
    losses: int = 0
    held: list[Future] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class _Request:
    """A call for a worker; the bytes of its parts come beside it. run: of the client."""

    run: str
    versions: Mapping[str, str]
    call: Call


@dataclass(frozen=True, slots=True)
class _Died:
    reason: str


@dataclass(frozen=True, slots=True)
class _Differs:
    versions: Mapping[str, str]


_Answer = Answered | _Died | _Differs


class Cluster:
    """A cluster that shares work; a `Pool`."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def check(self) -> None:
        """Raise Refused without a worker, or if a part of the cluster has another version."""
        found: dict[str, object] = {}
        with suppress(Exception):
            found["scheduler"] = None
            found["scheduler"] = self._client.run_on_scheduler(versions)
        answers = self._worker_versions()
        found |= {f"worker {name}": answer for name, answer in answers.items()}
        told = [self._difference(name, answer) for name, answer in found.items()]
        if findings := [one for one in told if one is not None]:
            raise Refused(*findings, exit_status=2)
        if not answers:
            raise Refused(NO_WORKERS(), exit_status=2)

    def _worker_versions(self) -> dict[str, object]:
        """The versions of each worker, or its error; none of one that dies meanwhile."""
        for _ in range(_MOST_CHECKS):
            if not self._client.nthreads():
                with suppress(TimeoutError):
                    self._client.wait_for_workers(1, timeout=_CONNECT_WITHIN)
            answers = self._client.run(versions, on_error="return")
            alive = {k: one for k, one in answers.items() if not isinstance(one, OSError)}
            if alive or not answers:
                return alive
        return {}

    @staticmethod
    def _difference(part: str, answer: object) -> Diagnostic | None:
        other = answer if isinstance(answer, Mapping) else {}
        said = differences(other)
        return OTHER_VERSION(part=part, differences=said) if said else None

    def answers(
        self,
        function: Callable[[A], B],
        arguments: Sequence[A],
        lost: Callable[[A, WorkerDied], B],
    ) -> list[B]:
        """See `Pool.answers`. A lost scheduler loses what is not answered yet."""
        import dask

        # Programs and drawings travel as parts of tasks, so that the scheduler has them for
        # another worker if one is lost.
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": "10GB"}):
            work = _Work(self._client, function, arguments)
            try:
                done = work.done()
            finally:
                work.close()
        found: list[B] = []
        for argument, one in zip(arguments, done, strict=True):
            if isinstance(one, WorkerDied):
                found.append(lost(argument, one))
            elif one is None:
                found.append(function(argument))
            else:
                found.append(mirrored_files.result_of(one))
        return found


class _Work:
    """The calls of a function with several arguments, on their way to a cluster and back."""

    def __init__(self, client: Client, function: Callable[[A], B], arguments: Sequence[A]) -> None:
        self._client = client
        self._run = secrets.token_hex(8)
        self._files = SentFiles()
        self._waiting = deque(
            _Sent(number, self._files.packed(function, argument))
            for number, argument in enumerate(arguments)
        )
        self._found: list[bytes | WorkerDied | None] = [None] * len(arguments)
        self._running: dict[Future, _Sent] = {}
        self._ended = queue.SimpleQueue[Any]()
        self._parts: WeakValueDictionary[str, Future] = WeakValueDictionary()

    def done(self) -> list[bytes | WorkerDied | None]:
        """Results, what they ended by, or None for what has to be done here."""
        died = deque[_Sent]()
        try:
            self._carry_out(_AHEAD * sum(self._client.nthreads().values()), died)
            while died:
                self._waiting.append(died.popleft())
                self._carry_out(1, deque[_Sent]())
        except (ClusterLost, OSError) as fault:
            gone = fault if isinstance(fault, ClusterLost) else ClusterLost(_NO_ANSWER)
            for one in (*self._waiting, *self._running.values(), *died):
                self._found[one.number] = gone
        return self._found

    def close(self) -> None:
        """Take back what is still on its way, and end the processes on the workers."""
        with suppress(Exception):
            if self._client.status == "running":
                self._client.cancel(list(self._running), force=True)
                self._client.run(end_processes, self._run, on_error="ignore")

    def _carry_out(self, most: int, died: deque[_Sent]) -> None:
        """Send what waits, so much at a time, until all is answered. died: is given what died."""
        while self._waiting or self._running:
            while self._waiting and len(self._running) < max(1, most):
                self._require_connection()
                self._send(self._waiting[0])
                self._waiting.popleft()
            if self._running:
                sent, answer = self._next()
                sent.held = []
                self._note(sent, answer, died)

    def _note(self, sent: _Sent, answer: _Answer | None, died: deque[_Sent]) -> None:
        if answer is None and sent.losses < _MOST_LOSSES:
            sent.losses += 1
            self._waiting.appendleft(sent)
        elif answer is None or isinstance(answer, _Died):
            reason = "its answer was lost again and again" if answer is None else answer.reason
            self._found[sent.number] = WorkerDied(reason)
            died.append(sent)
        elif isinstance(answer, _Differs):
            said = differences(answer.versions)
            raise Refused(OTHER_VERSION(part="worker", differences=said), exit_status=2)
        elif answer.result is not None:
            self._found[sent.number] = answer.result
        elif sent.tries < _MOST_TRIES and self._files.learn(sent.packed, answer.wants):
            self._waiting.appendleft(sent)
        else:
            self._found[sent.number] = None

    def _send(self, sent: _Sent) -> None:
        try:
            call = self._files.call(sent.packed)
        except NotMirrored:
            self._found[sent.number] = None  # it is done here
            return
        sent.tries += 1
        sent.held = [self._part(part) for part in call.parts]
        bare = replace(call, parts=[replace(part, data=b"") for part in call.parts])
        future = self._client.submit(
            carry_out,
            _Request(self._run, versions(), bare),
            sent.held,
            key=f"robot-assistant-{self._run}-{sent.number}-{sent.tries}-{sent.losses}",
            pure=False,
        )
        self._running[future] = sent
        future.add_done_callback(self._ended.put)

    def _part(self, part: Part) -> Future:
        key = f"robot-assistant-{self._run}-{part.key}"
        there = self._parts.get(key)
        if there is None or there.status in ("cancelled", "lost"):
            there = self._parts[key] = self._client.submit(bytes, part.data, key=key)
        return there

    def _next(self) -> tuple[_Sent, _Answer | None]:
        """Wait for the next answer, None for one that was lost; raises ClusterLost."""
        alone = time.monotonic()
        while True:
            self._require_connection()
            try:
                future = self._ended.get(timeout=_LOOK)
            except queue.Empty:
                if self._client.nthreads():
                    alone = time.monotonic()
                elif time.monotonic() - alone > _WORKERS_WITHIN:
                    raise ClusterLost("it has no worker any more") from None
                continue
            if future in self._running:
                answer = self._answer_of(future)
                return self._running.pop(future), answer

    def _require_connection(self) -> None:
        if self._client.status != "running":
            raise ClusterLost(_NO_ANSWER)

    def _answer_of(self, future: Future) -> _Answer | None:
        """The answer, None if it is to be asked for again; raises ClusterLost."""
        try:
            if future.status == "finished":
                found = future.result()
                assert isinstance(found, Answered | _Died | _Differs)
                return found
            if future.status == "error":
                fault = future.exception()
                return _Died(str(fault).partition("\n")[0] or type(fault).__name__)
        except Exception:  # noqa: BLE001 (whatever a lost connection ends in)
            self._require_connection()
        return None


# The side of the workers.


@dataclass(slots=True)
class _Process:
    """A process of a worker with its mirror; held: what that has, by path and key."""

    worker: Worker
    folder: tempfile.TemporaryDirectory[str]
    held: set[tuple[object, str]] = field(default_factory=set)
    idle: bool = False
    used: int = 0

    def close(self) -> None:
        self.worker.close()
        with suppress(OSError):
            self.folder.cleanup()


_LOCK: Final = threading.Lock()
_PROCESSES: Final[dict[str, list[_Process]]] = {}
"""Processes by the run of the client that they work for."""


def carry_out(request: _Request, data: Sequence[bytes]) -> _Answer:
    """Do the work of a request in a process of this worker."""
    if request.versions != versions():
        return _Differs(versions())
    process = _take(request.run)
    parts = [
        replace(part, data=b"" if (part.want, part.key) in process.held else octets)
        for part, octets in zip(request.call.parts, data, strict=True)
    ]
    call = replace(request.call, parts=parts)
    try:
        found = process.worker.answer(mirrored_files.answer, (process.folder.name, call))
        process.held |= {(part.want, part.key) for part in parts}
    except (WorkerDied, OSError) as died:
        _drop(request.run, process)
        return _Died(str(died))
    _give_back(request.run, process)
    return found


def _take(run: str) -> _Process:
    with _LOCK:
        for one in _PROCESSES.setdefault(run, []):
            if one.idle:
                one.idle = False
                return one
        folder = tempfile.TemporaryDirectory(
            prefix="robot-assistant-", dir=_folder(), ignore_cleanup_errors=True
        )
        made = _Process(Worker(), folder)
        _PROCESSES[run].append(made)
        return made


def _folder() -> str | None:
    """The folder that the worker may write to; Dask removes what killed ones have left there."""
    from distributed import get_worker

    with suppress(ValueError):
        return str(get_worker().local_directory)
    return None


def _give_back(run: str, process: _Process) -> None:
    """Keep a process for the next request of its client, for some time."""
    process.used += 1
    process.idle = True
    used = process.used

    def end() -> None:
        with _LOCK:
            unused = process.idle and process.used == used
            process.idle = False if unused else process.idle
        if unused:
            _drop(run, process)

    timer = threading.Timer(_IDLE, end)
    timer.daemon = True
    timer.start()


def _drop(run: str, process: _Process) -> None:
    with _LOCK:
        of_run = _PROCESSES.get(run, [])
        if process in of_run:
            of_run.remove(process)
    process.close()


def end_processes(run: str) -> None:
    """End the processes that work for a client."""
    with _LOCK:
        ended = _PROCESSES.pop(run, [])
    for one in ended:
        one.close()
