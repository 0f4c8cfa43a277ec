"""Values in brackets with the values of the constants that they name.

`CONST robtarget p2:=[pos1,[0,0,1,0],conf1,[9E9,…]];` becomes a declaration of numbers alone where
nothing changes `pos1` and `conf1`, so that another language has a position of it. Brackets with a
part that the program works out keep their names, but for those of constants that are records.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lift.plain.layouts import RecordLayouts
from assistant.languages.rapid.lift.plain.scopes import PI, NameUses, predefined_type, row_value
from assistant.languages.rapid.lift.plain.standard import predefined_value
from assistant.languages.rapid.lift.plain.substituting import is_literal
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.rapid.tree.walk import inner_names, nodes
from assistant.languages.runs.columns import NameIndex
from assistant.program.rewriting import rewrite

_WRITES_BY_TEXT: Final = frozenset(("setdataval", "setalldataval"))
"""Instructions that change variables whose names are worked out."""
_PARTS: Final = ("robconf", "extax", "robax")
"""Components of targets that other languages have only as numbers, or of the same target."""
MOST_NESTED: Final = 40
"""Constants that are declared by others; more is a circle."""

TypedValue = tuple[str, s.Expression]
"""A value that is written out, and its type without aliases; empty if that is not known."""


def with_constant_values(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules whose brackets, and extents of arrays, name constants only where they must."""
    if not any(map(_is_named, nodes(tuple(modules)))):
        return modules
    known = _Constants(modules)
    return [known.module(module) for module in modules]


def _is_named(node: Any) -> bool:
    match node:
        case s.AggregateNode(items):
            return not all(isinstance(one, s.AggregateNode) or is_literal(one) for one in items)
        case s.Data(dimensions=sizes):
            return any(literal_number(size) is None for size in sizes)
    return False


