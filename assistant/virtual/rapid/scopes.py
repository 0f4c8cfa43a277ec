"""What a name stands for: data, references, signals and routines, and where it is known."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from assistant.base.diagnostics import Span
from assistant.base.source_text import SourceText
from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid.ends import UNSURE, Fault
from assistant.virtual.rapid.values import (
    Array,
    Record,
    Shape,
    Value,
    copied,
    fitted,
    is_like,
    kind_of,
    overwrite,
)

Storage = Literal["VAR", "PERS", "CONST", "IN", "LOOP"]
"""`IN`: a parameter's own copy. `LOOP`: the variable of a FOR, which only the loop changes."""
READ_ONLY = ("CONST", "LOOP")


@dataclass(slots=True)
class Cell:
    """Where a value is stored. pending: its declaration, as long as it was not looked at.

    first: of a persistent, the value of its declaration.
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
        if self.storage in READ_ONLY:
            raise Fault("what cannot be changed is assigned to")
        if not is_like(value, self.shape):
            raise Fault(f"{kind_of(value)} is assigned to data of type {self.shape.type}")
        value = fitted(value, self.shape)
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
    """A routine and the module that it stands in."""

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
