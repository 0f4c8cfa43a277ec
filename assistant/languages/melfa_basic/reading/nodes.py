"""The typed nodes of syntax from what each rule of the grammar is made of."""

from __future__ import annotations

import math
import sys
from typing import Final

from assistant.base.diagnostics import Span
from assistant.languages import nodes
from assistant.languages.melfa_basic.tables.words import keyword_spelling
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import FLAGS
from assistant.languages.nodes import Children, Place, row, without_place

_INTEGER_LIMIT: Final = 15


def number_of(text: str, suffix: str = "") -> s.Number:
    """A number literal of any base; raises ValueError for one that is too large."""
    mark = text[:2].upper()
    if mark == "&H":
        return s.Number(_whole(text[2:], 16), 16, suffix)
    if mark == "&B":
        return s.Number(_whole(text[2:], 2), 2, suffix)
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


def _whole(digits: str, base: int) -> int:
    value = int(digits, base)
    if value > sys.float_info.max:
        raise ValueError(f"{digits} is too large")
    return value


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
    value = int(number_of(text).value) if text[0] == "&" else int(text)
    if value not in FLAGS:
        raise ValueError(f"{text} is too large")
    return value


def label_of(text: str) -> str:
    """A label's name without its mark."""
    return text.lstrip("*").strip()


def _unquoted(text: str) -> str:
    return text[1:-1]


LIST_ROWS: Final = dict.fromkeys(
    ("arguments", "given", "type", "parameters", "printed"), without_place(tuple)
)
NODE_ROWS: Final = {
    **LIST_ROWS,
    "later_arguments": without_place(lambda children: (None, *children)),
    # expressions
    "number": without_place(lambda children: number_of(*filter(None, children))),
    "string": row(s.String, value=_unquoted),
    "variable": row(s.Variable, "name suffix? arguments"),
    "empty_call": row(s.Variable, "name suffix? _", arguments=()),
    "component": row(s.Variable, "name arguments component", component=str.upper),
    "binary": row(s.Binary, "left operator right", operator=str.upper),
    "power": row(s.Binary, "left right", operator="^"),
    "unary": row(s.Unary, operator=str.upper),
    "pallet": row(s.Pallet),
    "word": row(s.Word, text=str.capitalize),
    "channel": row(s.Channel),
    "opening": row(s.Opening),
    # statements
    "command": row(s.Command, "keyword arguments?", keyword=keyword_spelling),
    "word_alone": row(s.Command, "keyword", keyword=keyword_spelling),
    "end_select": row(s.Command, "_", keyword="End Select"),
    "exit_function": row(s.Command, "", keyword="Exit Function"),
    "motion": row(s.Motion, "keyword arguments? type append", keyword=keyword_spelling),
    "append": row(s.Append),
    "append_if": row(s.Append, "condition statement"),
    "assign": row(s.Assign, "target value _ delay"),
    "label": row(s.Target, place=label_of),
    "step": row(s.Target, place=int),
    "data": row(s.Data, "type? variable value", type=keyword_spelling),
    "if": row(s.If, "condition then _ otherwise"),
    "if_jump": row(s.If, "condition _ then _ otherwise"),
    "elseif": row(s.ElseIf),
    "for": row(s.For),
    "next": row(s.Next, "*variables"),
    "select": row(s.Select),
    "case_range": row(s.CaseRange),
    "case_is": row(s.CaseIs),
    "case": row(s.Case, "*items"),
    "jump": row(s.Jump, keyword=keyword_spelling),
    "on_jump": row(s.OnJump, "_ subject keyword *targets", keyword=keyword_spelling),
    "on_com": row(s.OnCom, "_ line _ target"),
    "com": row(s.Com, state=str.capitalize),
    "callp": row(s.CallP, "program *arguments"),
    "fprm": row(s.FPrm, "*variables"),
    "def_names": row(s.DefNames, "type *variables", type=keyword_spelling),
    "def_io": row(s.DefIo, type=str.capitalize),
    "def_fn": row(s.DefFunction, "name suffix? *parameters value"),
    "def_other": row(s.DefOther, kind=keyword_spelling),
    "def_act": row(
        s.DefAct,
        "_ number condition keyword target stop?",
        keyword=keyword_spelling,
        stop=str.upper,
    ),
    "dim": row(s.Dim, "*variables"),
    "const": row(s.Const, "type? variable value", type=keyword_spelling),
    "static": row(s.Static),
    "include": row(s.Include, program=_unquoted),
    "result": without_place(lambda children: "".join(filter(None, children))),
    "function": row(s.Function, "result? name suffix? parameters"),
    "parameter": row(s.FunctionParameter, "mode? name suffix? array?", mode=keyword_spelling),
    "open": row(s.Open, "name mode? number", mode=str.capitalize),
    "close": row(s.Close, "*numbers"),
    "print": row(s.Print, "number *items"),
    "input": row(s.Input, "number *variables"),
    # lines
    "line": row(s.Line, "label statement comment", label=label_of, comment=str.rstrip),
}
"""Rules whose children are the fields of a node."""


class Nodes(nodes.Nodes, rows=NODE_ROWS):
    """And the others."""

    def signed(self, _: Place, children: Children) -> s.Number | s.Unary:
        sign, text, suffix = children
        number = number_of(text, suffix or "")
        return number if sign is None else s.Unary(sign, number)

    def position(self, place: Place, children: Children) -> s.Constant:
        return constant_of(children[0], self.span(place))

    def call(self, place: Place, children: Children) -> s.Call:
        name, suffix, arguments = children
        return s.Call(s.Variable(name, suffix or "", arguments or (), span=self.span(place)))
