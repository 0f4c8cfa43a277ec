"""Programs that run are never replaced, and what became of the program pointers is said."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path as FilePath
from typing import Final

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.source_text import decode
from assistant.controllers import Controller, Programs
from assistant.controllers.states import TaskState
from assistant.deploy import rules
from assistant.deploy.journal import Entry
from assistant.deploy.site import Site

MOST_PROGRAMS: Final = 200
"""That are followed from a running one through its calls."""


def check_not_running(site: Site, entries: Iterable[Entry]) -> None:
    """Raises Refused if a program that would be replaced runs, or one that runs calls it.

    Modules of a task's memory: if that task runs, or any task of the foreground. Where the session
    cannot tell, nothing is refused.
    """
    if not isinstance(site.controller, Controller):
        return
    running = [task for task in site.controller.state().tasks if task.running]
    entries = list(entries)
    busy = _of_memory(site, entries, running) if site.memory else _of_slots(site, entries, running)
    if busy:
        raise Refused(*busy)


def pointers_lost(
    site: Site, before: Iterable[TaskState], *, was_set: bool = False
) -> list[Diagnostic]:
    """A finding for each task that had a program pointer and has none now; nothing is started.

    was_set: whether every one in the foreground counts as set before, where nobody knows any more.
    """
    had = {task.name for task in before if task.line or (was_set and not task.background)}
    return [
        rules.POINTER_LOST(place=task.name, task=task.name)
        for task in tasks(site)
        if task.line is None and task.name in had
    ]


def tasks(site: Site) -> tuple[TaskState, ...]:
    """The tasks of a controller whose modules are in a memory; none of others."""
    if site.memory is None or not isinstance(site.controller, Controller):
        return ()
    return site.controller.state().tasks


def _of_memory(
    site: Site, entries: Iterable[Entry], running: Iterable[TaskState]
) -> list[Diagnostic]:
    own = site.task.lower()
    minding = [t.name for t in running if not t.background or t.name.lower() == own]
    if not minding:
        return []
    reason = f"the task `{minding[0]}` runs"
    return [
        rules.RUNNING(place=entry.name, name=entry.name, reason=reason)
        for entry in entries
        if entry.before.loaded is not None or entry.after.loaded is not None
    ]


def _of_slots(
    site: Site, entries: Iterable[Entry], running: Iterable[TaskState]
) -> list[Diagnostic]:
    users: dict[str, str] = {}
    there = by_stem(site.controller) if running else {}
    for task in running:
        for used in with_called(site.controller, site.language, task.program, there):
            users.setdefault(used, task.program)
    found = []
    for entry in entries:
        used = program_stem(entry.name)
        if used in users:
            user = users[used]
            reason = (
                "it is running" if program_stem(user) == used else f"`{user}` runs, which uses it"
            )
            found.append(rules.RUNNING(place=entry.name, name=entry.name, reason=reason))
    return found


def by_stem(controller: Programs) -> dict[str, str]:
    """Return the programs of a controller by their stems."""
    return {program_stem(name): name for name in controller.names()}


def with_called(
    controller: Programs, language: str, program: str, there: Mapping[str, str]
) -> set[str]:
    """Stems of a program and of all that it calls, or runs beside it, as far as they can be read.

    there: programs of the controller by their stems. A name that a program computes is not seen.
    """
    spoken = languages.get(language)
    open_ones, found = [program], set[str]()
    while open_ones and len(found) < MOST_PROGRAMS:
        used = program_stem(open_ones.pop())
        if used in found:
            continue
        found.add(used)
        data = controller.read(there[used]) if used in there else None
        if data is not None:
            tree = spoken.parse(decode(data, None, (*spoken.encodings, "latin-1")))
            open_ones += (*spoken.called_files(tree), *spoken.companions(tree))
    return found


def program_stem(name: str) -> str:
    """A program's name without suffix, in lower case."""
    return FilePath(name).stem.lower()
