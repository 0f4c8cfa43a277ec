"""Check which programs may be deleted from a controller: those that nothing on it uses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import Controller, Programs
from assistant.controllers.abb.files import TEXTS
from assistant.controllers.abilities import Disk, Memory
from assistant.deploy import resting, rules


def found_programs(session: Programs, names: Sequence[str]) -> dict[str, str | None]:
    """Return each name as the controller writes it, None for a program that it does not have."""
    there = {name.lower(): name for name in session.names()}
    return {name: there.get(name.lower()) for name in names}


def check_removable(session: Programs, names: Sequence[str]) -> None:
    """Raise Refused with every reason why programs cannot be deleted.

    Folders are never deleted. A program is in use if it is loaded, runs, or is called by one that
    runs; a session that only transfers files cannot report that.
    """
    found = [
        rules.IS_FOLDER(place=name, name=name)
        for name in names
        if isinstance(session, Disk) and session.is_folder(name)
    ]
    if not found and isinstance(session, Controller):
        found = [*_in_use(session, names)]
    if found:
        raise Refused(*found)


def unseen_use(session: Programs, names: Sequence[str]) -> list[Diagnostic]:
    """Warn of each program whose use a session that only transfers files cannot report."""
    if isinstance(session, Controller):
        return []
    programs = [name for name in names if name.lower().endswith(TEXTS)]
    return [rules.LOADED_UNSEEN(place=name, name=name) for name in programs]


def _in_use(controller: Controller, names: Sequence[str]) -> Iterator[Diagnostic]:
    if isinstance(controller, Memory):
        for name in names:
            module = controller.module(controller.read(name) or b"")
            homes = controller.homes(module) if module is not None else ()
            if homes:
                reason = f"its module `{module}` is loaded in the task `{homes[0]}`"
                yield rules.IN_USE(place=name, name=name, reason=reason)
        return
    users: dict[str, str] = {}
    there = resting.by_stem(controller)
    for task in controller.state().tasks:
        if not task.program:
            continue
        does = "runs" if task.running else "is loaded"
        users.setdefault(resting.program_stem(task.program), f"it {does} in slot {task.name}")
        if task.running and not all(resting.program_stem(name) in users for name in names):
            reason = f"`{task.program}` runs, which uses it"
            for used in resting.with_called(
                controller, controller.languages[0], task.program, there
            ):
                users.setdefault(used, reason)
    for name in names:
        if resting.program_stem(name) in users:
            yield rules.IN_USE(place=name, name=name, reason=users[resting.program_stem(name)])
