"""Process data by what of them is said elsewhere: the speed of a weld, the number of a spot.

`ArcL p10,v100,seam1,weld1,fine,tGun;` becomes `ArcL p10,v100,0,[12],fine,tGun;` where `weld1`
holds 12 mm/s throughout, else `[weld1.weld_speed]`. So `SpotL p10,v100,gun1,spot1,tGun;` becomes
`SpotL p10,v100,gun1,[3],tGun;` where nothing changes `spot1`, which begins with 3.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.tables.processes import GUNS, MOVES, SPOTS, WELDS
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.rapid.tree.walk import inner_names, nodes, root
from assistant.program.rewriting import rewrite

_ARGUMENTS_AFTER: Final = 2
"""Of the places that a move states: the speed on the way there, and the seam or the gun."""
_ZERO: Final = s.NumberLiteral("0")
"""Stands for a seam, of which nothing is said."""
_PROCESS_KINDS: Final = ("arc", "spot")
"""Kinds of processes of whose data a part is said."""


def with_process_data(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules with the speeds of welds and numbers of spots where they are given to moves."""
    own = {one.name.lower() for m in modules for one in m.items if isinstance(one, s.Routine)}
    every = list(nodes(tuple(modules)))
    if not own.isdisjoint(MOVES) or not any(map(_is_process_move, every)):
        return modules
    steady = _constant_first_parts(modules, every)

    def said(node: Any) -> Any:
        if not _is_process_move(node):
            return node
        known = MOVES[node.name.lower()]
        plain = [at for at, a in enumerate(node.arguments) if isinstance(a, s.Positional)]
        place = known.points + _ARGUMENTS_AFTER if known.given else len(plain)
        weld = known.kind == "arc"
        arguments = []
        for at, argument in enumerate(node.arguments):
            of_gun = isinstance(argument, s.Option) and argument.name.lower() in GUNS
            if isinstance(argument, s.Option) and argument.name.lower() in known.beside:
                continue
            if (plain[place : place + 1] == [at] or of_gun) and argument.value is not None:
                arguments.append(replace(argument, value=part(argument.value, weld)))
            elif weld and plain[place - 1 : place] == [at]:
                arguments.append(replace(argument, value=_ZERO))
            else:
                arguments.append(argument)
        return replace(node, arguments=tuple(arguments))

    def part(data: s.Expression, weld: bool) -> s.Expression:
        if not isinstance(data, s.NameRef | s.Element):
            return data
        value = steady.get(data.name.lower()) if isinstance(data, s.NameRef) else None
        if value is None and not weld:
            return data
        return s.AggregateNode((value or s.Component(data, WELDS),))

    return [rewrite(module, said, ()) for module in modules]


def _is_process_move(node: Any) -> bool:
    if not isinstance(node, s.ProcedureCall) or not isinstance(node.name, str):
        return False
    known = MOVES.get(node.name.lower())
    return known is not None and known.kind in _PROCESS_KINDS


def _constant_first_parts(
    modules: Sequence[s.Module], every: Sequence[Any]
) -> Mapping[str, s.Expression]:
    """First parts of data by lower-case name that nothing changes, and that no routine hides."""
    changed = {
        name.lower() for name in inner_names(m for n in modules for m in _module_routines(n))
    }
    for node in every:
        match node:
            case s.Assignment(target) if (found := root(target)) is not None:
                changed.add(found.name.lower())
            case s.ProcedureCall() | s.FunctionCall() if not _is_process_move(node):
                names = (n for n in nodes(node.arguments) if isinstance(n, s.NameRef))
                changed.update(name.name.lower() for name in names)
    steady: dict[str, s.Expression] = {}
    for item in (item for module in modules for item in module.items):
        match item:
            case s.Data(
                type=type, name=name, dimensions=(), value=s.AggregateNode(items=(first, *_))
            ) if name.lower() not in changed:
                number = literal_number(first)
                if number is not None and (number > 0 or type.lower() == SPOTS):
                    steady[name.lower()] = first
    return steady


def _module_routines(module: s.Module) -> list[s.Routine]:
    return [item for item in module.items if isinstance(item, s.Routine)]
