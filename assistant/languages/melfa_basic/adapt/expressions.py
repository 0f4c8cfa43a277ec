"""Expressions in the form that their text is read back as.

Truth values are numbers, `not` is turned into its opposite (the language's own works on
bits), signs of numbers are part of them, names are spelled as they were declared.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from assistant.program import expressions as e
from assistant.program.rewriting import map_expressions

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.adapt.context import Context

OPPOSITE: Final[dict[str, Any]] = {
    "=": "<>", "<>": "=", "<": ">=", ">=": "<", ">": "<=", "<=": ">", "and": "or", "or": "and",
}  # fmt: skip

MOVED: Final = ("relative", "offset")


def plain_expression(context: Context, value: e.Expression, deep: bool = True) -> e.Expression:
    """The same value, in the form that a lifted text has.

    deep: with all that is in it; else that is plain already.
    """
    if deep:
        return map_expressions(value, lambda x: plain_expression(context, x, deep=False))
    match value:
        case e.Truth(truth):
            return e.Number(int(truth))
        case e.Unary("-", e.Number(number)):
            return e.Number(-number)
        case e.Unary("not", operand):
            return opposite(operand)
        case e.Apply(function, arguments) if function.lower() in e.FUNCTIONS:
            known = function.lower()
            if known in MOVED:
                while len(arguments) > 4 and arguments[-1] in (e.Number(0), e.Number(0.0)):
                    arguments = arguments[:-1]
            return e.Apply(known, arguments)
        case e.Apply(function, arguments):
            return e.Apply(context.spelled_procedure(function), arguments)
        case e.Member(inner, field):
            return e.Member(inner, field.lower())
        case e.Name(name):
            return e.Name(context.spelled(name))
        case e.TargetValue(target):
            return e.TargetValue(context.target("a target", target))
        case e.JointValue(target):
            return e.JointValue(context.joints("a joint target", target))
    return value


def opposite(value: e.Expression) -> e.Expression:
    """What holds where the value does not."""
    match value:
        case e.Binary("and" | "or" as operator, left, right):
            return e.Binary(OPPOSITE[operator], opposite(left), opposite(right))
        case e.Binary(operator, left, right) if operator in OPPOSITE:
            return e.Binary(OPPOSITE[operator], left, right)
        case e.Number(number):
            return e.Number(int(number == 0))
    return e.Binary("=", value, e.Number(0))
