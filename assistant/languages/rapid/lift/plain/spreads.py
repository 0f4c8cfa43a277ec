"""Values of records, part by part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from assistant.languages.rapid.lift.plain.layouts import ComponentPath
from assistant.languages.rapid.tree import syntax as s

RecordValue = Mapping[ComponentPath, s.Expression]
"""A value of a record, part by part."""


class NotExpressible(Exception):
    """Something that a program with plain data cannot say. why: a clause."""

    def __init__(self, why: str) -> None:
        super().__init__(why)
        self.why = why


def in_brackets(spread: RecordValue) -> RecordValue:
    """With brackets around what is worked out."""
    return {path: grouped(one) for path, one in spread.items()}


def grouped(node: s.Expression) -> s.Expression:
    return s.Group(node) if isinstance(node, s.Infix | s.Prefix) else node


def element(name: s.NameRef, index: tuple[Any, ...]) -> Any:
    """Data, or an element of it if there are indices."""
    return s.Element(name, index) if index else name


def cross_product(a: RecordValue, b: RecordValue) -> RecordValue:
    """The vector that is at right angles to two."""
    x, y, z = (("x",), ("y",), ("z",))
    return {
        one: s.Infix("-", s.Infix("*", a[two], b[three]), s.Infix("*", a[three], b[two]))
        for one, two, three in ((x, y, z), (y, z, x), (z, x, y))
    }


def component_value(spread: RecordValue, path: Sequence[str]) -> RecordValue:
    key = tuple(one.lower() for one in path)
    found = {way[len(key) :]: one for way, one in spread.items() if way[: len(key)] == key}
    if not found:
        raise NotExpressible("it has no such component")
    return found
