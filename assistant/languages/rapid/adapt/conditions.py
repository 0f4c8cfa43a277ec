"""Conditions: RAPID's are truth values, while elsewhere a number that is not 0 holds as well."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from assistant.languages.rapid.messages import Kinds
from assistant.languages.rapid.tables import COMPONENTS
from assistant.program import expressions as e
from assistant.program import statements as p

_ARITHMETIC: Final = ("+", "-", "*", "/", "div", "mod", "^")
_NUMBERS: Final = ("number", "integer")


def with_conditions(statement: p.Statement, known: Kinds) -> p.Statement:
    """The statement with its own conditions as truth values; bodies are left alone."""
    match statement:
        case p.If(branches):
            made = tuple(replace(b, condition=condition(b.condition, known)) for b in branches)
            return replace(statement, branches=made)
        case p.While() | p.WaitUntil():
            return replace(statement, condition=condition(statement.condition, known))
    return statement


def condition(x: e.Expression, known: Kinds) -> e.Expression:
    """The expression, or that it is not 0 if it is a number."""
    match x:
        case e.Number(value):
            return e.Truth(value != 0)
        case e.Binary("and" | "or" | "xor", left, right):
            return replace(x, left=condition(left, known), right=condition(right, known))
        case e.Unary("not", operand):
            return e.Unary("not", condition(operand, known))
    return e.Binary("<>", x, e.Number(0)) if _is_number(x, known) else x


def _is_number(x: e.Expression, known: Kinds) -> bool:
    match x:
        case e.Name(name):
            return known.get(name.lower()) in _NUMBERS
        case e.Index(value):
            return _is_number(value, known)
        case e.Member(_, field):
            return field in COMPONENTS
        case e.Unary("-") | e.Number():
            return True
        case e.Binary(operator):
            return operator in _ARITHMETIC
    return False
