"""Declared data of modules: tools, work objects, speeds, zones, joint targets, variables."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain
from typing import Any, Final, TypeVar

from assistant.languages.rapid.lift.expressions import lift_expression
from assistant.languages.rapid.tables.motions import BLENDS, SPEEDS, speed_of, zone_of
from assistant.languages.rapid.tables.words import VALUE_OF_TYPE
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number, numbers
from assistant.languages.rapid.tree.walk import lists, root
from assistant.languages.records import frame_of, shape, tool_of
from assistant.program import expressions as e
from assistant.program.geometry import BASE, FLANGE, Frame, JointTarget, Target, Tool
from assistant.program.motion import Blend, Speed
from assistant.program.passes.motions import ValueNames
from assistant.program.program import Variable

T = TypeVar("T", Speed, Blend)
STORAGES: Final = {"CONST": "constant", "VAR": "variable", "PERS": "persistent"}


class DataLift:
    """What the data of modules say.

    speeds, blends: by lower-case name, also unnamed ones. start: where the text of the module at
    hand begins.
    """

    def __init__(
        self,
        modules: Sequence[s.Module],
        starts: Sequence[int],
        original: Callable[[str], str],
    ) -> None:
        self.original = original
        self.start = 0
        self.tools: dict[str, Tool] = {}
        self.frames: dict[str, Frame] = {}
        self.speeds: dict[str, Speed] = {}
        self.blends: dict[str, Blend] = {}
        self._spelled: dict[str, str] = {}
        self.joint_targets: dict[str, JointTarget] = {}
        self.targets: dict[str, Target] = {}
        self.variables: dict[str, Variable] = {}
        self._held: set[int] = set()
        self._names: set[str] = set()
        assigned = _assigned_names(modules)
        self._extents = dict(_constant_extents(modules))
        for module, self.start in zip(modules, starts, strict=True):
            for item in module.items:
                if isinstance(item, s.Data) and item.name.lower() not in self._names:
                    constant = item.storage == "CONST" or item.name.lower() not in assigned
                    if self._take(item, constant):
                        self._held.add(id(item))
                        self._names.add(item.name.lower())

    def holds(self, item: s.Data) -> bool:
        return id(item) in self._held

    def named(self, table: ValueNames[T], values: Mapping[str, T]) -> dict[str, T]:
        """Those of some speeds or blends that have names."""
        return {self.original(self._spelled[n]): v for n, v in table.named(values).items()}

    def _take(self, item: s.Data, constant: bool) -> bool:
        """Whether the pseudo-program has a place for the data."""
        type, name = item.type.lower(), self.original(item.name)
        if item.dimensions and type not in VALUE_OF_TYPE:
            return False
        value = numbers(item.value)
        if type == "tooldata" and (tool := tool_of(value)) and name.lower() != FLANGE:
            self.tools[name] = tool
        elif type == "wobjdata" and (frame := frame_of(value)) and name.lower() != BASE:
            self.frames[name] = frame
        elif (
            type == "speeddata"
            and constant
            and (speed := _value_of_other_name(SPEEDS, item, self.speeds))
        ):
            self.speeds[item.name.lower()] = speed
            self._spelled[item.name.lower()] = item.name
        elif (
            type == "zonedata"
            and constant
            and (blend := _value_of_other_name(BLENDS, item, self.blends))
        ):
            self.blends[item.name.lower()] = blend
            self._spelled[item.name.lower()] = item.name
        elif type == "speeddata" and constant and shape(value) == "nnnn":
            self.speeds[item.name.lower()] = speed_of(value)
            self._spelled[item.name.lower()] = item.name
        elif type == "zonedata" and constant and shape(value) == "bnnnnnn":
            zone = zone_of(value[0], value[1:])
            if zone.radius is None and any(value[1:]):
                return False
            self.blends[item.name.lower()] = zone
            self._spelled[item.name.lower()] = item.name
        elif type in VALUE_OF_TYPE:
            variable = self.variable(item)
            if variable is None:
                return False
            match fixed_target(variable):
                case Target() as target:
                    self.targets[name] = target
                case JointTarget() as joints:
                    self.joint_targets[name] = joints
                case None:
                    self.variables[name] = variable
        else:
            return False
        return True

    def _extent(self, node: s.Expression) -> float | int | None:
        """Of an array: a number, or a constant that is one."""
        if isinstance(node, s.NameRef):
            return self._extents.get(node.name.lower())
        return literal_number(node)

    def variable(self, item: s.Data) -> Variable | None:
        """A variable, None if the pseudo-program has none of that kind."""
        type = VALUE_OF_TYPE.get(item.type.lower())
        if type is None:
            return None
        size = [self._extent(d) for d in item.dimensions]
        storage: Any = STORAGES.get(item.storage)  # none in a damaged text
        if storage is None or not all(isinstance(n, int) and n > 0 for n in size):
            return None
        initial = None if item.value is None else lift_expression(item.value, self.original)
        extents = tuple(n for n in size if isinstance(n, int))
        span = item.span and item.span.moved(self.start)
        return Variable(type, initial, extents, storage, item.scope == "LOCAL", span)


def _value_of_other_name(table: ValueNames[T], item: s.Data, known: Mapping[str, T]) -> T | None:
    """The value of data that have the one of other data, which are constant; None for others."""
    if not isinstance(item.value, s.NameRef):
        return None
    low = item.value.name.lower()
    return known.get(low, table.predefined.get(low))


def _constant_extents(modules: Sequence[s.Module]) -> Iterator[tuple[str, int]]:
    """Constant whole numbers, which extents of arrays may be, by lower-case name."""
    for module in modules:
        for item in module.items:
            if isinstance(item, s.Data) and item.storage == "CONST" and not item.dimensions:
                value = literal_number(item.value) if item.value is not None else None
                if isinstance(value, int):
                    yield item.name.lower(), value


def fixed_target(variable: Variable) -> Target | JointTarget | None:
    """The target that a variable always is, None if it is one that can be assigned or no target."""
    if variable.storage != "constant" or variable.size:
        return None
    match variable.initial:
        case e.TargetValue(target):
            return target
        case e.JointValue(joints):
            return joints
    return None


def _assigned_names(modules: Sequence[s.Module]) -> set[str]:
    """Names of variables that a routine assigns to, lower case."""
    routines = (i for m in modules for i in m.items if isinstance(i, s.Routine))
    found: set[str] = set()
    for statement in chain.from_iterable(chain.from_iterable(map(lists, routines))):
        if isinstance(statement, s.Assignment) and (variable := root(statement.target)):
            found.add(variable.name.lower())
    return found
