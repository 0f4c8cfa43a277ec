"""Names that a program declares more than once, as different names.

A program has each name once. Local data get another name where another module declares the same
name, functions where RAPID or the pseudo-program has a function of that name, and local routines
where another module has a routine of that name: these become `module_routine`, the name that a
routine passed through unchanged has as well.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np

from assistant.languages.rapid.tables.predefined import FUNCTIONS
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes, renamed
from assistant.languages.runs.columns import NameIndex, Names
from assistant.program import expressions as e
from assistant.program.program import TakenNames, identifier
from assistant.program.rewriting import rewrite


def with_unique_data_names(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """Return the modules with a different name for everything that is named twice.

    Local data get another name where another module declares the same name, and so do data of a
    module that cannot be in one task with an earlier one: each module means its own. Functions get
    one where RAPID or the pseudo-program has a function of that name: a declaration hides it.
    """
    modules = _without_hiding_functions(modules)
    if len(modules) < 2 or not _has_duplicates(modules):
        return modules
    declared = [dict(_declared_data_names(module)) for module in modules]
    taken = TakenNames((*chain(*declared), *_used_names(modules)))
    made = []
    for at, (module, own) in enumerate(zip(modules, declared, strict=True)):
        names: dict[str, str] = {}
        for key, (name, is_local) in own.items():
            others = [k for k, found in enumerate(declared) if k != at and key in found]
            # Of several local ones, and of several others, the first keeps its name.
            if any(k < at if declared[k][key][1] == is_local else is_local for k in others):
                names[key] = identifier(f"{module.name}_{name}", taken)
                taken.add(names[key])
        changed = (renamed(item, names) for item in module.items)
        made.append(replace(module, items=tuple(changed)) if names else module)
    return made


def _without_hiding_functions(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """Rename functions that hide predefined ones, in the modules that call them."""
    own = [
        {
            key: item
            for item in module.items
            if isinstance(item, s.Routine) and item.kind == "FUNC"
            if (key := item.name.lower()) in FUNCTIONS or key in e.FUNCTIONS
        }
        for module in modules
    ]
    if not any(own):
        return modules
    taken = TakenNames(_used_names(modules))
    everywhere: dict[str, str] = {}
    alone: list[dict[str, str]] = []
    for routines in own:
        alone.append({})
        for key, routine in routines.items():
            names = alone[-1] if routine.local else everywhere
            names[key] = identifier(routine.name, taken)
            taken.add(names[key])
    return [
        _with_function_names(module, everywhere | names)
        for module, names in zip(modules, alone, strict=True)
    ]


def _with_function_names(module: s.Module, names: dict[str, str]) -> s.Module:
    def visit(node: Any) -> Any:
        match node:
            case s.FunctionCall(name=name) | s.Routine(kind="FUNC", name=name):
                return replace(node, name=names.get(name.lower(), name))
        return node

    made: s.Module = rewrite(module, visit, ())
    return made


def _has_duplicates(modules: Sequence[s.Module]) -> bool:
    """True if any name is declared twice, compared in columns."""
    items = [item for module in modules for item in module.items]
    single = [item.name.lower() for item in items if isinstance(item, s.Data)]
    # A task may have tens of thousands of targets, so their names are compared in columns.
    rows = Names.joined([item.run.names for item in items if isinstance(item, s.TargetRunNode)])
    index = NameIndex(rows)
    return (
        len(set(single)) < len(single)
        or bool((index.rows(rows) != np.arange(len(rows))).any())
        or any((index.row(name) >= 0).any() for name in single)
    )


def _declared_data_names(module: s.Module) -> Iterator[tuple[str, tuple[str, bool]]]:
    """By lower-case name each name of data as it is spelled, and whether it is local."""
    for item in module.items:
        match item:
            case s.Data(scope=scope, name=name):
                yield name.lower(), (name, scope == "LOCAL")
            case s.TargetRunNode(scope, run):
                names = map(run.names.name, range(len(run)))
                yield from ((name.lower(), (name, scope == "LOCAL")) for name in names)


def _used_names(modules: Sequence[s.Module]) -> Iterator[str]:
    """Yield every name that modules use: a renamed item must not take one of them."""
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


_NAMED_NODES = (s.NameRef, s.Data, s.ParameterNode, s.Routine, s.Record, s.Alias)


def with_unique_routine_names(
    modules: Sequence[s.Module],
) -> tuple[Sequence[s.Module], Mapping[str, str]]:
    """The modules with other names for local routines that another module has too.

    With the names that these had, in lower case both.
    """
    own = [{i.name.lower(): i for i in m.items if isinstance(i, s.Routine)} for m in modules]
    often = Counter(name for names in own for name in names)
    if all(count == 1 for count in often.values()):
        return modules, {}
    taken = TakenNames(n.name for n in nodes(tuple(modules)) if isinstance(n, _NAMED_NODES))
    before: dict[str, str] = {}
    made = []
    for module, routines in zip(modules, own, strict=True):
        names: dict[str, str] = {}
        for key, routine in routines.items():
            if routine.local and often[key] > 1:
                names[key] = identifier(f"{module.name}_{routine.name}", taken)
                taken.add(names[key])
                before[names[key].lower()] = key
        made.append(_with_routine_names(module, names) if names else module)
    return made, before


def _with_routine_names(module: s.Module, names: Mapping[str, str]) -> s.Module:
    def visit(node: Any) -> Any:
        match node:
            case s.Routine(name=name) | s.ProcedureCall(str(name)) | s.FunctionCall(str(name)):
                return replace(node, name=names[name.lower()]) if name.lower() in names else node
            case s.Connect(trap=trap) if trap.lower() in names:
                return replace(node, trap=names[trap.lower()])
        return node

    made: s.Module = rewrite(module, visit, ())
    return made
