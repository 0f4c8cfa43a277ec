"""Typed nodes from what the rules of a grammar are made of: most of them are rows of a table.

ROWS = {
    "while": row(WhileLoop),
    "function": row(Routine, "local? name parameters? body *handlers", kind="FUNC"),
    "data": row(Data, "scope? type name value", scope=str.upper),
    "arguments": without_place(tuple),
}

class RapidNodes(Nodes, rows=ROWS): ...  # with a method for each rule that is more
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, Final

from assistant.program.diagnostics import Span

Place = Span | None
"""Offsets in what the grammar read; None for what stands for no text."""
Children = list[Any]
"""What a rule is made of, in order: words, nodes, None for what is left out."""
Method = Callable[["Nodes", Place, Children], Any]


class Nodes:
    """What is made of the rules of a grammar: a method `(place, children)` for each.

    moved: from an offset in what the grammar read to one in the source, None for the same.
    """

    def __init__(self, moved: Callable[[int], int] | None = None) -> None:
        self._moved = moved

    def __init_subclass__(cls, rows: Mapping[str, Method] | None = None) -> None:
        for rule, method in (rows or {}).items():
            setattr(cls, rule, method)

    def span(self, place: Place) -> Place:
        """Where a rule stands in the source."""
        if place is None or self._moved is None:
            return place
        return Span(self._moved(place.start), self._moved(place.end))


def without_place(make: Callable[[Children], Any]) -> Method:
    """A rule that is made of its children alone."""
    return lambda _, __, children: make(children)


_EMPTY: Final[Mapping[str, object]] = {kind.__name__: kind() for kind in (bool, str, int)}
"""By type of a field; all others are tuples."""


def row(node: type[Any], named: str | None = None, **given: object) -> Method:
    """A rule whose children are the fields of a node.

    node: a dataclass; a field `span` gets the place. named: the fields in the order of the
    children, None for that of the class; `*` takes all that are left over, `?` has the empty value
    of its type where nothing stands (of a truth: whether something does), and `_` is no field.
    given: of a field, what is made of a child that stands there, or the one value that it has.
    """
    known = {field.name: field for field in fields(node) if field.name != "span"}
    marked = list(known) if named is None else named.split()
    dropped = [at for at, name in enumerate(marked) if name == "_"][::-1]
    marked = [name for name in marked if name != "_"]
    names = [name.strip("*?") for name in marked]
    rest = [
        slice(at, at + 1 - len(names) or None) for at, name in enumerate(marked) if name[0] == "*"
    ]
    changes = [
        (at, *_change(str(known[name].type), given.get(name), mark[-1] == "?"))
        for at, (name, mark) in enumerate(zip(names, marked, strict=True))
        if mark[-1] == "?" or name in given
    ]
    fixed = {
        name: given.get(name, field.default) for name, field in known.items() if name not in names
    }
    order = [[*names, *fixed].index(name) for name in known]
    if names == list(known)[: len(names)] and not fixed.keys() & given.keys():
        order.clear()
    values, spanned = tuple(fixed.values()), len(known) < len(fields(node))

    def plain(nodes: Nodes, place: Place, children: Children) -> Any:
        return node(*children, span=nodes.span(place)) if spanned else node(*children)

    def changed(nodes: Nodes, place: Place, children: Children) -> Any:
        made = children.copy()  # which may be part of a list that still grows
        for at in dropped:
            del made[at]
        for among in rest:
            made[among] = [tuple(made[among])]
        for at, empty, change in changes:
            made[at] = empty if made[at] is None else change(made[at])
        if order:
            made += values
            made = [made[at] for at in order]
        return plain(nodes, place, made)

    return changed if dropped or rest or changes or order else plain


def _change(type: str, change: object, may_miss: bool) -> tuple[object, Callable[[Any], object]]:
    """What stands for a child that is left out, and what is made of one that is not."""
    if type == bool.__name__:
        return False, lambda _: True
    empty = _EMPTY.get(type, ()) if may_miss else None
    return empty, change if callable(change) else lambda child: child
