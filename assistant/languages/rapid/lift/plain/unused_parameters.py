"""Routines without parameters that they never use, of types that nothing else is told about.

`PROC press(robtarget place,forcedata how)` whose body says nothing of `how` becomes
`PROC press(robtarget place)`, and its calls give it none: nobody lists what such data hold.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.processes import DATA
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.rewriting import rewrite


@dataclass(frozen=True, slots=True)
class _Removed:
    """Places of required parameters that are left out, and names of optional ones in lower case."""

    places: frozenset[int]
    options: frozenset[str]


def without_unused_parameters(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules without such parameters, and without what calls give for them."""
    routines = [item for m in modules for item in m.items if isinstance(item, s.Routine)]
    if not any(
        _is_equipment_data(group, frozenset()) for one in routines for group in one.parameters
    ):
        return modules
    own = frozenset(i.name.lower() for m in modules for i in m.items if isinstance(i, s.Record))
    names = Counter(one.name.lower() for one in routines)
    unused = {id(one): _unused_places(one, own) for one in routines if names[one.name.lower()] == 1}
    if not any(unused.values()) or any(map(_is_late_bound, nodes(tuple(modules)))):
        return modules
    gone = {
        one.name.lower(): _removed_parameters(one, unused[id(one)])
        for one in routines
        if id(one) in unused
    }

    def item(node: s.Item) -> Any:
        left = rewrite(node, lambda part: _with_used_arguments(part, gone), ())
        if isinstance(left, s.Routine) and unused.get(id(node)):
            kept = (g for at, g in enumerate(left.parameters) if at not in unused[id(node)])
            return replace(left, parameters=tuple(kept))
        return left

    return [replace(m, items=tuple(map(item, m.items))) for m in modules]


def _is_equipment_data(group: s.ParameterGroup, own: frozenset[str]) -> bool:
    """Whether a parameter is of data that only equipment is told. own: records of the program."""
    match group.alternatives:
        case (s.ParameterNode(type=type),) if type.lower() not in own:
            known = predefined.types().get(type.lower())
            open_ = known is not None and known.kind == "RECORD" and known.components is None
            return open_ or type.lower() in DATA
    return False


def _unused_places(routine: s.Routine, own: frozenset[str]) -> frozenset[int]:
    """Places in the list of parameters of those that the body never names."""
    opaque = {at for at, group in enumerate(routine.parameters) if _is_equipment_data(group, own)}
    if not opaque:
        return frozenset()
    named = {
        one.name.lower()
        for one in nodes((routine.body, routine.handlers))
        if isinstance(one, s.NameRef)
    }
    return frozenset(
        at
        for at in opaque
        if not any(
            isinstance(one, s.ParameterNode) and one.name.lower() in named
            for one in routine.parameters[at].alternatives
        )
    )


def _removed_parameters(routine: s.Routine, unused: frozenset[int]) -> _Removed:
    required = [at for at, group in enumerate(routine.parameters) if not group.optional]
    optional = (routine.parameters[at] for at in unused if routine.parameters[at].optional)
    names = (one for group in optional for one in group.alternatives)
    return _Removed(
        frozenset(place for place, at in enumerate(required) if at in unused),
        frozenset(one.name.lower() for one in names if isinstance(one, s.ParameterNode)),
    )


def _with_used_arguments(node: Any, gone: Mapping[str, _Removed]) -> Any:
    """A call without the arguments that nobody takes any more; anything else as it is."""
    if not isinstance(node, s.ProcedureCall | s.FunctionCall) or not isinstance(node.name, str):
        return node
    left_out = gone.get(node.name.lower())
    if left_out is None or not (left_out.places or left_out.options):
        return node
    return replace(node, arguments=tuple(_used_arguments(node.arguments, left_out)))


def _used_arguments(arguments: Sequence[s.Argument], left_out: _Removed) -> Iterator[s.Argument]:
    place = -1
    for argument in arguments:
        if isinstance(argument, s.Positional):
            place += 1
            if place in left_out.places:
                continue
        elif argument.name.lower() in left_out.options:
            continue
        yield argument


def _is_late_bound(node: Any) -> bool:
    """Whether a call gives arguments to a routine whose name is worked out."""
    late = isinstance(node, s.ProcedureCall) and not isinstance(node.name, str)
    return late and bool(node.arguments)
