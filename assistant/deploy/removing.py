"""Programs that may be deleted from a controller: files that nothing on it has loaded."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from assistant.controllers import Controller, Programs
from assistant.controllers.abb.files import TEXTS
from assistant.controllers.abilities import Disk, Memory
from assistant.deploy import resting, rules
from assistant.program.diagnostics import Diagnostic, Refused


def found_there(session: Programs, names: Sequence[str]) -> dict[str, str | None]:
    """The names as the controller writes them, None for a program that it does not have."""
    there = {name.lower(): name for name in session.names()}
    return {name: there.get(name.lower()) for name in names}


def check_removable(session: Programs, names: Sequence[str]) -> None:
    """Raise Refused with all that keeps programs from being deleted.

    Folders are never deleted. A program is in use if it is loaded, runs, or is called by one that
    runs; a session of files alone cannot report that.
    """
    found = [finding for name in names for finding in _hindrances(session, name)]
    if not found and isinstance(session, Controller):
        found = [*_in_use(session, session, names)]
    if found:
        raise Refused(*found)


def unseen(session: Programs, names: Sequence[str]) -> list[Diagnostic]:
    """A warning for each program of which a session of files alone cannot report its use."""
    if isinstance(session, Controller):
        return []
    programs = [name for name in names if name.lower().endswith(TEXTS)]
    return [rules.LOADED_UNSEEN(place=name, name=name) for name in programs]


def _hindrances(session: Programs, name: str) -> Iterator[Diagnostic]:
    if isinstance(session, Disk) and session.is_folder(name):
        yield rules.IS_FOLDER(place=name, name=name)


def _in_use(
    session: Programs, controller: Controller, names: Sequence[str]
) -> Iterator[Diagnostic]:
    if isinstance(session, Memory):
        for name in names:
            module = session.module(session.read(name) or b"")
            homes = session.homes(module) if module is not None else ()
            if homes:
                reason = f"its module `{module}` is loaded in the task `{homes[0]}`"
                yield rules.IN_USE(place=name, name=name, reason=reason)
        return
    users: dict[str, str] = {}
    for task in controller.state().tasks:
        if not task.program:
            continue
        does = "runs" if task.running else "is loaded"
        users.setdefault(resting.stem(task.program), f"it {does} in slot {task.name}")
        if task.running and not all(resting.stem(name) in users for name in names):
            reason = f"`{task.program}` runs, which uses it"
            for used in resting.with_called(session, session.languages[0], task.program):
                users.setdefault(used, reason)
    for name in names:
        if resting.stem(name) in users:
            yield rules.IN_USE(place=name, name=name, reason=users[resting.stem(name)])
