"""Values of a running program: numbers, strings, truths, records, arrays, clocks; precision.

A num has single precision, a dnum double (reference, 2.1). Wherever a program reads it, a num is a
plain float that single precision can hold; a literal that is not stored yet is as exact as the data
that it meets. Numbers that functions put into a record are rounded when they are read.
"""

from __future__ import annotations

import struct
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.virtual.events import Switched

LARGEST: Final = 3.40282347e38
"""Largest value of a num (manual, errnum, ERR_NUM_LIMIT)."""


class Double(float):
    """A dnum."""

    __slots__ = ()


class Exact(float):
    """A number of literals alone."""

    __slots__ = ()


_SINGLE: Final = struct.Struct("f")
_pack, _unpack = _SINGLE.pack, _SINGLE.unpack


def single(value: float) -> float:
    """The num next to a number; infinite beyond the largest."""
    try:
        found: float = _unpack(_pack(value))[0]
    except OverflowError:
        return float("inf") if value > 0 else float("-inf")
    return found


def paired(left: float, right: float) -> tuple[float, float, type[float]]:
    """Two operands as exact as they are together, and what their result is."""
    one, two = type(left), type(right)
    if one is two:
        return left, right, one
    if one is Double or two is Double:
        return left, right, Double
    # A literal beside a num is rounded like one.
    return single(left), single(right), float


def as_kind(value: float, kind: type[float]) -> float:
    """Return a result as the kind that `paired` gives."""
    return single(value) if kind is float else kind(value)


def digits(value: float) -> int:
    """Significant digits that ValToStr writes (manual, ValToStr)."""
    return 6 if type(value) is float else 15


@dataclass(slots=True, eq=False)
class Record:
    """type: in lower case. parts: by name in lower case, in their order."""

    type: str
    parts: dict[str, Value]


@dataclass(slots=True, eq=False)
class Array:
    """Elements in their order; of several dimensions arrays of arrays."""

    items: list[Value]


@dataclass(slots=True, eq=False)
class Clock:
    """total: seconds that it counted. since: when it was started, None while it stands."""

    total: float = 0.0
    since: float | None = None


@dataclass(slots=True, eq=False)
class Trigger:
    """Output that a motion sets on its path. change: None until an instruction sets it up."""

    change: Switched | None = None


@dataclass(slots=True, eq=False)
class Handle:
    """Data that a program cannot look into, as a socket. type: in lower case. inside: its
    contents.
    """

    type: str
    inside: object | None = None


Value = float | bool | str | Record | Array | Clock | Trigger | Handle


@dataclass(frozen=True, slots=True)
class Shape:
    """Type of stored data: in lower case, aliases resolved, and the size of an array.

    sizes: size of each dimension, -1 for any.
    """

    type: str
    sizes: tuple[int, ...] = ()

    @property
    def element(self) -> Shape:
        return Shape(self.type, self.sizes[1:])


NUMBER = Shape("num")
TEXT = Shape("string")
NUMBERS = ("num", "dnum")


def fitted(value: Value, shape: Shape) -> Value:
    """A number as exact as where it is stored; any other value as it is."""
    if isinstance(value, float):
        if shape.type == "num":
            return single(value)
        if shape.type == "dnum":
            return Double(value)
    return value


def copied(value: Value) -> Value:
    """The value apart from where it is stored."""
    match value:
        case Record(type, parts):
            return Record(type, {name: copied(part) for name, part in parts.items()})
        case Array(items):
            return Array([copied(item) for item in items])
    return value


def sizes(value: Value) -> tuple[int, ...]:
    """Return the size of each dimension of an array; none of any other value."""
    if not isinstance(value, Array):
        return ()
    return (len(value.items), *(sizes(value.items[0]) if value.items else ()))


def overwrite(old: Value, new: Value) -> bool:
    """Stores into a record or array in place, so that references into it stay; False for others.

    Raises ValueError if they are not of one type and size.
    """
    match old, new:
        case Record(), Record():
            if old.type != new.type:
                raise ValueError(f"{new.type} where {old.type} is stored")
            # A copy first: the new value may be a part of the old one.
            fresh = copied(new)
            assert isinstance(fresh, Record)
            for name, part in fresh.parts.items():
                if not overwrite(old.parts[name], part):
                    old.parts[name] = part
            return True
        case Array(), Array():
            if len(old.items) != len(new.items):
                raise ValueError(f"{len(new.items)} elements where {len(old.items)} are stored")
            for i, item in enumerate([copied(item) for item in new.items]):
                if not overwrite(old.items[i], item):
                    old.items[i] = item
            return True
    return False


def is_like(value: Value, shape: Shape) -> bool:
    """True if a value fits data of that shape."""
    if shape.sizes:
        return isinstance(value, Array) and shape.sizes[0] in (-1, len(value.items))
    match value:
        case bool():
            return shape.type in ("bool", "switch")
        case float():
            return shape.type in NUMBERS
        case str():
            return shape.type == "string"
        case Record(type):
            return type == shape.type
        case Clock():
            return shape.type == "clock"
        case Trigger():
            return shape.type == "triggdata"
    return False


def equal(left: Value, right: Value) -> bool:
    """`=` of two values; raises ValueError if they cannot be compared."""
    match left, right:
        case bool(), bool():
            return left == right
        case bool(), _:
            pass
        case float(), float():
            one, two, _ = paired(left, right)
            return one == two
        case str(), str():
            return left == right
        case Record(), Record() if left.type == right.type:
            return all(equal(part, right.parts[name]) for name, part in left.parts.items())
    raise ValueError(f"{kind_of(left)} and {kind_of(right)} cannot be compared")


def same(left: Value, right: Value) -> bool:
    """True if two values of any type are equal."""
    match left, right:
        case Record(parts=parts), Record():
            return all(same(part, right.parts[name]) for name, part in parts.items())
        case Array(items), Array():
            return len(items) == len(right.items) and all(map(same, items, right.items))
    return left == right


def kind_of(value: Value) -> str:
    """Return the type of a value for messages."""
    match value:
        case bool():
            return "bool"
        case float():
            return "num"
        case str():
            return "string"
        case Record(type):
            return type
        case Array():
            return "array"
        case Trigger():
            return "triggdata"
        case Handle(type):
            return type
    return "clock"


def text_of(value: Value) -> str:
    """A value as ValToStr writes it: six significant digits of a num, 15 of a dnum."""
    match value:
        case bool():
            return "TRUE" if value else "FALSE"
        case float():
            return f"{value:.{digits(value)}G}"
        case str():
            return f'"{value}"'
        case Record(parts=parts):
            return "[" + ",".join(map(text_of, parts.values())) + "]"
        case Array(items):
            return "[" + ",".join(map(text_of, items)) + "]"
    raise ValueError("data without a value cannot be written")
