"""Persistent data that the tasks of a controller share, as variables of all its programs.

Other controllers have a few of these, with names of their own: `M_00` to `M_19` for numbers and
truths, `C_00` to `C_19` for texts (MELFA-BASIC, CR1D 4.3.7). One of the tasks gives
the first value.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.language_types import SharedData
from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.renaming import renamed
from assistant.languages.rapid.tree.walk import nodes, root

_SHARED_LETTERS: Final[Mapping[str, str]] = {"num": "M", "bool": "M", "string": "C"}
"""By type: the letter of variables of all programs."""
_SHARED_NUMBERS: Final = tuple(f"{number:02}" for number in range(20))
"""What stands behind the letter and a line, as every controller has it."""

_CHANGING_MODES: Final = frozenset(("INOUT", "VAR"))
"""Modes of the parameters that instructions of the controller change."""
TaskFiles = Sequence[s.File]


def with_shared_data(tasks: Sequence[tuple[str, TaskFiles]]) -> list[SharedData]:
    """The files of each task of a controller, by the task's name, with names for all programs."""
    declared = [dict(_persistent_data(files)) for _, files in tasks]
    count = Counter(name for one in declared for name in one)
    both = {name for name, many in count.items() if many > 1}
    files = {id(file): file for _, given in tasks for file in given}
    changed = both & set(_changed_names(files.values())) if both else set()
    if not changed:
        return [SharedData(tuple(given)) for _, given in tasks]
    taken = {name.upper() for file in files.values() for name in _used_names(file)}
    free = {
        letter: iter([f"{letter}_{n}" for n in _SHARED_NUMBERS if f"{letter}_{n}" not in taken])
        for letter in "MC"
    }
    names: dict[str, str] = {}
    for name in sorted(changed):
        kinds = {_shared_kind(one[name]) for one in declared if name in one}
        letter = _SHARED_LETTERS.get(kinds.pop(), "") if len(kinds) == 1 else ""
        new = next(free[letter], None) if letter else None
        if new is not None:
            names[name] = new
    first = {name: next(at for at, one in enumerate(declared) if name in one) for name in changed}
    made = []
    for at, (_, given) in enumerate(tasks):
        own = {name: data for name, data in declared[at].items() if name in changed}
        kept = {name for name in names if first[name] == at}
        found = [
            _sharing_finding(
                data, names.get(name), tasks[first[name]][0] if first[name] != at else ""
            )
            for name, data in own.items()
        ]
        made.append(
            SharedData(tuple(_renamed_file(file, names, kept) for file in given), tuple(found))
        )
    return made


def _persistent_data(files: TaskFiles) -> Iterator[tuple[str, s.Data]]:
    """The data of a task that others may share, by lower-case name."""
    for file in files:
        for module in file.modules:
            for item in module.items:
                if isinstance(item, s.Data) and item.storage == "PERS" and not item.scope:
                    yield item.name.lower(), item


def _shared_kind(data: s.Data) -> str:
    return data.type.lower() if not data.dimensions else ""


def _changed_names(files: Collection[s.File]) -> Iterator[str]:
    """Names in lower case that are assigned, or handed over to what may change them."""
    modes = {
        item.name.lower(): {
            one.mode
            for group in item.parameters
            for one in group.alternatives
            if isinstance(one, s.ParameterNode)
        }
        for file in files
        for module in file.modules
        for item in module.items
        if isinstance(item, s.Routine)
    }

    def may_change(routine: str) -> bool:
        if routine.lower() in modes:
            return bool(modes[routine.lower()] - {""})
        known = signature(routine)
        slots = () if known is None else known.slots
        return known is None or any(
            one.mode in _CHANGING_MODES for slot in slots for one in slot.alternatives
        )

    for node in nodes(tuple(module for file in files for module in file.modules)):
        match node:
            case s.Assignment(target=target) if (found := root(target)) is not None:
                yield found.name.lower()
            case s.ProcedureCall(str(name)) | s.FunctionCall(str(name)) if may_change(name):
                for one in node.arguments:
                    found = root(one.value) if isinstance(one, s.Positional | s.Option) else None
                    if found is not None:
                        yield found.name.lower()


def _used_names(file: s.File) -> Iterator[str]:
    for node in nodes(file.modules):
        if isinstance(node, s.NameRef | s.Data | s.ParameterNode):
            yield node.name


def _sharing_finding(data: s.Data, new: str | None, first: str) -> Diagnostic:
    if new is None:
        return rules.NOT_SHARED(name=data.name)
    return rules.SHARED(
        name=data.name, new=new, begins=f"the program of `{first}`" if first else "this program"
    )


def _renamed_file(file: s.File, names: Mapping[str, str], kept: set[str]) -> s.File:
    """kept: names in lower case whose first value the task gives."""

    def of_module(module: s.Module) -> s.Module:
        own = {
            item.name.lower()
            for item in module.items
            if isinstance(item, s.Data) and (item.scope or item.storage != "PERS")
        }
        said = {name: new for name, new in names.items() if name not in own}
        return replace(module, items=tuple(renamed(bare(item), said) for item in module.items))

    def bare(item: s.Item) -> s.Item:
        if isinstance(item, s.Data) and item.storage == "PERS" and not item.scope:
            if item.name.lower() in names and item.name.lower() not in kept:
                return replace(item, value=None)
        return item

    parts = (of_module(one) if isinstance(one, s.Module) else one for one in file.parts)
    return replace(file, parts=tuple(parts))
