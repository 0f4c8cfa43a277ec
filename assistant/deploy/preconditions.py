"""Conditions under which programs may be replaced or deleted: not running, not used, no name clash.

A running program, and one that a running program calls, is never replaced; the findings report
program pointers that were lost. Two modules of one memory must not declare the same name: that is
refused before anything is changed. A program that another one uses is not deleted.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Final

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.source_text import decode
from assistant.controllers import Controller, Programs
from assistant.controllers.abb.files import TEXTS
from assistant.controllers.abilities import Disk, Memory
from assistant.controllers.rules import Lost
from assistant.controllers.states import TaskState
from assistant.deploy import rules
from assistant.deploy.history import Entry
from assistant.deploy.record import Held
from assistant.deploy.site import Site
from assistant.languages import Tree

_MOST_PROGRAMS: Final = 200
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
    there = _by_stem(site.controller) if running else {}
    for task in running:
        for used in _with_called(site.controller, site.language, task.program, there):
            users.setdefault(used, task.program)
    found = []
    for entry in entries:
        used = _program_stem(entry.name)
        if used in users:
            user = users[used]
            reason = (
                "it is running" if _program_stem(user) == used else f"`{user}` runs, which uses it"
            )
            found.append(rules.RUNNING(place=entry.name, name=entry.name, reason=reason))
    return found


def _by_stem(controller: Programs) -> dict[str, str]:
    """Return the programs of a controller by their stems."""
    return {_program_stem(name): name for name in controller.names()}


def _with_called(
    controller: Programs, language: str, program: str, there: Mapping[str, str]
) -> set[str]:
    """Stems of a program and of all that it calls, or runs beside it, as far as they can be read.

    there: programs of the controller by their stems. A name that a program computes is not seen.
    """
    spoken = languages.get(language)
    open_ones, found = [program], set[str]()
    while open_ones and len(found) < _MOST_PROGRAMS:
        used = _program_stem(open_ones.pop())
        if used in found:
            continue
        found.add(used)
        data = controller.read(there[used]) if used in there else None
        if data is not None:
            tree = spoken.parse(decode(data, None, (*spoken.encodings, "latin-1")))
            open_ones += (*spoken.called_files(tree), *spoken.companions(tree))
    return found


def _program_stem(name: str) -> str:
    """A program's name without suffix, in lower case."""
    return FilePath(name).stem.lower()


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
    there = _by_stem(controller)
    for task in controller.state().tasks:
        if not task.program:
            continue
        does = "runs" if task.running else "is loaded"
        users.setdefault(_program_stem(task.program), f"it {does} in slot {task.name}")
        if task.running and not all(_program_stem(name) in users for name in names):
            reason = f"`{task.program}` runs, which uses it"
            for used in _with_called(controller, controller.languages[0], task.program, there):
                users.setdefault(used, reason)
    for name in names:
        if _program_stem(name) in users:
            yield rules.IN_USE(place=name, name=name, reason=users[_program_stem(name)])


def check_clashes(
    site: Site, entries: Iterable[Entry], *, sent: bool = True
) -> tuple[Diagnostic, ...]:
    """Refuses modules that would not go together in memory; warnings of other tasks that have them.

    sent: whether they are new, and no files that were there before, which may be anything. Of
    modules whose text the controller keeps secret nothing is known.
    """
    memory = site.memory
    if memory is None:
        return ()
    programs = [entry for entry in entries if not site.is_list(entry.name)]
    brought = [entry for entry in programs if memory.module(_text(entry))]
    coming = [entry for entry in brought if entry.after.loaded is not None]
    findings = [
        rules.NO_MODULE(place=entry.name, name=entry.name)
        for entry in programs
        if sent and entry not in brought
    ]
    findings += (*_secret(site, coming), *_same_module(memory, coming))
    if any(entry.before.loaded != entry.after.loaded for entry in coming):
        findings += _same_names(site, memory, coming)
    if findings:
        raise Refused(*findings)
    return tuple(_elsewhere(site, memory, brought))


def in_the_way(site: Site, steps: Sequence[tuple[str, Held, Held]]) -> list[tuple[str, Held]]:
    """Modules that have to leave memory before another one is loaded which takes a name of theirs.

    steps: name of a file, what it is to be, and what it was. What comes back was there.
    """
    moving = [
        (name, dict(_shared(site, new.loaded or b"")), dict(_shared(site, old.loaded or b"")), old)
        for name, new, old in steps
        if not site.is_list(name) and (new.loaded, old.loaded) != (None, None)
    ]
    if len(moving) < 2:
        return []
    brought = {
        name: {own.lower() for own in new} - {own.lower() for own in old}
        for name, new, old, _ in moving
    }
    found = []
    for name, _, declared, old in moving:
        others = {own for other, names in brought.items() if other != name for own in names}
        if others & {own.lower() for own in declared}:
            found.append((name, old))
    return found


def _text(entry: Entry) -> bytes:
    return entry.after.loaded or entry.after.file or b""


def _secret(site: Site, coming: Iterable[Entry]) -> Iterator[Diagnostic]:
    for entry in coming:
        word = languages.get(site.language).kept_secret(_tree(site, _text(entry)))
        if word:
            yield rules.NOT_SHOWN(place=entry.name, name=entry.name, word=word)


def _same_module(memory: Memory, coming: Iterable[Entry]) -> Iterator[Diagnostic]:
    """Report files with the same module: the second would be loaded over the first."""
    first: dict[str, str] = {}
    for entry in coming:
        module = memory.module(_text(entry)) or ""
        other = first.setdefault(module.lower(), entry.name)
        if other != entry.name:
            yield rules.SAME_MODULE(place=entry.name, first=other, second=entry.name, name=module)


def _same_names(site: Site, memory: Memory, coming: list[Entry]) -> Iterator[Diagnostic]:
    owner: dict[str, tuple[str, str]] = {}
    leaving = {
        (memory.module(held) or "").lower()
        for entry in coming
        for held in (entry.before.loaded, entry.after.loaded)
        if held is not None
    }
    for module in memory.modules(site.task):
        if module.lower() not in leaving:
            for name, kind in _shared(site, _read(memory, module, site.task)):
                owner[name.lower()] = (module, kind)
    for entry in coming:
        own = memory.module(_text(entry)) or ""
        for name, kind in _shared(site, _text(entry)):
            other, there = owner.setdefault(name.lower(), (own, kind))
            if other != own:
                yield rules.CLASH(
                    place=entry.name, name=name, kind=kind, own=own, there=there, other=other
                )


def _elsewhere(site: Site, memory: Memory, brought: Iterable[Entry]) -> Iterator[Diagnostic]:
    """Other tasks keep their modules: only that of the deployment is changed."""
    here = memory.task_named(site.task)
    for entry in brought:
        module = memory.module(_text(entry)) or ""
        others = [task for task in memory.homes(module) if task != here]
        if others and entry.before != entry.after:
            shown = ", ".join(f"`{task}`" for task in others)
            yield rules.ELSEWHERE(place=entry.name, name=module, here=here, others=shown)


def _read(memory: Memory, module: str, task: str) -> bytes:
    try:
        return memory.module_text(module, task)
    except Lost:
        raise
    except Refused:  # some modules are only there to be run
        return b""


def _shared(site: Site, data: bytes) -> Iterator[tuple[str, str]]:
    return iter(languages.get(site.language).shared_names(_tree(site, data)))


def _tree(site: Site, data: bytes) -> Tree:
    spoken = languages.get(site.language)
    tree: Tree = spoken.parse(decode(data, None, (*spoken.encodings, "latin-1")))
    return tree
