"""What assignments read and change, and arrays that are given values in brackets."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lift.plain.kinds import Kind
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.rapid.tree.walk import nodes

ArrayCell = tuple[tuple[int, ...], s.Expression]
"""The indices and the value of an element."""
MOST_ELEMENTS: Final = 120
"""Of an array that is given values in brackets; of more it stays one statement."""


def differs_in_size(value: s.AggregateNode, sizes: Sequence[s.Expression]) -> bool:
    """Whether values in brackets are more or fewer than the elements of an array."""
    if not sizes:
        return False
    first, *others = sizes
    extent = literal_number(first)
    if extent is not None and extent != len(value.items):
        return True
    inner = (one for one in value.items if isinstance(one, s.AggregateNode))
    return any(differs_in_size(one, others) for one in inner)


def element_assignments(
    node: s.Assignment, kind: Kind | None, variable: Callable[[str, str], s.NameRef]
) -> Iterator[s.Assignment]:
    """An assignment, of values in brackets to an array one for each element.

    kind: of what is assigned. variable: gives a new one of a type: values go by way of variables
    where one is asked for that was an element before.
    """
    match node:
        case s.Assignment(s.NameRef(name), s.AggregateNode() as value) if kind and kind[1]:
            rows = list(_array_cells(value, kind[1]))
            if len(rows) <= MOST_ELEMENTS:
                if name.lower() in names_in(value):
                    held = [(index, variable("new", kind[0])) for index, _ in rows]
                    for (_, place), (_, cell) in zip(held, rows, strict=True):
                        yield replace(node, target=place, value=cell)
                    rows = [*held]
                for index, cell in rows:
                    numbers = tuple(s.NumberLiteral(str(at)) for at in index)
                    yield replace(node, target=s.Element(s.NameRef(name), numbers), value=cell)
                return
    yield node


def _array_cells(value: s.AggregateNode, depth: int) -> Iterator[ArrayCell]:
    """The values of an array in brackets, each with its indices."""
    for at, item in enumerate(value.items, 1):
        if depth == 1 or not isinstance(item, s.AggregateNode):
            yield (at,), item
        else:
            yield from (((at, *index), cell) for index, cell in _array_cells(item, depth - 1))


def names_in(value: Any) -> set[str]:
    """Every name in an expression, in lower case."""
    return {node.name.lower() for node in nodes(value) if isinstance(node, s.NameRef)}


def assigned_names(place: Any) -> set[str]:
    """The data that an assignment changes, in lower case."""
    while not isinstance(place, s.NameRef):
        place = place.value
    return {place.name.lower()}


def index_names(place: Any) -> set[str]:
    """Names in the indices of what is assigned, in lower case."""
    found: set[str] = set()
    while not isinstance(place, s.NameRef):
        if isinstance(place, s.Element):
            found |= names_in(place.indices)
        place = place.value
    return found
