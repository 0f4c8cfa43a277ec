"""What expressions of a program stand for, as far as its text and the way up to here tell."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from assistant.program.expressions import (
    Aggregate,
    Apply,
    Binary,
    Expression,
    Index,
    Member,
    Name,
    Number,
    TargetValue,
    Truth,
    Unary,
)
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import map_expressions
from assistant.program.statements import Assign, Comment, If, Return, Statement
from assistant.robots.target_lookup import Names, Place

KnownValues = dict[str, Expression | None]

MOST_CALL_DEPTH: Final = 16
"""Functions that are called within each other."""
COMPARISONS: Final[dict[str, Callable[[float, float], bool]]] = {
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}
_UNKNOWN: Final = Name("")
"""Stands for a value that is not known: no name of a program."""


class Values:
    """Looks expressions up in the names of a program.

    names: with the values of variables that are known now in `own`.
    """

    def __init__(self, program: Program, names: Names) -> None:
        self.names = names
        self.functions = {
            one.name.lower(): one for one in program.procedures if one.result is not None
        }
        self.depth = 0

    def number(self, expression: Expression) -> float | None:
        return self.names.number(self.settled(expression))

    def place(self, expression: Expression) -> Place | None:
        return self.names.place(self.settled(expression))

    def truth(self, expression: Expression) -> bool | None:
        """Whether a condition holds; None if only running the program tells."""
        return self._truth(self.settled(expression))

    def value(self, expression: Expression) -> Expression | None:
        """The number, truth, target or array that an expression stands for now."""
        settled = self.settled(expression)
        number = self.names.number(settled)
        if number is not None:
            return Number(number)
        place = self.names.place(settled)
        if place is not None:
            target = place.target
            return TargetValue(type(target)(place.pose, target.configuration, target.external))
        if isinstance(settled, Name):
            settled = self.names.constant(settled.name.lower()) or settled
        return settled if isinstance(settled, Truth | Aggregate) else None

    def settled(self, expression: Expression) -> Expression:
        """The expression with its array elements, components and function calls looked up."""
        return map_expressions(expression, self._settled)

    def _settled(self, part: Expression) -> Expression:
        found: Expression | None = None
        match part:
            case Index(value=value, indices=indices):
                found = self._element(value, indices)
            case Member(value=value, field="x" | "y" | "z" as axis):
                place = self.names.place(value)
                found = None if place is None else Number(place.pose.position["xyz".index(axis)])
            case Apply(function=name, arguments=arguments) if name.lower() in self.functions:
                found = self._result(self.functions[name.lower()], arguments)
        return part if found is None else found

    def _element(self, array: Expression, indices: Sequence[Expression]) -> Expression | None:
        found: Expression | None = array
        if isinstance(array, Name):
            found = self.names.constant(array.name.lower())
        for index in indices:
            number = self.names.number(index)
            if number is None or not isinstance(found, Aggregate):
                return None
            if number != int(number) or not 1 <= number <= len(found.items):
                return None
            found = found.items[int(number) - 1]
        return found

    def _result(self, function: Procedure, arguments: Sequence[Expression]) -> Expression | None:
        """What a function gives back, if it only computes."""
        if self.depth >= MOST_CALL_DEPTH:
            return None
        given = self.given(function, arguments)
        outer, self.depth = self.names.own, self.depth + 1
        self.names.own = {**outer, **local_values(function), **given}
        try:
            found = self._returned(function.body)
            return None if found is _UNKNOWN else found
        finally:
            self.names.own, self.depth = outer, self.depth - 1

    def given(self, procedure: Procedure, arguments: Sequence[Expression]) -> KnownValues:
        """Values of the parameters of a call, in lower case."""
        pairs = zip(procedure.parameters, arguments, strict=False)
        return {parameter.name.lower(): self.value(argument) for parameter, argument in pairs}

    def _returned(self, body: Sequence[Statement]) -> Expression | None:
        """The value that a body returns; None if it does what is no computing, or `_OPEN` if
        it goes on behind its end.
        """
        for statement in body:
            match statement:
                case Comment():
                    continue
                case Assign(target=Name(name), value=value):
                    self.names.own[name.lower()] = self.value(value)
                case Return(value=value) if value is not None:
                    return self.value(value)
                case If():
                    chosen = self.chosen(statement)
                    found = None if chosen is None else self._returned(chosen)
                    if found is not _UNKNOWN:
                        return found
                case _:
                    return None
        return _UNKNOWN

    def chosen(self, statement: If) -> Sequence[Statement] | None:
        """The body that is run; None if only running the program tells."""
        for branch in statement.branches:
            holds = self.truth(branch.condition)
            if holds is None:
                return None
            if holds:
                return branch.body
        return statement.otherwise

    def _truth(self, expression: Expression) -> bool | None:
        match expression:
            case Truth(value=value):
                return value
            case Unary(operator="not", operand=operand):
                inner = self._truth(operand)
                return None if inner is None else not inner
            case Binary(operator="and" | "or" as operator, left=left, right=right):
                sides = {self._truth(left), self._truth(right)}
                deciding = operator == "or"
                if deciding in sides:
                    return deciding
                return None if None in sides else not deciding
            case Binary(operator=operator, left=left, right=right) if operator in COMPARISONS:
                a, b = self.names.number(left), self.names.number(right)
                return None if a is None or b is None else COMPARISONS[operator](a, b)
            case Name(name=name):
                meant = self.names.constant(name.lower())
                return meant.value if isinstance(meant, Truth) else None
        return None


def first_values(variables: Mapping[str, Variable], assigned: set[str]) -> KnownValues:
    """Values of variables, in lower case, before anything is assigned.

    assigned: persistent ones of these names may have been changed by an earlier run.
    """
    return {
        name.lower(): variable.initial
        for name, variable in variables.items()
        if isinstance(variable.initial, Number | Truth | TargetValue | Aggregate)
        and not (variable.storage == "persistent" and name.lower() in assigned)
    }


def local_values(procedure: Procedure) -> KnownValues:
    """The variables of a procedure as a call begins; None for what has no value that is known."""
    unknown: KnownValues = {name.lower(): None for name in procedure.variables}
    return {**unknown, **first_values(procedure.variables, set())}


def loop_rounds(first: float, last: float, step: float | None) -> int:
    """How often a loop from first to last goes round; see `For`."""
    by = step if step is not None else (1.0 if last >= first else -1.0)
    if by == 0.0 or not math.isfinite(first + last + by):
        return 0
    return max(0, math.floor((last - first) / by + 1e-9) + 1)
