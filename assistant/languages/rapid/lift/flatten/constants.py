"""Data that nothing changes, as constants and as numbers where they are used.

Brackets get the values of the constants that they name, so that
`CONST robtarget p2:=[pos1,[0,0,1,0],conf1,[9E9,…]];` has a position; brackets with a computed part
keep names other than those of constant records. A speed, zone or load that a routine declares and
never changes becomes a constant of the module, and one that gets a single value anywhere a constant
of that value: other languages write them in the move. A speed without a first value can be in force
only after its assignment, since a move at no speed is an error; a zone without one needs a speed
that is assigned in the same run of assignments and that all its moves use. Weld and spot data
become the speed (mm/s) or number that they hold, or their first component:
`ArcL p10,v100,seam1,weld1,fine,tGun;` becomes `ArcL p10,v100,0,[12],fine,tGun;`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field, replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.languages.rapid.lift.flatten.data_names import (
    PI,
    predefined_type,
    predefined_value,
    row_value,
)
from assistant.languages.rapid.lift.flatten.record_layout import RecordLayouts
from assistant.languages.rapid.lift.flatten.tree_rewriting import is_literal
from assistant.languages.rapid.lift.flatten.unread_data import OMISSION_MARK
from assistant.languages.rapid.tables.constants import SPEEDS, ZONES
from assistant.languages.rapid.tables.signals import (
    GUN_OPTIONS,
    PROCESS_MOVES,
    SPOT_DATA,
    WELD_SPEED,
)
from assistant.languages.rapid.text.printer import expression as printed
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.changed_data import changed_names
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.syntax import MotionNames
from assistant.languages.rapid.tree.walk import inner_names, lists, nodes, root
from assistant.languages.runs.columns import NameIndex
from assistant.program.program import TakenNames, identifier
from assistant.program.rewriting import rewrite

_WRITES_BY_TEXT: Final = frozenset(("setdataval", "setalldataval"))
"""Instructions that change variables whose names are worked out."""
_PARTS: Final = ("robconf", "extax", "robax")
"""Components of targets that other languages have only as numbers, or of the same target."""
_MOST_NESTED: Final = 40
"""Constants that are declared by others; more is a circle."""

_TypedValue = tuple[str, s.Expression]
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
        # These instructions may change any variable, so only constants are certain.
        by_text = any(str(one.name).lower() in _WRITES_BY_TEXT for one in calls)
        self._written = None if by_text else changed_names(modules)
        items = [item for module in modules for item in module.items]
        declared = [item for item in items if isinstance(item, s.Data)]
        self._tables = [
            (NameIndex(item.run.names), item.run)
            for item in items
            if isinstance(item, s.TargetRunNode)
        ]
        self._count = Counter(item.name.lower() for item in declared)
        self._data = {item.name.lower(): item for item in declared}
        self._values: dict[str, _TypedValue | None] = {}
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
            # A loop variable hides data of its name, which is then not known here.
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
        # An extent that is not a positive whole number stays as it is written, for the checks to
        # report.
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

    def _typed(self, node: Any) -> _TypedValue | None:
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

    def _named(self, low: str) -> _TypedValue | None:
        """Return the value of a name; None while its own declaration is evaluated, as for data
        declared in terms of itself.
        """
        if low in self._own:
            # None while the value is asked for: data that is declared by itself has no value.
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
        # `vmax` is what the arm can, which differs between arms.
        known = predefined_value(low) if low != "vmax" else None
        return None if known is None else (predefined_type(low), known)

    def _declared(self, node: s.Data) -> _TypedValue | None:
        changed = self._written is None or node.name.lower() in self._written
        if node.value is None or (node.storage != "CONST" and changed) or self._deep > _MOST_NESTED:
            return None
        self._deep += 1
        value = self.value(node.value)
        self._deep -= 1
        return None if value is None else (self.layouts.base(node.type), value)

    def _component(self, of: _TypedValue | None, name: str) -> _TypedValue | None:
        if of is None or not isinstance(of[1], s.AggregateNode):
            return None
        names = [inner.lower() for inner, _ in self.layouts.components(of[0])]
        if name.lower() not in names or len(names) != len(of[1].items):
            return None
        value = of[1].items[names.index(name.lower())]
        return self.layouts.component(of[0], name) or "", value

    def _element(
        self, of: _TypedValue | None, indices: Sequence[s.Expression | s.Whole]
    ) -> _TypedValue | None:
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
    # Beyond 15 digits a float has no exact whole number to print.
    whole = number == int(number) and abs(number) < 1e15
    text = s.NumberLiteral(str(abs(int(number))) if whole else repr(abs(number)))
    return s.Prefix("-", text) if number < 0 else text


_CONSTANT_TYPES: Final = frozenset(("speeddata", "zonedata", "loaddata"))
_NAMED_NODES: Final = (s.NameRef, s.Data, s.Routine, s.Record, s.Alias, s.ParameterNode)


def with_module_settings(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules whose routines declare none of these that never changes."""
    layouts = RecordLayouts(modules)
    items = [item for module in modules for item in module.items]
    own = [
        node
        for item in items
        if isinstance(item, s.Routine)
        for node in item.body
        if isinstance(node, s.Data) and layouts.base(node.type) in _CONSTANT_TYPES
    ]
    if not own:
        return modules
    written = changed_names(modules)
    every = list(nodes(tuple(modules)))
    taken = TakenNames(one.name for one in every if isinstance(one, _NAMED_NODES))
    taken.update(one.variable for one in every if isinstance(one, s.ForLoop))
    made = []
    for module in modules:
        changed: list[s.Item] = []
        for item in module.items:
            if isinstance(item, s.Routine):
                data, item = _moved_settings(item, layouts, written, taken)
                changed += data
            changed.append(item)
        same = len(changed) == len(module.items)
        made.append(module if same else replace(module, items=tuple(changed)))
    return made


