"""Rewriting of the typed tree: statements in any block, and parameters in a routine.

`rewritten` replaces statements wherever they are. The rest puts arguments in the place of
parameters, removes branches that are never taken, and renames routines.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from assistant.languages.rapid.text.printer import expression as printed
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.syntax import MotionNames
from assistant.program.rewriting import rewrite

T = TypeVar("T")
_Body = tuple[s.StatementNode, ...]
StatementRewriting = Callable[[s.StatementNode], Iterable[s.StatementNode]]


def rewritten(value: T, said: StatementRewriting) -> T:
    """A module or routine with what `said` makes of each statement; itself if that is the same."""

    def body(statements: _Body) -> _Body:
        made = tuple(one for node in statements for one in said(node))
        # Identity tells callers that nothing changed, so an equal tuple is not made anew.
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


def _with_body(node: Any, body: _Body) -> Any:
    return node if body is node.body else replace(node, body=body)


def _is_same(one: Any, other: Any) -> bool:
    return one is other


def with_presence(node: Any, values: Mapping[str, s.Expression | None]) -> Any:
    """A node in which it is known which optional parameters are there; lower-case names."""
    match node:
        case s.FunctionCall(word, (s.Positional(s.NameRef(name), None),)):
            if word.lower() == "present" and name.lower() in values:
                return s.BoolLiteral(values[name.lower()] is not None)
        # NOT of a known presence is known too, which lets its branch be removed.
        case s.Prefix("NOT", s.BoolLiteral(value)) | s.Prefix("NOT", s.Group(s.BoolLiteral(value))):
            return s.BoolLiteral(not value)
        case s.ProcedureCall(arguments=arguments) | s.FunctionCall(arguments=arguments):
            given = tuple(g for a in arguments if (g := _known_argument(a, values)) is not None)
            return node if given == arguments else replace(node, arguments=given)
    return node


def _known_argument(
    argument: s.Argument, values: Mapping[str, s.Expression | None]
) -> s.Argument | None:
    """An argument that hands a parameter on, as what that is; None if it is not there."""
    match argument:
        case s.Conditional(option, s.NameRef(name)) if name.lower() in values:
            there = values[name.lower()] is not None
            return s.Option(option, s.NameRef(name)) if there else None
    return argument


def without_dead_branches(body: Sequence[s.StatementNode]) -> tuple[s.StatementNode, ...]:
    """Statements without branches that are never taken."""
    return tuple(one for node in body for one in _live_statements(node))


def _live_statements(node: s.StatementNode) -> Iterator[s.StatementNode]:
    match node:
        case s.CompactIf(s.BoolLiteral(value), inner):
            yield from _live_statements(inner) if value else ()
        case s.IfThen(branches, otherwise):
            left: list[s.IfBranch] = []
            other = None if otherwise is None else without_dead_branches(otherwise)
            for branch in branches:
                match branch.condition:
                    case s.BoolLiteral(False):
                        continue
                    # A branch that is always taken is the last one.
                    case s.BoolLiteral(True):
                        other = without_dead_branches(branch.body)
                        break
                left.append(replace(branch, body=without_dead_branches(branch.body)))
            if left:
                yield replace(node, branches=tuple(left), otherwise=other)
            else:
                yield from other or ()
        case s.WhileLoop(body=body) | s.ForLoop(body=body):
            yield replace(node, body=without_dead_branches(body))
        case s.TestOf(cases=cases, otherwise=otherwise):
            chosen = tuple(replace(case, body=without_dead_branches(case.body)) for case in cases)
            other = None if otherwise is None else without_dead_branches(otherwise)
            yield replace(node, cases=chosen, otherwise=other)
        case _:
            yield node


def substituted(node: Any, named: Mapping[str, s.Expression | None]) -> Any:
    """A node with what stands for parameters in their place; lower-case names."""
    match node:
        case s.NameRef(name) if (value := named.get(name.lower())) is not None:
            return replace(value, span=node.span)
        case MotionNames(speed, zone, tool, frame):
            return MotionNames(
                *(_substituted_name(one, named) for one in (speed, zone, tool, frame))
            )
    return node


def _substituted_name(name: str, named: Mapping[str, s.Expression | None]) -> str:
    value = named.get(name.lower())
    return value.name if isinstance(value, s.NameRef) else name


def with_first_statements(
    first: Sequence[s.StatementNode], body: tuple[s.StatementNode, ...]
) -> tuple[s.StatementNode, ...]:
    """A body with statements behind its declarations."""
    if not first:
        return body
    # Declarations have to come first in a routine.
    at = next(
        (k for k, n in enumerate(body) if not isinstance(n, s.Data | s.CommentLine)), len(body)
    )
    return (*body[:at], *first, *body[at:])


def with_routine_names(item: s.Item, names: Mapping[str, str]) -> s.Item:
    """An item with other names of routines, by lower-case name."""

    def visit(node: Any) -> Any:
        match node:
            case s.Routine(name=name) | s.ProcedureCall(str(name)) | s.FunctionCall(name):
                if name.lower() in names:
                    return replace(node, name=names[name.lower()])
        return node

    made: s.Item = rewrite(item, visit, ())
    return made


def argument_key(value: s.Expression) -> str:
    """Return a key that distinguishes the calls of a routine, and the name of one copy from
    others.
    """
    return value.name.lower() if isinstance(value, s.NameRef) else printed(value)


def is_literal(node: s.Expression) -> bool:
    if isinstance(node, s.AggregateNode):
        return all(map(is_literal, node.items))
    return isinstance(node, s.BoolLiteral | s.StringLiteral) or literal_number(node) is not None


def is_table_row(value: s.Expression) -> bool:
    """True if a value is a table row with a literal index."""
    if not isinstance(value, s.Element) or not isinstance(value.value, s.NameRef):
        return False
    numbers = (None if isinstance(i, s.Whole) else literal_number(i) for i in value.indices)
    return all(isinstance(number, int) for number in numbers)
