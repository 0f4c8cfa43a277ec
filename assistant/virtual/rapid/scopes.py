"""Names and types of a program: data, references, signals and routines, and where each is known.

Types are those of every controller, and the records and aliases that the program declares.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Final, Literal

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.base.source_text import SourceText
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid.control_flow import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.values import (
    Array,
    Clock,
    Handle,
    Record,
    Shape,
    Trigger,
    Value,
    copied,
    fitted,
    is_like,
    kind_of,
    overwrite,
)

Storage = Literal["VAR", "PERS", "CONST", "IN", "LOOP"]
"""`IN`: a parameter's own copy. `LOOP`: the variable of a FOR, which only the loop changes."""
_READ_ONLY = ("CONST", "LOOP")


@dataclass(slots=True)
class Cell:
    """Storage of a value. pending: its declaration, until it is evaluated.

    first: for a persistent, the value of its declaration.
    """

    shape: Shape
    storage: Storage
    value: Value | None = None
    pending: Pending | None = None
    first: Value | None = None


@dataclass(frozen=True, slots=True)
class Pending:
    """A declaration whose first value is worked out when it is first asked for."""

    node: s.Data
    unit: Unit


@dataclass(frozen=True, slots=True)
class Place:
    """A piece of data, or a part of one: what a reference refers to.

    holder, key: the cell, or the record or array with the part's name or index from 0.
    """

    holder: Cell | Record | Array
    key: str | int
    shape: Shape
    storage: Storage

    def get(self) -> Value:
        match self.holder:
            case Cell(value=value):
                if value is None:
                    raise Fault("data is read before it has a value")
                return value
            case Record(parts=parts):
                return parts[str(self.key)]
            case Array(items):
                return items[int(self.key)]

    def set(self, value: Value) -> None:
        """Stores a copy; raises Fault for constants and values of another type."""
        if self.storage in _READ_ONLY:
            raise Fault("what cannot be changed is assigned to")
        if not is_like(value, self.shape):
            raise Fault(f"{kind_of(value)} is assigned to data of type {self.shape.type}")
        value = fitted(value, self.shape)
        # The usual case, without a look at the old value.
        if isinstance(self.holder, Cell) and isinstance(value, float | str | bool):
            self.holder.value = value
            return
        try:
            stored = overwrite(self.get(), value)
        except ValueError as error:
            raise Fault(str(error), UNSURE) from None
        if stored:
            return
        match self.holder:
            case Cell() as cell:
                cell.value = copied(value)
            case Record(parts=parts):
                parts[str(self.key)] = copied(value)
            case Array(items):
                items[int(self.key)] = copied(value)


@dataclass(frozen=True, slots=True)
class Signal:
    """A signal of the controller, by its name in lower case."""

    name: str


@dataclass(frozen=True, slots=True)
class Absent:
    """An optional parameter that was not given."""


@dataclass(frozen=True, slots=True)
class Known:
    """A routine and its module."""

    node: s.Routine
    unit: Unit


Meaning = Cell | Place | Signal | Absent | Known


@dataclass(slots=True, eq=False)
class Unit:
    """A module: its text, and the names that only it knows, in lower case."""

    source: SourceText | None
    names: dict[str, Meaning] = field(default_factory=dict)
    name: str = ""


@dataclass(slots=True, eq=False)
class Frame:
    """A call of a routine. names: of its parameters, data and loops, in lower case.

    routine: None while data of a module gets its first value. called_at: the statement that calls.
    handling: the error whose handler runs. retries: of the statement that it happened in, that are
    left.
    """

    unit: Unit
    routine: s.Routine | None
    names: dict[str, Meaning] = field(default_factory=dict)
    called_at: tuple[Unit, Span | None] | None = None
    handling: Fault | None = None
    retries: int = 0


_PLAIN_TYPES: Mapping[str, Value] = {
    "num": 0.0,
    "dnum": 0.0,
    "bool": False,
    "string": "",
    "switch": True,
}
"""First values of the types without components."""
_MOST_ELEMENTS: Final = 1_000_000
"""Elements of one array or record, including those in its elements: more than a controller's memory
holds.
"""
_INPUT_TYPES: Final = ("signaldi", "signalgi", "signalai")
OUTPUT_TYPES: Final = ("signaldo", "signalgo", "signalao")
SIGNAL_TYPES: Final = (*_INPUT_TYPES, *OUTPUT_TYPES)
"""Types of data that stands for a signal once AliasIO says which one."""


