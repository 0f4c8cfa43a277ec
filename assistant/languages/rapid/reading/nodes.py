"""The nodes of the typed tree: one method a construct of the grammar."""

# ruff: noqa: ARG002 (every method takes the place and the children of its rule)

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.reading.rows import RunNode, Runs
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import gathered
from assistant.program.diagnostics import Span

_PARTS: Final = re.compile(r"[\[\]]|([-+]?)([0-9.]+(?:[eE][-+]?[0-9]+)?)")
_ESCAPE: Final = re.compile(r'""|\\\\|\\([0-9a-fA-F]{2})')


def unescaped(literal: str) -> str:
    """What a string literal, quotes included, says."""
    return _ESCAPE.sub(lambda m: chr(int(m[1], 16)) if m[1] else m[0][0], literal[1:-1])


Place = Span | None
"""Offsets in what the grammar read; None for what stands for no text."""


class Nodes:
    """text: what the grammar read. offset: from an offset in it to one in the source."""

    def __init__(self, text: str, offset: Callable[[int], int], runs: Runs) -> None:
        self._text, self._offset, self._runs = text, offset, runs

    def _span(self, place: Place) -> Place:
        if place is None or not self._runs:
            return place
        return Span(self._offset(place.start), self._offset(place.end))

    # Files and modules

    def start(self, place: Place, c: list[Any]) -> Any:
        header = None if c[0] is None else str(c[0])[3:-3]
        return header, tuple(c[1:])

    def statements(self, place: Place, c: list[Any]) -> Any:
        return gathered(c)

    items = block = statements

    def module(self, place: Place, c: list[Any]) -> s.Module:
        attributes = tuple(a for a in c[1:] if isinstance(a, str))
        items = gathered([i for i in c[1:] if i is not None and not isinstance(i, str)])
        return s.Module(str(c[0]), attributes, items, span=self._span(place))

    def attribute(self, place: Place, c: list[Any]) -> str:
        return str(c[0]).upper()

    def note(self, place: Span, c: list[Any]) -> s.CommentLine:
        at = place.start
        line = self._text[self._text.rfind("\n", 0, at) + 1 : at]
        return s.CommentLine(c[0][1:].strip(), bool(line.strip()), span=self._span(place))

    def placeholder(self, place: Place, c: list[Any]) -> s.Placeholder:
        return s.Placeholder(str(c[0]).upper(), span=self._span(place))

    hole = placeholder

    def targets(self, place: Place, c: list[Any]) -> RunNode:
        found = self._runs[int(c[0][1:-1])]
        return replace(found.node, span=Span(found.start, found.end))

    moves = targets

    # Declarations

    def record(self, place: Place, c: list[Any]) -> s.Record:
        return s.Record(c[0] is not None, str(c[1]), tuple(c[2:]), span=self._span(place))

    def component(self, place: Place, c: list[Any]) -> tuple[str, str]:
        return str(c[0]), str(c[1])

    def alias(self, place: Place, c: list[Any]) -> s.Alias:
        return s.Alias(c[0] is not None, str(c[1]), str(c[2]), span=self._span(place))

    def data(self, place: Place, c: list[Any]) -> s.Data:
        scope, storage, type, name, dimensions, value = c
        return s.Data(
            str(scope or "").upper(),
            str(storage).upper(),
            str(type),
            str(name),
            dimensions or (),
            value,
            span=self._span(place),
        )

    def dimensions(self, place: Place, c: list[Any]) -> Any:
        return tuple(c)

    def procedure(self, place: Place, c: list[Any]) -> s.Routine:
        local, name, parameters, body, *handlers = c
        return s.Routine(
            "PROC",
            local is not None,
            str(name),
            body,
            "",
            parameters or (),
            tuple(handlers),
            span=self._span(place),
        )

    def function(self, place: Place, c: list[Any]) -> s.Routine:
        local, type, name, parameters, body, *handlers = c
        return s.Routine(
            "FUNC",
            local is not None,
            str(name),
            body,
            str(type),
            parameters or (),
            tuple(handlers),
            span=self._span(place),
        )

    def trap(self, place: Place, c: list[Any]) -> s.Routine:
        local, name, body, *handlers = c
        return s.Routine(
            "TRAP",
            local is not None,
            str(name),
            body,
            handlers=tuple(handlers),
            span=self._span(place),
        )

    parameters = dimensions

    def required(self, place: Place, c: list[Any]) -> s.ParameterGroup:
        return s.ParameterGroup(False, (self._parameter(c[0]),), span=self._span(place))

    def optional(self, place: Place, c: list[Any]) -> s.ParameterGroup:
        return s.ParameterGroup(True, tuple(map(self._parameter, c)), span=self._span(place))

    def _parameter(self, child: Any) -> Any:
        return s.Placeholder(str(child).upper()) if isinstance(child, str) else child

    def parameter(self, place: Place, c: list[Any]) -> s.ParameterNode:
        mode, type, name, array = c
        return s.ParameterNode(
            str(mode or "").upper(), str(type), str(name), array or 0, span=self._span(place)
        )

    def open_array(self, place: Place, c: list[Any]) -> int:
        return len(c) if c[0] == "*" else -1

    def backward(self, place: Place, c: list[Any]) -> s.Handler:
        return s.Handler("BACKWARD", c[0], span=self._span(place))

    def error(self, place: Place, c: list[Any]) -> s.Handler:
        numbers = tuple(n for n in c[:-1] if n is not None)
        return s.Handler("ERROR", c[-1], numbers, span=self._span(place))

    def undo(self, place: Place, c: list[Any]) -> s.Handler:
        return s.Handler("UNDO", c[0], span=self._span(place))

    # Statements

    def assign(self, place: Place, c: list[Any]) -> s.Assignment:
        return s.Assignment(c[0], c[1], span=self._span(place))

    def call(self, place: Place, c: list[Any]) -> s.ProcedureCall:
        return s.ProcedureCall(str(c[0]), c[1] or (), span=self._span(place))

    def late_call(self, place: Place, c: list[Any]) -> s.ProcedureCall:
        return s.ProcedureCall(c[0], c[1] or (), span=self._span(place))

    def goto(self, place: Place, c: list[Any]) -> s.GotoLabel:
        return s.GotoLabel(str(c[0]), span=self._span(place))

    def label(self, place: Place, c: list[Any]) -> s.LabelMark:
        return s.LabelMark(str(c[0]), span=self._span(place))

    def return_(self, place: Place, c: list[Any]) -> s.ReturnFrom:
        return s.ReturnFrom(c[0], span=self._span(place))

    def raise_(self, place: Place, c: list[Any]) -> s.RaiseError:
        return s.RaiseError(c[0], span=self._span(place))

    def exit(self, place: Place, c: list[Any]) -> s.Word:
        return s.Word("EXIT", span=self._span(place))

    def retry(self, place: Place, c: list[Any]) -> s.Word:
        return s.Word("RETRY", span=self._span(place))

    def try_next(self, place: Place, c: list[Any]) -> s.Word:
        return s.Word("TRYNEXT", span=self._span(place))

    def connect(self, place: Place, c: list[Any]) -> s.Connect:
        return s.Connect(c[0], str(c[1]), span=self._span(place))

    def compound_if(self, place: Place, c: list[Any]) -> s.IfThen:
        condition, body, *rest, otherwise = c
        first = s.IfBranch(condition, body)
        return s.IfThen((first, *rest), otherwise, span=self._span(place))

    def elseif(self, place: Place, c: list[Any]) -> s.IfBranch:
        return s.IfBranch(c[0], c[1], span=self._span(place))

    def else_hole(self, place: Place, c: list[Any]) -> s.IfBranch:
        return s.IfBranch(None, (), span=self._span(place))

    def compact_if(self, place: Place, c: list[Any]) -> s.CompactIf:
        return s.CompactIf(c[0], c[1], span=self._span(place))

    def for_(self, place: Place, c: list[Any]) -> s.ForLoop:
        name, first, last, step, body = c
        return s.ForLoop(str(name), first, last, step, body, span=self._span(place))

    def while_(self, place: Place, c: list[Any]) -> s.WhileLoop:
        return s.WhileLoop(c[0], c[1], span=self._span(place))

    def test(self, place: Place, c: list[Any]) -> s.TestOf:
        subject, *cases, otherwise = c
        return s.TestOf(subject, tuple(cases), otherwise, span=self._span(place))

    def case(self, place: Place, c: list[Any]) -> s.TestCase:
        return s.TestCase(tuple(c[:-1]), c[-1], span=self._span(place))

    def case_hole(self, place: Place, c: list[Any]) -> s.TestCase:
        return s.TestCase((), (), span=self._span(place))

    # Arguments

    arguments = dimensions

    def positional(self, place: Place, c: list[Any]) -> s.Positional:
        if len(c) == 1:
            return s.Positional(s.Placeholder("<ARG>"), span=self._span(place))
        name, value = c
        return s.Positional(value, None if name is None else str(name), span=self._span(place))

    def option(self, place: Place, c: list[Any]) -> s.Option:
        return s.Option(str(c[0]), c[1], span=self._span(place))

    def conditional(self, place: Place, c: list[Any]) -> s.Conditional:
        return s.Conditional(str(c[0]), c[1], span=self._span(place))

    # Expressions

    def _infix(self, place: Place, c: list[Any]) -> Any:
        value = c[0]
        for operator, right in zip(c[1::2], c[2::2], strict=True):
            value = s.Infix(str(operator).upper(), value, right, span=self._span(place))
        return value

    disjunction = conjunction = relation = sum = term = _infix

    def negation(self, place: Place, c: list[Any]) -> s.Prefix:
        return s.Prefix("NOT", c[0], span=self._span(place))

    def signed(self, place: Place, c: list[Any]) -> s.Prefix:
        return s.Prefix("-" if c[0] == "-" else "+", c[1], span=self._span(place))

    def number(self, place: Place, c: list[Any]) -> s.NumberLiteral:
        return s.NumberLiteral(str(c[0]), span=self._span(place))

    def string(self, place: Place, c: list[Any]) -> s.StringLiteral:
        return s.StringLiteral(unescaped(c[0]), span=self._span(place))

    def true(self, place: Place, c: list[Any]) -> s.BoolLiteral:
        return s.BoolLiteral(True, span=self._span(place))

    def false(self, place: Place, c: list[Any]) -> s.BoolLiteral:
        return s.BoolLiteral(False, span=self._span(place))

    def aggregate(self, place: Place, c: list[Any]) -> s.AggregateNode:
        return s.AggregateNode(tuple(c), span=self._span(place))

    def table(self, place: Span, c: list[Any]) -> s.AggregateNode:
        """Numbers in brackets as `aggregate` gives them."""
        stack: list[list[Any]] = [[]]
        begins: list[int] = []
        for part in _PARTS.finditer(c[0]):
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

    def group(self, place: Place, c: list[Any]) -> s.Group:
        return s.Group(c[0], span=self._span(place))

    def function_call(self, place: Place, c: list[Any]) -> s.FunctionCall:
        return s.FunctionCall(str(c[0]), c[1] or (), span=self._span(place))

    def reference(self, place: Place, c: list[Any]) -> Any:
        span = self._span(place)
        value: s.Variable = s.NameRef(str(c[0]), span=span)
        for part in c[1:]:
            if isinstance(part, str):
                value = s.Component(value, part, span=span)
            else:
                value = s.Element(value, part, span=span)
        return value

    def member(self, place: Place, c: list[Any]) -> str:
        return str(c[0])

    def element(self, place: Place, c: list[Any]) -> Any:
        return tuple(c)

    def whole(self, place: Place, c: list[Any]) -> s.Whole:
        return s.Whole(span=self._span(place))


# Rules whose names are words of Python.
for _word in ("for", "while", "raise", "return"):
    setattr(Nodes, _word, getattr(Nodes, _word + "_"))
