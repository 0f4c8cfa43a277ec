"""The typed nodes of syntax from what each rule of the grammar is made of."""

from __future__ import annotations

import math
from typing import Any, Final

from assistant.languages.melfa_basic.tables.words import spelled
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.diagnostics import Span


class Token(str):
    """A word of the text. type: its terminal."""

    __slots__ = ("type",)
    type: str

    @staticmethod
    def of(text: str, type: str) -> Token:
        word = Token(text)
        word.type = type
        return word


Children = list[Any]

_INTEGER_LIMIT: Final = 15


def number_of(text: str, suffix: str = "") -> s.Number:
    """A number literal of any base; raises ValueError for one that is too large."""
    mark = text[:2].upper()
    if mark == "&H":
        return s.Number(int(text[2:], 16), 16, suffix)
    if mark == "&B":
        return s.Number(int(text[2:], 2), 2, suffix)
    if text.isdigit() and len(text) <= _INTEGER_LIMIT:
        return s.Number(int(text), 10, suffix)
    return s.Number(_finite(text), 10, suffix)


def constant_of(text: str, span: Span | None = None) -> s.Constant:
    """A position or joint constant from its text; raises ValueError as number_of does."""
    values, _, flags = text.partition(")")
    elements = tuple(_finite(e) + 0.0 if e else None for e in _elements(values))
    if "(" not in flags:
        return s.Constant(elements, None, span)
    one, two = (_flag(f) for f in _elements(flags.rstrip().rstrip(")")))
    return s.Constant(elements, (one, two), span)


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is too large")
    return value


def _elements(text: str) -> list[str]:
    return [part.strip() for part in text.strip().lstrip("(").split(",")]


def _flag(text: str) -> int | None:
    if not text:
        return None
    if text[0] == "&":
        return int(number_of(text).value)
    return int(text)


def _text(token: Token | None) -> str:
    return "" if token is None else str(token)


def _of(children: Children, kind: str) -> Token | None:
    return next((c for c in children if isinstance(c, Token) and c.type == kind), None)


def _nodes(children: Children) -> Children:
    """What is no token: expressions, statements, targets."""
    return [c for c in children if not isinstance(c, Token) and c is not None]


def _jump(children: Children) -> Any:
    return "GoTo" if _of(children, "GOTO") is not None else "GoSub"


