"""Typed tree nodes: made from the rules of a grammar by rows of a table, and walked.

ROWS = {
    "while": row(WhileLoop),
    "function": row(Routine, "local? name parameters? body *handlers", kind="function"),
    "data": row(Data, "scope? type name value", scope=str.upper),
    "arguments": without_place(tuple),
}

class TreeNodes(Nodes, rows=ROWS): ...  # with a method for each rule that needs more
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, fields
from functools import partial
from operator import itemgetter
from typing import Any, Final

from assistant.base.diagnostics import Span
from assistant.program.rewriting import record_fields

Place = Span | None
"""Offsets in what the grammar read; None for what stands for no text."""
Children = list[Any]
"""Children of a rule, in order: words, nodes, None for a missing one."""
Method = Callable[["Nodes", Place, Children], Any]


class Nodes:
    """Builds nodes from the rules of a grammar: a method `(place, children)` for each.

    moved: converts an offset in the text that the grammar read to one in the source, None for no
    change.
    """

    def __init__(self, moved: Callable[[int], int] | None = None) -> None:
        self.moved = moved

    def __init_subclass__(cls, rows: Mapping[str, Method] | None = None) -> None:
        for rule, method in (rows or {}).items():
            setattr(cls, rule, method)

    def span(self, place: Place) -> Place:
        """Return the span of a rule in the source."""
        if place is None or self.moved is None:
            return place
        return Span(self.moved(place.start), self.moved(place.end))


def without_place(make: Callable[[Children], Any]) -> Method:
    """A rule that is made of its children alone."""
    return lambda _, __, children: make(children)


_EMPTY: Final[Mapping[str, object]] = {kind.__name__: kind() for kind in (bool, str, int)}
"""By type of a field; all others are tuples."""


def row(node: type[Any], named: str | None = None, **given: object) -> Method:
    """Return the method of a rule whose children are the fields of a node.

    node: a dataclass; a field `span` gets the source span. named: the fields in the order of the
    children, None for that of the class; `*` takes all remaining ones, `?` has the empty value of
    its type for a missing child (for a truth: whether there is a child), and `_` is not a field.
    given: by field, a function of the child, or the one value of the field.
    """
    known = {field.name: field for field in fields(node) if field.init}
    spanned = known.pop("span", None) is not None
    marked = list(known) if named is None else named.split()
    steps: list[Callable[[Children], Any]] = [
        _listing(at, len(marked) - 1 - at) for at, name in enumerate(marked) if name[0] == "*"
    ]
    dropped = [at for at, name in enumerate(marked) if name == "_"]
    if dropped:
        steps.append(lambda children: [c for at, c in enumerate(children) if at not in dropped])
        marked = [name for name in marked if name != "_"]
    names = [name.strip("*?") for name in marked]
    changes = [
        (at, *_change(str(known[name].type), given.get(name), mark[-1] == "?"))
        for at, (name, mark) in enumerate(zip(names, marked, strict=True))
        if mark[-1] == "?" or name in given
    ]
    if changes:
        steps.append(partial(_changed, changes))
    others = {name: given.get(name, known[name].default) for name in known if name not in names}
    # Only children in another order than the fields need to be put in order.
    if names != list(known)[: len(names)] or others.keys() & given.keys():
        values, order = tuple(others.values()), [[*names, *others].index(name) for name in known]
        # Found when the table is made, not when the first text needs the row.
        if MISSING in values:
            raise TypeError(f"a field of {node.__name__} has no value")
        ordered = itemgetter(*order) if names else tuple
        steps.append(lambda children: ordered([*children, *values]))

    def method(nodes: Nodes, place: Place, children: Children) -> Any:
        for step in steps:
            children = step(children)
        if not spanned:
            return node(*children)
        return node(*children, span=place if nodes.moved is None else nodes.span(place))

    return method


def _listing(first: int, behind: int) -> Callable[[Children], Children]:
    """Makes one child of those from the first on up to the last ones behind."""
    if not first and not behind:
        return lambda children: [tuple(children)]

    def listed(children: Children) -> Children:
        last = len(children) - behind
        return [*children[:first], tuple(children[first:last]), *children[last:]]

    return listed


Change = tuple[int, object, Callable[[Any], object] | None]
"""The number of a child, what stands for one that is left out, and what is made of another."""


def _change(
    type: str, change: object, may_miss: bool
) -> tuple[object, Callable[[Any], object] | None]:
    if type == bool.__name__:
        return False, lambda _: True
    return _EMPTY.get(type, ()) if may_miss else None, change if callable(change) else None


def _changed(changes: Sequence[Change], children: Children) -> Children:
    made = children.copy()  # which may be part of a list that still grows
    for at, empty, change in changes:
        if made[at] is None:
            made[at] = empty
        elif change is not None:
            made[at] = change(made[at])
    return made


class Walk:
    """Goes through trees of one language.

    is_node: whether a type is one of its nodes. held: the type of those that keep in their `known`
    what is inside them, None for no type.
    """

    def __init__(self, is_node: Callable[[type], bool], held: type | None = None) -> None:
        self._is_node = is_node
        self._held = held
        self._inside: dict[type, tuple[str, ...] | None] = {}

    def inside(self, kind: type) -> tuple[str, ...] | None:
        """Fields of a node that may hold nodes, the last one first; None for what is no node."""
        if kind not in self._inside:
            found = None
            if self._is_node(kind):
                parts = record_fields(kind)
                said = () if parts is None else reversed(parts.names)
                found = tuple(name for name in said if name != "span")
            self._inside[kind] = found
        return self._inside[kind]

    def nodes(self, root: Any) -> Iterator[Any]:
        """Yield every node in a node or a tuple of nodes, itself first, in the text's order."""
        known, held = self._inside, self._held
        pending = [root]
        while pending:
            item = pending.pop()
            kind = type(item)
            # Reversed, as the stack gives the last one first.
            if kind is tuple:
                pending.extend(item[::-1])
                continue
            if kind is held:
                yield item
                # Gathered once; nodes are frozen, so that they stay the same.
                if not item.known:
                    parts = reversed(self.inside(kind) or ())
                    item.known.extend(self.nodes(tuple(getattr(item, part) for part in parts)))
                yield from item.known
                continue
            names = known[kind] if kind in known else self.inside(kind)
            if names is not None:
                yield item
                pending.extend([getattr(item, name) for name in names])
