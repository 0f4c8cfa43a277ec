"""The canonical text of code lines, statements and expressions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Final

from assistant.languages.melfa_basic.tables.words import (
    POWER_PRECEDENCE,
    PRECEDENCE,
    SIGN_PRECEDENCE,
)
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.text import one_line

INDENT: Final = 4
"""Blanks of a level (what RT ToolBox's editor indents by)."""
SIGNS: Final = ("+", "-")
SYMBOLS: Final = frozenset({"+", "-", "*", "/", "\\", "<<", ">>", "MOD"})
"""Operators that no sign follows without brackets."""


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
    return _Words(upper).statement(node)


def expression(node: s.Expression, upper: bool = False) -> str:
    return _Words(upper).expression(node)


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
    whole = value.is_integer() and abs(value) < 1e15
    return (str(int(value)) if whole else repr(value).upper()) + node.suffix


def _apart(text: str) -> str:
    """With brackets around what begins with a sign: not every controller reads two in a row."""
    return f"({text})" if text.startswith(SIGNS) else text


class _Words:
    """Prints statements in one case of keywords."""

    def __init__(self, upper: bool) -> None:
        self.upper = upper

    def word(self, text: str) -> str:
        return text.upper() if self.upper else text

    def statement(self, node: s.Statement) -> str:
        return STATEMENTS[type(node)](self, node)

    # --------------------------------------------------------------------- expressions

    def expression(self, node: s.Expression, least: int = 0) -> str:
        """least: binding that the surroundings ask for; looser expressions get brackets."""
        match node:
            case s.Number():
                return number(node)
            case s.String(value=value):
                return f'"{value}"'
            case s.Variable():
                return self.variable(node)
            case s.Constant():
                return constant(node)
            case s.Word(text=text):
                return self.word(text)
            case s.Pallet(number=plate, point=point):
                inner = f"{self.word('Plt')} {self.expression(plate)},{self.expression(point)}"
                return f"({inner})"
            case s.Unary(operator=operator, operand=operand):
                binding = PRECEDENCE["NOT"] if operator == "NOT" else SIGN_PRECEDENCE
                mark = self.word("Not ") if operator == "NOT" else operator
                text = self.expression(operand, binding)
                text = text if operator == "NOT" else _apart(text)
                return self.bracketed(mark + text, binding, least)
            case s.Binary(operator="^", left=left, right=right):
                text = self.expression(left, POWER_PRECEDENCE) + "^" + self.exponent(right)
                return self.bracketed(text, POWER_PRECEDENCE, least)
            case s.Binary(operator=operator, left=left, right=right):
                binding = PRECEDENCE[operator]
                mark = f" {self.word(operator.capitalize())} " if operator.isalpha() else operator
                second = self.expression(right, binding + 1)
                second = _apart(second) if operator in SYMBOLS else second
                text = self.expression(left, binding) + mark + second
                return self.bracketed(text, binding, least)

    def exponent(self, node: s.Expression) -> str:
        """What stands behind `^`, which may have a sign of its own; powers count from the left."""
        if isinstance(node, s.Unary) and node.operator in SIGNS:
            return node.operator + _apart(self.exponent(node.operand))
        return self.expression(node, POWER_PRECEDENCE + 1)

    @staticmethod
    def bracketed(text: str, binding: int, least: int) -> str:
        return f"({text})" if binding < least else text

    def variable(self, node: s.Variable) -> str:
        arguments = "" if node.arguments is None else f"({self.arguments(node.arguments)})"
        component = f".{node.component}" if node.component else ""
        return f"{node.name}{node.suffix}{arguments}{component}"

    def arguments(self, nodes: Iterable[s.Expression | None]) -> str:
        return ",".join("" if node is None else self.expression(node) for node in nodes)

    def variables(self, nodes: Sequence[s.Variable]) -> str:
        return ",".join(self.variable(node) for node in nodes)

    def target(self, node: s.Target) -> str:
        return str(node.place) if isinstance(node.place, int) else f"*{node.place}"

    def branch(self, node: s.Statement | s.Target) -> str:
        return self.target(node) if isinstance(node, s.Target) else self.statement(node)

    # ---------------------------------------------------------------------- statements

    def command(self, node: s.Command) -> str:
        arguments = self.arguments(node.arguments)
        return f"{self.word(node.keyword)} {arguments}".rstrip()

    def motion(self, node: s.Motion) -> str:
        text = f"{self.word(node.keyword)} {self.arguments(node.arguments)}"
        if node.type:
            text += f" {self.word('Type')} {self.arguments(node.type)}"
        if node.append:
            text += f" {self.append(node.append)}"
        return text

    def append(self, node: s.Append) -> str:
        inner = self.statement(node.statement)
        if node.condition is None:
            return f"{self.word('Wth')} {inner}"
        return f"{self.word('WthIf')} {self.expression(node.condition)},{inner}"

    def assign(self, node: s.Assign) -> str:
        text = f"{self.variable(node.target)}={self.expression(node.value)}"
        if node.delay is not None:
            text += f" {self.word('Dly')} {self.expression(node.delay)}"
        return text

    def if_(self, node: s.If) -> str:
        text = f"{self.word('If')} {self.expression(node.condition)} {self.word('Then')}"
        if node.then is not None:
            text += " " + self.branch(node.then)
        if node.otherwise is not None:
            text += f" {self.word('Else')} {self.branch(node.otherwise)}"
        return text

    def elseif(self, node: s.ElseIf) -> str:
        return f"{self.word('ElseIf')} {self.expression(node.condition)} {self.word('Then')}"

    def for_(self, node: s.For) -> str:
        step = "" if node.step is None else f" {self.word('Step')} {self.expression(node.step)}"
        return (
            f"{self.word('For')} {self.variable(node.variable)}={self.expression(node.first)} "
            f"{self.word('To')} {self.expression(node.last)}{step}"
        )

    def next(self, node: s.Next) -> str:
        return f"{self.word('Next')} {self.variables(node.variables)}".rstrip()

    def select(self, node: s.Select) -> str:
        return f"{self.word('Select')} {self.expression(node.subject)}"

    def case(self, node: s.Case) -> str:
        return f"{self.word('Case')} {','.join(self.case_item(item) for item in node.items)}"

    def case_item(self, item: s.CaseRange | s.CaseIs) -> str:
        if isinstance(item, s.CaseIs):
            return f"{self.word('Is')} {item.operator} {self.expression(item.value)}"
        last = "" if item.last is None else f" {self.word('To')} {self.expression(item.last)}"
        return self.expression(item.first) + last

    def jump(self, node: s.Jump) -> str:
        return f"{self.word(node.keyword)} {self.target(node.target)}"

    def on_jump(self, node: s.OnJump) -> str:
        targets = ",".join("" if t is None else self.target(t) for t in node.targets)
        subject = self.expression(node.subject)
        return f"{self.word('On')} {subject} {self.word(node.keyword)} {targets}"

    def on_com(self, node: s.OnCom) -> str:
        number = "" if node.line is None else f"({self.expression(node.line)})"
        return f"{self.word('On Com')}{number} {self.word('GoSub')} {self.target(node.target)}"

    def com(self, node: s.Com) -> str:
        number = "" if node.line is None else f"({self.expression(node.line)})"
        return f"{self.word('Com')}{number} {self.word(node.state)}"

    def callp(self, node: s.CallP) -> str:
        return f"{self.word('CallP')} {self.arguments((node.program, *node.arguments))}"

    def call(self, node: s.Call) -> str:
        return self.variable(node.function)

    def fprm(self, node: s.FPrm) -> str:
        return f"{self.word('FPrm')} {self.variables(node.variables)}"

    def def_names(self, node: s.DefNames) -> str:
        return f"{self.word('Def ' + node.type)} {self.variables(node.variables)}"

    def def_io(self, node: s.DefIo) -> str:
        mask = "" if node.mask is None else "," + self.expression(node.mask)
        name, number_ = self.variable(node.variable), self.expression(node.number)
        return f"{self.word('Def Io')} {name}={self.word(node.type)},{number_}{mask}"

    def def_function(self, node: s.DefFunction) -> str:
        parameters = f"({self.variables(node.parameters)})" if node.parameters else ""
        name = f"{node.name}{node.suffix}{parameters}"
        return f"{self.word('Def')} {name}={self.expression(node.value)}"

    def def_other(self, node: s.DefOther) -> str:
        return f"{self.word('Def ' + node.kind)} {self.arguments(node.arguments)}"

    def def_act(self, node: s.DefAct) -> str:
        condition = self.arguments((node.number, node.condition))
        stop = f",{node.stop}" if node.stop else ""
        jump = f"{self.word(node.keyword)} {self.target(node.target)}"
        return f"{self.word('Def Act')} {condition} {jump}{stop}"

    def dim(self, node: s.Dim) -> str:
        return f"{self.word('Dim')} {self.variables(node.variables)}"

    def const(self, node: s.Const) -> str:
        kind = f"{self.word('Def ' + node.type)} " if node.type else ""
        variable, value = self.variable(node.variable), self.expression(node.value)
        return f"{self.word('Const')} {kind}{variable}={value}"

    def static(self, node: s.Static) -> str:
        return f"{self.word('Static')} {self.statement(node.definition)}"

    def include(self, node: s.Include) -> str:
        return f'{self.word("#Include")} "{node.program}"'

    def function(self, node: s.Function) -> str:
        parts = [self.word("Function"), *([node.result] if node.result else [])]
        listed = node.parameters
        brackets = "" if listed is None else f"({','.join(self.parameter(p) for p in listed)})"
        return " ".join([*parts, f"{node.name}{node.suffix}{brackets}"])

    def parameter(self, node: s.FunctionParameter) -> str:
        by = f"{self.word(node.mode)} " if node.mode else ""
        return f"{by}{node.name}{node.suffix}{'()' if node.array else ''}"

    def open(self, node: s.Open) -> str:
        mode = f" {self.word('For')} {self.word(node.mode)}" if node.mode else ""
        name, number_ = self.expression(node.name), self.expression(node.number)
        return f"{self.word('Open')} {name}{mode} {self.word('As')} #{number_}"

    def close(self, node: s.Close) -> str:
        numbers = ",".join(f"#{self.expression(n)}" for n in node.numbers)
        return f"{self.word('Close')} {numbers}".rstrip()

    def print(self, node: s.Print) -> str:
        items = (m + ("" if e is None else self.expression(e)) for m, e in node.items)
        return f"{self.word('Print')} #{self.expression(node.number)}{''.join(items)}"

    def input(self, node: s.Input) -> str:
        number_, variables = self.expression(node.number), self.variables(node.variables)
        return f"{self.word('Input')} #{number_},{variables}"


STATEMENTS: Final[dict[type, Callable[[_Words, Any], str]]] = {
    s.Command: _Words.command,
    s.Motion: _Words.motion,
    s.Assign: _Words.assign,
    s.If: _Words.if_,
    s.ElseIf: _Words.elseif,
    s.For: _Words.for_,
    s.Next: _Words.next,
    s.Select: _Words.select,
    s.Case: _Words.case,
    s.Jump: _Words.jump,
    s.OnJump: _Words.on_jump,
    s.OnCom: _Words.on_com,
    s.Com: _Words.com,
    s.CallP: _Words.callp,
    s.Call: _Words.call,
    s.FPrm: _Words.fprm,
    s.DefNames: _Words.def_names,
    s.DefIo: _Words.def_io,
    s.DefFunction: _Words.def_function,
    s.DefOther: _Words.def_other,
    s.DefAct: _Words.def_act,
    s.Dim: _Words.dim,
    s.Const: _Words.const,
    s.Static: _Words.static,
    s.Include: _Words.include,
    s.Function: _Words.function,
    s.Open: _Words.open,
    s.Close: _Words.close,
    s.Print: _Words.print,
    s.Input: _Words.input,
}
