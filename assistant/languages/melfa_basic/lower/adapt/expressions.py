"""Expressions in the form that their text is read back as.

Truth values are numbers, `not` is turned into its opposite (the language's own works on
bits), signs of numbers are part of them, names are spelled as they were declared.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lower.adapt.vendor_text import plain_verbatim
from assistant.languages.melfa_basic.tables.vocabulary.timers import MILLISECONDS
from assistant.program import expressions as e
from assistant.program.geometry import BASE
from assistant.program.rewriting import map_expressions

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.adapt.context import Context

OPPOSITE: Final[dict[str, Any]] = {
    "=": "<>", "<>": "=", "<": ">=", ">=": "<", ">": "<=", "<=": ">", "and": "or", "or": "and",
}  # fmt: skip


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
        case e.Elapsed(timer):
            return e.Elapsed(context.timer(timer))
        case e.Here(tool, frame):
            return _here(context, e.Here(context.tool(tool), context.frame(frame)))
        case e.Binary(operator, e.Binary("*", e.Elapsed() as seconds, e.Number(1000)), e.Number(n)):
            return e.Binary(operator, seconds, _seconds(n)) if operator in e.RELATIONS else value
        case e.Binary(operator, e.Number(n), e.Binary("*", e.Elapsed() as seconds, e.Number(1000))):
            return e.Binary(operator, _seconds(n), seconds) if operator in e.RELATIONS else value
        case e.Apply(function, arguments) if function.lower() in e.FUNCTIONS:
            return _function(context, function.lower(), arguments)
        case e.Text(text):
            return _text(context, text)
        case e.Verbatim():
            return plain_verbatim(value, context.dialect)
        case e.Apply(function, arguments):
            return e.Apply(context.spelled_procedure(function), arguments)
        case e.Member(inner, field):
            return e.Member(inner, field.lower())
        case e.Name(name):
            return e.Name(context.spelled(name))
        case e.TargetValue(target):
            return e.TargetValue(context.target("a target", target, "a target"))
        case e.JointValue(target):
            return e.JointValue(context.joints("a joint target", target, "a joint target"))
    return value


def _here(context: Context, value: e.Here) -> e.Here:
    """The present position; an error in a frame that `Base` is not set to."""
    if value.frame != BASE and (context.products or context.five_axis is not None):
        how = "frames as products" if context.five_axis is None else "five axes"
        context.findings.append(rules.CANNOT_SAY(
            what=f"the present position in `{value.frame}`, with {how}",
            cure="write frames as base" if context.five_axis is None else "read it in the base",
        ))  # fmt: skip
    return value


def _seconds(milliseconds: float) -> e.Number:
    seconds = milliseconds / MILLISECONDS
    return e.Number(int(seconds) if seconds.is_integer() else seconds)


def _function(context: Context, name: str, arguments: tuple[e.Expression, ...]) -> e.Expression:
    match name, arguments:
        case "relative" | "offset", _:
            while len(arguments) > 4 and arguments[-1] in (e.Number(0), e.Number(0.0)):
                arguments = arguments[:-1]
        case "fixed", (value, e.Number(places)):
            return _rounded_text(context, value, int(places))
    return e.Apply(name, arguments)


def _rounded_text(context: Context, value: e.Expression, places: int) -> e.Expression:
    """A number as text with so many decimals at most; none is written exactly."""
    if places <= 0:
        return e.Apply("text", (e.Apply("round", (value,)),))
    context.findings.append(rules.ROUNDED_TEXT())
    power = e.Number(10**places)
    whole = e.Apply("round", (e.Binary("*", value, power),))
    return e.Apply("text", (e.Binary("/", whole, power),))


def _text(context: Context, text: str) -> e.Text:
    """Without quotes, which end a text, and control characters."""
    plain = "".join(c if c.isprintable() else " " for c in text).replace('"', "'")
    if plain != text:
        context.findings.append(rules.TEXT_CHANGED(given=repr(text), text=repr(plain)))
    return e.Text(plain)


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
