"""Expressions of RAPID: their values, their operators, and where a variable is stored."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.predefined import rows
from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid.control_flow import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.machine import Machine
from assistant.virtual.rapid.records import number, orient, pos, quaternion_of, truth, vector_of
from assistant.virtual.rapid.scopes import (
    ALL_TYPES,
    FIRST_VALUES,
    SIGNAL_TYPES,
    Absent,
    Cell,
    Known,
    Place,
    Signal,
)
from assistant.virtual.rapid.values import (
    LARGEST,
    Array,
    Double,
    Exact,
    Handle,
    Record,
    Shape,
    Value,
    copied,
    equal,
    kind_of,
    paired,
    single,
)

LONGEST_TEXT: Final = 80


def infix(sign: str, left: Value, right: Value) -> Value:
    """The value of two operands; raises Fault where a controller stops or refuses them."""
    if isinstance(left, float) and isinstance(right, float) and sign in _NUMBER_OPERATORS:
        one, two, kind = paired(left, right)
        found = _NUMBER_OPERATORS[sign](one, two)
        if found is True or found is False:
            return found
        if -LARGEST <= found <= LARGEST:
            return single(found) if kind is float else kind(found)
        return kind(_finite(found, kind))
    if sign in _TRUTH_OPERATORS:
        return _TRUTH_OPERATORS[sign](truth(left), truth(right))
    if sign in ("=", "<>"):
        try:
            return equal(left, right) is (sign == "=")
        except ValueError as error:
            raise Fault(str(error)) from None
    if sign == "+" and isinstance(left, str) and isinstance(right, str):
        return joined(left + right)
    vector = _vector_result(sign, left, right)
    if vector is None:
        raise Fault(f"`{sign}` cannot join {kind_of(left)} and {kind_of(right)}")
    return vector


def prefix(sign: str, value: Value) -> Value:
    if sign == "NOT":
        return not truth(value)
    factor = -1.0 if sign == "-" else 1.0
    if isinstance(value, float):
        return type(value)(factor * value)
    if isinstance(value, Record) and value.type == "pos":
        x, y, z = vector_of(value)
        return pos((factor * x, factor * y, factor * z))
    raise Fault(f"`{sign}` cannot stand before {kind_of(value)}")


def joined(text: str) -> str:
    """A text that was put together; raises Fault where it is too long for a string."""
    if len(text) > LONGEST_TEXT:
        raise Fault(f"a string of {len(text)} characters", "ERR_STRTOOLNG")
    return text


def whole(value: float, what: str) -> int:
    if not value.is_integer():
        raise Fault(f"{what} is {value:g}, no whole number", UNSURE)
    return int(value)


def _divide(left: float, right: float) -> float:
    if right == 0.0:
        raise Fault("division by zero", "ERR_DIVZERO")
    return left / right


def _quotient(left: float, right: float) -> float:
    """-14 DIV 4 is -3: towards zero, as the table of operations of the kernel manual has it."""
    a, b = whole(left, "an operand of DIV"), whole(right, "an operand of DIV")
    return float(math.trunc(_divide(a, b)))


def _remainder(left: float, right: float) -> float:
    """-14 MOD 4 is -2: with the sign of what is divided."""
    a, b = whole(left, "an operand of MOD"), whole(right, "an operand of MOD")
    if b == 0:
        raise Fault("division by zero", "ERR_DIVZERO")
    # + 0.0 turns -0.0 into 0.0, which would be written with its sign.
    return math.fmod(a, b) + 0.0


def _vector_result(sign: str, left: Value, right: Value) -> Value | None:
    """Operators of pos and orient; None for what there is not."""
    if _is_record(left, "pos") and _is_record(right, "pos") and sign in ("+", "-", "*"):
        return _pos_result(_VECTOR_OPERATORS[sign](vector_of(left), vector_of(right)))
    if _is_record(left, "pos") and _are_numbers(right) and sign in ("*", "/"):
        factor = _float(right) if sign == "*" else _divide(1.0, _float(right))
        return _pos_result(np.multiply(vector_of(left), factor))
    if _are_numbers(left) and _is_record(right, "pos") and sign == "*":
        return _pos_result(np.multiply(vector_of(right), _float(left)))
    if _is_record(left, "orient") and _is_record(right, "orient") and sign == "*":
        # Both signs of a quaternion are the same turn; the canonical one keeps comparisons equal.
        q = rotations.canonical(rotations.multiply(quaternion_of(left), quaternion_of(right)))
        w, x, y, z = (float(part) for part in q)
        return orient((w, x, y, z))
    return None


def _pos_result(values: Floats) -> Record:
    x, y, z = (float(part) for part in values)
    return pos((x, y, z))


def _is_record(value: Value, type: str) -> bool:
    return isinstance(value, Record) and value.type == type


def _are_numbers(*values: Value) -> bool:
    return all(isinstance(value, float) for value in values)


def _float(value: Value) -> float:
    assert isinstance(value, float)
    return value


def _finite(value: float, kind: type[float]) -> float:
    if math.isnan(value) or (kind is float and abs(value) > LARGEST and not math.isinf(value)):
        raise Fault(f"the number {value:g}, which is too large", "ERR_NUM_LIMIT")
    return value


_TRUTH_OPERATORS: Final[Mapping[str, Callable[[bool, bool], bool]]] = {
    "AND": operator.and_,
    "OR": operator.or_,
    "XOR": operator.xor,
}
"""Both sides are worked out: that the second may be left out is not documented."""
_NUMBER_OPERATORS: Final[Mapping[str, Callable[[float, float], Any]]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": _divide,
    "DIV": _quotient,
    "MOD": _remainder,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": operator.eq,
    "<>": operator.ne,
}
"""Operators of two numbers that give a number or a truth."""
_VECTOR_OPERATORS: Final[Mapping[str, Callable[..., Floats]]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.cross,
}


_Indices = tuple[s.Expression | s.Whole, ...]
_PREFIXES = {"0x": 16, "0o": 8, "0b": 2, "0d": 10}


def evaluate(machine: Machine, node: s.Expression | s.Whole, wanted: Shape | None = None) -> Value:
    """The value of an expression, not yet apart from where it may be stored.

    wanted: what it is for, which gives an aggregate its type.
    """
    worth = _WORTH.get(type(node))
    if worth is None:
        raise NotSimulated(f"{type(node).__name__} in an expression")
    return worth(machine, node, wanted)


def condition(machine: Machine, node: s.Expression) -> bool:
    return truth(evaluate(machine, node))


def numeric(machine: Machine, node: s.Expression | s.Whole) -> float:
    return number(evaluate(machine, node))


@lru_cache(4096)
def literal(text: str) -> float:
    """A number as it is written, `9E9` or `0x1F`."""
    base = _PREFIXES.get(text[:2].lower())
    return Exact(text if base is None else int(text[2:], base))


def place(machine: Machine, node: s.Expression | s.Whole) -> Place:
    """Return the storage of a variable or a part of one; raises Fault if it is missing."""
    match node:
        case s.NameRef(name):
            return place_named(machine, name)
        case s.Component(value, name):
            whole_of = place(machine, value)
            shape = machine.types.component(whole_of.shape.type, name.lower())
            record = whole_of.get()
            if shape is None or whole_of.shape.sizes or not isinstance(record, Record):
                raise Fault(f"{whole_of.shape.type} has no component `{name}`")
            return Place(record, name.lower(), shape, whole_of.storage)
        case s.Element(value, indices):
            return _element(machine, place(machine, value), indices)
        case s.Group(inner):
            return place(machine, inner)
    raise Fault("a value where data is wanted")


def signal(machine: Machine, node: s.Expression) -> str:
    """The signal that a name or data stands for, in lower case."""
    if isinstance(node, s.NameRef):
        meaning = machine.meaning(node.name)
        if isinstance(meaning, Signal):
            return meaning.name
        if meaning is None:
            return node.name.lower()
    if not isinstance(node, s.NameRef | s.Component | s.Element):
        raise NotSimulated("a signal that is worked out")
    found = place(machine, node).get()
    if not isinstance(found, Handle) or found.type not in SIGNAL_TYPES:
        raise NotSimulated(f"{kind_of(found)} as a signal")
    return _connected(found)


def _connected(handle: Handle) -> str:
    """The signal that AliasIO has said data to stand for."""
    if not isinstance(handle.inside, str):
        raise Fault("data that is connected to no signal", "ERR_NO_ALIASIO_DEF")
    return handle.inside


def settled(machine: Machine, cell: Cell) -> Cell:
    """Return the cell with its first value, which is evaluated now if it was not needed before."""
    pending = cell.pending
    if pending is None:
        return cell
    # Before the evaluation, so that a declaration that
    # refers to itself does not recurse without end.
    cell.pending = None
    node, unit = pending.node, pending.unit
    try:
        with machine.outside(unit):
            declare(machine, cell, node)
    # Data that is not simulated stops the run only when it is read, every time.
    except NotSimulated:
        cell.pending = pending
        raise
    # A persistent keeps the value of its declaration too, for a start from the beginning.
    if cell.storage == "PERS" and cell.value is not None:
        cell.first = copied(cell.value)
    return cell


def declare(machine: Machine, cell: Cell, node: s.Data) -> None:
    """Gives a cell the shape and first value of its declaration."""
    shape = shape_of(machine, node)
    cell.shape = shape
    value = machine.types.first(shape)
    cell.value = value
    if node.value is not None:
        first = evaluate(machine, node.value, shape)
        # VAR: the first value of a constant has to be stored as well.
        Place(cell, "", shape, "VAR").set(first)


def shape_of(machine: Machine, node: s.Data) -> Shape:
    sizes = [whole(numeric(machine, size), "the size of an array") for size in node.dimensions]
    return Shape(machine.types.name(node.type), tuple(sizes))


def place_named(machine: Machine, name: str) -> Place:
    """Return the storage of the data of a name; raises Fault if it is missing."""
    match machine.meaning(name):
        case Cell() as cell:
            settled(machine, cell)
            return Place(cell, "", cell.shape, cell.storage)
        case Place() as reference:
            return reference
        case Absent():
            message = f"the optional parameter `{name}` is read, which was not given"
            raise Fault(message, "ERR_NOTPRES")
        case Signal() | Known():
            raise Fault(f"`{name}` is no data")
    if name.lower() in predefined.data():
        raise NotSimulated(f"the predefined `{name}`")
    raise Fault(f"there is no data `{name}`, and no signal of a script or an instruction")


def _is_signal(machine: Machine, name: str) -> bool:
    return name.lower() not in predefined.data() and machine.signals.knows(name.lower())


def _element(machine: Machine, array: Place, indices: _Indices) -> Place:
    if len(indices) != len(array.shape.sizes):
        raise Fault(f"{len(indices)} indices of an array of {len(array.shape.sizes)} dimensions")
    values: list[int | None] = []
    for index in indices:
        if isinstance(index, s.Whole):
            values.append(None)
        else:
            values.append(whole(numeric(machine, index), "an index"))
    found = array
    while values and values[0] is not None:
        found = _item(found, values.pop(0) or 0)
    if any(value is not None for value in values):
        raise NotSimulated("a column of an array that is changed")
    return found


def _item(array: Place, index: int) -> Place:
    items = array.get()
    assert isinstance(items, Array)
    return Place(items, _bounded(index, items), array.shape.element, array.storage)


def _variable(machine: Machine, node: s.NameRef, _: Shape | None) -> Value:
    # The common case first: data with a value, which needs neither a copy nor its declaration.
    meaning = machine.meaning(node.name)
    if type(meaning) is Cell and meaning.pending is None:
        value = meaning.value
        if value is not None and type(value) is not Handle:
            return value
    if isinstance(meaning, Signal):
        return single(machine.signals.read(meaning.name))
    if meaning is None and _is_signal(machine, node.name):
        return single(machine.signals.read(node.name.lower()))
    return _stored(machine, node, None)


def _stored(machine: Machine, node: s.Expression, _: Shape | None) -> Value:
    """Return a stored value; a record may hold more exact values of functions than a num."""
    if isinstance(node, s.Element) and isinstance(node.indices[0], s.Whole):
        return _column(machine, place(machine, node.value).get(), node.indices)
    found = place(machine, node).get()
    if type(found) is float:
        return single(found)
    if isinstance(found, Handle) and found.type in SIGNAL_TYPES:
        return single(machine.signals.read(_connected(found)))
    return found


def _column(machine: Machine, value: Value, indices: _Indices) -> Value:
    """A copy of a part of an array: all elements where an index is `*`."""
    if not indices:
        return copied(value)
    if not isinstance(value, Array):
        raise Fault("more indices than an array has dimensions")
    if isinstance(indices[0], s.Whole):
        return Array([_column(machine, item, indices[1:]) for item in value.items])
    index = whole(numeric(machine, indices[0]), "an index")
    return _column(machine, value.items[_bounded(index, value)], indices[1:])


def _bounded(index: int, array: Array) -> int:
    """From 0; raises Fault for an element that there is not."""
    if not 1 <= index <= len(array.items):
        message = f"the index {index} of an array of {len(array.items)} elements"
        raise Fault(message, "ERR_OUTOFBND")
    return index - 1


def _infix(machine: Machine, node: s.Infix, _: Shape | None) -> Value:
    """Two operands, the left one first; an aggregate is of the type of the other."""
    # An aggregate has no type of its own; the other
    # operand gives it, and has to be evaluated first.
    if type(_bare(node.left)) is s.AggregateNode:
        right = evaluate(machine, node.right)
        return infix(node.operator, evaluate(machine, node.left, _shape(right)), right)
    left = evaluate(machine, node.left)
    if isinstance(left, Record):  # a function may change what is stored
        left = copied(left)
    return infix(node.operator, left, evaluate(machine, node.right, _shape(left)))


def _bare(node: s.Expression) -> s.Expression:
    while isinstance(node, s.Group):
        node = node.inner
    return node


def _shape(value: Value) -> Shape | None:
    return Shape(value.type) if isinstance(value, Record) else None


def _aggregate(machine: Machine, node: s.AggregateNode, wanted: Shape | None) -> Value:
    if wanted is None:
        raise NotSimulated("an aggregate of a type that is not stated")
    if wanted.sizes:
        if wanted.sizes[0] not in (-1, len(node.items)):
            raise Fault(f"{len(node.items)} elements for an array of {wanted.sizes[0]}")
        element = wanted.element
        array = Array([machine.types.first(element) for _ in node.items])
        for i, item in enumerate(node.items):
            Place(array, i, element, "VAR").set(evaluate(machine, item, element))
        return array
    if machine.types.is_unlisted(wanted.type):
        first = node.items[0] if node.items else None
        number = evaluate(machine, first) if isinstance(first, s.NumberLiteral) else 0.0
        return Record(wanted.type, {FIRST_VALUES: number, ALL_TYPES: repr(node.items)})
    parts = machine.types.components(wanted.type)
    if parts is None:
        raise Fault(f"an aggregate where {wanted.type} is wanted")
    if len(parts) != len(node.items):
        raise Fault(f"{len(node.items)} parts of {wanted.type}, which has {len(parts)}")
    record = machine.types.first(wanted)
    assert isinstance(record, Record)
    for (name, of), item in zip(parts.items(), node.items, strict=True):
        shape = Shape(machine.types.name(of))
        Place(record, name, shape, "VAR").set(evaluate(machine, item, shape))
    return record


def _call(machine: Machine, node: s.FunctionCall, _: Shape | None) -> Value:
    meaning = machine.meaning(node.name)
    if isinstance(meaning, Known):
        value = machine.abilities.call(machine, meaning, node.arguments)
    else:
        function = machine.abilities.functions.get(node.name.lower())
        if function is None:
            raise NotSimulated(f"the function `{node.name}`")
        value = function(machine, node.arguments)
        if type(value) is float:
            value = _number_of(node.name.lower(), value)
    if value is None:
        raise Fault(f"`{node.name}` gives no value")
    return value


def _number_of(name: str, value: float) -> float:
    """The number that a function of every controller gives."""
    return Double(value) if name in _GIVES_DNUM else single(value)


_GIVES_DNUM: Final = frozenset(
    n for n, (line, _) in rows().items() if line.startswith("FUNC dnum ")
)


_WORTH: Final[Mapping[type, Callable[[Machine, Any, Shape | None], Value]]] = {
    s.NameRef: _variable,
    s.NumberLiteral: lambda _, node, __: literal(node.text),
    s.Infix: _infix,
    s.Element: _stored,
    s.Component: _stored,
    s.FunctionCall: _call,
    s.Group: lambda machine, node, wanted: evaluate(machine, node.inner, wanted),
    s.Prefix: lambda machine, node, _: prefix(node.operator, evaluate(machine, node.operand)),
    s.AggregateNode: _aggregate,
    s.StringLiteral: lambda _, node, __: node.value,
    s.BoolLiteral: lambda _, node, __: node.value,
}
"""By what an expression is; the third argument is what it is for."""
