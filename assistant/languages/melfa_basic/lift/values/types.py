"""Types of the expressions of MELFA-BASIC, as far as its text tells them."""

from __future__ import annotations

from assistant.languages.melfa_basic.lift.structure.scopes import LETTER_TYPES
from assistant.languages.melfa_basic.lift.values.operators import (
    are_truth_operands,
    is_comparison,
    operator_name,
)
from assistant.languages.melfa_basic.lift.values.symbols import SIGNAL_VARIABLES, Symbols
from assistant.languages.melfa_basic.tables.vocabulary import function, status
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program import expressions as e
from assistant.program.analysis.declared_types import of_operation
from assistant.program.program import ValueType


class Types:
    """The types of what stands in one file."""

    def __init__(self, symbols: Symbols) -> None:
        self.m = symbols

    def type_of(self, node: s.Expression | None) -> ValueType:
        match node:
            case s.String():
                return "text"
            case s.Constant(flags=flags):
                return "joints" if flags is None and len(node.values) < 3 else "position"
            case s.Pallet():
                return "position"
            case s.Variable(component=component) if component:
                return "integer" if component.startswith("FL") else "number"
            case s.Variable():
                return self.type_of_name(node)
            case s.Unary(operand=operand):
                return self.type_of(operand)
            case s.Binary(operator=operator, left=left, right=right):
                return of_operation(
                    operator_name(operator), self.type_of(left), self.type_of(right)
                )
            case s.Number(value=value):
                return "integer" if float(value).is_integer() else "number"
        return "number"

    def type_of_name(self, node: s.Variable) -> ValueType:
        key = node.key
        if node.arguments is not None and (known := function(key)) is not None:
            if key in ("CINT", "FIX", "INT", "LEN", "ASC"):
                return "integer"
            return LETTER_TYPES[known.result[0]]
        if (known_status := status(key)) is not None:
            bits = key in SIGNAL_VARIABLES and SIGNAL_VARIABLES[key][0] != "analog"
            return "integer" if bits else LETTER_TYPES[known_status.type]
        if key in self.m.io and not self.m.is_shadowed(key):
            return "integer"  # of inputs, whatever letter their name begins with
        return self.m.type_of_key(key)

    def is_truth(self, node: s.Expression) -> bool:
        """Whether it is 0 or 1 (or a truth), so that bits and truths are the same."""
        match node:
            case s.Binary(operator=written, left=left, right=right):
                operator = operator_name(written)
                if operator in e.LOGICAL:
                    return self.is_truth(left) and self.is_truth(right)
                return operator in e.RELATIONS
            case s.Variable():
                return self.is_bit(node) or self.type_of(node) == "truth" or self.m.own
            case s.Unary():
                return self.m.own or is_comparison(node)
        return self.m.own

    def is_bit(self, node: s.Expression) -> bool:
        if not isinstance(node, s.Variable) or node.component:
            return False
        known = SIGNAL_VARIABLES.get(node.key) if node.arguments else None
        if known is not None:
            return known[0] == "digital"
        return node.key in self.m.io and self.m.io[node.key][0] == 1

    def joins_bits(self, left: s.Expression, right: s.Expression) -> bool:
        """Whether logic between two values is of the bits of numbers.

        In a text that was written here 0 and 1 may be truths, and what a function gives.
        """
        sides = (left, right)
        if any(is_comparison(node) for side in sides for node in nodes(side)):
            return False
        if any(map(self.is_bit, sides)):  # beside a number that was written here it is one too
            others = [side for side in sides if not self.is_bit(side)]
            return self.m.own and any(map(self._is_plain_number, others))
        kinds = [self.type_of(side) for side in sides]
        if not all(kind in ("number", "integer") for kind in kinds):
            return False
        return not self.m.own or not are_truth_operands(*sides) or any(map(self._is_number, sides))

    def _is_plain_number(self, node: s.Expression) -> bool:
        """Whether it is a number's own variable, or what is worked out of numbers."""
        match node:
            case s.Number(value=value):
                return value not in (0, 1)
            case s.Variable() | s.Binary():
                return self.type_of(node) in ("number", "integer") and self._is_number(node)
        return False

    def _is_number(self, node: s.Expression) -> bool:
        """Whether a value that has the type of a number is one for certain."""
        match node:
            case s.Number():
                return False
            case s.Variable() if node.key in self.m.routines:
                return self.m.routines[node.key].result not in (None, "truth")
        return True