def _moved_settings(
    routine: s.Routine, layouts: RecordLayouts, written: set[str], taken: TakenNames
) -> tuple[list[s.Data], s.Routine]:
    """The constants that a routine has, and the routine without them."""
    names: dict[str, str] = {}
    data: list[s.Data] = []
    for node in routine.body:
        match node:
            case s.Data(type=type, name=name, dimensions=(), value=s.AggregateNode() as value) if (
                layouts.base(type) in _CONSTANT_TYPES
                and is_literal(value)
                and name.lower() not in written
            ):
                new = identifier(f"{routine.name}_{name}", taken)
                taken.add(new)
                names[name.lower()] = new
                data.append(replace(node, scope="", storage="CONST", name=new))
    if not names:
        return [], routine

    def renamed(part: Any) -> Any:
        match part:
            case s.NameRef(name) if name.lower() in names:
                return replace(part, name=names[name.lower()])
            case MotionNames(speed, zone, tool, frame):
                new = (names.get(one.lower(), one) for one in (speed, zone, tool, frame))
                return MotionNames(*new)
        return part

    body = tuple(
        node
        for node in routine.body
        if not (isinstance(node, s.Data) and node.name.lower() in names)
    )
    changed: s.Routine = rewrite(replace(routine, body=body), renamed, ())
    return data, changed


_MOVES: Final = frozenset(("movej", "movel", "moveabsj", "movec"))
_SPEED_OPTIONS: Final = frozenset("tv")
"""Options that say how fast a move is in the place of its speed."""
_PREDEFINED: Final = {"speeddata": SPEEDS, "zonedata": ZONES}


@dataclass(slots=True)
class _Setting:
    """A speed or zone. values: what it is assigned, printed. uses: as an argument of a move.
    beside: data in lower case that each such move has beside it. runs: names that are assigned
    along with it, in each run of assignments.
    """

    node: s.Data
    values: dict[str, s.Expression] = field(default_factory=dict)
    uses: int = 0
    assigned: int = 0
    beside: list[frozenset[str]] = field(default_factory=list)
    runs: list[frozenset[str]] = field(default_factory=list)


