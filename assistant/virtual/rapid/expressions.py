"""What an expression is worth, and where a variable is stored."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, Final

from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.predefined import rows
from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.machine import Machine
from assistant.virtual.rapid.operators import infix, prefix, whole
from assistant.virtual.rapid.poses import number, truth
from assistant.virtual.rapid.precision import Double, Exact, single
from assistant.virtual.rapid.scopes import Absent, Cell, Known, Place, Signal
from assistant.virtual.rapid.types import ALL_TYPES, FIRST_VALUES, SIGNAL_TYPES
from assistant.virtual.rapid.values import Array, Handle, Record, Shape, Value, copied, kind_of

Indices = tuple[s.Expression | s.Whole, ...]
PREFIXES = {"0x": 16, "0o": 8, "0b": 2, "0d": 10}


def evaluate(machine: Machine, node: s.Expression | s.Whole, wanted: Shape | None = None) -> Value:
    """The value of an expression, not yet apart from where it may be stored.

    wanted: what it is for, which gives an aggregate its type.
    """
    worth = WORTH.get(type(node))
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
    base = PREFIXES.get(text[:2].lower())
    return Exact(text if base is None else int(text[2:], base))


def place(machine: Machine, node: s.Expression | s.Whole) -> Place:
    """Where a variable or a part of one is stored; raises Fault where there is none."""
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
    """The cell with its first value, worked out now if nobody asked for it before."""
    pending = cell.pending
    if pending is None:
        return cell
    cell.pending = None
    node, unit = pending.node, pending.unit
    try:
        with machine.outside(unit):
            declare(machine, cell, node)
    except NotSimulated:
        cell.pending = pending
        raise
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
        Place(cell, "", shape, "VAR").set(first)


def shape_of(machine: Machine, node: s.Data) -> Shape:
    sizes = [whole(numeric(machine, size), "the size of an array") for size in node.dimensions]
    return Shape(machine.types.name(node.type), tuple(sizes))


def place_named(machine: Machine, name: str) -> Place:
    """Where data of a name is stored; raises Fault where there is none."""
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


def _element(machine: Machine, array: Place, indices: Indices) -> Place:
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
    """What functions put into a record may be more exact than a num."""
    if isinstance(node, s.Element) and isinstance(node.indices[0], s.Whole):
        return _column(machine, place(machine, node.value).get(), node.indices)
    found = place(machine, node).get()
    if type(found) is float:
        return single(found)
    if isinstance(found, Handle) and found.type in SIGNAL_TYPES:
        return single(machine.signals.read(_connected(found)))
    return found


def _column(machine: Machine, value: Value, indices: Indices) -> Value:
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
    return Double(value) if name in GIVES_DNUM else single(value)


GIVES_DNUM: Final = frozenset(n for n, (line, _) in rows().items() if line.startswith("FUNC dnum "))


WORTH: Final[Mapping[type, Callable[[Machine, Any, Shape | None], Value]]] = {
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
