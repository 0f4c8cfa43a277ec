"""Routines that only one module has, apart from what others call so: a program has a name once.

The name is that which a program gets that stays as it is written: `module_routine`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.program import TakenNames, identifier
from assistant.program.rewriting import rewrite

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
