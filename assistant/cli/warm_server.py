"""A warm server: it loads this program once, and a fork of it runs each command.

The server listens on a socket in its user's folder. It ends after some time without commands, when
a file of the program changes, or when its socket is removed. It runs no command of a user itself,
so that each fork starts like a new process and reads the user's files anew.
"""

from __future__ import annotations

import atexit
import fcntl
import gc
import io
import os
import select
import signal
import socket
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, chdir, suppress
from pathlib import Path
from typing import Final, Never

from assistant.cli.command_line import run, settle_in
from assistant.cli.warm_client import COMPLETE, STATUS_BYTES
from assistant.resources import resource

_IDLE: Final = 900.0
"""Seconds without a command after which a server ends."""
_LOOK: Final = 30.0
"""Seconds between two looks at the socket and at the time."""
_FLUSH_FAILED: Final = 120
"""Exit status of Python where the last output could not be written."""
_SAMPLES: Final = (
    ("check", "rapid/pick_and_place.mod"),
    ("check", "melfa/PALLET.prg"),
    ("fmt", "rapid/pick_and_place.mod", "--check"),
    ("translate", "rapid/pick_and_place.mod", "--to", "melfa-basic-6", "-o", "{folder}/to_melfa"),
    ("translate", "melfa/PALLET.prg", "--to", "rapid", "-o", "{folder}/to_rapid"),
    ("compile", "plate.dxf", "-l", "rapid", "-r", "irb1200-7-0.7", "-o", "{folder}/drawing"),
    ("simulate", "plate.dxf", "-r", "irb1200-7-0.7"),
    ("explain", "RA102"),
    ("robots", "show", "irb1200-7-0.7"),
)
"""Commands that load the modules and tables that most commands use."""


def serve(place: str, idle: float = _IDLE) -> None:
    """Serve on a socket until no command comes for a time; return at once if another server does.

    place: path of the socket. idle: seconds.
    """
    began = time.time()
    with ExitStack() as held:
        lock = held.enter_context(Path(f"{place}.lock").open("w"))
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return
        files = _files_of_package()
        _load()
        files |= _files_of_modules()
        if max(changed for changed, _ in files.values()) > began * 1e9:
            return
        Path(place).unlink(missing_ok=True)
        listening = held.enter_context(socket.socket(socket.AF_UNIX))
        listening.bind(place)
        held.callback(Path(place).unlink, missing_ok=True)
        listening.listen(64)
        _Server(place, listening, files, idle).answer()


def _load() -> None:
    """Load what commands use by running some of them on samples."""
    with tempfile.TemporaryDirectory() as folder, chdir(folder):  # where no project is
        for name, *words in _SAMPLES:
            given = [word.format(folder=folder) for word in words]
            if "." in given[0]:
                given[0] = str(resource("samples", given[0]))
            with suppress(SystemExit):
                run([name, *given])
    sys.stdout.flush()
    sys.stderr.flush()
    gc.collect()
    gc.freeze()


Files = dict[str, tuple[float, int]]
"""Path → when the file changed (ns since 1970) and its size in bytes."""


def _files_of_package() -> Files:
    """The files of this program, those that are read later too."""
    package = Path(__file__).parent.parent
    folders = [package, *(package.parent / name for name in ("grammars", "templates", "samples"))]
    return dict(found for folder in folders for found in _files_below(str(folder)))


