"""The arguments of a function or instruction that every controller knows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid import poses
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.expressions import evaluate, place, signal
from assistant.virtual.rapid.machine import Function, Machine
from assistant.virtual.rapid.scopes import Absent, Place
from assistant.virtual.rapid.values import Record, Shape, Value, fitted, is_like, kind_of


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
        return poses.number(self.value(index))

    def truth(self, index: int) -> bool:
        return poses.truth(self.value(index))

    def text(self, index: int) -> str:
        return poses.text(self.value(index))

    def record(self, index: int, type: str) -> Record:
        return poses.record(self.value(index, type), type)

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
        return None if value is None else poses.number(value)

    def optional_record(self, option: str, type: str) -> Record | None:
        value = self.optional(option, type)
        return None if value is None else poses.record(value, type)


def sorted_arguments(
    machine: Machine, arguments: Sequence[s.Argument], name: str, count: int, options: str
) -> Given:
    """Arguments sorted; raises NotSimulated for other options, Fault for another count."""
    found = any_arguments(machine, arguments)
    unknown = set(found.options) - set(options.split())
    if unknown:
        raise NotSimulated(f"`\\{min(unknown)}` of `{name}`")
    if len(found.required) != count:
        raise Fault(f"`{name}` is given {len(found.required)} arguments and takes {count}")
    return found


def any_arguments(machine: Machine, arguments: Sequence[s.Argument]) -> Given:
    """Arguments sorted, whatever they are."""
    found = Given(machine, [], {})
    for argument in arguments:
        match argument:
            case s.Positional(value):
                found.required.append(value)
            case s.Option(option, value):
                found.options[option.lower()] = value
            case s.Conditional(option, variable):
                if is_present(machine, variable):
                    found.options[option.lower()] = variable
    return found


def is_present(machine: Machine, variable: s.Expression) -> bool:
    """Whether an optional parameter was given."""
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
        return does(sorted_arguments(machine, arguments, name, count, options))

    return name.lower(), call


Ability = Callable[[Given], Value | None]
"""What a controller has beside what all of them have: it gets the arguments of its call."""


def as_function(does: Ability) -> Function:
    def call(machine: Machine, arguments: Sequence[s.Argument]) -> Value | None:
        return does(any_arguments(machine, arguments))

    return call
