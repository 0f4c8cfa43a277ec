"""Types of names and expressions, as far as the given modules and the standard tables tell.

What is not known for sure has no kind, and a rule says nothing about it: it may be a signal, or
data of a module that was not given.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from assistant.languages.checks.names import Declaration
from assistant.languages.checks.values import Kind, Kinds, Operators
from assistant.languages.rapid.checks.module_view import Declared, RuleContext
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.signatures import NamedTypes, Type
from assistant.program import expressions as e

NUMBER: Final = "number"
"""Type of a numeric literal, which is a num or a dnum as the place wants it."""
NUMERIC: Final = frozenset({"num", "dnum"})
LOGICAL: Final = frozenset({"OR", "XOR", "AND"})
SIGNAL_TYPES: Final = frozenset({f"signal{kind}{way}" for kind in "adg" for way in "io"})
OPERATORS: Final = Operators(
    always=dict.fromkeys((*LOGICAL, *e.RELATIONS), "bool"),
    made={
        **{(o, n, n): n for o in ("+", "-", "*", "/", "DIV", "MOD") for n in NUMERIC},
        ("+", "string", "string"): "string",
        **{(o, "pos", "pos"): "pos" for o in "+-*"},
        **{(o, "pos", "num"): "pos" for o in "*/"},
        ("*", "num", "pos"): "pos",
        ("*", "orient", "orient"): "orient",
    },
    choices={NUMBER: NUMERIC},
    copied=dict.fromkeys(SIGNAL_TYPES, NUMERIC),
    ordered=NUMERIC,
)


class Types(NamedTypes):
    """Types that a module sees: its own, those of its task, predefined ones."""

    def __init__(self, look: RuleContext) -> None:
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


class Scope(Kinds[s.Expression]):
    """What names mean at one place: in a module, in a routine, in loops inside it."""

    operators = OPERATORS
    without_value = frozenset({"switch", "anytype"})
    types: Types

    def __init__(
        self,
        types: Types,
        routine: s.Routine | None = None,
        loops: frozenset[str] = frozenset(),
    ) -> None:
        super().__init__(types)
        self.look, self.routine, self.loops = types.look, routine, loops
        self._found: dict[str, Declared | None] = {}

    def inside(self, loop: s.ForLoop) -> Scope:
        return Scope(self.types, self.routine, self.loops | {loop.variable.lower()})

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

    def items(self, node: s.Expression) -> tuple[s.Expression, ...] | None:
        return node.items if isinstance(node, s.AggregateNode) else None

    def kind(self, node: s.Expression) -> Kind | None:
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
                return self.component(self.kind(value), name)
            case s.Element(value, indices):
                whole = sum(isinstance(index, s.Whole) for index in indices)
                return self.element(self.kind(value), len(indices), whole)
            case s.Group(inner):
                return self.kind(inner)
            case s.FunctionCall(name):
                return self._result(name)
            case s.Prefix(operator, operand):
                return Kind("bool") if operator == "NOT" else self.kind(operand)
            case s.Infix(operator, left, right):
                return self.infix(operator, left, right)
        return None

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

    def _result(self, name: str) -> Kind | None:
        found = self.find(name)
        if found is not None:
            sure = found.kind == "FUNC" and not self.doubtful(found)
            return self.of(found.type) if sure else None
        standard = signature(name)
        return self.of(standard.result) if standard and standard.result else None

    def read(self, node: s.Expression) -> Kind | None:
        """Of a signal the number that it has."""
        kind = self.kind(node)
        if kind is not None and kind.type in SIGNAL_TYPES:
            return None if kind.type.startswith("signalg") else Kind("num")
        return kind