def with_constant_speeds(
    modules: Sequence[s.Module], layouts: RecordLayouts, kept: Collection[int]
) -> list[s.Module]:
    """The modules with such constants; assignments become comments, `OMISSION_MARK` and the name.

    kept: statements that stay as they are written, by `id`.
    """
    found = _single_valued(modules, layouts)
    if found and kept:
        whole = [node for node in nodes(tuple(modules)) if id(node) in kept]
        # A statement that stays as text needs its data as variables.
        text = {one.name.lower() for one in nodes(tuple(whole)) if isinstance(one, s.NameRef)}
        found = {name: one for name, one in found.items() if name not in text}
    if not found:
        return list(modules)

    def visit(node: Any) -> Any:
        match node:
            case s.Data(name=name) if (one := found.get(name.lower())) is not None:
                (value,) = one.values.values()
                return replace(node, storage="CONST", value=value)
            case s.Assignment(s.NameRef(name)) if name.lower() in found:
                return s.CommentLine(f"{OMISSION_MARK}{name}", span=node.span)
        return node

    return [rewrite(module, visit, ()) for module in modules]


def _single_valued(modules: Sequence[s.Module], layouts: RecordLayouts) -> Mapping[str, _Setting]:
    """By lower-case name."""
    items = [item for module in modules for item in module.items]
    routines = [item for item in items if isinstance(item, s.Routine)]
    names = Counter(item.name.lower() for item in items if isinstance(item, s.Data))
    inner = {name.lower() for name in inner_names(routines)}
    every = {
        item.name.lower(): _Setting(item)
        for item in items
        if isinstance(item, s.Data) and item.storage == "VAR" and not item.dimensions
        and layouts.base(item.type) in _PREDEFINED
        and names[item.name.lower()] == 1 and item.name.lower() not in inner
    }  # fmt: skip
    if not every:
        return {}
    own = {routine.name.lower() for routine in routines}
    said: Counter[str] = Counter()
    for node in nodes(tuple(modules)):
        match node:
            case s.NameRef(name):
                said[name.lower()] += 1
            # Any setting may be changed by its name as a text.
            case s.ProcedureCall(str(name)) if name.lower() in _WRITES_BY_TEXT:
                return {}
            case s.MoveRunNode(run):
                for how in run.motions.table:
                    pair = [name.lower() for name in (how.speed, how.zone) if name]
                    _count_uses(every, pair)
                    said.update(pair)
            case s.ProcedureCall(str(name), given) if name.lower() in _MOVES - own:
                # Such a move states its speed by an option, so its speeddata does not hold there.
                if any(isinstance(a, s.Option) and a.name.lower() in _SPEED_OPTIONS for a in given):
                    continue
                plain = [a.value for a in given if isinstance(a, s.Positional)]
                _count_uses(every, [v.name.lower() for v in plain if isinstance(v, s.NameRef)])
    for body in (body for routine in routines for body in lists(routine)):
        for row in _assignment_runs(body):
            together = frozenset(name for name, _ in row)
            for name, value in row:
                if (one := every.get(name)) is not None:
                    one.values[printed(value).lower()] = value
                    one.assigned += 1
                    one.runs.append(together)
    steady = {
        name: one
        for name, one in every.items()
        # Every mention must be an assignment or the argument of a move.
        if one.assigned and len(one.values) == 1 and said[name] == one.uses + one.assigned
        and _is_constant_value(next(iter(one.values.values())), layouts.base(one.node.type))
        and (one.node.value is None or printed(one.node.value).lower() in one.values)
    }  # fmt: skip
    return {name: one for name, one in steady.items() if _holds_throughout(one, steady, layouts)}


def _count_uses(every: Mapping[str, _Setting], names: Sequence[str]) -> None:
    for name in names:
        if (one := every.get(name)) is not None:
            one.uses += 1
            one.beside.append(frozenset(names))


def _assignment_runs(body: Sequence[s.StatementNode]) -> Iterator[list[tuple[str, s.Expression]]]:
    """Assignments to whole data that follow one another: names in lower case and values."""
    run: list[tuple[str, s.Expression]] = []
    # The last run ends with the list.
    for node in (*body, None):
        match node:
            case s.CommentLine():
                continue
            case s.Assignment(s.NameRef(name), value):
                run.append((name.lower(), value))
            case _:
                yield run
                run = []


def _is_constant_value(value: s.Expression, type: str) -> bool:
    match value:
        case s.NameRef(name):
            return name.lower() in _PREDEFINED[type]
        case s.AggregateNode(items):
            return all(isinstance(i, s.BoolLiteral) or literal_number(i) is not None for i in items)
    return False


