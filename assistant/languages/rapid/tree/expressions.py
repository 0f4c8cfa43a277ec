"""The part of the tree of RAPID that has values: expressions, and arguments of calls."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from assistant.program.diagnostics import Span


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    span: Span | None = field(default=None, compare=False, repr=False)


# Expressions


@dataclass(frozen=True, slots=True)
class NumberLiteral(Node):
    """text: as written, `9E9` or `0x1F`; without a sign, which is an operator."""

    text: str


@dataclass(frozen=True, slots=True)
class StringLiteral(Node):
    """value: what it says, escapes undone."""

    value: str


@dataclass(frozen=True, slots=True)
class BoolLiteral(Node):
    value: bool


@dataclass(frozen=True, slots=True)
class NameRef(Node):
    name: str


@dataclass(frozen=True, slots=True)
class Component(Node):
    value: Variable
    name: str


@dataclass(frozen=True, slots=True)
class Whole(Node):
    """The `*` that stands for every index."""


@dataclass(frozen=True, slots=True)
class Element(Node):
    value: Variable
    indices: tuple[Expression | Whole, ...]


@dataclass(frozen=True, slots=True)
class AggregateNode(Node):
    items: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Group(Node):
    """An expression in parentheses."""

    inner: Expression


@dataclass(frozen=True, slots=True)
class FunctionCall(Node):
    name: str
    arguments: tuple[Argument, ...] = ()


@dataclass(frozen=True, slots=True)
class Prefix(Node):
    operator: Literal["+", "-", "NOT"]
    operand: Expression


@dataclass(frozen=True, slots=True)
class Infix(Node):
    """operator: upper case; `OR XOR AND < <= = > >= <> + - * / DIV MOD`."""

    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class Placeholder(Node):
    """A hole that the pendant left, `<SMT>`; also where a statement or an item may stand."""

    text: str


Variable = NameRef | Component | Element | Placeholder
Expression = (
    NumberLiteral
    | StringLiteral
    | BoolLiteral
    | NameRef
    | Component
    | Element
    | AggregateNode
    | Group
    | FunctionCall
    | Prefix
    | Infix
    | Placeholder
)


@dataclass(frozen=True, slots=True)
class Positional(Node):
    """name: of the parameter, if it is written out."""

    value: Expression
    name: str | None = None


@dataclass(frozen=True, slots=True)
class Option(Node):
    r"""`\name:=value`, or the mere switch `\name`."""

    name: str
    value: Expression | None = None


@dataclass(frozen=True, slots=True)
class Conditional(Node):
    r"""`\name?variable`: hands an optional parameter on if it is there."""

    name: str
    variable: Variable


Argument = Positional | Option | Conditional
