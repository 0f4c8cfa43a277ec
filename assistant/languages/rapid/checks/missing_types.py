"""Types of names and records that nobody declares, inferred from their uses.

Every use of a name is counted; the type that most of them need is taken. Records of undeclared
types get components: with `VAR message m:=[[0,"x"],FALSE];`, `m.data.text` and `m.full`, `message`
is a record of a record (a number and a text) and a truth. Names that are used get the first values
that fit; a value without a name is a `part_1`. The cell states what it really is.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from typing import Final, Literal

from assistant.base.data_classes import dataclass
from assistant.languages.rapid.checks.rule_context import NUMBER, SIGNAL_TYPES, Types
from assistant.languages.rapid.tree import syntax as s
from assistant.program.program import Signal, TakenNames, identifier
from assistant.program.undeclared_names import CallArgument, Plain, Wanted, WantedKind

_SCALARS: Final[dict[str, Plain]] = {"num": 0.0, "dnum": 0.0, "bool": False, "string": ""}
_ANY_KIND: Final = ""
"""Kind of a value that may have any type."""
_BRACKETS: Final = "["


_OWN_PARTS: Final[Mapping[str, tuple[str, ...]]] = {
    "robtarget": ("robconf",),
    "jointtarget": ("robax",),
    "tooldata": ("tframe", "tload"),
    "wobjdata": ("uframe", "oframe", "ufprog", "ufmec"),
    "speeddata": ("v_tcp", "v_ori", "v_leax", "v_reax"),
    "zonedata": ("finep", "pzone_tcp", "pzone_ori", "zone_ori"),
    "loaddata": ("mass", "cog", "aom"),
    "pos": ("x", "y", "z"),
    "orient": ("q1", "q2", "q3", "q4"),
    "confdata": ("cf1", "cf4", "cf6", "cfx"),
}
_RECORD_OF_PART: Final = {part: type for type, parts in _OWN_PARTS.items() for part in parts}
"""Components that one predefined record alone has → that record."""


@dataclass(slots=True)
class RecordUses:
    """A type, or a component that is itself a record.

    parts: by lower-case name. types: of a type or component that is not a record, how many uses
    require each type. rows: values in brackets.
    """

    name: str
    parts: dict[str, RecordUses] = field(default_factory=dict)
    types: Counter[str] = field(default_factory=Counter)
    rows: list[s.AggregateNode] = field(default_factory=list)
    uses: dict[str, None] = field(default_factory=dict)

    def note(self, path: Sequence[str], type: str, place: str) -> None:
        """A use of a component of a component …, and the type that is wanted there."""
        if place:
            self.uses.setdefault(place)
        if not path:
            if type:
                self.types[type] += 1
            return
        first, *rest = path
        self.parts.setdefault(first.lower(), RecordUses(first)).note(rest, type, "")

    def join(self, other: RecordUses) -> None:
        for key, part in other.parts.items():
            self.parts.setdefault(key, RecordUses(part.name)).join(part)
        self.types += other.types
        self.uses |= other.uses


@dataclass(frozen=True, slots=True)
class SolvedRecord:
    """Components of a type, (type, name) each, with the value that says least."""

    components: tuple[tuple[str, str], ...]
    nothing: Plain | None


class UndeclaredRecords:
    """The types of a program that nobody declares, or whose components are not known."""

    def __init__(self, types: Types) -> None:
        self.types = types
        self.found: dict[str, RecordUses] = {}
        self.solved: dict[str, SolvedRecord] = {}
        self._names: dict[str, str] = {}
        self._taken = TakenNames()

    def is_open(self, type: str) -> bool:
        """True if a type may be a record with unknown components."""
        low = type.lower()
        if not low:
            return False
        base = self.types.base(low) or low
        kind = self.types.kind(base)
        return kind == "" or (kind == "RECORD" and not self.types.components(base))

    def note(self, type: str, path: Sequence[str], wanted: str, place: str) -> None:
        self.found.setdefault(type.lower(), RecordUses(type)).note(path, wanted, place)

    def row(self, type: str, value: s.Expression, dimensions: int, place: str) -> None:
        """A value of a type, in an array of so many dimensions."""
        if not isinstance(value, s.AggregateNode):
            return
        if dimensions > 0:
            for item in value.items:
                self.row(type, item, dimensions - 1, place)
            return
        shape = self.found.setdefault(type.lower(), RecordUses(type))
        shape.rows.append(value)
        shape.note((), "", place)

    def owner(self, data: str, parts: RecordUses) -> str:
        """The type of data with components of these names: a new one if no other or several do."""
        names = parts.parts.keys()
        found = [key for key, shape in self.found.items() if names & shape.parts.keys()]
        if len(found) == 1:
            return self.found[found[0]].name
        name = f"{data}_type"
        self.found.setdefault(name.lower(), RecordUses(name))
        return name

    def wanted(self) -> Iterator[Wanted]:
        """The types with their components, as far as those can be."""
        self._taken.update(shape.name for shape in self.found.values())
        for key, shape in list(self.found.items()):
            if self._is_told(key, shape):
                made = list(self._made(shape.name, shape))
                yield from made

    def _is_told(self, key: str, shape: RecordUses) -> bool:
        """True if the cell should be asked about the type: a type of a controller option only if
        the program reads a component.
        """
        return bool(shape.parts) or (bool(shape.rows) and self.types.kind(key) == "")

    def _made(self, name: str, shape: RecordUses) -> Iterator[Wanted]:
        solved = self._solve(name, shape)
        if solved is None:
            return
        inner, outer = solved
        self.solved[name.lower()] = outer
        said = tuple(f"{type} {part}" for type, part in outer.components)
        yield Wanted(name, "record", uses=tuple(shape.uses), nothing=said)
        yield from inner

    def _solve(self, name: str, shape: RecordUses) -> tuple[list[Wanted], SolvedRecord] | None:
        """The components of a record, and the records among them; None if its uses disagree."""
        slots = _kinds_of_values(shape.rows)
        if slots is None:
            return None
        inner: list[Wanted] = []
        found: dict[int, tuple[str, str, Plain | None]] = {}
        # Components with components come first, as only a value in brackets can be theirs.
        parts = sorted(shape.parts.values(), key=lambda part: not part.parts)
        for part in parts:
            at = self._place(part, slots, found) if shape.rows else len(found)
            if at is None:
                return None
            if shape.rows:
                part.rows += _inner_values(shape.rows, at)
                if not part.types and slots[at] in _SCALARS:  # no use tells more than its value
                    part.types[slots[at]] += 1
            said = self._component(name, part, inner)
            if said is None:
                return None
            found[at] = (said[0], part.name, said[1])
        for at, kind in enumerate(slots):
            if at not in found:
                rest = RecordUses(
                    identifier(f"part_{at + 1}", {p.name for p in shape.parts.values()})
                )
                rest.rows += _inner_values(shape.rows, at)
                rest.types[kind or "num"] += kind != _BRACKETS
                said = self._component(name, rest, inner)
                if said is None:
                    return None
                found[at] = (said[0], rest.name, said[1])
        order = [found[at] for at in sorted(found)]
        values = [value for _, _, value in order if value is not None]
        nothing = tuple(values) if len(values) == len(order) else None
        return inner, SolvedRecord(tuple((type, part) for type, part, _ in order), nothing)

    def _component(
        self, owner: str, part: RecordUses, inner: list[Wanted]
    ) -> tuple[str, Plain | None] | None:
        """The type of a component and the value of it that says least."""
        type = part.types.most_common(1)[0][0] if part.types else _ANY_KIND
        type = "num" if type == NUMBER else type
        if part.parts or (part.rows and not self._fits(type, part.rows)):
            name = identifier(f"{owner}_{part.name}", self._taken)[:32]
            self._taken.add(name)
            made = list(self._made(name, part))
            if not made:
                return None
            inner += made
            return name, self.solved[name.lower()].nothing
        type = type or "num"
        return type, _SCALARS.get(self.types.base(type) or type)

    def _place(
        self,
        part: RecordUses,
        slots: Sequence[str],
        taken: dict[int, tuple[str, str, Plain | None]],
    ) -> int | None:
        """The first value that a component may be."""
        type = part.types.most_common(1)[0][0] if part.types else _ANY_KIND
        base = self.types.base(type) or type
        if part.parts or (base and base not in _SCALARS and base != NUMBER):
            kinds: tuple[str, ...] = (_BRACKETS, _ANY_KIND)
        else:
            kinds = ("num" if base in (NUMBER, "dnum") else base, _ANY_KIND)
        elsewhere = not base and not part.parts
        for at, kind in enumerate(slots):
            # A component of unknown type may be any value but one in brackets.
            if at not in taken and (kind in kinds or (elsewhere and kind != _BRACKETS)):
                return at
        return None

    def _fits(self, type: str, rows: Sequence[s.AggregateNode]) -> bool:
        """True if values in brackets fit a known type."""
        components = self.types.components(self.types.base(type) or type) if type else None
        return bool(components) and all(len(row.items) == len(components or ()) for row in rows)


def _kinds_of_values(rows: Sequence[s.AggregateNode]) -> list[str] | None:
    """Return the kinds of the values of records, in order; None if the records differ."""
    slots: list[str] = []
    for row in rows:
        kinds = list(map(_value_kind, row.items))
        slots = slots or kinds
        if len(kinds) != len(slots):
            return None
        for at, (one, other) in enumerate(zip(slots, kinds, strict=True)):
            if one and other and one != other:
                return None
            slots[at] = one or other
    return slots


def _inner_values(rows: Sequence[s.AggregateNode], at: int) -> list[s.AggregateNode]:
    items = (row.items[at] for row in rows)
    return [item for item in items if isinstance(item, s.AggregateNode)]


def _value_kind(node: s.Expression) -> str:
    match node:
        case s.AggregateNode():
            return _BRACKETS
        case s.NumberLiteral() | s.Prefix("-" | "+", s.NumberLiteral()):
            return "num"
        case s.StringLiteral():
            return "string"
        case s.BoolLiteral():
            return "bool"
    return _ANY_KIND


def record_of(parts: Sequence[str]) -> str:
    """The predefined record that has a component of a component …, empty if several have."""
    first = parts[0]
    if first in _RECORD_OF_PART:
        return _RECORD_OF_PART[first]
    if first in ("trans", "rot"):
        return "robtarget"
    if first == "extax":
        return "jointtarget" if "robax" in parts else "robtarget"
    return ""


KIND_OF_TYPE: Final[Mapping[str, WantedKind]] = {
    "tooldata": "tool", "wobjdata": "frame", "speeddata": "speed", "zonedata": "blend",
    "robtarget": "position", "jointtarget": "joints",
}  # fmt: skip
_SIGNAL_TYPE: Final = re.compile(r"signal([adg])([io])")
_SIGNAL_LETTERS: Final = {"a": "analog", "d": "digital", "g": "group", "i": "input", "o": "output"}
_SIGNAL_NAME: Final = re.compile(r"(?i:([adg])([io])|s?(d)(i))(?=_|\d|[A-Z]|$)")
"""Common signal names: `diReady`, `DO_3`, `sdiStart`."""

TRAP_TYPE: Final = "trap"
"""Marker used as the result type of a routine that interrupts call."""
WEAK_USE: Final = 0.01
"""Weight of a use that allows another type as well: a number in a comparison may be the state of a
signal.
"""


@dataclass(frozen=True, slots=True)
class GivenArgument:
    """An argument of a call of a routine that nobody declares.

    name: of the data that the argument is, in lower case, if nobody declares those either: their
    other uses give the type. element: it is one element of them.
    """

    argument: CallArgument
    name: str = ""
    element: bool = False


@dataclass(slots=True)
class NameUses:
    """Uses of one name. types: how many uses require each type. usual: usual value of a controller
    state. parts: the components that the program reads. compared: True if a comparison uses it.
    counted: True if a use requires more than on or off, such as a sum, or a comparison with 5.
    sets: data that calls of a routine hand over to be given values.
    """

    name: str
    types: Counter[str] = field(default_factory=Counter)
    compared: bool = False
    counted: bool = False
    assigned: bool = False
    extents: list[int] = field(default_factory=list)
    routine: str = ""
    calls: list[tuple[GivenArgument, ...]] = field(default_factory=list)
    uses: dict[str, None] = field(default_factory=dict)
    usual: Plain | None = None
    sets: dict[str, None] = field(default_factory=dict)
    parts: RecordUses = field(default_factory=lambda: RecordUses(""))


def agree_on_types(alike: Sequence[tuple[str, str]], met: Mapping[str, NameUses]) -> None:
    """Give names whose uses show no type that of names they are assigned to or compared with.

    alike: pairs of names in lower case that have one type. A signal that is read is a number.
    """
    pairs = [(met[a], met[b]) for a, b in alike if a in met and b in met]
    changed = True
    while changed:
        changed = False
        for one, other in (*pairs, *((b, a) for a, b in pairs)):
            type, weight = other.types.most_common(1)[0] if other.types else ("", 0)
            if type and weight >= 1 and not one.types and not one.parts.parts:
                one.types["num" if type in SIGNAL_TYPES else type] += 1
                changed = True


_ROWS: Final[Mapping[tuple[int, ...], str]] = {
    (3, 4, 4, 6): "robtarget", (6, 6): "jointtarget", (3, 4): "pose",
}  # fmt: skip
"""Lengths of the brackets in a value that only one type has → that type."""


def type_of_row(value: s.Expression) -> str:
    """Return the type that a value in brackets shows, empty if several have such values."""
    if not isinstance(value, s.AggregateNode):
        return ""
    inner = [one.items if isinstance(one, s.AggregateNode) else () for one in value.items]
    numbers = all(_value_kind(one) != _BRACKETS for items in inner for one in items)
    return _ROWS.get(tuple(map(len, inner)), "") if numbers else ""


def wanted_of(
    met: Mapping[str, NameUses], types: Types, records: Mapping[str, SolvedRecord]
) -> Iterator[Wanted]:
    """Questions to a cell, in the order of the names. records: record types to be asked for.

    Data that are only given to a routine have the type that other calls give there, and a
    parameter that of the data.
    """
    # First the types that calls agree on, as data without another use gets its type from them.
    routines = [one for one in met.values() if one.routine and one.usual is None]
    for routine in routines:
        for slot in _parameter_slots(routine.calls).values():
            _agree_on_type(slot, met)
    data = {key: _missing_data(one, types, records) for key, one in met.items() if not one.routine}
    for key, one in met.items():
        found = data[key] if key in data else _missing_routine(one, types, records, data)
        if found is not None:
            yield found


def _parameter_slots(
    calls: Sequence[Sequence[GivenArgument]],
) -> dict[int | str, list[GivenArgument]]:
    """Return the arguments of all calls for each parameter, by its position or the lower-case name
    of its option.
    """
    slots: dict[int | str, list[GivenArgument]] = {}
    for call in calls:
        plain = (one for one in call if not one.argument.option)
        for at, one in enumerate(plain):
            slots.setdefault(at, []).append(one)
        for one in call:
            if one.argument.option:
                slots.setdefault(one.argument.option.lower(), []).append(one)
    return slots


def _agree_on_type(slot: Sequence[GivenArgument], met: Mapping[str, NameUses]) -> None:
    """Give data without another use the type of what other calls give for the same parameter."""
    type = next((one.argument.type for one in slot if one.argument.type), "")
    for one in slot if type else ():
        if one.name and not (met[one.name].types or met[one.name].parts.parts):
            met[one.name].types[type] += 1


def _missing_routine(
    met: NameUses,
    types: Types,
    records: Mapping[str, SolvedRecord],
    data: Mapping[str, Wanted | None],
) -> Wanted | None:
    if met.usual is not None:
        return _missing_data(met, types, records)
    uses = tuple(met.uses)
    if met.routine == "TRAP":
        return Wanted(met.name, "routine", TRAP_TYPE, uses=uses)
    parameters = tuple(
        _parameter(slot, data) for slot in _ordered_slots(_parameter_slots(met.calls))
    )
    if met.routine == "PROC":
        return Wanted(met.name, "routine", arguments=parameters, uses=uses, sets=tuple(met.sets))
    type = met.types.most_common(1)[0][0] if met.types else "num"
    nothing = _neutral_value(type, types)
    return Wanted(
        met.name, "routine", type, (), parameters, uses=uses, nothing=nothing, sets=tuple(met.sets)
    )


def _ordered_slots(slots: Mapping[int | str, list[GivenArgument]]) -> Iterator[list[GivenArgument]]:
    """Parameters by their place, and then the optional ones."""
    yield from (slot for key, slot in slots.items() if isinstance(key, int))
    yield from (slot for key, slot in slots.items() if isinstance(key, str))


def _parameter(slot: Sequence[GivenArgument], data: Mapping[str, Wanted | None]) -> CallArgument:
    """The parameter that takes what all calls give; a signal may be given for its value."""
    known = [one for given in slot if (one := _resolved_argument(given, data)).type]
    values = (one for one in known if one.type not in SIGNAL_TYPES)
    return next(values, known[0] if known else slot[-1].argument)


def _resolved_argument(given: GivenArgument, data: Mapping[str, Wanted | None]) -> CallArgument:
    found = data.get(given.name)
    if found is None:
        return given.argument
    dimensions = 0 if given.element else len(found.size)
    return replace(given.argument, type=found.type, dimensions=dimensions)


def _missing_data(
    met: NameUses, types: Types, records: Mapping[str, SolvedRecord]
) -> Wanted | None:
    """Return the question to the cell about undeclared data. records: types that the cell is also
    asked for.
    """
    uses = tuple(met.uses)
    if met.usual is not None:
        # A controller state is noted with the one type of its table.
        (type,) = met.types
        return Wanted(met.name, "data", type, uses=uses, nothing=met.usual)
    type = met.types.most_common(1)[0][0] if met.types else ""
    if type in SIGNAL_TYPES:
        return Wanted(met.name, "signal", type, signal=_signal_of_type(type), uses=uses)
    read = type in ("", "num") and not met.assigned and not met.extents
    if read and type and (letters := _signal_letters(met)):
        type = f"signal{letters}"
        return Wanted(
            met.name,
            "signal",
            type,
            signal=_signal_of_type(type),
            uses=uses,
            perhaps=None if _agrees(met, letters) else "data",
        )
    if type in records:
        nothing = _array_of(records[type].nothing, met.extents)
        size = tuple(met.extents)
        return Wanted(met.name, "data", type, size, uses=uses, assigned=True, nothing=nothing)
    type = type if types.kind(type) not in ("", "OTHER") else "num"
    if types.kind(type) == "DEVICE" or (
        types.kind(type) == "RECORD" and type not in _NEUTRAL_VALUES and not types.components(type)
    ):
        return None  # of the controller's configuration, or of an option whose records nobody lists
    # The cell's tables hold single values that nothing assigns; anything else is data.
    kind = KIND_OF_TYPE.get(type, "data") if not (met.extents or met.assigned) else "data"
    nothing = _array_of(_neutral_value(type, types), met.extents)
    size = tuple(met.extents)
    perhaps: Literal["signal", "type"] | None = None
    if kind == "data":
        perhaps = "signal" if read else "type" if not met.types else None
    return Wanted(met.name, kind, type, size, (), None, uses, met.assigned, nothing, perhaps)


def _signal_letters(met: NameUses) -> str:
    """Return the kind of a signal that a number which is only read may be, empty for data."""
    named = _SIGNAL_NAME.match(met.name)
    if named is not None:
        return "".join(filter(None, named.groups())).lower()
    # Only compared with 0 and 1: such a name is more often a signal than a number.
    return "di" if met.compared and not met.counted else ""


def _agrees(met: NameUses, letters: str) -> bool:
    """True if the name and each use show the same signal."""
    named = _SIGNAL_NAME.match(met.name) is not None
    return (
        named and met.compared and met.types["num"] < 1 and (letters[0] != "d" or not met.counted)
    )


_ORIENT: Final = (1.0, 0.0, 0.0, 0.0)
_ORIGIN: Final = (0.0, 0.0, 0.0)
_LOAD: Final = (0.001, (0.0, 0.0, 0.001), _ORIENT, 0.0, 0.0, 0.0)
_NEUTRAL_VALUES: Final[Mapping[str, Plain]] = {
    "num": 0.0, "dnum": 0.0, "bool": False, "string": "", "orient": _ORIENT,
    "extjoint": (9e9,) * 6,
    "loaddata": _LOAD, "tooldata": (True, (_ORIGIN, _ORIENT), _LOAD),
    "speeddata": (100.0, 500.0, 5000.0, 1000.0),
    "zonedata": (True, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    "welddata": (100.0, 0.0, (0.0,) * 9, (0.0,) * 9),
    "spotdata": (0.0,), "beaddata": ("",),
    "wobjdata": (False, True, "", (_ORIGIN, _ORIENT), (_ORIGIN, _ORIENT)),
}  # fmt: skip


def _array_of(value: Plain | None, extents: Sequence[int]) -> Plain | None:
    """An array with one value for all elements."""
    for extent in reversed(extents):
        value = None if value is None else (value,) * extent
    return value


def _neutral_value(type: str, types: Types) -> Plain | None:
    """The value of a type that says least, None where it has no values."""
    base = types.base(type) or type
    if base in _NEUTRAL_VALUES:
        return _NEUTRAL_VALUES[base]
    parts = types.components(base)
    if not parts:
        return None
    inner = [_neutral_value(of.lower(), types) for of in parts.values()]
    known = [one for one in inner if one is not None]
    return tuple(known) if len(known) == len(inner) else None


def _signal_of_type(type: str) -> Signal | None:
    found = _SIGNAL_TYPE.fullmatch(type)
    if found is None:
        return None
    kind, direction = _SIGNAL_LETTERS[found[1]], _SIGNAL_LETTERS[found[2]]
    return Signal(kind, direction)  # type: ignore[arg-type]
