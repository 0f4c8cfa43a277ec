"""What the uses of a name that nobody declares tell of it, gathered one by one."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from assistant.languages.rapid.checks.kinds import SIGNAL_TYPES, Types
from assistant.languages.rapid.checks.wanted_records import RecordUses, SolvedRecord
from assistant.program.program import Signal
from assistant.program.undeclared_names import CallArgument, Plain, Wanted, WantedKind

KIND_OF_TYPE: Final[Mapping[str, WantedKind]] = {
    "tooldata": "tool", "wobjdata": "frame", "speeddata": "speed", "zonedata": "blend",
    "robtarget": "position", "jointtarget": "joints",
}  # fmt: skip
SIGNAL_TYPE: Final = re.compile(r"signal([adg])([io])")
_SIGNAL_LETTERS: Final = {"a": "analog", "d": "digital", "g": "group", "i": "input", "o": "output"}
SIGNAL_NAME: Final = re.compile(r"(?i:([adg])([io])|s?(d)(i))(?=_|\d|[A-Z]|$)")
"""How people name signals: `diReady`, `DO_3`, `sdiStart`."""

TRAP_TYPE: Final = "trap"
"""What stands for the type of the result of a routine that interrupts call."""
WEAK_USE: Final = 0.01
"""What a use counts that may be of another type as well: a number that is compared may be the state
of a signal."""


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
    """What is known of one name. types: how often its uses want it to be of each. usual: of what
    the controller tells of itself, what it mostly is. parts: its components that are asked for.
    """

    name: str
    types: Counter[str] = field(default_factory=Counter)
    counted: bool = False
    assigned: bool = False
    extents: list[int] = field(default_factory=list)
    routine: str = ""
    calls: list[tuple[GivenArgument, ...]] = field(default_factory=list)
    uses: dict[str, None] = field(default_factory=dict)
    usual: Plain | None = None
    parts: RecordUses = field(default_factory=lambda: RecordUses(""))


def wanted_of(
    met: Mapping[str, NameUses], types: Types, records: Mapping[str, SolvedRecord]
) -> Iterator[Wanted]:
    """Questions to a cell, in the order of the names. records: record types to be asked for.

    Data that are only given to a routine have the type that other calls give there, and a
    parameter that of the data.
    """
    routines = [one for one in met.values() if one.routine and one.usual is None]
    for routine in routines:
        for slot in _parameter_slots(routine.calls).values():
            _agree_on_type(slot, met)
    data = {key: missing_data(one, types, records) for key, one in met.items() if not one.routine}
    for key, one in met.items():
        found = data[key] if key in data else _missing_routine(one, types, records, data)
        if found is not None:
            yield found


def _parameter_slots(
    calls: Sequence[Sequence[GivenArgument]],
) -> dict[int | str, list[GivenArgument]]:
    """What all calls give for each parameter, by its place or the lower-case name of its option."""
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
        return missing_data(met, types, records)
    uses = tuple(met.uses)
    if met.routine == "TRAP":
        return Wanted(met.name, "routine", TRAP_TYPE, uses=uses)
    parameters = tuple(
        _parameter(slot, data) for slot in _ordered_slots(_parameter_slots(met.calls))
    )
    if met.routine == "PROC":
        return Wanted(met.name, "routine", arguments=parameters, uses=uses)
    type = met.types.most_common(1)[0][0] if met.types else "num"
    nothing = _neutral_value(type, types)
    return Wanted(met.name, "routine", type, (), parameters, uses=uses, nothing=nothing)


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


def missing_data(met: NameUses, types: Types, records: Mapping[str, SolvedRecord]) -> Wanted | None:
    """What a cell is asked for data. records: types that it is asked for as well."""
    uses = tuple(met.uses)
    if met.usual is not None:
        (type,) = met.types
        return Wanted(met.name, "data", type, uses=uses, nothing=met.usual)
    type = met.types.most_common(1)[0][0] if met.types else ""
    if type in SIGNAL_TYPES:
        return Wanted(met.name, "signal", type, signal=_signal_of_type(type), uses=uses)
    if type == "num" and not met.assigned and met.types["num"] < 1 and not met.extents:
        named = SIGNAL_NAME.match(met.name)
        letters = "".join(filter(None, named.groups())).lower() if named else "di"
        type = f"signal{letters}"
        return Wanted(met.name, "signal", type, signal=_signal_of_type(type), uses=uses)
    if type in records:
        nothing = _array_of(records[type].nothing, met.extents)
        size = tuple(met.extents)
        return Wanted(met.name, "data", type, size, uses=uses, assigned=True, nothing=nothing)
    type = type if types.kind(type) not in ("", "OTHER") else "num"
    if types.kind(type) == "DEVICE" or (
        types.kind(type) == "RECORD" and type not in _NEUTRAL_VALUES and not types.components(type)
    ):
        return None  # of the controller's configuration, or of an option whose records nobody lists
    kind = KIND_OF_TYPE.get(type, "data") if not (met.extents or met.assigned) else "data"
    nothing = _array_of(_neutral_value(type, types), met.extents)
    size = tuple(met.extents)
    return Wanted(met.name, kind, type, size, uses=uses, assigned=met.assigned, nothing=nothing)


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
    found = SIGNAL_TYPE.fullmatch(type)
    if found is None:
        return None
    kind, direction = _SIGNAL_LETTERS[found[1]], _SIGNAL_LETTERS[found[2]]
    return Signal(kind, direction)  # type: ignore[arg-type]
