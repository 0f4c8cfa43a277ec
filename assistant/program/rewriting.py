"""Rewriting: the same program with some of its parts exchanged."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, Final, TypeVar

from assistant.program.path import Path

T = TypeVar("T")


def rewrite(value: T, visit: Callable[[Any], Any]) -> T:
    """The value with every record in it replaced by what `visit` makes of it, inner ones first.

    Goes through records, tuples and tables; a `Path` is one record. A record that `visit`
    gives back as it is stays the same object, so that an untouched program costs nothing.
    """
    return _rewritten(value, visit)  # type: ignore[no-any-return]


_LEAVES: Final = (float, int, str, type(None))


def _rewritten(value: Any, visit: Callable[[Any], Any]) -> Any:
    if isinstance(value, _LEAVES):
        return value
    if isinstance(value, tuple):
        items = [_rewritten(item, visit) for item in value]
        return value if all(a is b for a, b in zip(items, value, strict=True)) else tuple(items)
    if isinstance(value, Mapping):
        table = {key: _rewritten(item, visit) for key, item in value.items()}
        return value if all(table[key] is value[key] for key in table) else table
    if not is_dataclass(value) or isinstance(value, type):
        return value
    if isinstance(value, Path):
        return visit(value)
    changed = {}
    for part in fields(value):
        if not part.compare:  # where it came from, not what it says
            continue
        before = getattr(value, part.name)
        after = _rewritten(before, visit)
        if after is not before:
            changed[part.name] = after
    return visit(replace(value, **changed) if changed else value)
