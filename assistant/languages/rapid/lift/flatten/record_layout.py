"""The layout of records: their parts, and the variables that hold a part each.

A tool, frame, speed or zone in a record stays one value where a move or another instruction gets
that component. A parameter that is a tool or work object in its components alone gets the parts of
any. A tool or work object that the program changes has variables for its parts, and gets its value
from them after each change: `grip.tframe.trans.z:=120;` becomes `grip_tframe.trans.z:=120;` and
`grip:=grip_tframe;`, as the pseudo-program takes the name of a tool or frame in an expression for
its pose. A work object is `table:=PoseMult(table_uframe,table_oframe);`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.languages.rapid.tables.constants import VALUE_OF_TYPE
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tables.predefined import types as predefined
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_values
from assistant.languages.rapid.tree.walk import nodes, root
from assistant.languages.records import frame_of, tool_of
from assistant.languages.signatures import MOST_ALIASES, Type
from assistant.program.geometry import IDENTITY

ComponentPath = tuple[str, ...]
"""Names of components in lower case, the outermost first; empty of the whole."""

SETTING_TYPES: Final = frozenset(("tooldata", "wobjdata", "speeddata", "zonedata"))
"""Records that moves name: they have separate tables in the pseudo-program."""
READ_ONLY_TYPES: Final = SETTING_TYPES | {"loaddata"}
"""Types of data that instructions only read, though they want them to be PERS."""
SPEED_AND_ZONE: Final = frozenset(("speeddata", "zonedata"))
"""Those of them that a move may also state by their parts."""
_MOST_PARTS: Final = 400
"""Maximum parts of one record; a larger one is not split."""


@dataclass(frozen=True, slots=True)
class Part:
    """One value in a record. name: as its type spells it. type: without aliases, lower case."""

    path: ComponentPath
    name: str
    type: str


class RecordLayouts:
    """The types of a program: its own and those that every controller knows.

    A tool, frame, speed or zone in a record stays one value where a move or another instruction is
    given the component. apart: types of those that do not.
    """

    def __init__(self, modules: Sequence[s.Module], apart: frozenset[str] = frozenset()) -> None:
        self._whole = SETTING_TYPES - apart
        self._named = frozenset(_passed_components(modules))
        self._types: dict[str, Type] = dict(predefined())
        self._parts: dict[str, tuple[Part, ...] | None] = {}
        declared: dict[str, list[Type]] = {}
        for item in (item for module in modules for item in module.items):
            match item:
                case s.Alias(_, of, name):
                    declared.setdefault(name.lower(), []).append(Type(name, "ALIAS", of))
                case s.Record(_, name, components):
                    known = {inner: type for type, inner in components}
                    # A component that occurs twice has no single type.
                    whole = len(known) == len(components)
                    found = Type(name, "RECORD", components=known if whole else None)
                    declared.setdefault(name.lower(), []).append(found)
        for name, types in declared.items():
            # Modules may each have a type of that name; only equal ones have known parts.
            said = {(one.kind, one.of.lower(), *(one.components or {}).items()) for one in types}
            self._types[name] = types[0] if len(said) == 1 else Type(name, "OTHER")

    def base(self, type: str) -> str:
        """The type itself in lower case, of an alias what it stands for."""
        low = type.lower()
        # Aliases of a circle would never end.
        for _ in range(MOST_ALIASES):
            found = self._types.get(low)
            if found is None or not found.of:
                break
            low = found.of.lower()
        return low

    def kind(self, type: str) -> str:
        """Return the kind of a type as its table names it, empty for an undeclared type."""
        found = self._types.get(self.base(type))
        return "" if found is None else found.kind

    def components(self, type: str) -> tuple[tuple[str, str], ...]:
        """Names and types of the components of a record, none of any other type."""
        found = self._types.get(self.base(type))
        return () if found is None else tuple((found.components or {}).items())

    def component(self, type: str, name: str) -> str | None:
        """Return the type of a component without aliases, None for an unknown component."""
        low = name.lower()
        found = (of for inner, of in self.components(type) if inner.lower() == low)
        return next(map(self.base, found), None)

    def is_whole(self, type: str) -> bool:
        """True if the pseudo-program has one variable for a value of a type."""
        return self.base(type) in VALUE_OF_TYPE

    def parts(self, type: str) -> tuple[Part, ...] | None:
        """The values in a record, None of what is no record or not known in all its parts."""
        base = self.base(type)
        if base not in self._parts:
            self._parts[base] = None  # a record that holds itself ends here
            found = None if self.is_whole(base) else self._found(base)
            self._parts[base] = found if found and len(found) <= _MOST_PARTS else None
        return self._parts[base]

    def _found(self, base: str) -> tuple[Part, ...] | None:
        listed: list[Part] = []
        for name, of in self.components(base):
            kind = self.base(of)
            inner = self.parts(kind)
            # A type whose inside nobody knows is one value.
            unknown = inner is None and kind in self._types and not self.components(kind)
            # A component that is passed by its name has to stay one value.
            named = kind in self._whole and name.lower() in self._named
            if unknown or named or self.is_whole(kind):
                listed.append(Part((name.lower(),), name, kind))
            elif inner is None:
                return None
            else:
                listed += (
                    Part((name.lower(), *one.path), f"{name}_{one.name}", one.type) for one in inner
                )
        return tuple(listed) or None


def _passed_components(modules: Sequence[s.Module]) -> Iterator[str]:
    """Components in lower case that calls are given as they are."""
    for node in nodes(tuple(modules)):
        match node:
            case s.Positional(s.Component(_, name)) | s.Option(_, s.Component(_, name)):
                yield name.lower()


RecordValue = Mapping[ComponentPath, s.Expression]
"""A value of a record, part by part."""


class NotExpressible(Exception):
    """A construct that a program with plain data cannot express. why: a clause."""

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


RoutineTable = Mapping[str, s.Routine]
"""Routines whose names are theirs alone, by lower-case name."""


def component_parameters(routines: RoutineTable, layouts: RecordLayouts) -> frozenset[int]:
    """The `id` of each such parameter."""
    found: dict[tuple[str, str], s.ParameterNode] = {}
    for key, routine in routines.items():
        for group in routine.parameters:
            for one in group.alternatives:
                if isinstance(one, s.ParameterNode) and not one.dimensions and not group.optional:
                    if layouts.base(one.type) in SETTING_TYPES - SPEED_AND_ZONE:
                        found[key, one.name.lower()] = one
    handed = {key: set(_receiving_parameters(routines, key[0], key[1])) for key in found}
    # Removing one parameter may rule out those that are passed to it.
    while wrong := [place for place in found if not handed[place] <= found.keys()]:
        for place in wrong:
            del found[place]
    return frozenset(map(id, found.values()))


_ANYWHERE: Final = ("", "")
"""Stands for what takes a tool or work object by its name."""


def _receiving_parameters(
    routines: RoutineTable, routine: str, name: str
) -> Iterator[tuple[str, str]]:
    """Yield the parameters to which a parameter is passed complete."""
    said = known = 0
    for node in nodes(routines[routine]):
        match node:
            case s.NameRef():
                said += _is_named(node, name)
            case s.Component(inner) | s.Group(inner) | s.ReturnFrom(inner):
                known += _is_named(inner, name)
            case s.Assignment(one, two) | s.Infix(_, one, two):
                known += _is_named(one, name) + _is_named(two, name)
            # A move needs the name of its tool and frame.
            case s.MoveRunNode(run):
                named = {n.lower() for m in run.motions.table for n in (m.tool, m.frame)}
                if name in named:
                    yield _ANYWHERE
            case s.ProcedureCall(str(called), arguments) | s.FunctionCall(str(called), arguments):
                for to in _argument_parameters(routines.get(called.lower()), arguments, name):
                    known += 1
                    yield to
    # Any mention beside the counted ones may take the tool or work object by its name.
    if said != known:
        yield _ANYWHERE


def _argument_parameters(
    routine: s.Routine | None, arguments: Sequence[s.Argument], name: str
) -> Iterator[tuple[str, str]]:
    """Yield the required parameters of the program to which arguments pass a name, or a marker for
    any other receiver.
    """
    required = iter(() if routine is None else [g for g in routine.parameters if not g.optional])
    for argument in arguments:
        if isinstance(argument, s.Positional):
            group = next(required, None)
            one = None if group is None else group.alternatives[0]
            if _is_named(argument.value, name):
                if routine is not None and isinstance(one, s.ParameterNode):
                    yield routine.name.lower(), one.name.lower()
                else:
                    yield _ANYWHERE


def _is_named(node: Any, name: str) -> bool:
    return isinstance(node, s.NameRef) and node.name.lower() == name


TOOL: Final = "tooldata"
FRAME: Final = "wobjdata"
_POSES: Final[Mapping[str, tuple[str, ...]]] = {
    TOOL: ("tframe",), FRAME: ("uframe", "oframe")
}  # fmt: skip
"""Components that say where a tool or work object is, the outer one first."""
_STATIONARY: Final = {TOOL: {"robhold": True}, FRAME: {"robhold": False, "ufprog": True}}
"""Components that say what carries it, and what all that can be changed have."""
_NO_UNIT: Final = {"ufmec": ""}
_ENTRY: Final = "main"

_Body = tuple[s.StatementNode, ...]


def steady_types(modules: Sequence[s.Module], layouts: RecordLayouts) -> frozenset[str]:
    """Return which of both types are stationary: no value of the type, anywhere, lets anything but
    its pose move it.

    A tool is mounted on the robot and a work object is fixed in the room; the program changes
    neither.
    """
    found = set(_POSES)
    for node in nodes(tuple(modules)):
        match node:
            case s.Data(type=type, value=value) if (base := layouts.base(type)) in found:
                if value is not None and not _is_steady(base, value):
                    found.discard(base)
            case s.AggregateNode(items):
                found -= set(_unsteady(items))
            case s.Assignment(s.Component(_, name), value):
                for type in tuple(found):
                    # A component that carries it may be assigned only the value that all of them
                    # have.
                    sure = {**_STATIONARY[type], **_NO_UNIT}.get(name.lower())
                    if sure is not None and literal_values(value) != sure:
                        found.discard(type)
    return frozenset(found)


def _is_steady(type: str, value: Any) -> bool:
    if not isinstance(value, s.AggregateNode):
        return True  # another of them, or values that are looked at by themselves
    said = literal_values(value)
    if type == TOOL:
        tool = tool_of(said)
        return tool is None or tool.held
    frame = frame_of(said)
    return frame is None or not (frame.held or frame.mechanism)


def _unsteady(items: Sequence[Any]) -> Iterator[str]:
    """The type that values in brackets are of, if they say that something else moves it."""
    match items:
        # Without a type the shape tells: three values are a tool, five a work object.
        case (s.BoolLiteral(held), s.AggregateNode(), s.AggregateNode()):
            if not held:
                yield TOOL
        case (s.BoolLiteral(held), fixed, mechanism, s.AggregateNode(), s.AggregateNode()):
            if held or literal_values(fixed) is not True or literal_values(mechanism) != "":
                yield FRAME


@dataclass(frozen=True, slots=True)
class ChangedFrame:
    """One that changes. poses: the variables of its parts that tell where it is."""

    name: str
    poses: tuple[str, ...]

    def set(self, node: s.StatementNode | None = None) -> s.Assignment:
        """The statement that gives the whole its pose."""
        value: s.Expression = s.NameRef(self.poses[0])
        for other in self.poses[1:]:
            given = s.Positional(value), s.Positional(s.NameRef(other))
            value = s.FunctionCall("PoseMult", given)
        return s.Assignment(s.NameRef(self.name), value, span=None if node is None else node.span)


def changed_frame(
    node: s.Data,
    type: str,
    names: Mapping[tuple[str, ...], str],
    displaced: str = "",
    steady: bool = False,
) -> ChangedFrame:
    """Return the frame that the program changes. names: of its parts, by their paths. displaced: a
    pose appended to work objects.

    steady: nothing else changes the frame, so that identity parts are omitted.
    """
    parts = _POSES[type]
    frame = frame_of(literal_values(node.value)) if steady and displaced and type == FRAME else None
    if frame is not None:
        poses = zip(parts, (frame.user, frame.object), strict=True)
        # A product with identity would only cost time in every update.
        parts = tuple(part for part, pose in poses if pose != IDENTITY)
    behind = (displaced,) if displaced and type == FRAME else ()
    return ChangedFrame(node.name, (*(names[part,] for part in parts), *behind))


def with_frame_updates(
    modules: Sequence[s.Module], found: Iterable[ChangedFrame]
) -> list[s.Module]:
    """The modules, in which each change of a part of one is followed by that of the whole."""
    by_part: dict[str, list[ChangedFrame]] = {}
    for one in found:
        for part in one.poses:
            by_part.setdefault(part.lower(), []).append(one)
    if not by_part:
        return list(modules)
    items = (item for module in modules for item in module.items)
    own = {item.name.lower() for item in items if isinstance(item, s.Routine)}
    wholes = _FrameUpdates(by_part, own)
    return [_with_module_updates(module, wholes) for module in modules]


def _with_module_updates(module: s.Module, wholes: _FrameUpdates) -> s.Module:
    items: list[s.Item] = []
    for item in module.items:
        made = wholes.routine(item) if isinstance(item, s.Routine) else item
        if isinstance(made, s.Routine) and made.name.lower() == _ENTRY:
            # Comments may be between the data.
            places = (at for at, node in enumerate(made.body, 1) if isinstance(node, s.Data))
            end = max(places, default=0)
            made = replace(made, body=(*made.body[:end], *wholes.first(), *made.body[end:]))
        items.append(made)
    same = all(a is b for a, b in zip(items, module.items, strict=True))
    return module if same else replace(module, items=tuple(items))


class _FrameUpdates:
    def __init__(self, by_part: Mapping[str, Sequence[ChangedFrame]], own: Collection[str]) -> None:
        self.by_part, self.own = by_part, own

    def first(self) -> list[s.Assignment]:
        """All as their parts are at the start, which others may give their first values again."""
        found = dict.fromkeys(one for several in self.by_part.values() for one in several)
        return [one.set() for one in found]

    def routine(self, routine: s.Routine) -> s.Routine:
        if not any(
            isinstance(node, s.NameRef) and node.name.lower() in self.by_part
            for node in nodes(routine)
        ):
            return routine
        handlers = tuple(replace(h, body=self.body(h.body)) for h in routine.handlers)
        return replace(routine, body=self.body(routine.body), handlers=handlers)

    def body(self, body: _Body) -> _Body:
        made: list[s.StatementNode] = []
        for at, node in enumerate(body):
            made.append(self.inside(node))
            following = body[at + 1] if at + 1 < len(body) else None
            # In a row of assignments, the last one that changes the whole updates it.
            later = self.changed(following) if isinstance(following, s.Assignment) else {}
            # A call may use the whole while it changes parts of others, so each call is followed by
            # its update.
            alone = not isinstance(node, s.Assignment)
            made += (one.set(node) for one in self.changed(node) if alone or one not in later)
        return tuple(made)

    def changed(self, node: Any) -> Mapping[ChangedFrame, None]:
        """Those that a statement changes a part of, in their order."""
        places: list[Any] = []
        match node:
            case s.Assignment(target):
                places.append(target)
        if isinstance(node, s.Assignment | s.ProcedureCall):
            for call in nodes(node):
                if isinstance(call, s.ProcedureCall | s.FunctionCall) and self.changes(call):
                    places += (getattr(one, "value", None) for one in call.arguments)
        found = (root(place) for place in places)
        names = (one.name.lower() for one in found if one is not None)
        return {one: None for name in names for one in self.by_part.get(name, ())}

    def changes(self, call: s.ProcedureCall | s.FunctionCall) -> bool:
        """True if a routine may change its arguments."""
        name = call.name.lower() if isinstance(call.name, str) else ""
        known = signature(name)
        # An unknown routine may change everything that it is given.
        if name in self.own or known is None:
            return True
        return any(one.mode for slot in known.slots for one in slot.alternatives)

    def inside(self, node: s.StatementNode) -> Any:
        match node:
            case s.IfThen(branches, otherwise):
                parts = tuple(replace(one, body=self.body(one.body)) for one in branches)
                other = None if otherwise is None else self.body(otherwise)
                return replace(node, branches=parts, otherwise=other)
            case s.TestOf(_, cases, otherwise):
                chosen = tuple(replace(one, body=self.body(one.body)) for one in cases)
                other = None if otherwise is None else self.body(otherwise)
                return replace(node, cases=chosen, otherwise=other)
            # The update is a second statement, which a compact IF cannot hold.
            case s.CompactIf(condition, statement) if self.changed(statement):
                return s.IfThen((s.IfBranch(condition, self.body((statement,))),), span=node.span)
            case s.ForLoop() | s.WhileLoop():
                return replace(node, body=self.body(node.body))
        return node
