"""The variables of an FMU: values in a column of their type, each with its place there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Literal

VariableType = Literal["Real", "Integer", "Boolean", "String"]
Causality = Literal["parameter", "input", "output"]
VARIABLE_TYPES: Final[tuple[VariableType, ...]] = ("Real", "Integer", "Boolean", "String")
UNITS: Final = {
    "s": 's="1"',
    "deg": 'rad="1" factor="0.017453292519943295"',
    "mm": 'm="1" factor="0.001"',
    "deg/s": 'rad="1" s="-1" factor="0.017453292519943295"',
    "mm/s": 'm="1" s="-1" factor="0.001"',
    "deg/s2": 'rad="1" s="-2" factor="0.017453292519943295"',
    "mm/s2": 'm="1" s="-2" factor="0.001"',
}
"""Units of variables → what they are in SI units, as a model description says it."""

StartValue = float | int | bool | str


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable. start: its value before anything is set; None for an output."""

    name: str
    description: str
    start: StartValue | None = None
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Group:
    """Variables of one type beside each other; place: what the source calls the first one."""

    place: str
    type: VariableType
    causality: Causality
    variables: Sequence[Variable]


@dataclass(frozen=True, slots=True)
class TypeColumn:
    """The values of one type in a source. kinds: a letter each. starts: literals of C."""

    kinds: str
    starts: Sequence[str]


@dataclass(frozen=True, slots=True)
class PlacedVariable:
    """A variable as a model description has it. reference: its place in the column of its type."""

    name: str
    description: str
    type: VariableType
    causality: Causality
    variability: str
    initial: str
    reference: int
    start: str | None
    unit: str


def column_of_type(groups: Sequence[Group], type: VariableType) -> TypeColumn:
    """The column of a type, with starts of 0 for outputs."""
    kinds, starts = "", []
    for group in groups:
        if group.type == type:
            kinds += group.causality[0] * len(group.variables)
            starts += [_c_literal(variable.start) for variable in group.variables]
    return TypeColumn(kinds, starts)


def group_offsets(groups: Sequence[Group]) -> Iterator[tuple[str, int]]:
    """Where each group begins in the column of its type."""
    counted = dict.fromkeys(VARIABLE_TYPES, 0)
    for group in groups:
        yield group.place, counted[group.type]
        counted[group.type] += len(group.variables)


def placed_variables(groups: Sequence[Group]) -> Iterator[PlacedVariable]:
    """The variables in their order, which is that of the groups."""
    for group, (_, first) in zip(groups, group_offsets(groups), strict=True):
        for reference, one in enumerate(group.variables, first):
            varies = "continuous" if group.type == "Real" else "discrete"
            parameter = group.causality == "parameter"
            initial = {"parameter": "exact", "output": "calculated"}.get(group.causality, "")
            yield PlacedVariable(
                one.name,
                one.description,
                group.type,
                group.causality,
                "fixed" if parameter else varies,
                initial,
                reference,
                None if one.start is None else _xml_text(one.start),
                one.unit,
            )


def _c_literal(start: StartValue | None) -> str:
    if isinstance(start, str):
        return f'"{start}"'
    if isinstance(start, bool) or start is None:
        return str(int(start or False))
    return repr(start)


def _xml_text(start: StartValue) -> str:
    if isinstance(start, bool):
        return "true" if start else "false"
    return str(start)
