"""Speeds, zones and loads that a routine declares and never changes, as constants of its module.

`VAR zonedata z:=[FALSE,5,8,8,0.8,8,0.8];` in a routine becomes a constant under a name of its own:
other languages write the values of a move where it stands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lift.plain.layouts import RecordLayouts
from assistant.languages.rapid.lift.plain.scopes import NameUses
from assistant.languages.rapid.lift.plain.substituting import is_literal
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.runs import MotionNames
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.program import TakenNames, identifier
from assistant.program.rewriting import rewrite

_CONSTANT_TYPES: Final = frozenset(("speeddata", "zonedata", "loaddata"))
_NAMED_NODES: Final = (s.NameRef, s.Data, s.Routine, s.Record, s.Alias, s.ParameterNode)


def with_module_settings(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules whose routines declare none of these that never changes."""
    layouts = RecordLayouts(modules)
    items = [item for module in modules for item in module.items]
    own = [
        node
        for item in items
        if isinstance(item, s.Routine)
        for node in item.body
        if isinstance(node, s.Data) and layouts.base(node.type) in _CONSTANT_TYPES
    ]
    if not own:
        return modules
    written = NameUses(modules, frozenset()).written
    every = list(nodes(tuple(modules)))
    taken = TakenNames(one.name for one in every if isinstance(one, _NAMED_NODES))
    taken.update(one.variable for one in every if isinstance(one, s.ForLoop))
    made = []
    for module in modules:
        changed: list[s.Item] = []
        for item in module.items:
            if isinstance(item, s.Routine):
                data, item = _moved_settings(item, layouts, written, taken)
                changed += data
            changed.append(item)
        same = len(changed) == len(module.items)
        made.append(module if same else replace(module, items=tuple(changed)))
    return made


def _moved_settings(
    routine: s.Routine, layouts: RecordLayouts, written: set[str], taken: TakenNames
) -> tuple[list[s.Data], s.Routine]:
    """The constants that a routine has, and the routine without them."""
    names: dict[str, str] = {}
    data: list[s.Data] = []
    for node in routine.body:
        match node:
            case s.Data(type=type, name=name, dimensions=(), value=s.AggregateNode() as value) if (
                layouts.base(type) in _CONSTANT_TYPES
                and is_literal(value)
                and name.lower() not in written
            ):
                new = identifier(f"{routine.name}_{name}", taken)
                taken.add(new)
                names[name.lower()] = new
                data.append(replace(node, scope="", storage="CONST", name=new))
    if not names:
        return [], routine

    def renamed(part: Any) -> Any:
        match part:
            case s.NameRef(name) if name.lower() in names:
                return replace(part, name=names[name.lower()])
            case MotionNames(speed, zone, tool, frame):
                new = (names.get(one.lower(), one) for one in (speed, zone, tool, frame))
                return MotionNames(*new)
        return part

    body = tuple(
        node
        for node in routine.body
        if not (isinstance(node, s.Data) and node.name.lower() in names)
    )
    changed: s.Routine = rewrite(replace(routine, body=body), renamed, ())
    return data, changed
