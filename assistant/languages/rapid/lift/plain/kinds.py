"""What expressions of a program with records are."""

from __future__ import annotations

from typing import Any, Final

from assistant.languages.rapid.lift.plain.library import library_call
from assistant.languages.rapid.lift.plain.scopes import Datum, Names, ProgramData, predefined_type
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tree import syntax as s

Kind = tuple[str, int]
"""A type without aliases, and of how many dimensions."""
POS: Final = "pos"
ORIENT: Final = "orient"


class Kinds:
    """Expressions where some names mean something.

    names: of the routine, in front of those of the program.
    """

    def __init__(self, program: ProgramData, names: Names) -> None:
        self.program, self.layouts, self.names = program, program.layouts, names

    def is_own(self, name: str) -> bool:
        return name.lower() in self.program.own

    def find(self, name: str) -> Datum | None:
        low = name.lower()
        return self.names[low] if low in self.names else self.program.data_of(low)

    def kind(self, node: Any) -> Kind | None:
        """What an expression is, None if that is not known."""
        match node:
            case s.NameRef(name):
                found = self.find(name)
                if found is not None:
                    return (found.type, found.dimensions) if found.type else None
                standard = predefined_type(name)
                return (self.layouts.base(standard), 0) if standard else None
            case s.Component(value, name):
                of = self.kind(value)
                inner = None if of is None else self.layouts.component(of[0], name)
                return None if inner is None else (inner, 0)
            case s.Element(value, indices):
                of = self.kind(value)
                left = sum(isinstance(index, s.Whole) for index in indices)
                return None if of is None else (of[0], left)
            case s.Group(inner):
                return self.kind(inner)
            case s.FunctionCall() if (said := library_call(self, node)) is not node:
                return self.kind(said)
            case s.FunctionCall(str(name)):
                own = self.program.routines.get(name.lower())
                if own is not None:
                    return self.layouts.base(own.type), 0
                known = None if name.lower() in self.program.own else signature(name)
                return (known.result, 0) if known is not None and known.result else None
            case s.Infix("*", left, right) if (ORIENT, 0) in (self.kind(left), self.kind(right)):
                return ORIENT, 0
            case s.Infix("+" | "-" | "*" | "/", left, right):
                return (POS, 0) if (POS, 0) in (self._side(left), self._side(right)) else None
            case s.Prefix("-" | "+", operand):
                return self.kind(operand)
            case (
                s.BoolLiteral()
                | s.Prefix("NOT")
                | s.Infix("=" | "<>" | "<" | "<=" | ">" | ">=" | "AND" | "OR" | "XOR")
            ):
                return "bool", 0
        return None

    def is_record(self, kind: Kind | None) -> bool:
        """Whether something is a record that is taken apart."""
        return kind is not None and self.layouts.parts(kind[0]) is not None

    def _side(self, node: Any) -> Kind | None:
        """What one side of an operator is: values in brackets there are a position."""
        return (POS, 0) if isinstance(node, s.AggregateNode) else self.kind(node)

    def whole_turn(self, node: Any) -> s.Variable | None:
        """The plain target or pose that a node is the orientation of; None for any other."""
        raise NotImplementedError
