"""Meaning of data names in a program, and names for the parts of records.

`ProgramData` holds the data of all modules, `NameUses` the uses of names anywhere. Data of every
controller have the values of the instruction and data type manual (3HAC050917): tool0, wobj0,
load0, speeddata, zonedata. External axes for which no target states a position are not in the cell:
RAPID has 9E9 for their components, and an assignment to them moves nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import field
from functools import cache
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Span
from assistant.languages.rapid.lift.flatten.record_layout import (
    FRAME,
    SETTING_TYPES,
    SPEED_AND_ZONE,
    ChangedFrame,
    ComponentPath,
    RecordLayouts,
    changed_frame,
    component_parameters,
    steady_types,
)
from assistant.languages.rapid.tables.constants import (
    LEAST_CENTRE,
    LEAST_MASS,
    SPEEDS,
    UNUSED,
    ZONES,
    usual_sizes,
)
from assistant.languages.rapid.tables.predefined import data as predefined
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.changed_data import changed_by, routines_by_name
from assistant.languages.rapid.tree.literals import (
    EXTERNAL_AXES,
    EXTERNAL_COMPONENT,
    literal_number,
    used_axes,
)
from assistant.languages.rapid.tree.syntax import TargetRun
from assistant.languages.rapid.tree.walk import nodes, root
from assistant.languages.runs.columns import NameIndex
from assistant.program.program import TakenNames, identifier

NO_AXIS: Final = s.NumberLiteral("9E9")
NO_AXIS_TEXT: Final = s.StringLiteral("9E+09")
"""The same as ValToStr writes it."""


def _unused_axes(modules: Sequence[s.Module]) -> frozenset[str]:
    """Components of external axes that no target which is written out gives a place."""
    return frozenset(EXTERNAL_AXES) - used_axes(modules)


def is_unused_axis(node: Any, unused: frozenset[str]) -> bool:
    """True if a component of a target belongs to an external axis that the cell does not have."""
    match node:
        case s.Component(s.Component(_, part), axis):
            return part.lower() == EXTERNAL_COMPONENT and axis.lower() in unused
    return False


def _only_computes(routine: s.Routine | None, divisors: Set[str]) -> bool:
    """True if a function only computes a value and cannot raise an error.

    divisors: lower-case names of data that are never 0.
    """
    match routine:
        case s.Routine(kind="FUNC", body=(s.ReturnFrom(value=value),), handlers=()):
            return value is not None and _never_fails(value, divisors)
    return False


def _never_fails(value: s.Expression, divisors: Set[str]) -> bool:
    match value:
        # Division by 0 is an error, which a left out call would no longer raise.
        case s.Infix("/", left, s.NameRef(name)):
            return name.lower() in divisors and _never_fails(left, divisors)
        case s.Infix("/", left, right):
            return bool(literal_number(right)) and _never_fails(left, divisors)
        case s.Infix("+" | "-" | "*", left, right):
            return _never_fails(left, divisors) and _never_fails(right, divisors)
        case s.Prefix("+" | "-", operand):
            return _never_fails(operand, divisors)
    return isinstance(value, s.NumberLiteral | s.NameRef)


@dataclass(frozen=True, slots=True)
class Datum:
    """Data, or a parameter.

    type: without aliases. dimensions: how many. names: of its parts by their ways, empty for what
    stays whole. value: of data that nothing changes, None if that is not known. sizes: of an array,
    none of a parameter.
    """

    name: str
    type: str
    dimensions: int = 0
    names: Mapping[ComponentPath, str] = field(default_factory=dict)
    value: s.Expression | None = None
    sizes: tuple[s.Expression, ...] = ()


Names = Mapping[str, Datum]
"""Data by lower-case name."""
PI: Final = "pi"
"""A constant of the system, which a program may hide."""


class FreshNames:
    """Gives names that nothing in some modules has. made: those that it gave, in lower case."""

    def __init__(self, modules: Sequence[s.Module]) -> None:
        self._taken = TakenNames(_all_names(modules))
        self.made: set[str] = set()

    def __call__(self, wanted: str) -> str:
        name = identifier(wanted, self._taken)
        self._taken.add(name)
        self.made.add(name.lower())
        return name


class ProgramData:
    """All modules together.

    unused: components of external axes that nothing states a place of. at: where the statement at
    hand stands. outside: where such a component is left out. remarks: other findings.
    data: of the modules. routines: those whose names are theirs alone, by lower-case name.
    displaced: the displacement of all work objects, empty without any. steady: see `steady_types`.
    moving: tools and work objects of the modules that change.
    """

    def __init__(
        self,
        modules: Sequence[s.Module],
        layouts: RecordLayouts,
        name: FreshNames,
        displaced: str = "",
    ) -> None:
        self.layouts, self.name, self.displaced = layouts, name, displaced
        self.steady = steady_types(modules, layouts)
        self.moving: dict[str, ChangedFrame] = {}
        self.unused = _unused_axes(modules)
        self.at: Span | None = None
        self.outside: list[tuple[Span | None, str]] = []
        self.remarks: list[Diagnostic] = []
        items = [item for module in modules for item in module.items]
        routines: dict[str, list[s.Routine]] = {}
        for item in items:
            if isinstance(item, s.Routine):
                routines.setdefault(item.name.lower(), []).append(item)
        self.routines = {name: own[0] for name, own in routines.items() if len(own) == 1}
        self.own = frozenset(routines)
        self.parted = component_parameters(self.routines, layouts)
        self.uses = NameUses(modules, self.parted)
        declared: dict[str, list[s.Data]] = {}
        for item in items:
            if isinstance(item, s.Data):
                declared.setdefault(item.name.lower(), []).append(item)
        self.data: dict[str, Datum] = {
            name: self.datum(own[0], shared=True) for name, own in declared.items() if len(own) == 1
        }

        self._tables = [
            (NameIndex(item.run.names), item.run)
            for item in items
            if isinstance(item, s.TargetRunNode)
        ]
        self._declared = frozenset(declared)
        self._elsewhere: set[str] = set()
        """Names in lower case that no module declares data by."""
        self._parameters: dict[int, Datum] = {}
        self._results: dict[int, Mapping[ComponentPath, str]] = {}

    @property
    def has_axes(self) -> bool:
        """True if anything states the position of an external axis."""
        return not self.unused.issuperset(EXTERNAL_AXES)

    def data_of(self, name: str) -> Datum | None:
        """Data of the modules by its lower-case name, also a row of a table of targets."""
        if name in self.data:
            return self.data[name]
        if name in self._elsewhere:
            return None
        for index, run in self._tables:
            row = int(index.row(name)[0])
            if row >= 0:
                datum = Datum(run.names.name(row), "robtarget", value=row_value(run, row))
                # Cached under its name, so that tables are searched once for each target.
                return self.data.setdefault(name, datum)
        self._elsewhere.add(name)
        return None

    def only_works_out(self, name: str) -> bool:
        """True if a function of the modules changes nothing. name: in lower case."""
        routine = self.routines.get(name)
        own = set() if routine is None else {one.name.lower() for one in parameter_nodes(routine)}
        return _only_computes(routine, {PI} - self._declared - own)

    def datum(self, node: s.Data | s.ParameterNode, shared: bool = False) -> Datum:
        """Return the datum of a declaration, with names for its parts if it is split.

        shared: the declaration is in a module.
        """
        type, moves, steady = self.layouts.base(node.type), False, False
        if isinstance(node, s.ParameterNode):
            apart = type not in SETTING_TYPES or type in SPEED_AND_ZONE or id(node) in self.parted
            value, dimensions = None, node.dimensions
            sizes: tuple[s.Expression, ...] = ()
        else:
            key, dimensions = node.name.lower(), len(node.dimensions)
            sizes = node.dimensions
            steady = node.storage == "CONST" or key not in self.uses.written
            value = node.value if steady else None
            changing = type in SPEED_AND_ZONE and not steady
            apart = type not in SETTING_TYPES or changing or self._is_data(key, steady)
            named = key in self.uses.named and shared and not dimensions and type in self.steady
            # A displacement moves every named work object; without one, only those that the program
            # changes in parts.
            moves = named and ((type == FRAME and bool(self.displaced)) or not (apart or steady))
            apart = apart or moves
        parts = (self.layouts.parts(type) or ()) if apart else ()
        names = {one.path: self.name(f"{node.name}_{one.name}") for one in parts}
        if names and moves and isinstance(node, s.Data):
            self.moving[node.name.lower()] = changed_frame(
                node, type, names, self.displaced, steady
            )
        return Datum(node.name, type, dimensions, names, value, sizes)

    def _is_data(self, key: str, steady: bool) -> bool:
        """True if a tool, frame, speed or zone is used by its parts, or as one of several
        values.
        """
        named, uses = key in self.uses.named, self.uses
        return (steady and key in uses.parted) or (not named and (not steady or key in uses.read))

    def stays(self, node: s.Data) -> bool:
        """True if data that is split is also used complete, by its name."""
        type = self.layouts.base(node.type)
        if type in SPEED_AND_ZONE and node.name.lower() in self.uses.written:
            # Each move states the parts of a speed or zone that changes.
            return False
        return type in SETTING_TYPES and node.name.lower() in self.uses.named

    @property
    def made(self) -> set[str]:
        """Names in lower case that nothing in the program as it was read has."""
        return self.name.made

    def datum_of(self, node: s.ParameterNode) -> Datum:
        """Return the datum of a parameter, the same one for every caller."""
        if id(node) not in self._parameters:
            self._parameters[id(node)] = self.datum(node)
        return self._parameters[id(node)]

    def result(self, routine: s.Routine) -> Mapping[ComponentPath, str]:
        """Variables for the parts of the record that a function gives back, none of any other."""
        if id(routine) not in self._results:
            own = routine.kind == "FUNC" and self.routines.get(routine.name.lower()) is routine
            parts = (self.layouts.parts(routine.type) or ()) if own else ()
            names = {one.path: self.name(f"{routine.name}_{one.name}") for one in parts}
            self._results[id(routine)] = names
        return self._results[id(routine)]

    def plain_type(self, type: str) -> str:
        """Return the type behind an alias if every controller has it; else the type itself."""
        layouts = self.layouts
        plain = layouts.is_whole(type) or layouts.kind(type) in ("HANDLE", "DEVICE")
        return layouts.base(type) if plain else type


class NameUses:
    """Uses of names anywhere, regardless of their meaning there, in lower case.

    written: may be changed. named: passed by name to a routine or a move. parted: a component is
    read. read: used in any other way, as where a routine of the program takes the parts. parted
    (argument): see `component_parameters`.
    """

    def __init__(self, modules: Sequence[s.Module], parted: Set[int]) -> None:
        self._parts = parted
        self.written: set[str] = set()
        self.named: set[str] = set()
        self.parted: set[str] = set()
        self.read: set[str] = set()
        self._own = routines_by_name(modules)
        for node in nodes(tuple(modules)):
            if isinstance(node, s.Assignment | s.ProcedureCall | s.FunctionCall):
                self.written.update(changed_by(node, self._own))
            match node:
                case s.Assignment(_, value):
                    self._add(self.read, value)
                case s.ProcedureCall(_, arguments) | s.FunctionCall(_, arguments):
                    self._given(node.name, arguments)
                case s.Component(value):
                    self._add(self.parted, value)
                case s.MoveRunNode(run):
                    for one in run.motions.table:
                        given = (one.speed, one.zone, one.tool, one.frame)
                        self.named.update(name.lower() for name in given if name)
                case s.Infix(_, left, right):
                    self._add(self.read, left)
                    self._add(self.read, right)
                case s.ReturnFrom(value):
                    self._add(self.read, value)

    def _add(self, names: set[str], value: Any) -> None:
        if (found := root(value)) is not None:
            names.add(found.name.lower())

    def _given(self, name: Any, arguments: Sequence[s.Argument]) -> None:
        own = self._own.get(name.lower(), ()) if isinstance(name, str) else ()
        apart = _parted_arguments(own[0], arguments, self._parts) if len(own) == 1 else ()
        for argument in arguments:
            value = argument.variable if isinstance(argument, s.Conditional) else argument.value
            if any(argument is one for one in apart):
                self._add(self.read, value)
            # A component is passed by its own variable, so the whole is not needed by name.
            elif not isinstance(value, s.Component):
                self._add(self.named, value)


def _parted_arguments(
    routine: s.Routine, arguments: Sequence[s.Argument], parted: Set[int]
) -> Sequence[s.Argument]:
    """Arguments of which a routine takes the parts."""
    groups = (group for group in routine.parameters if not group.optional)
    given = (one for one in arguments if isinstance(one, s.Positional))
    pairs = zip(groups, given, strict=False)
    return [one for group, one in pairs if id(group.alternatives[0]) in parted]


def parameter_nodes(routine: s.Routine) -> Iterator[s.ParameterNode]:
    for group in routine.parameters:
        yield from (one for one in group.alternatives if isinstance(one, s.ParameterNode))


def predefined_type(name: str) -> str:
    """Return the type of data that every controller has, empty for an unknown name."""
    found = predefined().get(name.lower())
    return "" if found is None else found.type


_NAMED_NODES: Final = (s.NameRef, s.Data, s.ParameterNode, s.Routine, s.Record, s.Alias)


def row_value(run: TargetRun, row: int) -> s.Expression:
    """The value of a row of a table as it would be written out."""
    numbers = [_number_literal(n) for n in run.values[row].tolist()]
    parts = (numbers[:3], numbers[3:7], numbers[7:11], numbers[11:])
    return s.AggregateNode(tuple(s.AggregateNode(tuple(part)) for part in parts))


def _number_literal(value: float) -> s.Expression:
    # 17 digits give every double back exactly.
    text = s.NumberLiteral("9E9" if value >= UNUSED else f"{abs(value):.17g}")
    return s.Prefix("-", text) if value < 0.0 else text


def _all_names(modules: Iterable[s.Module]) -> Iterator[str]:
    """Every name in the modules."""
    for node in nodes(tuple(modules)):
        if isinstance(node, _NAMED_NODES):
            yield node.name
        elif isinstance(node, s.ForLoop):
            yield node.variable
        elif isinstance(node, s.TargetRunNode):
            yield from map(node.run.names.name, range(len(node.run)))


_BASE_POSE: Any = [[0, 0, 0], [1, 0, 0, 0]]
_LEAST_LOAD: Any = [LEAST_MASS, list(LEAST_CENTRE), [1, 0, 0, 0], 0, 0, 0]


_VMAX_SPEED: Final = 10000.0
"""mm/s in the place of `vmax`, which is what the arm can: no arm's tool is faster."""


