"""The nodes of the typed tree: a row or a method for each rule of the grammar."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from operator import itemgetter
from typing import Any, Final

from assistant.base.diagnostics import Span
from assistant.languages import nodes
from assistant.languages.grammar import number_of
from assistant.languages.nodes import Children, Place, row, without_place
from assistant.languages.rapid.reading.rows import RunNode, Runs
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import gathered

_TABLE_PART: Final = re.compile(r"[\[\]]|([-+]?)([0-9.]+(?:[eE][-+]?[0-9]+)?)")
_ESCAPE: Final = re.compile(r'""|\\\\|\\([0-9a-fA-F]{2})')


def unescaped(literal: str) -> str:
    """What a string literal, quotes included, says."""
    return _ESCAPE.sub(lambda m: chr(int(m[1], 16)) if m[1] else m[0][0], literal[1:-1])


def _module_attribute(children: Children) -> str:
    return str(children[0]).upper()


def _open_dimensions(children: Children) -> int:
    """Of an array that a routine is given, -1 for the hole that the pendant leaves."""
    return len(children) if children[0] == "*" else -1


NODE_ROWS: Final = {
    **dict.fromkeys(("statements", "items", "block"), without_place(gathered)),
    **dict.fromkeys(("attributes", "component", "dimensions", "element"), without_place(tuple)),
    **dict.fromkeys(("parameters", "arguments"), without_place(tuple)),
    **dict.fromkeys(("placeholder", "hole"), row(s.Placeholder, text=str.upper)),
    "module": row(s.Module, "name attributes? items"),
    "attribute": without_place(_module_attribute),
    # declarations
    "record": row(s.Record, "local? name *components"),
    "alias": row(s.Alias, "local? type name"),
    "data": row(
        s.Data, "scope? storage type name dimensions? value", scope=str.upper, storage=str.upper
    ),
    "procedure": row(s.Routine, "local? name parameters? body *handlers", kind="PROC"),
    "function": row(s.Routine, "local? type name parameters? body *handlers", kind="FUNC"),
    "trap": row(s.Routine, "local? name body *handlers", kind="TRAP"),
    "required": row(s.ParameterGroup, "*alternatives", optional=False),
    "optional": row(s.ParameterGroup, "*alternatives", optional=True),
    "parameter": row(s.ParameterNode, "mode? type name dimensions?", mode=str.upper),
    "open_array": without_place(_open_dimensions),
    "backward": row(s.Handler, "body", kind="BACKWARD"),
    "error": row(s.Handler, "*numbers body", kind="ERROR"),
    "undo": row(s.Handler, "body", kind="UNDO"),
    # statements
    "assign": row(s.Assignment),
    "call": row(s.ProcedureCall),
    "late_call": row(s.ProcedureCall),
    "goto": row(s.GotoLabel),
    "label": row(s.LabelMark),
    "return": row(s.ReturnFrom),
    "raise": row(s.RaiseError),
    "exit": row(s.Word, "", word="EXIT"),
    "retry": row(s.Word, "", word="RETRY"),
    "try_next": row(s.Word, "", word="TRYNEXT"),
    "connect": row(s.Connect),
    "elseif": row(s.IfBranch),
    "else_hole": row(s.IfBranch, "_", condition=None, body=()),
    "compact_if": row(s.CompactIf),
    "for": row(s.ForLoop),
    "while": row(s.WhileLoop),
    "test": row(s.TestOf, "subject *cases otherwise"),
    "case": row(s.TestCase, "*values body"),
    "case_hole": row(s.TestCase, "_", values=(), body=()),
    # arguments
    "positional": row(s.Positional, "value"),
    "named_argument": row(s.Positional, "name value"),
    "argument_hole": row(s.Positional, "_", value=s.Placeholder("<ARG>")),
    "option": row(s.Option),
    "conditional": row(s.Conditional),
    # expressions
    "negation": row(s.Prefix, "operand", operator="NOT"),
    "signed": row(s.Prefix),
    "number": row(s.NumberLiteral),
    "string": row(s.StringLiteral, value=unescaped),
    "true": row(s.BoolLiteral, "_", value=True),
    "false": row(s.BoolLiteral, "_", value=False),
    "aggregate": row(s.AggregateNode, "*items"),
    "group": row(s.Group),
    "function_call": row(s.FunctionCall),
    "member": without_place(itemgetter(0)),
    "whole": row(s.Whole, "_"),
}
"""Rules whose children are the fields of a node."""


class Nodes(nodes.Nodes, rows=NODE_ROWS):
    """And the others.

    text: what the grammar read. offset: from an offset in it to one in the source, None for the
    same.
    """

    def __init__(self, text: str, offset: Callable[[int], int] | None, runs: Runs) -> None:
        super().__init__(offset)
        self._text, self._runs = text, runs
        self._offset: Callable[[int], int] = offset or (lambda at: at)

    def start(self, _: Place, c: Children) -> tuple[str | None, tuple[Any, ...]]:
        header, *parts = c
        return None if header is None else header[3:-3], tuple(parts)

    def note(self, place: Span, c: Children) -> s.CommentLine:
        at = place.start
        line = self._text[self._text.rfind("\n", 0, at) + 1 : at]
        return s.CommentLine(c[0][1:].strip(), bool(line.strip()), span=self.span(place))

    def targets(self, _: Place, c: Children) -> RunNode:
        found = self._runs[number_of(c[0])]
        return replace(found.node, span=Span(found.start, found.end))

    moves = targets

    def compound_if(self, place: Place, c: Children) -> s.IfThen:
        condition, body, *rest, otherwise = c
        first = s.IfBranch(condition, body)
        return s.IfThen((first, *rest), otherwise, span=self.span(place))

    def _infix(self, place: Place, c: Children) -> Any:
        value = c[0]
        for operator, right in zip(c[1::2], c[2::2], strict=True):
            value = s.Infix(operator.upper(), value, right, span=self.span(place))
        return value

    disjunction = conjunction = relation = sum = term = _infix

    def reference(self, place: Place, c: Children) -> Any:
        span = self.span(place)
        value: s.Variable = s.NameRef(c[0], span=span)
        for part in c[1:]:
            if isinstance(part, str):
                value = s.Component(value, part, span=span)
            else:
                value = s.Element(value, part, span=span)
        return value

    def table(self, place: Span, c: Children) -> s.AggregateNode:
        """Numbers in brackets as `aggregate` gives them."""
        stack: list[list[Any]] = [[]]
        begins: list[int] = []
        for part in _TABLE_PART.finditer(c[0]):
            start, end = place.start + part.start(), place.start + part.end()
            if part[0] == "[":
                begins.append(start)
                stack.append([])
            elif part[0] == "]":
                span = Span(self._offset(begins.pop()), self._offset(end))
                items = tuple(stack.pop())
                stack[-1].append(s.AggregateNode(items, span=span))
            else:
                last = self._offset(end)
                value: Any = s.NumberLiteral(part[2], span=Span(last - len(part[2]), last))
                if part[1]:
                    span = Span(self._offset(start), last)
                    value = s.Prefix("-" if part[1] == "-" else "+", value, span=span)
                stack[-1].append(value)
        (node,) = stack[0]
        assert isinstance(node, s.AggregateNode)
        return node


class SingleNodes(
    Nodes, rows=dict.fromkeys(("statements", "items", "block"), without_place(tuple))
):
    """Every line as a node of its own, however many are alike."""
