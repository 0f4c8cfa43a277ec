"""Targets, joint targets and poses that are worked out in brackets, part by part.

Other languages keep them whole: `j:=[[0,0,n,0,30,0],outside];` becomes a value of numbers alone,
and `j.robax.rax_3:=n;`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from assistant.languages.rapid.lift.plain.library import ORIENTATION, is_written_out
from assistant.languages.rapid.lift.plain.spreads import NotExpressible
from assistant.languages.rapid.tree import syntax as s

_TARGET_PARTS: Final = {
    "pose": ("trans", ORIENTATION),
    "robtarget": ("trans", ORIENTATION, "robconf", "extax"),
    "jointtarget": ("robax", "extax"),
}
ASSEMBLED_TYPES: Final = frozenset(_TARGET_PARTS)
"""Types whose values in brackets other languages are told part by part."""
_DEFAULT_PARTS: Final = {"trans": (0, 0, 0), ORIENTATION: (1, 0, 0, 0)}
_CONFIGURATION: Final = "robconf"
NO_EXTERNAL_AXES: Final = s.AggregateNode((s.NumberLiteral("9E9"),) * 6)
"""The places of external axes that there are none of."""
_EXTERNAL_AXES: Final = tuple(f"eax_{letter}" for letter in "abcdef")
_ROBOT_AXES: Final = tuple(f"rax_{axis}" for axis in range(1, 7))


def assembled_parts(
    type: str, place: Any, value: s.AggregateNode
) -> Iterator[tuple[Any, s.Expression]]:
    """What is assigned, and to what, so that a place has a value; first the whole one.

    Raises Unsaid where a part of it is not told so.
    """
    items = dict(zip(_TARGET_PARTS[type], value.items, strict=False))
    if len(items) != len(value.items) or len(items) != len(_TARGET_PARTS[type]):
        raise NotExpressible("it has another number of components")
    if type == "jointtarget":
        yield from _joint_parts(place, items)
        return
    outer = [items[name] for name in ("robconf", "extax") if name in items]
    match outer:
        case [s.Component(one, "robconf"), s.Component(two, "extax")] if one == two:
            yield place, one
        case [s.Component(one, "robconf"), outside] if outside == NO_EXTERNAL_AXES:
            yield place, one
        case [conf, s.NameRef() | s.Component() as outside] if is_written_out(conf):
            first = (_number_aggregate(_DEFAULT_PARTS[name]) for name in ("trans", ORIENTATION))
            yield place, s.AggregateNode((*first, conf, NO_EXTERNAL_AXES))
            yield s.Component(place, "extax"), outside
        case [conf, s.AggregateNode(axes)] if is_written_out(conf) and len(axes) == len(
            _EXTERNAL_AXES
        ):
            first = (_number_aggregate(_DEFAULT_PARTS[name]) for name in ("trans", ORIENTATION))
            none = s.NumberLiteral("9E9")
            written = tuple(one if is_written_out(one) else none for one in axes)
            yield place, s.AggregateNode((*first, conf, s.AggregateNode(written)))
            for axis, worked_out in zip(_EXTERNAL_AXES, axes, strict=True):
                if not is_written_out(worked_out):
                    yield s.Component(s.Component(place, "extax"), axis), worked_out
        case _ if all(map(is_written_out, outer)):
            first = (_number_aggregate(_DEFAULT_PARTS[name]) for name in ("trans", ORIENTATION))
            yield place, s.AggregateNode((*first, *outer))
        case _:
            raise NotExpressible("its configuration is worked out")
    for name in ("trans", ORIENTATION):
        yield s.Component(place, name), items[name]


def takes_configuration(target: Any, value: Any) -> bool:
    """Whether a target takes the configuration of another, or one that is written out."""
    match target, value:
        case s.Component(_, name), s.Component(_, other):
            return (name.lower(), other.lower()) == (_CONFIGURATION, _CONFIGURATION)
        case s.Component(_, name), s.AggregateNode():
            return name.lower() == _CONFIGURATION and is_written_out(value)
    return False


def with_configuration(
    target: s.Component, value: s.Expression, held: s.NameRef
) -> Iterator[tuple[Any, s.Expression]]:
    """What is assigned then, and to what; external axes are not kept.

    held: a variable for a target.
    """
    if isinstance(value, s.Component):
        yield held, value.value
    else:
        first = (_number_aggregate(_DEFAULT_PARTS[name]) for name in ("trans", ORIENTATION))
        yield held, s.AggregateNode((*first, value, NO_EXTERNAL_AXES))
    for name in ("trans", ORIENTATION):
        yield s.Component(held, name), s.Component(target.value, name)
    yield target.value, held


def _joint_parts(place: Any, items: dict[str, s.Expression]) -> Iterator[tuple[Any, s.Expression]]:
    match items["robax"], items["extax"]:
        case s.Component(one, "robax"), s.Component(two, "extax") if one == two:
            yield place, one
        case s.AggregateNode(angles), outside if is_written_out(outside) and len(angles) == 6:
            none = s.NumberLiteral("0")
            written = tuple(one if is_written_out(one) else none for one in angles)
            yield place, s.AggregateNode((s.AggregateNode(written), outside))
            for axis, angle in zip(_ROBOT_AXES, angles, strict=True):
                if not is_written_out(angle):
                    yield s.Component(s.Component(place, "robax"), axis), angle
        case _:
            raise NotExpressible("its axes are worked out as a whole")


def _number_aggregate(values: tuple[int, ...]) -> s.AggregateNode:
    return s.AggregateNode(tuple(s.NumberLiteral(str(value)) for value in values))
