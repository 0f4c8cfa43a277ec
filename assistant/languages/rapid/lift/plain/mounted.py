r"""Tools and work objects that a program changes: their parts, and after them the whole.

`grip.tframe.trans.z:=120;` becomes `grip_tframe.trans.z:=120;` and `grip:=grip_tframe;`: the
pseudo-program takes the name of a tool or frame in an expression for its pose. A work object is
`table:=PoseMult(table_uframe,table_oframe);`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from assistant.languages.rapid.lift.plain.layouts import RecordLayouts
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import numbers
from assistant.languages.rapid.tree.walk import nodes, root
from assistant.languages.records import frame_of, tool_of
from assistant.program.geometry import IDENTITY

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

Body = tuple[s.StatementNode, ...]


def steady_types(modules: Sequence[s.Module], layouts: RecordLayouts) -> frozenset[str]:
    """Which of both types say of each value, anywhere, that nothing moves it but its pose.

    A tool is on the robot, a work object stands in the room; the program changes neither.
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
                    sure = {**_STATIONARY[type], **_NO_UNIT}.get(name.lower())
                    if sure is not None and numbers(value) != sure:
                        found.discard(type)
    return frozenset(found)


def _is_steady(type: str, value: Any) -> bool:
    if not isinstance(value, s.AggregateNode):
        return True  # another of them, or values that are looked at by themselves
    said = numbers(value)
    if type == TOOL:
        tool = tool_of(said)
        return tool is None or tool.held
    frame = frame_of(said)
    return frame is None or not (frame.held or frame.mechanism)


def _unsteady(items: Sequence[Any]) -> Iterator[str]:
    """The type that values in brackets are of, if they say that something else moves it."""
    match items:
        case (s.BoolLiteral(held), s.AggregateNode(), s.AggregateNode()):
            if not held:
                yield TOOL
        case (s.BoolLiteral(held), fixed, mechanism, s.AggregateNode(), s.AggregateNode()):
            if held or numbers(fixed) is not True or numbers(mechanism) != "":
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
    """names: of its parts, by their ways. displaced: a pose that is put behind work objects.

    steady: nothing else changes it, so that parts which say nothing are left out.
    """
    parts = _POSES[type]
    frame = frame_of(numbers(node.value)) if steady and displaced and type == FRAME else None
    if frame is not None:
        poses = zip(parts, (frame.user, frame.object), strict=True)
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
            data = [node for node in made.body if isinstance(node, s.Data)]
            made = replace(made, body=(*data, *wholes.first(), *made.body[len(data) :]))
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

    def body(self, body: Body) -> Body:
        made: list[s.StatementNode] = []
        for at, node in enumerate(body):
            made.append(self.inside(node))
            following = body[at + 1] if at + 1 < len(body) else None
            later = self.changed(following) if isinstance(following, s.Assignment) else {}
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
        """Whether a routine may change what it is given."""
        name = call.name.lower() if isinstance(call.name, str) else ""
        known = signature(name)
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
            case s.CompactIf(condition, statement) if self.changed(statement):
                return s.IfThen((s.IfBranch(condition, self.body((statement,))),), span=node.span)
            case s.ForLoop() | s.WhileLoop():
                return replace(node, body=self.body(node.body))
        return node