class Nodes:
    """One method a rule of the grammar, of the same name.

    Each takes the place of the rule in the text, None for an empty one, and what it is made of.
    """

    # ------------------------------------------------------------------- expressions

    def number(self, _: Span | None, children: Children) -> s.Number:
        return number_of(str(children[0]), _text(_of(children[1:], "SUFFIX")))

    def string(self, _: Span | None, children: Children) -> s.String:
        return s.String(str(children[0])[1:-1])

    def position(self, span: Span | None, children: Children) -> s.Constant:
        return constant_of(str(children[0]), span)

    def variable(self, span: Span | None, children: Children) -> s.Variable:
        if len(children) == 1:
            return s.Variable(str(children[0]), span=span)
        arguments = next((c for c in children if isinstance(c, tuple)), None)
        suffix = _text(_of(children[1:], "SUFFIX"))
        return s.Variable(str(children[0]), suffix, arguments, span=span)

    user_function = variable

    def empty_call(self, span: Span | None, children: Children) -> s.Variable:
        return s.Variable(str(children[0]), _text(_of(children[1:], "SUFFIX")), (), span=span)

    def component(self, span: Span | None, children: Children) -> s.Variable:
        arguments = next((c for c in children if isinstance(c, tuple)), None)
        return s.Variable(str(children[0]), "", arguments, str(children[-1]).upper(), span)

    def binary(self, _: Span | None, children: Children) -> s.Binary:
        left, operator, right = children
        return s.Binary(str(operator).upper(), left, right)

    def power(self, _: Span | None, children: Children) -> s.Binary:
        left, right = children
        return s.Binary("^", left, right)

    def unary(self, _: Span | None, children: Children) -> s.Unary:
        return s.Unary(str(children[0]).upper(), children[1])

    def pallet(self, _: Span | None, children: Children) -> s.Pallet:
        number, point = _nodes(children)
        return s.Pallet(number, point)

    def word(self, _: Span | None, children: Children) -> s.Word:
        return s.Word(str(children[0]).capitalize())

    def arguments(self, _: Span | None, children: Children) -> tuple[Any, ...]:
        return tuple(children)

    def later_arguments(self, _: Span | None, children: Children) -> tuple[Any, ...]:
        return (None, *children)

    def signed(self, _: Span | None, children: Children) -> s.Number | s.Unary:
        mark = _of(children[-1:], "SUFFIX")
        number = number_of(str(children[-1 if mark is None else -2]), _text(mark))
        sign = _of(children, "SIGN")
        return number if sign is None else s.Unary(str(sign), number)

    # -------------------------------------------------------------------- statements

    def command(self, _: Span | None, children: Children) -> s.Command:
        arguments = children[1] if len(children) > 1 and children[1] is not None else ()
        return s.Command(spelled(str(children[0])), arguments)

    def end_select(self, _: Span | None, __: Children) -> s.Command:
        return s.Command("End Select")

    def exit_function(self, _: Span | None, __: Children) -> s.Command:
        return s.Command("Exit Function")

    def motion(self, _: Span | None, children: Children) -> s.Motion:
        arguments = next((c for c in children if isinstance(c, tuple)), ())
        kind = next((c for c in children if isinstance(c, list)), None)
        append = next((c for c in children if isinstance(c, s.Append)), None)
        return s.Motion(
            spelled(str(children[0])), arguments, (kind[0], kind[1]) if kind else None, append
        )

    def type(self, _: Span | None, children: Children) -> Children:
        return _nodes(children)

    def append(self, _: Span | None, children: Children) -> s.Append:
        nodes = _nodes(children)
        return s.Append(nodes[-1], nodes[0] if len(nodes) > 1 else None)

    def assign(self, _: Span | None, children: Children) -> s.Assign:
        nodes = _nodes(children)
        return s.Assign(nodes[0], nodes[1], nodes[2] if len(nodes) > 2 else None)

    def call(self, span: Span | None, children: Children) -> s.Call:
        arguments = next((c for c in children if isinstance(c, tuple)), ())
        suffix = _text(_of(children[1:], "SUFFIX"))
        return s.Call(s.Variable(str(children[0]), suffix, arguments, span=span))

    def target(self, span: Span | None, children: Children) -> s.Target:
        token = children[0]
        if token.type == "STEP":
            return s.Target(int(token), span)
        return s.Target(label_of(str(token)), span)

    def data(self, _: Span | None, children: Children) -> s.Data:
        variable, value = _nodes(children)
        kind = _of(children, "TYPE")
        if not isinstance(value, s.Constant | s.Number | s.Unary | s.String):
            raise TypeError(f"not a constant: {value!r}")
        return s.Data(variable, value, "" if kind is None else spelled(str(kind)))

    def if_(self, _: Span | None, children: Children) -> s.If:
        condition, *branches = _nodes(children)
        return s.If(condition, *(branches or [None]))

    def elseif(self, _: Span | None, children: Children) -> s.ElseIf:
        return s.ElseIf(_nodes(children)[0])

    def for_(self, _: Span | None, children: Children) -> s.For:
        return s.For(*_nodes(children))

    def next(self, _: Span | None, children: Children) -> s.Next:
        return s.Next(tuple(_nodes(children)))

    def select(self, _: Span | None, children: Children) -> s.Select:
        return s.Select(_nodes(children)[0])

    def case_range(self, _: Span | None, children: Children) -> s.CaseRange:
        return s.CaseRange(*_nodes(children))

    def case_is(self, _: Span | None, children: Children) -> s.CaseIs:
        return s.CaseIs(str(_of(children, "COMPARISON") or "="), _nodes(children)[0])

    def case(self, _: Span | None, children: Children) -> s.Case:
        return s.Case(tuple(_nodes(children)))

    def goto(self, _: Span | None, children: Children) -> s.Jump:
        return s.Jump("GoTo", children[-1])

    def gosub(self, _: Span | None, children: Children) -> s.Jump:
        return s.Jump("GoSub", children[-1])

    def on_jump(self, _: Span | None, children: Children) -> s.OnJump:
        targets = [c for c in children if not isinstance(c, Token)][1:]
        return s.OnJump(children[1], _jump(children), tuple(targets))

    def on_com(self, _: Span | None, children: Children) -> s.OnCom:
        nodes = _nodes(children)
        return s.OnCom(nodes[0] if len(nodes) > 1 else None, nodes[-1])

    def com(self, _: Span | None, children: Children) -> s.Com:
        nodes = _nodes(children)
        return s.Com(nodes[0] if nodes else None, str(children[-1]).capitalize())

    def callp(self, _: Span | None, children: Children) -> s.CallP:
        program, *arguments = _nodes(children)
        return s.CallP(program, tuple(arguments))

    def fprm(self, _: Span | None, children: Children) -> s.FPrm:
        return s.FPrm(tuple(_nodes(children)))

    def def_names(self, _: Span | None, children: Children) -> s.DefNames:
        return s.DefNames(spelled(_text(_of(children, "TYPE"))), tuple(_nodes(children)))

    def def_io(self, _: Span | None, children: Children) -> s.DefIo:
        variable, *rest = _nodes(children)
        return s.DefIo(variable, str(_of(children, "NAME")).capitalize(), *rest)

    def def_fn(self, _: Span | None, children: Children) -> s.DefFunction:
        *parameters, value = _nodes(children)
        name, suffix = str(_of(children, "FN_NAME")), _text(_of(children, "SUFFIX"))
        return s.DefFunction(name, suffix, tuple(parameters), value)

    def def_other(self, _: Span | None, children: Children) -> s.DefOther:
        return s.DefOther(spelled(_text(_of(children, "DEF_OF"))), children[-1])

    def def_act(self, _: Span | None, children: Children) -> s.DefAct:
        number, condition, target = _nodes(children)
        stop = _text(_of(children, "NAME")).upper()
        return s.DefAct(number, condition, _jump(children), target, stop)

    def dim(self, _: Span | None, children: Children) -> s.Dim:
        return s.Dim(tuple(_nodes(children)))

    def const(self, _: Span | None, children: Children) -> s.Const:
        kind = _of(children, "TYPE")
        variable, value = _nodes(children)
        return s.Const("" if kind is None else spelled(str(kind)), variable, value)

    def static(self, _: Span | None, children: Children) -> s.Static:
        return s.Static(_nodes(children)[0])

    def include(self, _: Span | None, children: Children) -> s.Include:
        return s.Include(str(children[-1])[1:-1])

    def parameter(self, _: Span | None, children: Children) -> s.FunctionParameter:
        by = _of(children, "BYVAL") or _of(children, "BYREF")
        return s.FunctionParameter(
            "" if by is None else spelled(str(by)),
            str(_of(children, "NAME")),
            _text(_of(children, "SUFFIX")),
            _of(children, "EMPTY") is not None,
        )

    def result(self, _: Span | None, children: Children) -> s.String:
        return s.String("".join(map(_text, children)))

    def parameters(self, _: Span | None, children: Children) -> tuple[Any, ...]:
        return tuple(_nodes(children))

    def function(self, _: Span | None, children: Children) -> s.Function:
        result = next((c.value for c in children if isinstance(c, s.String)), "")
        listed = next((c for c in children if isinstance(c, tuple)), None)
        name, suffix = str(_of(children, "NAME")), _text(_of(children, "SUFFIX"))
        return s.Function(result, name, suffix, listed)

    def open(self, _: Span | None, children: Children) -> s.Open:
        name, number = _nodes(children)
        mode = _of(children, "NAME")
        return s.Open(name, "" if mode is None else str(mode).capitalize(), number)

    def close(self, _: Span | None, children: Children) -> s.Close:
        return s.Close(tuple(_nodes(children)))

    def print_mark(self, _: Span | None, children: Children) -> Token:
        return Token.of(str(children[0]), "MARK")

    def print(self, _: Span | None, children: Children) -> s.Print:
        number, *rest = [c for c in children if not isinstance(c, Token) or c.type == "MARK"]
        items: list[tuple[str, Any]] = []
        for child in rest:
            if isinstance(child, Token):
                items.append((str(child), None))
            elif child is not None:
                items[-1] = (items[-1][0], child)
        return s.Print(number, tuple(items))

    def input(self, _: Span | None, children: Children) -> s.Input:
        number, *variables = _nodes(children)
        return s.Input(number, tuple(variables))

    # -------------------------------------------------------------------------- line

    def comment(self, _: Span | None, children: Children) -> Token:
        return Token.of(str(children[0]), "COMMENT")

    def line(self, _: Span | None, children: Children) -> s.Line:
        label, comment = _of(children, "LABEL"), _of(children, "COMMENT")
        nodes = _nodes(children)
        return s.Line(
            None,
            None if label is None else label_of(str(label)),
            nodes[0] if nodes else None,
            None if comment is None else str(comment).rstrip(),
        )


for _rule in ("if", "for"):  # words of Python, which a method cannot be called
    setattr(Nodes, _rule, getattr(Nodes, _rule + "_"))


def label_of(text: str) -> str:
    """A label's name without its mark."""
    return text.lstrip("*").strip()
