"""Targets and poses that are compared, by the numbers that other languages have for them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any, Final, Protocol

from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.plain.kinds import Kind
from assistant.languages.rapid.lift.plain.library import function_call, is_written_out
from assistant.languages.rapid.lift.plain.scopes import ProgramData
from assistant.languages.rapid.lift.plain.spreads import RecordValue
from assistant.languages.rapid.tree import syntax as s

CONJUNCTIONS: Final = {"=": "AND", "<>": "OR"}
"""What joins the comparisons of parts."""
_JOINT_TARGET: Final = "jointtarget"
COMPARED_TYPES: Final = frozenset(("robtarget", "pose", _JOINT_TARGET))
_ANGLES: Final = ("X", "Y", "Z")
NEAR_FUNCTION: Final = "pose_near"
"""Library function: true if a pose equals numbers within 0.005 mm and 0.05 degrees."""


class _ComparedValues(Protocol):
    """What tells the parts of values, see `Values`."""

    program: ProgramData

    def is_record(self, kind: Kind | None) -> bool: ...

    def plain(self, node: Any) -> Any: ...

    def spread(self, node: Any, kind: Kind) -> RecordValue: ...


def compared_records(
    values: _ComparedValues, operator: str, left: Any, right: Any, kind: Kind
) -> s.Expression:
    """Two records, targets or poses compared; as they are where not all of one can be told."""
    if values.is_record(kind):
        first, second = values.spread(left, kind), values.spread(right, kind)
        types = {one.path: one.type for one in values.program.layouts.parts(kind[0]) or ()}
        each = [
            compared_records(values, operator, first[path], second[path], (types[path], 0))
            if types.get(path) in COMPARED_TYPES
            else s.Infix(operator, first[path], second[path])
            for path in first
        ]
        return s.Group(reduce(lambda one, two: s.Infix(CONJUNCTIONS[operator], one, two), each))
    type, program = kind[0], values.program
    for place, written in ((left, right), (right, left)):
        match written:
            case s.AggregateNode((s.AggregateNode(where), s.AggregateNode(turn))) if (
                type == "pose" and is_written_out(written) and len(where) == 3 and len(turn) == 4
            ):
                whole = values.plain(place)
                if isinstance(whole, s.NameRef | s.Component | s.Element):
                    program.remarks.append(rules.NEARLY(span=program.at))
                    return _near_pose(values, operator, whole, where, turn)
    sides = [values.plain(left), values.plain(right)]
    named = [one for one in sides if isinstance(one, s.NameRef | s.Component | s.Element)]
    if len(named) < len(sides) or (type != "pose" and program.has_axes):
        return s.Infix(operator, *sides)
    if type == "robtarget":
        program.remarks.append(rules.COMPARED(span=program.at))
    one, two = (map(values.plain, _compared_parts(place, type)) for place in named)
    return _compared_pairs(operator, list(zip(one, two, strict=True)))


def _near_pose(
    values: _ComparedValues,
    operator: str,
    place: s.NameRef | s.Component | s.Element,
    where: Sequence[s.Expression],
    turn: Sequence[s.Expression],
) -> s.Expression:
    """A pose that is compared with numbers, which the other controller has with other digits."""
    numbers = (*where, *turn)
    near = values.plain(function_call(NEAR_FUNCTION, place, *numbers))
    return near if operator == "=" else s.Prefix("NOT", near)


def _compared_pairs(operator: str, pairs: Sequence[tuple[Any, Any]]) -> s.Expression:
    """Whether all parts of two values are equal, or any is not."""
    each: list[s.Expression] = [s.Infix(operator, one, two) for one, two in pairs]
    return s.Group(reduce(lambda one, two: s.Infix(CONJUNCTIONS[operator], one, two), each))


def _compared_parts(
    place: s.NameRef | s.Component | s.Element, type: str
) -> Sequence[s.Expression]:
    """What of a target or pose is compared: where it is, and the angles of its orientation."""
    if type == _JOINT_TARGET:
        robax = s.Component(place, "robax")
        return [s.Component(robax, f"rax_{axis}") for axis in range(1, 7)]
    trans, turn = s.Component(place, "trans"), s.Positional(s.Component(place, "rot"))
    where: list[s.Expression] = [s.Component(trans, axis) for axis in "xyz"]
    turned = [s.FunctionCall("EulerZYX", (s.Option(one), turn)) for one in _ANGLES]
    return [*where, *turned]