FIRST_VALUES, ALL_TYPES = "<first>", "<all>"
"""Keys of a record whose components are unknown: its first number, and all as text."""


@dataclass(slots=True)
class Types:
    """Records by name in lower case, each its components' types; aliases of types.

    A LOCAL record and one of another module must not share a name here.
    """

    records: dict[str, dict[str, str]] = field(default_factory=dict)
    aliases: dict[str, str] = field(default_factory=dict)
    _counts: dict[str, int] = field(default_factory=dict, init=False, repr=False, compare=False)

    def declare(self, item: s.Record | s.Alias) -> None:
        name = item.name.lower()
        if name in self.records or name in self.aliases:
            raise NotSimulated(f"two types of the name `{item.name}`")
        # Counts of records that contain the new type may differ now.
        self._counts.clear()
        if isinstance(item, s.Alias):
            self.aliases[name] = item.type.lower()
        else:
            self.records[name] = {of.lower(): type.lower() for type, of in item.components}

    def name(self, type: str) -> str:
        """The type that a name stands for, aliases undone, in lower case."""
        name = type.lower()
        if name in self.aliases:
            return self.name(self.aliases[name])
        known = predefined.types().get(name)
        if name not in self.records and known is not None and known.kind == "ALIAS":
            return known.of.lower()
        return name

    def components(self, type: str) -> Mapping[str, str] | None:
        """Types of a record's components by name, None for any other type."""
        if type in self.records:
            return self.records[type]
        known = predefined.types().get(type)
        if known is None or known.components is None:
            return None
        return {of.lower(): kind.lower() for of, kind in known.components.items()}

    def is_unlisted(self, type: str) -> bool:
        """True if a type is a record of an option whose components are unknown here."""
        known = predefined.types().get(type)
        unknown = known is not None and known.kind == "RECORD" and known.components is None
        return unknown and type not in self.records

    def component(self, type: str, name: str) -> Shape | None:
        parts = self.components(type)
        of = None if parts is None else parts.get(name)
        return None if of is None else Shape(self.name(of))

    def first(self, shape: Shape) -> Value:
        """The value of data without a first value.

        Raises NotSimulated for types without one, and for more than `_MOST_ELEMENTS` elements.
        """
        if self._count(shape) > _MOST_ELEMENTS:
            what = "an array" if shape.sizes else f"a record `{shape.type}`"
            raise NotSimulated(f"{what} of more than {_MOST_ELEMENTS} elements")
        return self._first(shape)

    def _count(self, shape: Shape) -> int:
        """Elements of data, those of the arrays and records in it counted; nothing is built."""
        if shape.sizes:
            # An empty array counts too, so that arrays of empty ones have a limit.
            return max(1, shape.sizes[0] * self._count(shape.element))
        if shape.type in _PLAIN_TYPES:
            return 1
        if shape.type not in self._counts:
            parts = self.components(shape.type) or {}
            inner = sum(self._count(Shape(self.name(of))) for of in parts.values())
            # Kept, since records in records would be counted again and again.
            self._counts[shape.type] = max(1, inner)
        return self._counts[shape.type]

    def _first(self, shape: Shape) -> Value:
        if shape.sizes:
            return Array([self._first(shape.element) for _ in range(max(shape.sizes[0], 0))])
        if shape.type in _PLAIN_TYPES:
            return _PLAIN_TYPES[shape.type]
        if shape.type == "clock":
            return Clock()
        if shape.type == "triggdata":
            return Trigger()
        known = predefined.types().get(shape.type)
        # A signal variable is empty until AliasIO.
        if known is not None and (known.kind == "HANDLE" or shape.type in SIGNAL_TYPES):
            return Handle(shape.type)
        if self.is_unlisted(shape.type):
            return Record(shape.type, {FIRST_VALUES: 0.0, ALL_TYPES: ""})
        parts = self.components(shape.type)
        if parts is None:
            raise NotSimulated(f"data of type {shape.type}")
        return Record(
            shape.type, {name: self._first(Shape(self.name(of))) for name, of in parts.items()}
        )
