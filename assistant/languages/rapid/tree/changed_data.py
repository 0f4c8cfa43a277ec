"""Data that statements and calls may change, by their names in lower case.

A routine that is neither among the modules nor in the tables may change all that it is given, and
so may one whose name is worked out.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tables.signals import PROCESS_MOVES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes, root
from assistant.languages.signatures import Parameter, Slot

Routines = Mapping[str, Sequence[s.Routine]]
"""Routines of modules by lower-case name; several where local ones have one name."""

_SETS_PERSISTENTS: Final = frozenset(
    (
        "ipathpos", "loadid", "mtoolrotcalib", "mtooltcpcalib", "setupcyclicbool", "stoolrotcalib",
        "stooltcpcalib", "triggstopproc", "uishow", "waittestandset",
    )
)  # fmt: skip
"""Routines of every controller that set a PERS argument; the others read or watch theirs."""


def routines_by_name(modules: Iterable[s.Module]) -> Routines:
    found: dict[str, list[s.Routine]] = {}
    for item in (item for module in modules for item in module.items):
        if isinstance(item, s.Routine):
            found.setdefault(item.name.lower(), []).append(item)
    return found


def changed_names(modules: Sequence[s.Module]) -> set[str]:
    """Names that an assignment or a call anywhere in the modules may change."""
    own = routines_by_name(modules)
    found: set[str] = set()
    for node in nodes(tuple(modules)):
        if isinstance(node, s.Assignment | s.ProcedureCall | s.FunctionCall):
            found.update(changed_by(node, own))
    return found


def changed_by(
    node: s.Assignment | s.ProcedureCall | s.FunctionCall, own: Routines
) -> Iterator[str]:
    """Names that a statement or a call itself may change, without the calls in it."""
    places: Iterable[Any]
    if isinstance(node, s.Assignment):
        places = (node.target,)
    else:
        key = node.name.lower() if isinstance(node.name, str) else ""
        reads = key not in own and key not in _SETS_PERSISTENTS
        places = (
            place
            for slots in _slots_of(key, own)
            for place in _changed_arguments(node.arguments, slots, reads)
        )
    for place in places:
        if (found := root(place)) is not None:
            yield found.name.lower()


def _slots_of(key: str, own: Routines) -> Sequence[Sequence[Slot]]:
    """The places in the list of parameters of each routine with a name; none of an unknown one."""
    if key in own:
        return [_parameter_slots(one) for one in own[key]]
    known = signature(key)
    # Of an open list not all parameters are known.
    listed = known is not None and (not known.open or key in PROCESS_MOVES)
    return [known.slots if known is not None and listed else ()]


def _parameter_slots(routine: s.Routine) -> tuple[Slot, ...]:
    return tuple(
        Slot(
            tuple(
                Parameter(one.name, one.type, one.mode)
                for one in group.alternatives
                if isinstance(one, s.ParameterNode)
            ),
            group.optional,
        )
        for group in routine.parameters
    )


def _changed_arguments(
    arguments: Sequence[s.Argument], slots: Sequence[Slot], reads: bool
) -> Iterator[Any]:
    """The values of the arguments that a routine may change. reads: it sets no PERS argument."""
    required = iter([slot for slot in slots if not slot.optional])
    optional = {one.name.lower(): one for x in slots if x.optional for one in x.alternatives}
    for argument in arguments:
        meant: Sequence[Parameter] = ()
        match argument:
            case s.Positional(value):
                slot = next(required, None)
                meant = () if slot is None else slot.alternatives
            case s.Option(name, value) | s.Conditional(name, value):
                found = optional.get(name.lower())
                meant = () if found is None else (found,)
        # A parameter that is not known may change what it gets.
        if not meant or any(one.mode and not (reads and one.mode == "PERS") for one in meant):
            yield value
