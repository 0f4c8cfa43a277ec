"""Arguments of a call: of built-in instructions and functions, and of the program's routines.

`Given` evaluates the arguments of a built-in one on request. A parameter of a routine is a copy of
a value, or a reference to data.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid import records
from assistant.virtual.rapid.control_flow import Fault, NotSimulated
from assistant.virtual.rapid.expressions import evaluate, place, signal
from assistant.virtual.rapid.machine import Function, Machine
from assistant.virtual.rapid.scopes import Absent, Cell, Meaning, Place, Signal, Storage
from assistant.virtual.rapid.values import (
    Record,
    Shape,
    Value,
    copied,
    fitted,
    is_like,
    kind_of,
    sizes,
)


@dataclass(slots=True)
class Given:
    """Required arguments in order, and options by name in lower case, None for a mere switch."""

    machine: Machine
    required: list[s.Expression]
    options: dict[str, s.Expression | None]

    def value(self, index: int, type: str = "") -> Value:
        return evaluate(self.machine, self._node(index), Shape(type) if type else None)

    def _node(self, index: int) -> s.Expression:
        if index >= len(self.required):
            raise Fault(f"{len(self.required)} arguments where {index + 1} are needed")
        return self.required[index]

    def number(self, index: int) -> float:
        return records.number(self.value(index))

    def truth(self, index: int) -> bool:
        return records.truth(self.value(index))

    def text(self, index: int) -> str:
        return records.text(self.value(index))

    def record(self, index: int, type: str) -> Record:
        return records.record(self.value(index, type), type)

    def signal(self, index: int) -> str:
        return signal(self.machine, self._node(index))

    def place(self, index: int) -> Place:
        return place(self.machine, self._node(index))

    def has(self, option: str) -> bool:
        return option in self.options

    def optional(self, option: str, type: str = "") -> Value | None:
        """The value of an option, None if it is not given."""
        node = self.options.get(option)
        if node is None:
            return None
        wanted = Shape(type) if type else None
        value = evaluate(self.machine, node, wanted)
        if wanted is None:
            return value
        if not is_like(value, wanted):
            raise Fault(f"{kind_of(value)} where {type} is wanted")
        return fitted(value, wanted)

    def optional_number(self, option: str) -> float | None:
        value = self.optional(option)
        return None if value is None else records.number(value)

    def optional_record(self, option: str, type: str) -> Record | None:
        value = self.optional(option, type)
        return None if value is None else records.record(value, type)


def _sorted_arguments(
    machine: Machine, arguments: Sequence[s.Argument], name: str, count: int, options: str
) -> Given:
    """Arguments sorted; raises NotSimulated for other options, Fault for another count."""
    found = _any_arguments(machine, arguments)
    unknown = set(found.options) - set(options.split())
    if unknown:
        # min(): the same message on each run.
        raise NotSimulated(f"`\\{min(unknown)}` of `{name}`")
    if len(found.required) != count:
        raise Fault(f"`{name}` is given {len(found.required)} arguments and takes {count}")
    return found


def _any_arguments(machine: Machine, arguments: Sequence[s.Argument]) -> Given:
    """Arguments sorted, whatever they are."""
    found = Given(machine, [], {})
    for argument in arguments:
        match argument:
            case s.Positional(value):
                found.required.append(value)
            case s.Option(option, value):
                found.options[option.lower()] = value
            case s.Conditional(option, variable):
                # `\x?y` passes the option on only if the caller got it.
                if is_present(machine, variable):
                    found.options[option.lower()] = variable
    return found


def is_present(machine: Machine, variable: s.Expression) -> bool:
    """True if an optional parameter was given."""
    if not isinstance(variable, s.NameRef):
        return True
    return not isinstance(machine.meaning(variable.name), Absent)


def table_row(
    name: str, count: int, does: Callable[[Given], Value | None], options: str = ""
) -> tuple[str, Function]:
    """A row of a table: a name in lower case, and what does it with its arguments sorted.

    options: names in lower case of those that are simulated, or that change nothing here.
    """

    def call(machine: Machine, arguments: Sequence[s.Argument]) -> Value | None:
        return does(_sorted_arguments(machine, arguments, name, count, options))

    return name.lower(), call


Ability = Callable[[Given], Value | None]
"""Instruction or function of one controller beyond the common ones: it gets the arguments of its
call.
"""


def as_function(does: Ability) -> Function:
    def call(machine: Machine, arguments: Sequence[s.Argument]) -> Value | None:
        return does(_any_arguments(machine, arguments))

    return call


_REFERENCE_MODES: Final[Mapping[str, tuple[Storage, ...]]] = {
    "VAR": ("VAR", "IN"),
    "PERS": ("PERS",),
    "INOUT": ("VAR", "IN", "PERS"),
}
"""Storage classes that a parameter of each mode may refer to."""


def bound_parameters(
    machine: Machine, routine: s.Routine, arguments: Sequence[s.Argument]
) -> dict[str, Meaning]:
    """Return the meanings of the parameters' names during a call; arguments are evaluated in
    order.
    """
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
    # Absent hides data of the same name outside the routine.
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
    """Return the meaning of one parameter."""
    # -1: a parameter takes arrays of any size.
    shape = Shape(machine.types.name(one.type), (-1,) * max(one.dimensions, 0))
    if shape.type == "switch":
        return Cell(shape, "CONST", True)
    if value is None:
        raise Fault(f"the parameter `{one.name}` is given no value")
    if shape.type.startswith("signal"):
        return Signal(signal(machine, value))
    if one.mode in _REFERENCE_MODES:
        return _reference(machine, one, value, shape)
    found = fitted(copied(evaluate(machine, value, shape)), shape)
    if not is_like(found, shape):
        raise Fault(f"{kind_of(found)} for the parameter `{one.name}`")
    return Cell(Shape(shape.type, sizes(found)), "IN", found)


def _reference(machine: Machine, one: s.ParameterNode, value: s.Expression, wanted: Shape) -> Place:
    found = place(machine, value)
    if found.storage not in _REFERENCE_MODES[one.mode]:
        raise Fault(f"the parameter `{one.name}` refers to what cannot be changed so")
    if found.shape.type != wanted.type or len(found.shape.sizes) != len(wanted.sizes):
        raise Fault(f"{found.shape.type} for the parameter `{one.name}`")
    return found
