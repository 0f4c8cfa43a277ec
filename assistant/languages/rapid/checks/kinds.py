"""Types of names and expressions, as far as the given modules and the standard tables tell.

What is not known for sure has no kind, and a rule says nothing about it: it may be a signal, or
data of a module that was not given.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from assistant.languages.checks.symbols import Declaration
from assistant.languages.named_types import NamedTypes, Type
from assistant.languages.rapid.checks.module_view import Declared, Look
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.signatures import Parameter, Slot
from assistant.program import expressions as e

NUMBER: Final = "number"
"""Type of a numeric literal, which is a num or a dnum as the place wants it."""
NUMERIC: Final = frozenset({"num", "dnum", NUMBER})
LOGICAL: Final = frozenset({"OR", "XOR", "AND"})


@dataclass(frozen=True, slots=True)
class Kind:
    """type: lower case, of an alias what it stands for. dimensions: -1 of an array of any."""

    type: str
    dimensions: int = 0

    def __str__(self) -> str:
        return f"array of {self.type}" if self.dimensions else self.type


Joined = Mapping[tuple[str, str, str], str]
_NUM: Final = {("num", "num"): "num", ("dnum", "dnum"): "dnum", (NUMBER, NUMBER): NUMBER}
_MIXED: Final = {
    **_NUM,
    **{pair: kind for kind in ("num", "dnum") for pair in ((kind, NUMBER), (NUMBER, kind))},
}
OPERATIONS: Final[Joined] = {
    **{
        (o, *pair): kind
        for o in ("+", "-", "*", "/", "DIV", "MOD")
        for pair, kind in _MIXED.items()
    },
    ("+", "string", "string"): "string",
    **{(o, "pos", "pos"): "pos" for o in "+-*"},
    **{(o, "pos", n): "pos" for o in "*/" for n in ("num", NUMBER)},
    **{("*", n, "pos"): "pos" for n in ("num", NUMBER)},
    ("*", "orient", "orient"): "orient",
}
"""What an operator makes of two types."""


class Types(NamedTypes):
    """Types that a module sees: its own, those of its task, predefined ones."""

    def __init__(self, look: Look) -> None:
        super().__init__(predefined.types())
        self.look = look

    def declared(self, name: str) -> Type | None:
        found = self.look.find(name)
        match found.node if found is not None else None:
            case s.Alias(local, of, name):
                return Type(name, "ALIAS", of)
            case s.Record(local, name, components):
                several = not local and len(self.look.task.shared.all(name)) > 1
                known = None if several else {inner: type for type, inner in components}
                return Type(name, "RECORD", components=known)
        return None

    def atomic(self, base: str) -> bool:
        """Whether a type surely has no components."""
        return self.kind(base) == "VALUE"

    def device(self, base: str) -> bool:
        """Whether the configuration of the controller may name objects of a type."""
        return base == "" or self.kind(base) in ("DEVICE", "OTHER")

    def known(self) -> Iterator[str]:
        """Names of types as they are declared."""
        for level in reversed(self.look.task.levels(self.look.module)):
            yield from (one.name for one in level if one.kind in ("RECORD", "ALIAS"))
        yield from (standard.name for standard in self.predefined.values())


class Scope:
    """What names mean at one place: in a module, in a routine, in loops inside it."""

    def __init__(
        self,
        types: Types,
        routine: s.Routine | None = None,
        loops: frozenset[str] = frozenset(),
    ) -> None:
        self.types, self.look = types, types.look
        self.routine, self.loops = routine, loops

    def inside(self, loop: s.ForLoop) -> Scope:
        return Scope(self.types, self.routine, self.loops | {loop.variable.lower()})

    @cached_property
    def _found(self) -> dict[str, Declared | None]:
        return {}

    def find(self, name: str) -> Declared | None:
        """The declaration that a name means, None if no given module has one."""
        low = name.lower()
        if low not in self._found:
            if low in self.loops:
                self._found[low] = Declaration(name, "FOR", "num", True)
            else:
                self._found[low] = self.look.find(name, self.routine)
        return self._found[low]

    def doubtful(self, found: Declared) -> bool:
        """Whether several modules declare the name, or another one of a mixed set does."""
        task = self.look.task
        if task.mixed and found.module is not None and found.module is not self.look.module:
            return True
        return not found.local and len(task.shared.all(found.name)) > 1

    def kind(self, node: s.Expression | s.Variable | None) -> Kind | None:
        """Type of an expression, None if it is not known for sure."""
        match node:
            case s.NumberLiteral():
                return Kind(NUMBER)
            case s.StringLiteral():
                return Kind("string")
            case s.BoolLiteral():
                return Kind("bool")
            case s.NameRef(name):
                return self._name(name)
            case s.Component(value, name):
                return self._component(value, name)
            case s.Element(value, indices):
                return self._element(value, indices)
            case s.Group(inner):
                return self.kind(inner)
            case s.FunctionCall(name):
                return self._result(name)
            case s.Prefix(operator, operand):
                return Kind("bool") if operator == "NOT" else self.kind(operand)
            case s.Infix(operator, left, right):
                return self._infix(operator, left, right)
        return None

    def of(self, type: str, dimensions: int = 0) -> Kind | None:
        """Kind of a declared type, None if the type is not known or no value has it."""
        base = self.types.base(type)
        return None if base is None or base in ("switch", "anytype") else Kind(base, dimensions)

    def wanted(self, parameter: Parameter) -> Kind | None:
        """Kind of a parameter, None if it takes any."""
        return self.of(parameter.type, parameter.dimensions) if parameter.type else None

    def suiting(self, value: s.Expression, parameters: Iterable[Parameter]) -> list[Parameter]:
        """Those of some parameters that a value may be for."""
        given = self.kind(value)
        return [p for p in parameters if fits(given, self.wanted(p), read=not p.mode)]

    def suits(self, value: s.Expression, slot: Slot) -> bool:
        return bool(self.suiting(value, slot.alternatives))

    def _name(self, name: str) -> Kind | None:
        found = self.find(name)
        if found is None:
            standard = predefined.data().get(name.lower())
            return self.of(standard.type) if standard else None
        if self.doubtful(found) or not found.type or found.kind in ("FUNC", "ALIAS"):
            return None
        match found.node:
            case s.Data(dimensions=dimensions):
                return self.of(found.type, len(dimensions))
            case s.ParameterNode(dimensions=dimensions):
                return self.of(found.type, dimensions)
            case None:
                # A loop counts in dnum if its bounds do.
                return Kind(NUMBER) if found.kind == "FOR" else self.of(found.type)
        return None

    def _component(self, value: s.Variable, name: str) -> Kind | None:
        kind = self.kind(value)
        if kind is None or kind.dimensions:
            return None
        components = self.types.components(kind.type) or {}
        found = next((t for n, t in components.items() if n.lower() == name.lower()), None)
        return self.of(found) if found else None

    def _element(
        self, value: s.Variable, indices: tuple[s.Expression | s.Whole, ...]
    ) -> Kind | None:
        kind = self.kind(value)
        if kind is None or kind.dimensions not in (-1, len(indices)):
            return None
        return Kind(kind.type, sum(isinstance(index, s.Whole) for index in indices))

    def _result(self, name: str) -> Kind | None:
        found = self.find(name)
        if found is not None:
            sure = found.kind == "FUNC" and not self.doubtful(found)
            return self.of(found.type) if sure else None
        standard = signature(name)
        return self.of(standard.result) if standard and standard.result else None

    def _infix(self, operator: str, left: s.Expression, right: s.Expression) -> Kind | None:
        if operator in LOGICAL or operator in e.RELATIONS:
            return Kind("bool")
        one, other = self.read(left), self.read(right)
        if one is None or other is None or one.dimensions or other.dimensions:
            return None
        made = OPERATIONS.get((operator, one.type, other.type))
        return Kind(made) if made else None

    def read(self, node: s.Expression) -> Kind | None:
        """Kind of a value that is read: of a signal the number that it has."""
        kind = self.kind(node)
        if kind is not None and kind.type.startswith("signal"):
            return None if kind.type.startswith("signalg") else Kind("num")
        return kind


def fits(given: Kind | None, wanted: Kind | None, *, read: bool = True) -> bool:
    """Whether a value may stand where a kind is wanted; yes if either is not known.

    read: the value is copied, so that a signal gives its number.
    """
    if given is None or wanted is None or wanted.type in ("", "anytype"):
        return True
    if bool(given.dimensions) != bool(wanted.dimensions):
        return False
    if -1 not in (given.dimensions, wanted.dimensions) and given.dimensions != wanted.dimensions:
        return False
    if given.type == wanted.type or (given.type == NUMBER and wanted.type in NUMERIC):
        return True
    if wanted.type == NUMBER:
        return given.type in NUMERIC
    return read and given.type.startswith("signal") and wanted.type in ("num", "dnum")
