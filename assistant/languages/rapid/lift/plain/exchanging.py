"""Statements of RAPID that stand for others, wherever they stand."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, TypeVar

from assistant.languages.rapid.tree import syntax as s
from assistant.program.rewriting import rewrite

T = TypeVar("T")
Body = tuple[s.StatementNode, ...]
StatementRewriting = Callable[[s.StatementNode], Iterable[s.StatementNode]]


def rewritten(value: T, said: StatementRewriting) -> T:
    """A module or routine with what `said` makes of each statement; itself if that is the same."""

    def body(statements: Body) -> Body:
        made = tuple(one for node in statements for one in said(node))
        same = len(made) == len(statements)
        same = same and all(a is b for a, b in zip(made, statements, strict=True))
        return statements if same else made

    def change(node: Any) -> Any:
        match node:
            case s.IfThen(branches, otherwise):
                parts = tuple(_with_body(one, body(one.body)) for one in branches)
                other = None if otherwise is None else body(otherwise)
                same = other is otherwise and all(map(_is_same, parts, branches))
                return node if same else replace(node, branches=parts, otherwise=other)
            case s.TestOf(_, cases, otherwise):
                chosen = tuple(_with_body(one, body(one.body)) for one in cases)
                other = None if otherwise is None else body(otherwise)
                same = other is otherwise and all(map(_is_same, chosen, cases))
                return node if same else replace(node, cases=chosen, otherwise=other)
            case s.CompactIf(condition, statement):
                made = body((statement,))
                if len(made) == 1:
                    return node if made[0] is statement else replace(node, statement=made[0])
                return s.IfThen((s.IfBranch(condition, made),), span=node.span)
            case s.ForLoop() | s.WhileLoop() | s.Handler() | s.Routine():
                return _with_body(node, body(node.body))
        return node

    return rewrite(value, change, ())


def _with_body(node: Any, body: Body) -> Any:
    return node if body is node.body else replace(node, body=body)


def _is_same(one: Any, other: Any) -> bool:
    return one is other
