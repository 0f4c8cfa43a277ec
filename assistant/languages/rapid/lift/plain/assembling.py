"""Targets, joint targets and poses that are worked out in brackets, part by part.

Other languages keep them whole: `j:=[[0,0,n,0,30,0],outside];` becomes a value of numbers alone,
and `j.robax.rax_3:=n;`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from assistant.languages.rapid.lift.plain.library import TURN, is_written_out
from assistant.languages.rapid.lift.plain.spreads import Unsaid
from assistant.languages.rapid.tree import syntax as s

_PARTS: Final = {
    "pose": ("trans", TURN),
    "robtarget": ("trans", TURN, "robconf", "extax"),
    "jointtarget": ("robax", "extax"),
}
ASSEMBLED: Final = frozenset(_PARTS)
"""Types whose values in brackets other languages are told part by part."""
_NOWHERE: Final = {"trans": (0, 0, 0), TURN: (1, 0, 0, 0)}
_CONF: Final = "robconf"
OUTSIDE_ALL: Final = s.AggregateNode((s.NumberLiteral("9E9"),) * 6)
"""The places of external axes that there are none of."""
_OUTSIDE: Final = tuple(f"eax_{letter}" for letter in "abcdef")
_AXES: Final = tuple(f"rax_{axis}" for axis in range(1, 7))


def assembled(type: str, place: Any, value: s.AggregateNode) -> Iterator[tuple[Any, s.Expression]]:
    """What is assigned, and to what, so that a place has a value; first the whole one.

    Raises Unsaid where a part of it is not told so.
    """
    items = dict(zip(_PARTS[type], value.items, strict=False))
    if len(items) != len(value.items) or len(items) != len(_PARTS[type]):
        raise Unsaid("it has another number of components")
    if type == "jointtarget":
        yield from _joints(place, items)
        return
    outer = [items[name] for name in ("robconf", "extax") if name in items]
    match outer:
        case [s.Component(one, "robconf"), s.Component(two, "extax")] if one == two:
            yield place, one
        case [s.Component(one, "robconf"), outside] if outside == OUTSIDE_ALL:
            yield place, one
        case [conf, s.NameRef() | s.Component() as outside] if is_written_out(conf):
            first = (_numbers(_NOWHERE[name]) for name in ("trans", TURN))
            yield place, s.AggregateNode((*first, conf, OUTSIDE_ALL))
            yield s.Component(place, "extax"), outside
        case [conf, s.AggregateNode(axes)] if is_written_out(conf) and len(axes) == len(_OUTSIDE):
            first = (_numbers(_NOWHERE[name]) for name in ("trans", TURN))
            none = s.NumberLiteral("9E9")
            written = tuple(one if is_written_out(one) else none for one in axes)
            yield place, s.AggregateNode((*first, conf, s.AggregateNode(written)))
            for axis, worked_out in zip(_OUTSIDE, axes, strict=True):
                if not is_written_out(worked_out):
                    yield s.Component(s.Component(place, "extax"), axis), worked_out
        case _ if all(map(is_written_out, outer)):
            first = (_numbers(_NOWHERE[name]) for name in ("trans", TURN))
            yield place, s.AggregateNode((*first, *outer))
        case _:
            raise Unsaid("its configuration is worked out")
    for name in ("trans", TURN):
        yield s.Component(place, name), items[name]


def is_configured(target: Any, value: Any) -> bool:
    """Whether a target takes the configuration of another, or one that is written out."""
    match target, value:
        case s.Component(_, name), s.Component(_, other):
            return (name.lower(), other.lower()) == (_CONF, _CONF)
        case s.Component(_, name), s.AggregateNode():
            return name.lower() == _CONF and is_written_out(value)
    return False


def configured(
    target: s.Component, value: s.Expression, held: s.NameRef
) -> Iterator[tuple[Any, s.Expression]]:
    """What is assigned then, and to what; external axes are not kept.

    held: a variable for a target.
    """
    if isinstance(value, s.Component):
        yield held, value.value
    else:
        first = (_numbers(_NOWHERE[name]) for name in ("trans", TURN))
        yield held, s.AggregateNode((*first, value, OUTSIDE_ALL))
    for name in ("trans", TURN):
        yield s.Component(held, name), s.Component(target.value, name)
    yield target.value, held


def _joints(place: Any, items: dict[str, s.Expression]) -> Iterator[tuple[Any, s.Expression]]:
    match items["robax"], items["extax"]:
        case s.Component(one, "robax"), s.Component(two, "extax") if one == two:
            yield place, one
        case s.AggregateNode(angles), outside if is_written_out(outside) and len(angles) == 6:
            none = s.NumberLiteral("0")
            written = tuple(one if is_written_out(one) else none for one in angles)
            yield place, s.AggregateNode((s.AggregateNode(written), outside))
            for axis, angle in zip(_AXES, angles, strict=True):
                if not is_written_out(angle):
                    yield s.Component(s.Component(place, "robax"), axis), angle
        case _:
            raise Unsaid("its axes are worked out as a whole")


def _numbers(values: tuple[int, ...]) -> s.AggregateNode:
    return s.AggregateNode(tuple(s.NumberLiteral(str(value)) for value in values))
