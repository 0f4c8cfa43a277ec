"""Expressions in the form that their text is read back as.

Truth values are numbers, and `not` is turned into its opposite: the language's own works on bits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lower.adapt.vendor_text import plain_verbatim
from assistant.languages.melfa_basic.tables.vocabulary.timers import MILLISECONDS
from assistant.program import expressions as e
from assistant.program.geometry import BASE
from assistant.program.passes.plain_expressions import fixed, of_numbers, shifted
from assistant.program.rewriting import map_expressions

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.adapt.context import Context


def plain_expression(context: Context, value: e.Expression, deep: bool = True) -> e.Expression:
    """The same value, in the form that a lifted text has.

    deep: with all that is in it; else that is plain already.
    """
    if deep:
        return map_expressions(value, lambda x: plain_expression(context, x, deep=False))
    match value:
        case e.Truth() | e.Unary():
            return of_numbers(value)
        case e.Here(tool, frame):
            return _here(context, e.Here(context.tool(tool), context.frame(frame)))
        case e.Binary(operator, e.Binary("*", e.Elapsed() as seconds, e.Number(1000)), e.Number(n)):
            return e.Binary(operator, seconds, _seconds(n)) if operator in e.RELATIONS else value
        case e.Binary(operator, e.Number(n), e.Binary("*", e.Elapsed() as seconds, e.Number(1000))):
            return e.Binary(operator, _seconds(n), seconds) if operator in e.RELATIONS else value
        case e.Apply("relative" | "offset"):
            return shifted(value)
        case e.Apply("fixed", (number, e.Number(places))):
            if places > 0:
                context.findings.append(rules.ROUNDED_TEXT())
            return fixed(number, int(places))
        case e.Text(text):
            return _text(context, text)
        case e.Verbatim():
            return plain_verbatim(value, context.dialect)
        case e.TargetValue(target):
            return e.TargetValue(context.target("a target", target, "a target"))
        case e.JointValue(target):
            return e.JointValue(context.joints("a joint target", target, "a joint target"))
    return value


def _here(context: Context, value: e.Here) -> e.Here:
    """The present position; an error in a frame that `Base` is not set to."""
    if value.frame != BASE and (context.products or context.five_axis is not None):
        how = "frames as products" if context.five_axis is None else "five axes"
        context.job.cannot(
            what=f"the present position in `{value.frame}`, with {how}",
            cure="write frames as base" if context.five_axis is None else "read it in the base",
        )
    return value


def _seconds(milliseconds: float) -> e.Number:
    seconds = milliseconds / MILLISECONDS
    return e.number_of(seconds)


def _text(context: Context, text: str) -> e.Text:
    """Without quotes, which end a text, and control characters."""
    plain = "".join(c if c.isprintable() else " " for c in text).replace('"', "'")
    if plain != text:
        context.findings.append(rules.TEXT_CHANGED(given=repr(text), text=repr(plain)))
    return e.Text(plain)
