"""Welds by their speed: of what an instruction of arc welding is given, that alone moves the arm.

`ArcL p10,v100,seam1,weld1,fine,tGun;` becomes `ArcL p10,v100,seam1,[12],fine,tGun;` where `weld1`
holds 12 mm/s throughout, else `[weld1.weld_speed]`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.tables.welding import MOVES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.rapid.tree.walk import inner_names, nodes, root
from assistant.program.rewriting import rewrite

_SPEED: Final = "weld_speed"
_BEHIND: Final = 2
"""Of the places that a move states: the speed on the way there, and the seam."""


def with_weld_speeds(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules with the speeds of welds where these are given to moves."""
    own = {one.name.lower() for m in modules for one in m.items if isinstance(one, s.Routine)}
    every = list(nodes(tuple(modules)))
    if not own.isdisjoint(MOVES) or not any(map(_is_weld, every)):
        return modules
    steady = _steady(modules, every)

    def said(node: Any) -> Any:
        if not _is_weld(node):
            return node
        plain = [at for at, a in enumerate(node.arguments) if isinstance(a, s.Positional)]
        place = MOVES[node.name.lower()].points + _BEHIND
        if len(plain) <= place:
            return node
        weld = node.arguments[plain[place]].value
        if not isinstance(weld, s.NameRef | s.Element):
            return node
        speed = steady.get(weld.name.lower()) if isinstance(weld, s.NameRef) else None
        value = s.AggregateNode((speed or s.Component(weld, _SPEED),))
        arguments = list(node.arguments)
        arguments[plain[place]] = replace(arguments[plain[place]], value=value)
        return replace(node, arguments=tuple(arguments))

    return [rewrite(module, said, ()) for module in modules]


def _is_weld(node: Any) -> bool:
    return (
        isinstance(node, s.ProcedureCall)
        and isinstance(node.name, str)
        and node.name.lower() in MOVES
    )


def _steady(modules: Sequence[s.Module], every: Sequence[Any]) -> Mapping[str, s.Expression]:
    """Speeds of welds by lower-case name that nothing changes, and that no routine hides."""
    changed = {name.lower() for name in inner_names(m for n in modules for m in _routines(n))}
    for node in every:
        match node:
            case s.Assignment(target) if (found := root(target)) is not None:
                changed.add(found.name.lower())
            case s.ProcedureCall() | s.FunctionCall() if not _is_weld(node):
                names = (n for n in nodes(node.arguments) if isinstance(n, s.NameRef))
                changed.update(name.name.lower() for name in names)
    steady: dict[str, s.Expression] = {}
    for item in (item for module in modules for item in module.items):
        match item:
            case s.Data(name=name, dimensions=(), value=s.AggregateNode(items=(first, *_))):
                if name.lower() not in changed and (literal_number(first) or 0) > 0:
                    steady[name.lower()] = first
    return steady


def _routines(module: s.Module) -> list[s.Routine]:
    return [item for item in module.items if isinstance(item, s.Routine)]
