"""The canonical text of code lines, statements and expressions."""

from __future__ import annotations

import math
from functools import cache
from typing import Any, Final

from assistant.base.source_text import one_line
from assistant.languages.melfa_basic.tables.equivalents import (
    NOT,
    OPERATOR_NAMES,
    OPERATOR_PRECEDENCE,
    POWER,
    SIGN,
)
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.texts.layout import INDENT
from assistant.languages.texts.printed_trees import Templates
from assistant.program.expressions import needs_parentheses_for_readers

_SIGNS: Final = ("+", "-")
_SYMBOLS: Final = frozenset({"+", "-", "*", "/", "\\", "<<", ">>", "MOD"})
"""Operators that no sign follows without brackets."""
_TIGHTEST: Final = math.inf
"""Binding of what needs no brackets anywhere."""


def line(item: s.Line, upper: bool = False, level: int = 0) -> str:
    """A code line without its line end; what may end a line in its comment becomes a blank."""
    parts = [] if item.number is None else [str(item.number)]
    body = statement(item.statement, upper) if item.statement is not None else ""
    if item.label is not None:
        body = f"*{item.label}:{body}" if body else f"*{item.label}"
    parts += [part for part in (body, one_line(item.comment or "")) if part]
    if len(parts) > (item.number is not None):
        at = item.number is not None
        parts[at] = " " * (INDENT * level) + parts[at]
    return " ".join(parts)


def statement(node: s.Statement, upper: bool = False) -> str:
    """A statement's text; keywords in upper case for MELFA-BASIC IV."""
    return _printer(upper).text(node)


def expression(node: s.Expression, upper: bool = False) -> str:
    return _printer(upper).text(node)


def constant(node: s.Constant, places: int | None = None) -> str:
    """A position or joint constant. places: decimals, with a sign; None for what each needs."""
    values = [
        "" if v is None else number(s.Number(v)) if places is None else f"{v:+.{places}f}"
        for v in node.values
    ]
    text = f"({','.join(_unsigned_zero(v) for v in values)})"
    if node.flags is None:
        return text
    return text + "({},{})".format(*("" if f is None else f for f in node.flags))


def _unsigned_zero(text: str) -> str:
    # Rounding may leave a minus before zeros.
    return "+" + text[1:] if text.startswith("-") and not text.strip("-0.") else text


def number(node: s.Number) -> str:
    """A number literal; raises ValueError for one that is not finite."""
    if not math.isfinite(node.value):
        raise ValueError("not a finite number")
    if node.base == 16:
        return f"&H{int(node.value):X}" + node.suffix
    if node.base == 2:
        return f"&B{int(node.value):b}" + node.suffix
    value = float(node.value)
    # From there on the digits of a whole number are not all exact.
    whole = value.is_integer() and abs(value) < 1e15
    return (str(int(value)) if whole else repr(value).upper()) + node.suffix


# Operators


def _binding(node: s.Expression) -> float:
    """Return the precedence of the outermost operator of an expression."""
    match node:
        case s.Unary(operator="NOT"):
            return NOT
        case s.Unary():
            return SIGN
        case s.Binary(operator=operator):
            return OPERATOR_PRECEDENCE[operator]
    return _TIGHTEST


def _operand(to: Templates, node: s.Expression, least: float) -> str:
    """An operand, in brackets if it binds less than its surroundings ask for."""
    return f"({to.text(node)})" if _binding(node) < least else to.text(node)


def _apart(text: str) -> str:
    """With brackets around what begins with a sign: not every controller reads two in a row."""
    return f"({text})" if text.startswith(_SIGNS) else text


def _unary(to: Templates, node: s.Unary) -> str:
    # `-A^2` is -(A^2), and `Not A=B` is Not (A=B): readers may take them for something else.
    least = _binding(node) if isinstance(node.operand, s.Unary) else _TIGHTEST
    text = _operand(to, node.operand, least)
    return to.word("Not ") + text if node.operator == "NOT" else node.operator + _apart(text)


def _binary(to: Templates, node: s.Binary) -> str:
    binding, operator = _binding(node), node.operator
    left = _operand(to, node.left, _TIGHTEST if _in_doubt(node, node.left) else binding)
    if operator == "^":
        return f"{left}^{_exponent(to, node.right)}"
    # Operators associate to the left, so an equal one on the right needs brackets.
    least = _TIGHTEST if _in_doubt(node, node.right) else binding + 1
    right = _operand(to, node.right, least)
    mark = f" {to.word(operator.capitalize())} " if operator.isalpha() else operator
    return left + mark + (_apart(right) if operator in _SYMBOLS else right)


