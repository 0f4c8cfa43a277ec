"""Parts of records that may hold records: programs are looked through many times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from operator import attrgetter
from types import EllipsisType, NoneType
from typing import Any, Final, Literal, get_args, get_origin, get_type_hints


@dataclass(frozen=True, slots=True)
class RecordFields:
    """What of a kind of record is to be entered.

    names: of its fields in their order, without those that compare nothing and those whose types
    tell that no record is in them. of: their values.
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
    several = attrgetter(*names)
    return RecordFields(names, several if len(names) > 1 else lambda record: (several(record),))


def _holds_no_record(hint: Any) -> bool:
    """Whether what has a type surely is no record, and holds none."""
    if get_origin(hint) is Literal or hint in _PLAIN_TYPES:
        return True
    return bool(get_args(hint)) and all(map(_holds_no_record, get_args(hint)))
