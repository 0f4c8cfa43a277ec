"""Virtual controllers of a project: each runs as long as a command needs it.

`.robot-assistant/virtual/<name>/` holds what a real controller keeps when it is switched off: HOME:
and the program memory of an IRC5, the programs of a CR. One process has a controller at a time.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.base.file_access import read_file, write_whole
from assistant.base.termination import defer_termination
from assistant.controllers import Credentials, Named, Programs, connect
from assistant.project import rules

if TYPE_CHECKING:
    from assistant.virtual.irc5.programs import Programs as Memory


_VIRTUAL_FOLDER: Final = "virtual"
_HOME_FOLDER: Final = "home"
_MEMORY_FILE: Final = "memory.json"
_PROGRAM_FOLDER: Final = "programs"
_LOCK_FILE: Final = "lock"
_LOCK_TIMEOUT: Final = 30.0
"""Seconds for which another command may have the controller."""
_MEMORY_ENCODING: Final = "utf-8"
Clients = Callable[[], Programs]
"""Gives a client, not connected yet, each time."""
_Starter = Callable[[Named, FilePath, float | None], AbstractContextManager[Clients]]


@contextmanager
def running_client(
    controller: Named, kept: FilePath, *, timeout: float | None = None
) -> Iterator[Programs]:
    """A client, not connected yet, of a virtual controller that runs inside; see `clients`."""
    with running_clients(controller, kept, timeout=timeout) as client:
        yield client()


@contextmanager
def running_clients(
    controller: Named, kept: FilePath, *, timeout: float | None = None
) -> Iterator[Clients]:
    """Yield a factory of clients for a virtual controller that runs inside the context.

    kept: `.robot-assistant` of the project. timeout: of each client. Raises Refused. It ends in the
    thread in which it began.
    """
    from filelock import FileLock, Timeout

    assert controller.virtual is not None
    folder = kept / _VIRTUAL_FOLDER / controller.name
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / _LOCK_FILE, timeout=_LOCK_TIMEOUT)
        lock.acquire()
    except Timeout:
        finding = rules.BUSY(place=controller.name, name=controller.name)
        raise Refused(finding, exit_status=2) from None
    except OSError as error:
        raise _not_started(controller, error.strerror or str(error)) from None
    try:
        with _STARTERS[controller.virtual](controller, folder, timeout) as client:
            yield client
    finally:
        lock.release()


@contextmanager
def _start_irc5(controller: Named, folder: FilePath, timeout: float | None) -> Iterator[Clients]:
    from assistant.virtual.irc5 import VirtualIrc5

    arm, home = _robot_of(controller), folder / _HOME_FOLDER
    virtual = (
        VirtualIrc5(home, rwss=None) if arm is None else VirtualIrc5(home, robot=arm, rwss=None)
    )
    _start(controller, virtual.start)
    try:
        virtual.cabinet.serial = controller.serial or ""
        virtual.cabinet.do(lambda memory: _load_memory(memory, folder / _MEMORY_FILE))
        try:
            login = Credentials(virtual.user, virtual.password)
            yield partial(_client, controller, virtual.rws_port, timeout, login)
        finally:
            # What programs have made of their data since a module was last taken in.
            with defer_termination():
                virtual.cabinet.do(lambda memory: _save_memory(memory, folder / _MEMORY_FILE))
    finally:
        with defer_termination():
            virtual.stop()


@contextmanager
def _start_cr(controller: Named, folder: FilePath, timeout: float | None) -> Iterator[Clients]:
    from assistant.virtual.cr import VirtualCr

    arm, programs = _robot_of(controller), folder / _PROGRAM_FOLDER
    try:
        virtual = VirtualCr(folder=programs) if arm is None else VirtualCr(arm, folder=programs)
    except (ValueError, OSError) as error:
        raise _not_started(controller, str(error)) from None
    _start(controller, virtual.start)
    try:
        yield partial(_client, controller, virtual.port, timeout)
    finally:
        with defer_termination():
            virtual.stop()


_STARTERS: Final[dict[str, _Starter]] = {"irc5": _start_irc5, "cr": _start_cr}


def _robot_of(controller: Named) -> str | None:
    """Return the robot that the controller moves, None for its default robot."""
    known = {name.lower(): name for name in robots.names()}
    if controller.robot is None or controller.robot.lower() in known:
        return None if controller.robot is None else known[controller.robot.lower()]
    raise _not_started(controller, f"`{controller.robot}` is no robot of the catalogue")


def _start(controller: Named, start: Callable[[], None]) -> None:
    try:
        start()
    except (OSError, ImportError) as error:
        raise _not_started(controller, str(error)) from None


def _client(
    controller: Named, port: int, timeout: float | None, login: Credentials | None = None
) -> Programs:
    there = replace(controller, address=replace(controller.address, port=port), virtual=None)
    return connect(there, credentials=login, timeout=timeout)


def _not_started(controller: Named, reason: str) -> Refused:
    finding = rules.NOT_STARTED(place=controller.name, name=controller.name, reason=reason)
    return Refused(finding, exit_status=2)


# ------------------------------------------------------------------------------ program memory


def _save_memory(memory: Memory, file: FilePath) -> None:
    """The modules in memory, with the values that their data have now."""
    rows = [
        {"name": one.name, "file": one.file, "text": memory.text(one)}
        for one in memory.modules.values()
    ]
    with suppress(OSError):  # the disk is full: it is loaded again the next time
        write_whole(file, (json.dumps(rows, indent=1) + "\n").encode())


def _load_memory(memory: Memory, file: FilePath) -> None:
    """Load the memory contents of the last run, even if it crashed; ignore a damaged file."""
    from assistant.virtual.irc5.programs import NotPossible, read_module

    with suppress(OSError, ValueError, KeyError, TypeError, NotPossible):
        rows = json.loads(read_file(file))
        texts = [(str(row["file"]), str(row["text"]).encode(_MEMORY_ENCODING)) for row in rows]
        memory.restore([one for name, text in texts for one in read_module(name, text)])
    # Set last, so that restoring does not write the file.
    memory.keep = lambda changed: _save_memory(changed, file)