def _in_doubt(node: s.Binary, operand: s.Expression) -> bool:
    return isinstance(operand, s.Binary) and needs_parentheses_for_readers(
        OPERATOR_NAMES[node.operator], OPERATOR_NAMES[operand.operator]
    )


def _exponent(to: Templates, node: s.Expression) -> str:
    """Print the operand after `^`, which may have a sign; powers associate to the left."""
    if isinstance(node, s.Unary) and node.operator in _SIGNS:
        return node.operator + _apart(_exponent(to, node.operand))
    return _operand(to, node, POWER + 1)


# Rows


def _variable(to: Templates, node: s.Variable) -> str:
    """Print a variable by `<name><suffix>[[(<arguments?>)]][[.<component>]]`: most nodes are
    variables.
    """
    arguments = "" if node.arguments is None else f"({to.listed(node.arguments)})"
    component = f".{node.component}" if node.component else ""
    return f"{node.name}{node.suffix}{arguments}{component}"


def _target(_: Templates, node: s.Target) -> str:
    return str(node.place) if isinstance(node.place, int) else f"*{node.place}"


def _close(to: Templates, node: s.Close) -> str:
    numbers = ",".join("#" + to.text(number) for number in node.numbers)
    return f"{to.word('Close')} {numbers}".rstrip()


def _print(to: Templates, node: s.Print) -> str:
    items = "".join(mark + to.text(value) for mark, value in node.items)
    return f"{to.word('Print')} #{to.text(node.number)}{items}"


def _append(to: Templates, node: s.Append) -> str:
    if node.condition is None:
        return f"{to.word('Wth')} {to.text(node.statement)}"
    return f"{to.word('WthIf')} {to.text(node.condition)},{to.text(node.statement)}"


_ROWS: Final[dict[type, Any]] = {
    s.Number: lambda _, node: number(node),
    s.String: '"<value>"',
    s.Variable: _variable,
    s.Constant: lambda _, node: constant(node),
    s.Word: "<text^>",
    s.Channel: "#<number>",
    s.Opening: "<name> As #<number>",
    s.Pallet: "(Plt <number>,<point>)",
    s.Unary: _unary,
    s.Binary: _binary,
    s.Target: _target,
    s.Command: "<keyword^>[[ <arguments>]]",
    s.Motion: "<keyword^> <arguments>[[ Type <type>]][[ <append>]]",
    s.Append: _append,
    s.Assign: "<target>=<value>[[ Dly <delay>]]",
    s.If: "If <condition> Then[[ <then>]][[ Else <otherwise>]]",
    s.ElseIf: "ElseIf <condition> Then",
    s.For: "For <variable>=<first> To <last>[[ Step <step>]]",
    s.Next: "Next[[ <variables>]]",
    s.Select: "Select <subject>",
    s.Case: "Case <items>",
    s.CaseIs: "Is <operator> <value>",
    s.CaseRange: "<first>[[ To <last>]]",
    s.Jump: "<keyword^> <target>",
    s.OnJump: "On <subject> <keyword^> <targets>",
    s.OnCom: "On Com[[(<line>)]] GoSub <target>",
    s.Com: "Com[[(<line>)]] <state^>",
    s.CallP: "CallP <program>[[,<arguments>]]",
    s.Call: "<function>",
    s.FPrm: "FPrm <variables>",
    s.DefNames: "Def <type^> <variables>",
    s.DefIo: "Def Io <variable>=<type^>,<number>[[,<mask>]]",
    s.DefFunction: "Def <name><suffix>[[(<parameters>)]]=<value>",
    s.DefOther: "Def <kind^> <arguments>",
    s.DefAct: "Def Act <number>,<condition> <keyword^> <target>[[,<stop>]]",
    s.Dim: "Dim <variables>",
    s.Const: "Const [[Def <type^> ]]<variable>=<value>",
    s.Static: "Static <definition>",
    s.Include: '#Include "<program>"',
    s.Function: "Function [[<result> ]]<name><suffix>[[(<parameters?>)]]",
    s.FunctionParameter: "[[<mode^> ]]<name><suffix><array:()>",
    s.Open: "Open <name>[[ For <mode^>]] As #<number>",
    s.Close: _close,
    s.Print: _print,
    s.Input: "Input #<number>,<variables>",
}
"""Text template of each kind of statement and expression."""


@cache
def _printer(upper: bool) -> Templates:
    return Templates(_ROWS, str.upper if upper else str)
