"""What the parameters of a routine mean in a call: copies of values, or references to data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.expressions import evaluate, place, signal
from assistant.virtual.rapid.given import is_present
from assistant.virtual.rapid.machine import Machine
from assistant.virtual.rapid.scopes import Absent, Cell, Meaning, Place, Signal, Storage
from assistant.virtual.rapid.values import Shape, copied, fitted, is_like, kind_of, sizes

REFERENCE_MODES: Final[Mapping[str, tuple[Storage, ...]]] = {
    "VAR": ("VAR", "IN"),
    "PERS": ("PERS",),
    "INOUT": ("VAR", "IN", "PERS"),
}
"""What data a parameter of each mode may refer to."""


def bound_parameters(
    machine: Machine, routine: s.Routine, arguments: Sequence[s.Argument]
) -> dict[str, Meaning]:
    """What the names of the parameters mean during a call; arguments are worked out in order."""
    found: dict[str, Meaning] = {}
    required = iter(_parameter_argument(routine, optional=False))
    optional = {one.name.lower(): one for one in _parameter_argument(routine, optional=True)}
    for argument in arguments:
        if isinstance(argument, s.Positional):
            one, value = next(required, None), argument.value
            if one is None:
                raise Fault(f"`{routine.name}` is given too many arguments")
            if argument.name is not None and argument.name.lower() != one.name.lower():
                raise Fault(f"`{argument.name}` where `{routine.name}` takes `{one.name}`")
            found[one.name.lower()] = _bound_parameter(machine, one, value)
        elif isinstance(argument, s.Option):
            one = _optional_parameter(routine, optional, argument.name)
            found[one.name.lower()] = _bound_parameter(machine, one, argument.value)
        elif is_present(machine, argument.variable):
            one = _optional_parameter(routine, optional, argument.name)
            found[one.name.lower()] = _bound_parameter(machine, one, argument.variable)
    missing = next(required, None)
    if missing is not None:
        raise Fault(f"`{routine.name}` is not given `{missing.name}`")
    for group in routine.parameters:
        alternatives = [
            one.name for one in group.alternatives if not isinstance(one, s.Placeholder)
        ]
        given = [name for name in alternatives if name.lower() in found]
        if len(given) > 1:
            raise Fault(f"`{given[0]}` and `{given[1]}` of `{routine.name}` exclude each other")
    return {**dict.fromkeys(optional, Absent()), **found}


def _parameter_argument(routine: s.Routine, optional: bool) -> Iterator[s.ParameterNode]:
    for group in routine.parameters:
        if group.optional is optional:
            for one in group.alternatives:
                if isinstance(one, s.Placeholder):
                    raise Fault("a parameter that was never filled in")
                yield one


def _optional_parameter(
    routine: s.Routine, optional: dict[str, s.ParameterNode], name: str
) -> s.ParameterNode:
    parameter = optional.get(name.lower())
    if parameter is None:
        raise Fault(f"`{routine.name}` has no optional parameter `{name}`")
    return parameter


def _bound_parameter(machine: Machine, one: s.ParameterNode, value: s.Expression | None) -> Meaning:
    """What one parameter means."""
    shape = Shape(machine.types.name(one.type), (-1,) * max(one.dimensions, 0))
    if shape.type == "switch":
        return Cell(shape, "CONST", True)
    if value is None:
        raise Fault(f"the parameter `{one.name}` is given no value")
    if shape.type.startswith("signal"):
        return Signal(signal(machine, value))
    if one.mode in REFERENCE_MODES:
        return _reference(machine, one, value, shape)
    found = fitted(copied(evaluate(machine, value, shape)), shape)
    if not is_like(found, shape):
        raise Fault(f"{kind_of(found)} for the parameter `{one.name}`")
    return Cell(Shape(shape.type, sizes(found)), "IN", found)


def _reference(machine: Machine, one: s.ParameterNode, value: s.Expression, wanted: Shape) -> Place:
    found = place(machine, value)
    if found.storage not in REFERENCE_MODES[one.mode]:
        raise Fault(f"the parameter `{one.name}` refers to what cannot be changed so")
    if found.shape.type != wanted.type or len(found.shape.sizes) != len(wanted.sizes):
        raise Fault(f"{found.shape.type} for the parameter `{one.name}`")
    return found