_ARM_MAXIMA: Final[Mapping[str, float]] = {"maxrobspeed": 5000.0, "maxrobreorientspeed": 500.0}
"""Assumed results of functions that return a maximum of the arm: mm/s and deg/s.

Values of `vmax` for the usual arms (3HAC050917, speeddata).
"""


def arm_maximum(name: str) -> s.NumberLiteral | None:
    """Return the assumed result of a function that returns a maximum of the arm. name: in lower
    case.
    """
    return s.NumberLiteral(f"{_ARM_MAXIMA[name]:g}") if name in _ARM_MAXIMA else None


@cache
def predefined_value(name: str) -> s.Expression | None:
    """The value of predefined data of that name in lower case, None if it is not known here.

    Source: the instruction and data type manual (3HAC050917): tool0, wobj0, load0, speeddata,
    zonedata.
    """
    match name:
        case "tool0":
            return _literal([True, _BASE_POSE, _LEAST_LOAD])
        case "wobj0":
            return _literal([False, True, "", _BASE_POSE, _BASE_POSE])
        case "load0":
            return _literal(_LEAST_LOAD)
    speed, zone = SPEEDS.get(name), ZONES.get(name)
    if speed is not None:
        # `vmax` has no finite number of its own.
        return _literal([min(speed.tcp, _VMAX_SPEED), 500, 5000, 1000])
    if zone is not None and zone.radius is not None:
        return _literal([False, zone.radius, *usual_sizes(zone.radius)])
    return None if zone is None else _literal([True, *(0,) * 6])


def _literal(value: Any) -> s.Expression:
    match value:
        case bool():
            return s.BoolLiteral(value)
        case str():
            return s.StringLiteral(value)
        case list():
            return s.AggregateNode(tuple(map(_literal, value)))
    return s.NumberLiteral(f"{value:g}")


def predefined_component(
    layouts: RecordLayouts, name: str, path: Sequence[str]
) -> s.Expression | None:
    """A component of predefined data, None if its value is not known here."""
    low, type = name.lower(), predefined_type(name)
    value = None if low == "vmax" else predefined_value(low)
    for component in path:
        names = [inner.lower() for inner, _ in layouts.components(type)]
        low = component.lower()
        if not isinstance(value, s.AggregateNode) or low not in names:
            return None
        value = value.items[names.index(low)]
        type = layouts.component(type, component) or ""
    whole = not isinstance(value, s.AggregateNode) or layouts.is_whole(type)
    return value if whole else None
