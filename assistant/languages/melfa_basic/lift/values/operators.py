"""Operators as the pseudo-program names them, and what is a truth by its form alone."""

from __future__ import annotations

from typing import Final

from assistant.languages.melfa_basic.tables.operators import OPERATOR_NAMES
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e

_TRUTHS: Final = (*e.RELATIONS, *e.LOGICAL)
INTEGER_OPERATORS: Final = ("div", "mod")
"""Operators that round their operands first."""


def operator_name(written: str) -> str:
    return OPERATOR_NAMES.get(written, written)


def is_comparison(node: s.Expression) -> bool:
    """Whether it is a comparison, or what joins and turns nothing else."""
    match node:
        case s.Binary(operator=written, left=left, right=right):
            operator = operator_name(written)
            if operator in e.LOGICAL:
                return is_comparison(left) and is_comparison(right)
            return operator in e.RELATIONS
        case s.Unary(operator=sign, operand=operand):
            return sign.upper() == "NOT" and is_comparison(operand)
    return False


def are_truth_operands(*operands: s.Expression) -> bool:
    """Whether logic that was written here may be of truths; else it is vendor text, of bits."""
    for node in operands:
        match node:
            case s.Number(value=value) if value not in (0, 1):
                return False
            case s.Unary():
                return False
            case s.Binary(operator=written) if operator_name(written) not in _TRUTHS:
                return False
    return True
