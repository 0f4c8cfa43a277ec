"""Rewriting: the same program with some of its parts replaced; and the records that are its parts.

Programs are traversed many times, so the fields of a kind of record that may hold other records are
computed once.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from operator import attrgetter
from types import EllipsisType, NoneType
from typing import Any, Final, Literal, TypeVar, get_args, get_origin, get_type_hints

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Path
from assistant.program.program import Procedure, Program, bodies, walk


@dataclass(frozen=True, slots=True)
class RecordFields:
    """Fields of a kind of record that may hold other records.

    names: of its fields in their order, without those excluded from comparison and those whose
    types exclude records. of: their values.
    """

    names: tuple[str, ...]
    of: Callable[[Any], tuple[Any, ...]]


def record_fields(kind: type) -> RecordFields | None:
    """Parts of a kind of record, None for what is no record."""
    if kind not in _FIELDS_BY_KIND:
        _FIELDS_BY_KIND[kind] = _read_record_fields(kind) if is_dataclass(kind) else None
    return _FIELDS_BY_KIND[kind]


_FIELDS_BY_KIND: Final[dict[type, RecordFields | None]] = {}
_PLAIN_TYPES: Final = (str, int, float, bool, bytes, NoneType, EllipsisType, ...)


def _read_record_fields(kind: Any) -> RecordFields:
    said = tuple(f.name for f in fields(kind) if f.compare)
    try:
        hints = get_type_hints(kind)
    except NameError:  # of a type that only type checkers import
        hints = {}
    names = tuple(name for name in said if not _holds_no_record(hints.get(name, Any)))
    if not names:
        return RecordFields((), lambda _: ())
    # `attrgetter` of one name returns the value itself, not a tuple.
    several = attrgetter(*names)
    return RecordFields(names, several if len(names) > 1 else lambda record: (several(record),))


def _holds_no_record(hint: Any) -> bool:
    """True if a value of the type surely is not a record, and holds no record."""
    if get_origin(hint) is Literal or hint in _PLAIN_TYPES:
        return True
    return bool(get_args(hint)) and all(map(_holds_no_record, get_args(hint)))


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


def with_vendor_statements_replaced(
    program: Program, made: Callable[[p.Opaque], Iterable[p.Statement]]
) -> Program:
    """The program with what is made of each statement that is kept as its text."""

    def body(statements: Body) -> Body:
        return tuple(
            part
            for node in statements
            for part in (made(node) if isinstance(node, p.Opaque) else (map_bodies(node, body),))
        )

    def each(procedure: Procedure) -> Procedure:
        kept = any(isinstance(node, p.Opaque) for node in walk(procedure.body))
        return replace(procedure, body=body(procedure.body)) if kept else procedure

    return replace(program, procedures=tuple(map(each, program.procedures)))


def map_spans(body: Body, change: Callable[[Span], Span | None]) -> Body:
    """The body with the place in a source text of each statement changed, inner ones too."""
    return tuple(
        replace(
            map_bodies(node, lambda inner: map_spans(inner, change)),
            span=None if node.span is None else change(node.span),
        )
        for node in body
    )


def with_spans_from(procedure: Procedure, start: int) -> Procedure:
    """A procedure with its spans counted on, its text beginning at `start`, see `starts_of`."""
    if not start:
        return procedure
    body = map_spans(procedure.body, lambda span: span.moved(start))
    return replace(procedure, body=body, span=procedure.span and procedure.span.moved(start))


def with_names_replaced(procedure: Procedure, names: Mapping[str, str]) -> Procedure:
    """A procedure with other names for some, its own and in calls. names: by lower-case name."""

    def named(part: Any) -> Any:
        match part:
            case p.Call(name) if name.lower() in names:
                return replace(part, procedure=names[name.lower()])
            case e.Apply(name) if name.lower() in names:
                return replace(part, function=names[name.lower()])
        return part

    if not names:
        return procedure
    name = names.get(procedure.name.lower(), procedure.name)
    return replace(procedure, name=name, body=rewrite(procedure.body, named))


def map_expressions(node: T, change: Callable[[e.Expression], e.Expression]) -> T:
    """A statement or expression with `change` made of every expression in it, inner ones first.

    The names of a motion are no expressions: they are looked up among speeds, blends, tools.
    """

    def changed(part: Any) -> Any:
        if isinstance(part, p.Motion):
            speed, blend = part.speed, part.blend
            if isinstance(speed, p.ComputedSpeed):
                part = replace(part, speed=rewrite(speed, changed, _WHOLE))
            if isinstance(blend, p.ComputedBlend):
                part = replace(part, blend=rewrite(blend, changed, _WHOLE))
            return part
        return change(part) if isinstance(part, e.Expression) else part

    return rewrite(node, changed, _WHOLE)


def map_head(statement: Any, change: Callable[[e.Expression], e.Expression]) -> Any:
    """The statement with its own expressions changed; the bodies that it holds stay as they are."""
    # The bodies are taken out first, so that their expressions stay.
    held = iter(bodies(statement))
    return map_bodies(map_expressions(head(statement), change), lambda _: next(held))


def head(statement: Any) -> Any:
    """The statement with nothing in the bodies that it holds."""
    return map_bodies(statement, lambda _: ())


def records(value: Any) -> Iterator[Any]:
    """Every record that a value says, itself included, in no order; a `Path` has none."""
    pending = [value]
    while pending:
        item = pending.pop()
        kind = type(item)
        if kind is tuple:
            pending += item
            continue
        parts = record_fields(kind)
        if parts is not None:
            if kind is not Path:
                yield item
                pending += parts.of(item)
        elif issubclass(kind, tuple):
            # Named tuples.
            pending += item
        elif _is_table(kind):
            pending += item.values()


def is_repeatable(value: e.Expression) -> bool:
    """True if computing it several times is the same as once: it calls no routine of the user."""
    return not any(
        isinstance(part, e.Verbatim)
        or (isinstance(part, e.Apply) and part.function not in e.FUNCTIONS)
        or (isinstance(part, e.Apply) and part.function in e.TAKING)
        for part in records(value)
    )


_WHOLE: Final = (Path, p.Motion, e.TargetValue, e.JointValue, e.PoseValue)
_LEAVES: Final = (float, int, str, type(None))


_TABLES: Final[dict[type, bool]] = {}


def is_steady(value: e.Expression, changing: Container[str]) -> bool:
    """True if working it out again gives the same, as long as the program itself changes nothing.

    changing: names in lower case of what others change: inputs, data of several tasks.
    """
    return is_repeatable(value) and not any(
        isinstance(part, e.Elapsed | e.Here)
        or (isinstance(part, e.Apply) and part.function in e.CHANGING)
        or (isinstance(part, e.Name) and part.name.lower() in changing)
        for part in records(value)
    )


def _is_table(kind: type) -> bool:
    if kind not in _TABLES:
        _TABLES[kind] = issubclass(kind, Mapping)
    return _TABLES[kind]


def _rewritten(value: Any, visit: Callable[[Any], Any], whole: tuple[type, ...]) -> Any:
    if isinstance(value, _LEAVES):
        return value
    if isinstance(value, tuple):
        items = [_rewritten(item, visit, whole) for item in value]
        return value if all(a is b for a, b in zip(items, value, strict=True)) else tuple(items)
    if _is_table(type(value)):
        table = {key: _rewritten(item, visit, whole) for key, item in value.items()}
        return value if all(table[key] is value[key] for key in table) else table
    parts = record_fields(type(value))
    if parts is None:
        return value
    if isinstance(value, whole):
        return visit(value)
    changed = {}
    for part in parts.names:
        before = getattr(value, part)
        after = _rewritten(before, visit, whole)
        if after is not before:
            changed[part] = after
    return visit(replace(value, **changed) if changed else value)
