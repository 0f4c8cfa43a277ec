"""Names that two modules of one memory would both declare: refused before anything is changed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.source_text import decode
from assistant.controllers.abilities import Memory
from assistant.controllers.rules import Lost
from assistant.deploy import rules
from assistant.deploy.held import Held
from assistant.deploy.journal import Entry
from assistant.deploy.site import Site
from assistant.languages import Tree


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
    """Of two files that hold one module the second would be loaded over the first."""
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
