"""Data that only one module has, apart from what others call so: a program has a name once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.renaming import renamed
from assistant.languages.rapid.tree.walk import nodes
from assistant.languages.runs.names import Index, Names
from assistant.program.program import TakenNames, identifier


def with_own_names(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules, with other names for local data where another module has such a name."""
    if len(modules) < 2 or not _any_twice(modules):
        return modules
    declared = [dict(_declared(module)) for module in modules]
    taken = TakenNames((*chain(*declared), *_said(modules)))
    made = []
    for at, (module, own) in enumerate(zip(modules, declared, strict=True)):
        names: dict[str, str] = {}
        for key, (name, is_local) in own.items():
            others = [k for k, found in enumerate(declared) if k != at and key in found]
            # of several local ones the first keeps its name
            if is_local and any(k < at or not declared[k][key][1] for k in others):
                names[key] = identifier(f"{module.name}_{name}", taken)
                taken.add(names[key])
        changed = (renamed(item, names) for item in module.items)
        made.append(replace(module, items=tuple(changed)) if names else module)
    return made


def _any_twice(modules: Sequence[s.Module]) -> bool:
    """Whether any name is declared twice, by columns of names."""
    items = [item for module in modules for item in module.items]
    single = [item.name.lower() for item in items if isinstance(item, s.Data)]
    rows = Names.joined([item.run.names for item in items if isinstance(item, s.TargetRunNode)])
    index = Index(rows)
    return (
        len(set(single)) < len(single)
        or bool((index.rows(rows) != np.arange(len(rows))).any())
        or any((index.row(name) >= 0).any() for name in single)
    )


def _declared(module: s.Module) -> Iterator[tuple[str, tuple[str, bool]]]:
    """By lower-case name each name of data as it is spelled, and whether it is local."""
    for item in module.items:
        match item:
            case s.Data(scope=scope, name=name):
                yield name.lower(), (name, scope == "LOCAL")
            case s.TargetRunNode(scope, run):
                names = map(run.names.name, range(len(run)))
                yield from ((name.lower(), (name, scope == "LOCAL")) for name in names)


def _said(modules: Sequence[s.Module]) -> Iterator[str]:
    """What modules call anything: another name must not become that of something else there."""
    for node in nodes(tuple(modules)):
        match node:
            case s.NameRef(name) | s.Data(name=name) | s.ParameterNode(name=name):
                yield name
            case s.Routine(name=name) | s.ForLoop(variable=name):
                yield name
            case s.MoveRunNode(run):
                for names in (run.names, run.vias):
                    yield from map(names.name, range(len(names)))
                for motion in run.motions.table:
                    yield from (motion.speed, motion.zone, motion.tool, motion.frame)
