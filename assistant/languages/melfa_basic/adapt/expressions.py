"""Expressions and statements in a form that reads back the same.

Truth values are numbers, `not` is turned into its opposite (the language's own works on
bits), signs of numbers are part of them, names are spelled as they were declared.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic import rules
from assistant.program import expressions as e
from assistant.program import statements as p

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.adapt.program import Context

OPPOSITE: Final[dict[str, Any]] = {
    "=": "<>", "<>": "=", "<": ">=", ">=": "<", ">": "<=", "<=": ">", "and": "or", "or": "and",
}  # fmt: skip


def plain_expression(context: Context, value: e.Expression) -> e.Expression:
    """The same value, in the form that a lifted text has."""

    def plain(inner: e.Expression) -> e.Expression:
        return plain_expression(context, inner)

    match value:
        case e.Truth(value=truth):
            return e.Number(int(truth))
        case e.Unary(operator="-", operand=operand):
            inner = plain(operand)
            return e.Number(-inner.value) if isinstance(inner, e.Number) else e.Unary("-", inner)
        case e.Unary(operand=operand):
            return _opposite(plain(operand))
        case e.Binary(operator=operator, left=left, right=right):
            return e.Binary(operator, plain(left), plain(right))
        case e.Apply(function=function, arguments=arguments):
            known = function.lower() if function.lower() in e.FUNCTIONS else function
            made = tuple(plain(a) for a in arguments)
            if known in ("relative", "offset"):
                while len(made) > 4 and made[-1] in (e.Number(0), e.Number(0.0)):
                    made = made[:-1]
            return e.Apply(known, made)
        case e.Member(value=inner, field=name):
            return e.Member(plain(inner), name.lower())
        case e.Index(value=inner, indices=indices):
            return e.Index(plain(inner), tuple(plain(i) for i in indices))
        case e.Name(name=name):
            return e.Name(_declared(context, name))
        case e.TargetValue(target=target):
            return e.TargetValue(context.target("a target", target))
        case e.JointValue(target=target):
            from assistant.languages.melfa_basic.adapt.program import _joints

            return e.JointValue(_joints(context, "a joint target", target))
    return value


def _opposite(value: e.Expression) -> e.Expression:
    match value:
        case e.Binary(operator=("and" | "or") as operator, left=left, right=right):
            return e.Binary(OPPOSITE[operator], _opposite(left), _opposite(right))
        case e.Binary(operator=operator, left=left, right=right) if operator in OPPOSITE:
            return e.Binary(OPPOSITE[operator], left, right)
        case e.Number(value=number):
            return e.Number(int(number == 0))
    return e.Binary("=", value, e.Number(0))


def _declared(context: Context, name: str) -> str:
    """The name as its declaration spells it."""
    program, key = context.program, name.lower()
    for table in (program.variables, program.targets, program.joint_targets, program.signals):
        for given in table:
            if given.lower() == key:
                return given
    return name


FIELDS: Final = (
    "target", "via", "seconds", "value", "timeout", "condition", "pulse", "acceleration",
    "deceleration", "percent", "first", "last", "step", "subject",
)  # fmt: skip
"""Fields of statements that hold an expression."""


def plain_statement(context: Context, node: p.Statement) -> p.Statement:
    """The statement with its own expressions in plain form; bodies are left alone."""
    changed: dict[str, Any] = {}
    for field in fields(node):
        value = getattr(node, field.name)
        if field.name in FIELDS and isinstance(value, e.Expression):
            changed[field.name] = plain_expression(context, value)
    match node:
        case p.Call(arguments=arguments):
            changed["arguments"] = tuple(plain_expression(context, a) for a in arguments)
        case p.If(branches=branches):
            changed["branches"] = tuple(
                replace(b, condition=plain_expression(context, b.condition)) for b in branches
            )
        case p.Switch(cases=cases):
            changed["cases"] = tuple(
                replace(c, values=tuple(plain_expression(context, v) for v in c.values))
                for c in cases
            )
        case p.WaitSignal(signal=signal) | p.SetSignal(signal=signal):
            changed["signal"] = _declared(context, signal)
        case p.For(step=None):
            changed["step"] = _direction(context, node)
        case p.Opaque():
            return _plain_opaque(context, node)
    made: p.Statement = replace(node, **changed)
    return _waiting(context, made)


def _direction(context: Context, node: p.For) -> e.Number:
    """The step of a loop that counts towards its end, which MELFA-BASIC must be told."""
    first, last = (plain_expression(context, x) for x in (node.first, node.last))
    if isinstance(first, e.Number) and isinstance(last, e.Number):
        return e.Number(1 if first.value <= last.value else -1)
    context.findings.append(rules.UPWARDS(name=node.variable))
    return e.Number(1)


def _waiting(context: Context, node: p.Statement) -> p.Statement:
    """A wait for a signal and a number is a WaitSignal, any other a WaitUntil."""
    signals = {name.lower() for name in context.program.signals}
    match node:
        case p.WaitSignal(signal=signal, value=value) if not isinstance(value, e.Number):
            condition = e.Binary("=", e.Name(signal), value)
            return p.WaitUntil(condition, node.timeout, span=node.span)
        case p.WaitUntil(
            condition=e.Binary(operator="=", left=e.Name(name=name), right=e.Number() as value)
        ) if name.lower() in signals:
            return p.WaitSignal(name, value, node.timeout, span=node.span)
        case p.WaitUntil(condition=e.Name(name=name)) if name.lower() in signals:
            return p.WaitSignal(name, e.Number(1), node.timeout, span=node.span)
    return node


def _plain_opaque(context: Context, node: p.Opaque) -> p.Opaque:
    """The vendor text in its canonical layout, if this language has it."""
    from assistant.languages.melfa_basic import printer
    from assistant.languages.melfa_basic.lower.statements import opaque_line

    line = opaque_line(node, context.dialect)
    if line is None:
        return node
    text = printer.line(line, context.dialect.upper)
    return p.Opaque(context.dialect.name, text, span=node.span)