class _Constants:
    """Data of the modules, and of the routine at hand, that nothing changes."""

    def __init__(self, modules: Sequence[s.Module]) -> None:
        self.layouts = RecordLayouts(modules)
        every = list(nodes(tuple(modules)))
        calls = (one for one in every if isinstance(one, s.ProcedureCall))
        by_text = any(str(one.name).lower() in _WRITES_BY_TEXT for one in calls)
        self._written = None if by_text else NameUses(modules, frozenset()).written
        items = [item for module in modules for item in module.items]
        declared = [item for item in items if isinstance(item, s.Data)]
        self._tables = [
            (NameIndex(item.run.names), item.run)
            for item in items
            if isinstance(item, s.TargetRunNode)
        ]
        self._count = Counter(item.name.lower() for item in declared)
        self._data = {item.name.lower(): item for item in declared}
        self._values: dict[str, TypedValue | None] = {}
        self._own: dict[str, s.Data | None] = {}
        self._deep = 0

    def module(self, module: s.Module) -> s.Module:
        items = tuple(map(self._item, module.items))
        same = all(a is b for a, b in zip(items, module.items, strict=True))
        return module if same else replace(module, items=items)

    def _item(self, item: s.Item) -> s.Item:
        self._own = {}
        if isinstance(item, s.Routine):
            own: dict[str, s.Data | None] = dict.fromkeys(map(str.lower, inner_names((item,))))
            counted = {one.variable.lower() for one in nodes(item) if isinstance(one, s.ForLoop)}
            for node in item.body:
                if isinstance(node, s.Data) and node.name.lower() not in counted:
                    own[node.name.lower()] = node
            self._own = own
        elif not isinstance(item, s.Data):
            return item
        made: s.Item = rewrite(item, self._visit, ())
        return made

    def _visit(self, node: Any) -> Any:
        match node:
            case s.AggregateNode(items):
                if is_literal(node):
                    return node
                whole = self.value(node)
                if whole is not None:
                    return whole
                changed = tuple(map(self._part, items))
                same = all(a is b for a, b in zip(items, changed, strict=True))
                return node if same else replace(node, items=changed)
            case s.Data(dimensions=sizes) if sizes:
                extents = tuple(map(self._extent, sizes))
                return node if extents == sizes else replace(node, dimensions=extents)
        return node

    def _extent(self, size: s.Expression) -> s.Expression:
        value = None if literal_number(size) is not None else self.value(size)
        number = None if value is None else literal_number(value)
        whole = isinstance(number, float | int) and number == int(number) > 0
        return s.NumberLiteral(str(int(number or 0))) if whole else size

    def _part(self, item: s.Expression) -> s.Expression:
        """A part of brackets that are worked out: numbers for a record that is a constant."""
        match item:
            case s.NameRef() | s.Element():
                pass
            case s.Component(_, name) if name.lower() in _PARTS:
                pass
            case _:
                return item
        value = self.value(item)
        return value if isinstance(value, s.AggregateNode) else item

    # ---------------------------------------------------------------------------- values

    def value(self, node: s.Expression) -> s.Expression | None:
        """The value of an expression, None if it is not one of constants alone."""
        found = self._typed(node)
        return None if found is None else found[1]

    def _typed(self, node: Any) -> TypedValue | None:
        match node:
            case s.Group(inner):
                return self._typed(inner)
            case s.NameRef(name):
                return self._named(name.lower())
            case s.Component(of, name):
                return self._component(self._typed(of), name)
            case s.Element(of, indices):
                return self._element(self._typed(of), indices)
            case s.AggregateNode(items):
                values = [self.value(item) for item in items]
                known = tuple(one for one in values if one is not None)
                return ("", s.AggregateNode(known)) if len(known) == len(values) else None
            case s.BoolLiteral() | s.StringLiteral():
                return "", node
            case s.Prefix("-" | "+") | s.Infix("+" | "-" | "*" | "/"):
                number = self._number(node)
                return None if number is None else ("num", _number_literal(number))
        return None if literal_number(node) is None else ("num", node)

    def _number(self, node: Any) -> float | int | None:
        match node:
            case s.Prefix("-" | "+" as operator, operand):
                inner = self._number(operand)
                return -inner if operator == "-" and inner is not None else inner
            case s.Infix("+" | "-" | "*" | "/" as operator, left, right):
                one, two = self._number(left), self._number(right)
                if one is None or two is None or (operator == "/" and not two):
                    return None
                made = _computed(operator, one, two)
                return made if math.isfinite(made) else None
        value = self.value(node)
        number = None if value is None else literal_number(value)
        return number if number is not None and math.isfinite(number) else None

    def _named(self, low: str) -> TypedValue | None:
        """The value of a name; none while it is looked for, as of data declared by themselves."""
        if low in self._own:
            node, self._own[low] = self._own[low], None
            found = None if node is None else self._declared(node)
            self._own[low] = node
            return found
        if low in self._data:
            if self._count[low] > 1:
                return None
            if low not in self._values:
                self._values[low] = None
                own, self._own = self._own, {}
                self._values[low] = self._declared(self._data[low])
                self._own = own
            return self._values[low]
        for index, run in self._tables:
            row = int(index.row(low)[0])
            if row >= 0:
                return "robtarget", row_value(run, row)
        if low == PI:
            return "num", s.NumberLiteral(repr(math.pi))
        known = predefined_value(low) if low != "vmax" else None
        return None if known is None else (predefined_type(low), known)

    def _declared(self, node: s.Data) -> TypedValue | None:
        changed = self._written is None or node.name.lower() in self._written
        if node.value is None or (node.storage != "CONST" and changed) or self._deep > MOST_NESTED:
            return None
        self._deep += 1
        value = self.value(node.value)
        self._deep -= 1
        return None if value is None else (self.layouts.base(node.type), value)

    def _component(self, of: TypedValue | None, name: str) -> TypedValue | None:
        if of is None or not isinstance(of[1], s.AggregateNode):
            return None
        names = [inner.lower() for inner, _ in self.layouts.components(of[0])]
        if name.lower() not in names or len(names) != len(of[1].items):
            return None
        value = of[1].items[names.index(name.lower())]
        return self.layouts.component(of[0], name) or "", value

    def _element(
        self, of: TypedValue | None, indices: Sequence[s.Expression | s.Whole]
    ) -> TypedValue | None:
        if of is None:
            return None
        type, value = of
        for index in indices:
            found = None if isinstance(index, s.Whole) else self.value(index)
            at = None if found is None else literal_number(found)
            if not isinstance(value, s.AggregateNode) or not isinstance(at, int):
                return None
            if not 1 <= at <= len(value.items):
                return None
            value = value.items[at - 1]
        return type, value


def _computed(operator: str, one: float, two: float) -> float:
    if operator == "+":
        return one + two
    if operator == "-":
        return one - two
    return one * two if operator == "*" else one / two


def _number_literal(number: float) -> s.Expression:
    whole = number == int(number) and abs(number) < 1e15
    text = s.NumberLiteral(str(abs(int(number))) if whole else repr(abs(number)))
    return s.Prefix("-", text) if number < 0 else text
