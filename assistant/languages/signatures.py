"""Signatures of routines, the arguments of a call matched with them, and types by name.

`Call` assigns the arguments of a call to the parameters of a `Signature`. `NamedTypes` resolves a
type name, alias or not, among those that the program declares and those built into every
controller.
"""

from __future__ import annotations

import abc
import enum
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field
from typing import Any, Final, Generic, TypeVar

from assistant.base.data_classes import dataclass

N = TypeVar("N")


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter. type: lower case, empty if not known. dimensions: 0 for a single value, -1 any.

    mode: how it is passed, in the language's own word; empty for a value.
    """

    name: str
    type: str
    mode: str = ""
    dimensions: int = 0


@dataclass(frozen=True, slots=True)
class Slot:
    """One place in a list of parameters: a parameter, or several that exclude each other."""

    alternatives: tuple[Parameter, ...]
    optional: bool = False


@dataclass(frozen=True, slots=True)
class Signature:
    """Parameters and result of a routine.

    kind: kind of routine, in the language's own word. result: type of a function's value, empty if
    not known. open: true if there may be more parameters than stated. option: of the controller
    that brings the routine, empty for every controller.
    """

    name: str
    kind: str
    slots: tuple[Slot, ...] = ()
    result: str = ""
    open: bool = False
    option: str = ""

    @property
    def required(self) -> tuple[Slot, ...]:
        return tuple(slot for slot in self.slots if not slot.optional)

    @property
    def optional(self) -> tuple[Slot, ...]:
        return tuple(slot for slot in self.slots if slot.optional)


@dataclass(frozen=True, slots=True)
class Given(Generic[N]):
    """An argument of a call.

    value: None of one that says no more than that it is there. name: of the parameter, empty if it
    is not written. optional: it is for a parameter that may be left out, by its name.
    handed_on: it is what the caller itself may have been given. hole: nothing is written yet.
    """

    node: N
    value: Any = None
    name: str = ""
    optional: bool = False
    handed_on: bool = False
    hole: bool = False


class Misfit(enum.Enum):
    """Possible faults in the arguments of a call."""

    MISSING = enum.auto()
    TOO_MANY = enum.auto()
    OTHER_NAME = enum.auto()
    UNKNOWN = enum.auto()
    EXCLUSIVE = enum.auto()
    NO_VALUE = enum.auto()
    SWITCH_WITH_VALUE = enum.auto()


Wrong = tuple[Misfit, N | None, dict[str, Any]]
"""A misfit, the argument with the fault (None for the call), and the fields of its message."""


class Call(Generic[N]):
    """Arguments beside the signature of what is called."""

    def __init__(self, given: Sequence[Given[N]], routine: Signature) -> None:
        self.given, self.routine = given, routine
        self.plain = [one for one in given if not one.optional]
        self.named = [one for one in given if one.optional]
        self.options = {
            one.name.lower(): (slot, one) for slot in routine.optional for one in slot.alternatives
        }

    def bound(self) -> Iterator[tuple[Any, tuple[Parameter, ...]]]:
        """Values with the parameters that they may be for: several where those exclude each other.

        Only what has its place for sure: plain arguments if there are as many as there are to be.
        """
        required = self.routine.required
        # With another number nothing tells which parameter a plain argument is for.
        counted = self.routine.open or len(self.plain) == len(required)
        places = iter(required if counted else ())
        for one in self.given:
            if not one.optional:
                slot = next(places, None)
                if slot is not None:
                    yield one.value, slot.alternatives
            elif one.value is not None and not one.handed_on:
                found = self.options.get(one.name.lower())
                if found is not None and found[1].type != "switch":
                    yield one.value, (found[1],)

    def misfits(
        self, suits: Callable[[Any, Slot], bool], *, any_name: bool = False
    ) -> Iterator[Wrong[N]]:
        """Arguments that are missing, too many, unknown, named wrongly, or given twice.

        suits: whether a value may be for a slot. any_name: names that no parameter has may be
        written before plain arguments.
        """
        yield from self._misnamed(any_name)
        yield from self._counted(suits)
        taken: dict[int, Given[N]] = {}
        for one in self.named:
            found = self.options.get(one.name.lower())
            if found is not None and not one.handed_on:
                slot, parameter = found
                fields = {"option": one.name, "type": parameter.type}
                if parameter.type == "switch" and one.value is not None:
                    yield Misfit.SWITCH_WITH_VALUE, one.node, fields
                elif parameter.type not in ("", "switch") and one.value is None:
                    yield Misfit.NO_VALUE, one.node, fields
                # Alternatives of one slot exclude each other.
                before = taken.setdefault(id(slot), one)
                if before is not one:
                    yield Misfit.EXCLUSIVE, one.node, {"one": before.name, "other": one.name}
            elif found is None and not self.routine.open:
                yield Misfit.UNKNOWN, one.node, {"option": one.name}

    def _misnamed(self, any_name: bool) -> Iterator[Wrong[N]]:
        slots = self.routine.required
        known = {one.name.lower() for slot in slots for one in slot.alternatives}
        for given, slot in zip(self.plain, slots, strict=False):
            name = given.name.lower()
            own = {one.name.lower() for one in slot.alternatives}
            if name and name not in own and (name in known or not any_name):
                parameter = slot.alternatives[0].name
                yield Misfit.OTHER_NAME, given.node, {"name": given.name, "parameter": parameter}

    def _counted(self, suits: Callable[[Any, Slot], bool]) -> Iterator[Wrong[N]]:
        slots, given = self.routine.required, len(self.plain)
        # With an open list or a hole, the count says nothing.
        if self.routine.open or any(one.hole for one in self.plain):
            return
        if given > len(slots):
            yield Misfit.TOO_MANY, self.plain[len(slots)].node, {"given": given}
        elif given < len(slots):
            yield Misfit.MISSING, None, {"parameters": self._missing(suits)}

    def _missing(self, suits: Callable[[Any, Slot], bool]) -> str:
        """The one parameter without which the types fit, else how many are missing."""
        slots, values = self.routine.required, [one.value for one in self.plain]
        gaps: Sequence[Slot] = slots
        # Exactly one is missing: the one without which the types of the others fit.
        if len(slots) == len(values) + 1 and len(slots) > 1:
            gaps = [
                gap
                for i, gap in enumerate(slots)
                if all(map(suits, values, (*slots[:i], *slots[i + 1 :])))
            ]
        if len(gaps) == 1:
            return " or ".join(f"`{one.name}`" for one in gaps[0].alternatives)
        return f"{len(slots) - len(values)} of its {len(slots)} arguments"


MOST_ALIASES: Final = 8
"""Most aliases of aliases that are followed."""


@dataclass(frozen=True, slots=True)
class Type:
    """kind: what it is, in the language's own word. of: what an alias stands for, else empty.

    components: type by name of a record, in order; None if they are not known.
    """

    name: str
    kind: str
    of: str = ""
    components: Mapping[str, str] | None = field(default=None, hash=False)


class NamedTypes(abc.ABC):
    """The types that a part of a program sees, in any case.

    predefined: by lower-case name; what is declared hides them.
    """

    def __init__(self, predefined: Mapping[str, Type]) -> None:
        self.predefined = predefined
        self._bases: dict[str, str | None] = {}

    @abc.abstractmethod
    def declared(self, name: str) -> Type | None:
        """The type that the program declares by a name."""

    @abc.abstractmethod
    def atomic(self, base: str) -> bool:
        """True if a type surely has no components."""

    def find(self, name: str) -> Type | None:
        return self.declared(name) or self.predefined.get(name.lower())

    def base(self, name: str) -> str | None:
        """The type itself, of an alias what it stands for; None if nothing declares it."""
        low = name.lower()
        if low not in self._bases:
            self._bases[low] = self._base(low)
        return self._bases[low]

    def _base(self, low: str) -> str | None:
        # Aliases of a circle would never end.
        for _ in range(MOST_ALIASES):
            found = self.find(low)
            if found is None or not found.of:
                return None if found is None else low
            low = found.of.lower()
        return None

    def components(self, base: str) -> Mapping[str, str] | None:
        """Components of a record in order, type by name; None if they are not known."""
        found = self.find(base)
        return None if found is None else found.components

    def kind(self, base: str) -> str:
        """Return the kind of a type; empty if it is not known."""
        found = self.find(base)
        return "" if found is None else found.kind
