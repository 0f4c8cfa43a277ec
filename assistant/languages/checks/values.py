"""Types of expressions where they are known, and limits of literal numbers.

An expression whose type is not certain has no `Kind`, and no check reports on it.
"""

from __future__ import annotations

import abc
import enum
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from itertools import product
from math import inf
from typing import Any, Generic, TypeVar

from assistant.base.data_classes import dataclass
from assistant.languages.signatures import NamedTypes, Parameter, Slot
from assistant.program import expressions as e

N = TypeVar("N")

Sizes = tuple[int | None, ...]
"""Elements of each dimension of an array, None where that is not known; empty for one value."""


@dataclass(frozen=True, slots=True)
class Kind:
    """type: in one case, of an alias what it stands for. dimensions: -1 of an array of any."""

    type: str
    dimensions: int = 0

    def __str__(self) -> str:
        return f"array of {self.type}" if self.dimensions else self.type


@dataclass(frozen=True, slots=True, kw_only=True)
class Operators:
    """Result types of the operators of a language.

    always: operator → the type of its result, for all operands. made: operator and the types of its
    operands → the type of its result. choices: a type of values that may be of several others →
    those others, as a literal number may be an integer or not. copied: type → what a copy of its
    value may be, besides that type itself. ordered: types whose values `<` and `>` compare.
    """

    always: Mapping[str, str]
    made: Mapping[tuple[str, str, str], str]
    choices: Mapping[str, frozenset[str]] = field(default_factory=dict)
    copied: Mapping[str, frozenset[str]] = field(default_factory=dict)
    ordered: frozenset[str] = frozenset()

    def types(self, type: str) -> frozenset[str]:
        """Return the types that a value of a type may have."""
        return self.choices.get(type) or frozenset((type,))

    def joined(self, operator: str, left: Kind | None, right: Kind | None) -> Kind | None:
        """Return the kind of an operator's result for two values; None if it has no result or is
        unknown.
        """
        if left is None or right is None or left.dimensions or right.dimensions:
            return None
        # Each operand may be of several types: the result is sure if what is possible is one kind.
        pairs = product(self.types(left.type), self.types(right.type))
        found = {self.made.get((operator, *pair)) for pair in pairs} - {None}
        kinds = (type for type in (left.type, right.type, *found) if type)
        return next((Kind(type) for type in kinds if self.types(type) == found), None)

    def join(self, operator: str, left: Kind, right: Kind) -> bool:
        """True if an operator may join two values that are read."""
        if operator not in e.RELATIONS:
            return self.joined(operator, left, right) is not None
        known = self.types(left.type) | self.types(right.type)
        comparable = operator in ("=", "<>") or known <= self.ordered
        return comparable and self.fits(left, right, read=False)

    def fits(self, given: Kind | None, wanted: Kind | None, *, read: bool = True) -> bool:
        """True if a value fits a required kind, or if either kind is unknown.

        read: its value is copied.
        """
        if given is None or wanted is None:
            return True
        dimensions = {given.dimensions, wanted.dimensions}
        # -1 stands for an array of any dimensions, which a single value never fits.
        if len(dimensions) > 1 and (0 in dimensions or -1 not in dimensions):
            return False
        if given.type == wanted.type:
            return True
        # An integer literal, say, may be of several types: one in common is enough.
        types = self.types(given.type)
        if read:
            types |= self.copied.get(given.type, frozenset())
        return not types.isdisjoint(self.types(wanted.type))


class Unfit(enum.Enum):
    """Possible faults of a value where a type is required."""

    TYPE = enum.auto()
    ELEMENTS = enum.auto()
    COMPONENTS = enum.auto()


