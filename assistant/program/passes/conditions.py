"""Conditions of a language with truth values: elsewhere a number that is not 0 holds as well."""

from __future__ import annotations

from dataclasses import replace

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.kinds import KnownTypes, is_number, is_truth


def with_conditions(statement: p.Statement, known: KnownTypes) -> p.Statement:
    """The statement with its own conditions as truth values; bodies are left alone."""
    match statement:
        case p.If(branches):
            made = tuple(replace(b, condition=condition(b.condition, known)) for b in branches)
            return replace(statement, branches=made)
        case p.Interrupt(ends=ends) if ends is not None:
            inner = condition(statement.condition, known), condition(ends, known)
            return replace(statement, condition=inner[0], ends=inner[1])
        case p.Move() | p.MoveCircular() | p.MoveJoints() if statement.until is not None:
            return replace(statement, until=condition(statement.until, known))
        case p.While() | p.WaitUntil() | p.Interrupt():
            return replace(statement, condition=condition(statement.condition, known))
    return statement


def compared(x: e.Expression, known: KnownTypes) -> e.Expression:
    """A truth that is compared with 0 or 1 as itself: it is compared with truths only."""
    match x:
        case e.Binary("=" | "<>" as operator, left, e.Number(value)) if value in (
            0,
            1,
        ) and is_truth(left, known):
            return e.Unary("not", left) if (operator == "=") == (value == 0) else left
    return x


def as_truth(x: e.Expression) -> e.Expression:
    """The value of a truth: 0 and 1 stand for them elsewhere."""
    return e.Truth(x.value != 0) if isinstance(x, e.Number) else x


def condition(x: e.Expression, known: KnownTypes) -> e.Expression:
    """The expression, or that it is not 0 if it is a number."""
    match x:
        case e.Number(value):
            return e.Truth(value != 0)
        case e.Binary("and" | "or" | "xor", left, right):
            return replace(x, left=condition(left, known), right=condition(right, known))
        case e.Unary("not", operand):
            return e.Unary("not", condition(operand, known))
    return e.Binary("<>", x, e.Number(0)) if is_number(x, known) else x
