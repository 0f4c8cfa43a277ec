"""Parameters that are tools or work objects in their components alone: no move is made with them.

`FUNC string told(tooldata t)` that reads `t.tframe.trans.x` is given the parts of any tool, also of
one that a routine has for itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from assistant.languages.rapid.lift.plain.layouts import (
    SETTING_TYPES,
    SPEED_AND_ZONE,
    RecordLayouts,
)
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes

RoutineTable = Mapping[str, s.Routine]
"""Routines whose names are theirs alone, by lower-case name."""


def component_parameters(routines: RoutineTable, layouts: RecordLayouts) -> frozenset[int]:
    """The `id` of each such parameter."""
    found: dict[tuple[str, str], s.ParameterNode] = {}
    for key, routine in routines.items():
        for group in routine.parameters:
            for one in group.alternatives:
                if isinstance(one, s.ParameterNode) and not one.dimensions and not group.optional:
                    if layouts.base(one.type) in SETTING_TYPES - SPEED_AND_ZONE:
                        found[key, one.name.lower()] = one
    handed = {key: set(_receiving_parameters(routines, key[0], key[1])) for key in found}
    while wrong := [place for place in found if not handed[place] <= found.keys()]:
        for place in wrong:
            del found[place]
    return frozenset(map(id, found.values()))


_ANYWHERE: Final = ("", "")
"""Stands for what takes a tool or work object by its name."""


def _receiving_parameters(
    routines: RoutineTable, routine: str, name: str
) -> Iterator[tuple[str, str]]:
    """The parameters that a parameter is handed to as a whole."""
    said = known = 0
    for node in nodes(routines[routine]):
        match node:
            case s.NameRef():
                said += _is_named(node, name)
            case s.Component(inner) | s.Group(inner) | s.ReturnFrom(inner):
                known += _is_named(inner, name)
            case s.Assignment(one, two) | s.Infix(_, one, two):
                known += _is_named(one, name) + _is_named(two, name)
            case s.MoveRunNode(run):
                named = {n.lower() for m in run.motions.table for n in (m.tool, m.frame)}
                if name in named:
                    yield _ANYWHERE
            case s.ProcedureCall(str(called), arguments) | s.FunctionCall(str(called), arguments):
                for to in _argument_parameters(routines.get(called.lower()), arguments, name):
                    known += 1
                    yield to
    if said != known:
        yield _ANYWHERE


def _argument_parameters(
    routine: s.Routine | None, arguments: Sequence[s.Argument], name: str
) -> Iterator[tuple[str, str]]:
    """Where some arguments hand it to, as far as that is a required parameter of the program."""
    required = iter(() if routine is None else [g for g in routine.parameters if not g.optional])
    for argument in arguments:
        if isinstance(argument, s.Positional):
            group = next(required, None)
            one = None if group is None else group.alternatives[0]
            if _is_named(argument.value, name):
                if routine is not None and isinstance(one, s.ParameterNode):
                    yield routine.name.lower(), one.name.lower()
                else:
                    yield _ANYWHERE


def _is_named(node: Any, name: str) -> bool:
    return isinstance(node, s.NameRef) and node.name.lower() == name
