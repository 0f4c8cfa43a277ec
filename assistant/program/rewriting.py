"""Rewriting: the same program with some of its parts exchanged; and what the parts are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, Final, TypeVar

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Span
from assistant.program.path import Path
from assistant.program.program import bodies

T = TypeVar("T")
Body = tuple[p.Statement, ...]


def rewrite(value: T, visit: Callable[[Any], Any], whole: tuple[type, ...] = (Path,)) -> T:
    """The value with every record in it replaced by what `visit` makes of it, inner ones first.

    Goes through records, tuples and tables. A record that `visit` gives back as it is stays the
    same object, so that an untouched program costs nothing.

    whole: kinds of records that are not entered.
    """
    return _rewritten(value, visit, whole)  # type: ignore[no-any-return]


def map_bodies(statement: Any, body: Callable[[Body], Body]) -> Any:
    """The statement with each body that it holds replaced by what `body` makes of it."""
    match statement:
        case p.If(branches, otherwise):
            changed = tuple(replace(b, body=body(b.body)) for b in branches)
            return replace(statement, branches=changed, otherwise=body(otherwise))
        case p.While() | p.For():
            return replace(statement, body=body(statement.body))
        case p.Switch(_, cases, otherwise):
            selected = tuple(replace(c, body=body(c.body)) for c in cases)
            return replace(statement, cases=selected, otherwise=body(otherwise))
    return statement


def map_spans(body: Body, change: Callable[[Span], Span | None]) -> Body:
    """The body with the place in a source text of each statement changed, inner ones too."""
    return tuple(
        replace(
            map_bodies(node, lambda inner: map_spans(inner, change)),
            span=None if node.span is None else change(node.span),
        )
        for node in body
    )


def map_expressions(node: T, change: Callable[[e.Expression], e.Expression]) -> T:
    """A statement or expression with `change` made of every expression in it, inner ones first.

    The names of a motion are no expressions: they are looked up among speeds, blends, tools.
    """
    return rewrite(node, lambda x: change(x) if isinstance(x, e.Expression) else x, _WHOLE)


def map_head(statement: Any, change: Callable[[e.Expression], e.Expression]) -> Any:
    """The statement with its own expressions changed; the bodies that it holds stay as they are."""
    held = iter(bodies(statement))
    return map_bodies(map_expressions(head(statement), change), lambda _: next(held))


def head(statement: Any) -> Any:
    """The statement with nothing in the bodies that it holds."""
    return map_bodies(statement, lambda _: ())


def records(value: Any) -> Iterator[Any]:
    """Every record in a value, itself included, in no order; those of a `Path` are no such."""
    pending = [value]
    while pending:
        item = pending.pop()
        if isinstance(item, tuple):
            pending += item
        elif isinstance(item, Mapping):
            pending += item.values()
        elif is_dataclass(item) and not isinstance(item, Path):
            yield item
            pending += [getattr(item, part.name) for part in fields(item)]


_WHOLE: Final = (Path, p.Motion, e.TargetValue, e.JointValue, e.PoseValue)
_LEAVES: Final = (float, int, str, type(None))


def _rewritten(value: Any, visit: Callable[[Any], Any], whole: tuple[type, ...]) -> Any:
    if isinstance(value, _LEAVES):
        return value
    if isinstance(value, tuple):
        items = [_rewritten(item, visit, whole) for item in value]
        return value if all(a is b for a, b in zip(items, value, strict=True)) else tuple(items)
    if isinstance(value, Mapping):
        table = {key: _rewritten(item, visit, whole) for key, item in value.items()}
        return value if all(table[key] is value[key] for key in table) else table
    if not is_dataclass(value) or isinstance(value, type):
        return value
    if isinstance(value, whole):
        return visit(value)
    changed = {}
    for part in fields(value):
        if not part.compare:  # where it came from, not what it says
            continue
        before = getattr(value, part.name)
        after = _rewritten(before, visit, whole)
        if after is not before:
            changed[part.name] = after
    return visit(replace(value, **changed) if changed else value)