def _holds_throughout(
    one: _Setting, steady: Mapping[str, _Setting], layouts: RecordLayouts
) -> bool:
    """True if no move can run with another value; without a speed nothing moves."""
    if one.node.value is not None or layouts.base(one.node.type) == "speeddata":
        return True
    speeds = {
        name
        for name, other in steady.items()
        # Such a speed and the zone are always assigned together, so whatever moves at it has the
        # zone.
        if other.node.value is None and layouts.base(other.node.type) == "speeddata"
        and all(name in run for run in one.runs)
        and all(one.node.name.lower() in run for run in other.runs)
    }  # fmt: skip
    return all(beside & speeds for beside in one.beside)


_ARGUMENTS_AFTER: Final = 2
"""Arguments between the targets of a move and its process data: the speed on the path, and the seam
or the gun.
"""
_ZERO: Final = s.NumberLiteral("0")
"""Placeholder for a seam, which is not translated."""
_PROCESS_KINDS: Final = ("arc", "spot")
"""Kinds of processes whose data are translated in part."""


def with_process_data(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules with the speeds of welds and numbers of spots where they are given to moves."""
    own = {one.name.lower() for m in modules for one in m.items if isinstance(one, s.Routine)}
    every = list(nodes(tuple(modules)))
    # A routine of the program may hide a process move.
    if not own.isdisjoint(PROCESS_MOVES) or not any(map(_is_process_move, every)):
        return modules
    steady = _constant_first_parts(modules, every)

    def said(node: Any) -> Any:
        if not _is_process_move(node):
            return node
        known = PROCESS_MOVES[node.name.lower()]
        plain = [at for at, a in enumerate(node.arguments) if isinstance(a, s.Positional)]
        # Without arguments between speed and zone, the data come in options of the guns alone.
        place = known.points + _ARGUMENTS_AFTER if known.given else len(plain)
        weld = known.kind == "arc"
        arguments = []
        for at, argument in enumerate(node.arguments):
            of_gun = isinstance(argument, s.Option) and argument.name.lower() in GUN_OPTIONS
            if isinstance(argument, s.Option) and argument.name.lower() in known.beside:
                continue
            if (plain[place : place + 1] == [at] or of_gun) and argument.value is not None:
                arguments.append(replace(argument, value=part(argument.value, weld)))
            elif weld and plain[place - 1 : place] == [at]:
                arguments.append(replace(argument, value=_ZERO))
            else:
                arguments.append(argument)
        return replace(node, arguments=tuple(arguments))

    def part(data: s.Expression, weld: bool) -> s.Expression:
        if not isinstance(data, s.NameRef | s.Element):
            return data
        value = steady.get(data.name.lower()) if isinstance(data, s.NameRef) else None
        if value is None and not weld:
            return data
        return s.AggregateNode((value or s.Component(data, WELD_SPEED),))

    return [rewrite(module, said, ()) for module in modules]


def _is_process_move(node: Any) -> bool:
    if not isinstance(node, s.ProcedureCall) or not isinstance(node.name, str):
        return False
    known = PROCESS_MOVES.get(node.name.lower())
    return known is not None and known.kind in _PROCESS_KINDS


def _constant_first_parts(
    modules: Sequence[s.Module], every: Sequence[Any]
) -> Mapping[str, s.Expression]:
    """First parts of data by lower-case name that nothing changes, and that no routine hides."""
    changed = {
        name.lower() for name in inner_names(m for n in modules for m in _module_routines(n))
    }
    for node in every:
        match node:
            case s.Assignment(target) if (found := root(target)) is not None:
                changed.add(found.name.lower())
            # Any other routine may change what it is given.
            case s.ProcedureCall() | s.FunctionCall() if not _is_process_move(node):
                names = (n for n in nodes(node.arguments) if isinstance(n, s.NameRef))
                changed.update(name.name.lower() for name in names)
    steady: dict[str, s.Expression] = {}
    for item in (item for module in modules for item in module.items):
        match item:
            case s.Data(
                type=type, name=name, dimensions=(), value=s.AggregateNode(items=(first, *_))
            ) if name.lower() not in changed:
                number = literal_number(first)
                if number is not None and (number > 0 or type.lower() == SPOT_DATA):
                    steady[name.lower()] = first
    return steady


def _module_routines(module: s.Module) -> list[s.Routine]:
    return [item for item in module.items if isinstance(item, s.Routine)]