class Kinds(abc.ABC, Generic[N]):
    """Kinds of expressions at one place of a program.

    operators: of the language. without_value: types that no value is of.
    """

    operators: Operators
    without_value: frozenset[str] = frozenset()

    def __init__(self, types: NamedTypes) -> None:
        self.types = types

    @abc.abstractmethod
    def kind(self, node: N) -> Kind | None:
        """Kind of an expression, None if it is not known for sure."""

    @abc.abstractmethod
    def items(self, node: N) -> Sequence[N] | None:
        """Return the elements of a literal list of values; None for any other expression."""

    def read(self, node: N) -> Kind | None:
        """Kind of the value that is read where an expression stands."""
        return self.kind(node)

    def infix(self, operator: str, left: N, right: N) -> Kind | None:
        """Kind of what an operator makes of two expressions."""
        if operator in self.operators.always:
            return Kind(self.operators.always[operator])
        return self.operators.joined(operator, self.read(left), self.read(right))

    def of(self, type: str, dimensions: int = 0) -> Kind | None:
        """Kind of a declared type, None if the type is not known or no value has it."""
        base = self.types.base(type)
        return None if base is None or base in self.without_value else Kind(base, dimensions)

    def wanted(self, parameter: Parameter) -> Kind | None:
        """Kind of a parameter, None if it takes any."""
        return self.of(parameter.type, parameter.dimensions) if parameter.type else None

    def suiting(self, value: N, parameters: Iterable[Parameter]) -> list[Parameter]:
        """Those of some parameters that a value may be for."""
        given = self.kind(value)
        fits = self.operators.fits
        return [p for p in parameters if fits(given, self.wanted(p), read=not p.mode)]

    def suits(self, value: N, slot: Slot) -> bool:
        return bool(self.suiting(value, slot.alternatives))

    def component(self, of: Kind | None, name: str) -> Kind | None:
        """Kind of a component of a record, in any case."""
        if of is None or of.dimensions:
            return None
        components = self.types.components(of.type) or {}
        found = next((t for n, t in components.items() if n.lower() == name.lower()), None)
        return self.of(found) if found else None

    def element(self, of: Kind | None, indices: int, whole: int = 0) -> Kind | None:
        """Kind of what so many indices pick from an array. whole: how many pick all elements."""
        if of is None or of.dimensions not in (-1, indices):
            return None
        return Kind(of.type, whole)

    def unfit(
        self, value: N, type: str, sizes: Sizes = ()
    ) -> Iterator[tuple[Unfit, N, dict[str, Any]]]:
        """Yield the faults of a value where a type, or an array of it, is required.

        Each comes with the faulty part of the value and the fields of the finding's message.
        """
        items = self.items(value)
        if items is None:
            given, wanted = self.kind(value), Kind(type, len(sizes))
            if not self.operators.fits(given, wanted):
                yield Unfit.TYPE, value, {"given": given, "wanted": wanted}
        elif sizes:
            if sizes[0] is not None and len(items) != sizes[0]:
                yield Unfit.ELEMENTS, value, {"given": len(items), "count": sizes[0]}
            for item in items:
                yield from self.unfit(item, type, sizes[1:])
        else:
            yield from self._unfit_record(value, items, type)

    def _unfit_record(
        self, value: N, items: Sequence[N], type: str
    ) -> Iterator[tuple[Unfit, N, dict[str, Any]]]:
        components = self.types.components(type)
        if components is None:
            if self.types.atomic(type):
                yield Unfit.TYPE, value, {"given": "list", "wanted": type}
        elif len(items) != len(components):
            counts = {"given": len(items), "count": len(components)}
            yield Unfit.COMPONENTS, value, {**counts, "type": type, "names": ", ".join(components)}
        else:
            for item, of in zip(items, components.values(), strict=True):
                base = self.types.base(of)
                if base is not None:
                    yield from self.unfit(item, base)


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a literal number.

    above: low itself is too low. number: of the error that a controller shows, 0 for the usual one.
    """

    what: str
    low: float
    high: float
    above: bool = False
    cure: str = ""
    number: int = 0

    def holds(self, value: float) -> bool:
        return self.low <= value <= self.high and not (self.above and value == self.low)

    def words(self, value: float, number: int) -> dict[str, Any]:
        """Return the fields of a finding about a value outside the limits. number: the usual
        error.
        """
        return {
            "what": self.what,
            "value": f"{value:g}",
            "range": self.range,
            "number": self.number or number,
            "cure": self.cure or f"write {self.range}",
        }

    @property
    def range(self) -> str:
        if self.high == inf:
            return f"above {self.low:g}" if self.above else f"{self.low:g} or more"
        begin = f"above {self.low:g} and at most" if self.above else f"{self.low:g} to"
        return f"{begin} {self.high:g}"