def _files_below(folder: str) -> Iterator[tuple[str, tuple[float, int]]]:
    with suppress(FileNotFoundError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name == "__pycache__":
                continue
            if entry.is_dir():
                yield from _files_below(entry.path)
            else:
                found = entry.stat()
                yield entry.path, (found.st_mtime_ns, found.st_size)


def _files_of_modules() -> Files:
    """The files of all modules that are loaded."""
    paths = {str(path) for one in list(sys.modules.values()) if (path := _file_of(one))}
    return {path: state for path in paths if (state := _state_of(path)) is not None}


def _file_of(module: object) -> str | None:
    path = getattr(module, "__file__", None)
    return path if isinstance(path, str) else None


def _state_of(path: str) -> tuple[float, int] | None:
    try:
        found = os.stat(path)  # noqa: PTH116 (a thousand of them)
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


class _Server:
    """Forks for each connection, and sends the exit status of each fork to its client.

    place: path of the socket. files: as they were when they were loaded.
    """

    def __init__(self, place: str, listening: socket.socket, files: Files, idle: float) -> None:
        self._place, self._listening, self._files, self._idle = place, listening, files, idle
        self._serves = True
        self._polled = select.poll()
        self._forks: dict[int, tuple[int, int, socket.socket]] = {}
        """Descriptor of a fork, or of its connection → process number, descriptor, connection."""

    def answer(self) -> None:
        """Serve until no command came for a time and every fork has ended."""
        self._polled.register(self._listening, select.POLLIN)
        asked = time.monotonic()
        while self._serves or self._forks:
            for number, _ in self._polled.poll(1000 * min(_LOOK, self._idle)):
                if number == self._listening.fileno():
                    asked = time.monotonic()
                    self._accept()
                elif number in self._forks:
                    self._attend(number)
            if self._forks:
                asked = time.monotonic()
            elif time.monotonic() - asked >= self._idle or not Path(self._place).exists():
                return

    def _accept(self) -> None:
        connection, _ = self._listening.accept()
        package = _files_of_package()  # with those that are new
        others = {path: _state_of(path) for path in self._files if path not in package}
        now = {**package, **others}
        if now != self._files:
            # The client runs the command with the new program, and starts another server.
            connection.close()
            self._polled.unregister(self._listening)
            self._listening.close()
            self._serves = False
            return
        child = os.fork()
        if child == 0:
            try:
                self._listening.close()
                for _, _, other in self._forks.values():
                    other.close()
                _carry_out(connection)
            except BaseException:  # noqa: BLE001 (a fork never serves)
                sys.excepthook(*sys.exc_info())
            finally:
                os._exit(1)
        running = os.pidfd_open(child)
        for number, events in ((running, select.POLLIN), (connection.fileno(), 0)):
            self._forks[number] = (child, running, connection)
            self._polled.register(number, events)
        _send(connection, child)

    def _attend(self, number: int) -> None:
        """Report a fork that has ended, or end a fork whose client has ended."""
        child, running, connection = self._forks[number]
        if number != running:
            # The descriptor of the fork becomes readable when it has ended.
            os.kill(child, signal.SIGTERM)
            self._polled.unregister(number)
            return
        _, status = os.waitpid(child, 0)
        _send(connection, os.waitstatus_to_exitcode(status))
        for one in (running, connection.fileno()):
            del self._forks[one]
            with suppress(KeyError):
                self._polled.unregister(one)
        os.close(running)
        connection.close()


def _send(connection: socket.socket, number: int) -> None:
    with suppress(OSError):  # the client is gone
        connection.sendall(number.to_bytes(STATUS_BYTES, "little", signed=True))


def _carry_out(connection: socket.socket) -> Never:
    """Run the command of a client in a fork, with its streams, folder and environment, and end."""
    with connection, connection.makefile("rb") as file:
        _, streams, _, _ = socket.recv_fds(connection, 1, 3)
        request = file.read().decode("utf-8", "surrogateescape")
    if not request.endswith(COMPLETE):  # the client is gone, or runs the command
        os._exit(0)
    for stream, number in zip(streams, (0, 1, 2), strict=True):
        os.dup2(stream, number)
        os.close(stream)
    folder, mask, ignored, count, *texts = request.removesuffix(COMPLETE).split("\0")
    words, variables = texts[: int(count)], texts[int(count) :]
    os.chdir(folder)
    os.umask(int(mask))
    for name in ignored.split():
        signal.signal(signal.Signals[name], signal.SIG_IGN)
    os.environ.clear()
    for variable in variables:
        name, _, value = variable.partition("=")
        os.environ[name] = value
    sys.argv = words
    if isinstance(sys.stdout, io.TextIOWrapper):
        # As Python does for a stream that it opens; nothing else depends on what it leads to.
        sys.stdout.reconfigure(line_buffering=sys.stdout.isatty())
    settle_in()
    try:
        run(None)
    except SystemExit as ended:
        _end(ended.code)
    _end(0)


def _end(code: str | int | None) -> Never:
    """End as the interpreter does, but leave objects alone, whose memory is shared."""
    if isinstance(code, str):
        sys.stderr.write(f"{code}\n")
    status = code if isinstance(code, int) else int(code is not None)
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        status = _FLUSH_FAILED
    with suppress(OSError, ValueError):
        sys.stderr.flush()
    os._exit(status & 0xFF)
