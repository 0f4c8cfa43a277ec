r"""Moves in work objects that a program changes, as moves in the robot's base frame.

`MoveL p,v100,fine,t\WObj:=w;` becomes `placed:=target_in(p,w.uframe,w.oframe);` and `MoveL
placed,v100,fine,t;` if something assigns to `w`, which is then data like any other. The target
keeps its configuration.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lift.plain.layouts import Layouts
from assistant.languages.rapid.lift.plain.library import IN_FRAME, call_of, library
from assistant.languages.rapid.lift.plain.scopes import Fresh
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import numbers
from assistant.languages.rapid.tree.walk import inner_names, nodes, root
from assistant.languages.records import frame_of
from assistant.program.rewriting import rewrite

TARGETS: Final[Mapping[str, int]] = {"movel": 1, "movej": 1, "movec": 2}
"""How many targets the moves begin with."""
OPTION: Final = "wobj"
_DISPLACED: Final = frozenset(("pdispon", "pdispset"))
"""What moves later targets in their work objects."""
_STANDING: Final = frozenset(("crobt", "cpos"))
"""Without a work object they read in that of the move before."""

Body = tuple[s.StatementNode, ...]


def with_still_frames(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules with such moves; themselves if there are none."""
    named = _moving(modules)
    if not named:
        return modules
    fresh = Fresh(modules)
    variables = fresh("placed"), fresh("passed")
    return tuple(_module(module, named, variables) for module in modules)


def _moving(modules: Sequence[s.Module]) -> frozenset[str]:
    """Work objects in lower case that are assigned to, and that only moves are given."""
    layouts = Layouts(modules)
    items = [item for module in modules for item in module.items]
    routines = [item for item in items if isinstance(item, s.Routine)]
    declared: dict[str, list[s.Data]] = {}
    for item in items:
        if isinstance(item, s.Data):
            declared.setdefault(item.name.lower(), []).append(item)
    frames = {
        name for name, own in declared.items() if len(own) == 1 and _is_still(own[0], layouts)
    }
    frames -= {name.lower() for name in inner_names(routines)}
    own = {one.name.lower() for one in routines}
    if not frames or not own.isdisjoint(one.name.lower() for one in library()):
        return frozenset()
    changed: set[str] = set()
    given: dict[str, int] = dict.fromkeys(frames, 0)
    moved: dict[str, int] = dict.fromkeys(frames, 0)
    for node in nodes(tuple(modules)):
        match node:
            case s.ProcedureCall() | s.FunctionCall() if _displaces(node):
                return frozenset()
            case s.ProcedureCall() if (key := _frame(node)) in frames:
                moved[key] += 1
            case s.Assignment(target) if (base := root(target)) is not None:
                changed.add(base.name.lower())
            case s.MoveRunNode(run):
                frames -= {one.frame.lower() for one in run.motions.table if one.frame}
        match node:
            case s.ProcedureCall(_, arguments) | s.FunctionCall(_, arguments):
                for argument in arguments:
                    held: Any = argument
                    one = held.variable if isinstance(held, s.Conditional) else held.value
                    if isinstance(one, s.NameRef) and one.name.lower() in given:
                        given[one.name.lower()] += 1
    return frozenset(n for n in frames & changed if moved[n] and moved[n] == given[n])


def _is_still(item: s.Data, layouts: Layouts) -> bool:
    """Whether data is one work object that stands in the room."""
    if layouts.base(item.type) != "wobjdata" or item.dimensions or item.storage == "CONST":
        return False
    frame = frame_of(numbers(item.value))
    return frame is not None and not frame.held and not frame.mechanism


def _displaces(call: s.ProcedureCall | s.FunctionCall) -> bool:
    """Whether what a call does depends on the work object of a move elsewhere."""
    key = str(call.name).lower()
    options = (one.name.lower() for one in call.arguments if isinstance(one, s.Option))
    return key in _DISPLACED or (key in _STANDING and OPTION not in options)


def _frame(call: Any) -> str:
    """The work object in lower case of a move that can be said without it, else nothing."""
    if not isinstance(call, s.ProcedureCall) or not isinstance(call.name, str):
        return ""
    count = TARGETS.get(call.name.lower())
    if count is None:
        return ""
    first = [a for a in call.arguments if isinstance(a, s.Positional)][:count]
    if len(first) < count or any(isinstance(one.value, s.Placeholder) for one in first):
        return ""
    for one in call.arguments:
        if isinstance(one, s.Option) and one.name.lower() == OPTION:
            return one.value.name.lower() if isinstance(one.value, s.NameRef) else ""
    return ""


def _module(module: s.Module, named: frozenset[str], variables: tuple[str, str]) -> s.Module:
    """A module whose moves are in the base frame where they were in one of the work objects."""

    def body(statements: Body) -> Body:
        return tuple(made for node in statements for made in _said(node, named, variables))

    def change(node: Any) -> Any:
        match node:
            case s.IfThen(branches, otherwise):
                parts = tuple(replace(one, body=body(one.body)) for one in branches)
                other = None if otherwise is None else body(otherwise)
                return replace(node, branches=parts, otherwise=other)
            case s.TestOf(_, cases, otherwise):
                chosen = tuple(replace(one, body=body(one.body)) for one in cases)
                other = None if otherwise is None else body(otherwise)
                return replace(node, cases=chosen, otherwise=other)
            case s.CompactIf(condition, statement) if _frame(statement) in named:
                return s.IfThen((s.IfBranch(condition, body((statement,))),), span=node.span)
            case s.ForLoop() | s.WhileLoop() | s.Handler():
                return replace(node, body=body(node.body))
            case s.Routine():
                return _declaring(replace(node, body=body(node.body)), variables)
        return node

    asked = any(_frame(node) in named for node in nodes(module))
    return rewrite(module, change, ()) if asked else module


def _declaring(routine: s.Routine, variables: tuple[str, str]) -> s.Routine:
    """A routine with the variables that it uses."""
    used = {node.name for node in nodes(routine) if isinstance(node, s.NameRef)}
    data = tuple(s.Data("", "VAR", "robtarget", name) for name in variables if name in used)
    return replace(routine, body=(*data, *routine.body))


def _said(
    node: s.StatementNode, named: frozenset[str], variables: tuple[str, str]
) -> Iterator[s.StatementNode]:
    if not isinstance(node, s.ProcedureCall) or (key := _frame(node)) not in named:
        yield node
        return
    count, left = TARGETS[str(node.name).lower()], list(variables)
    user, of = (s.Component(s.NameRef(key), part) for part in ("uframe", "oframe"))
    arguments: list[s.Argument] = []
    for one in node.arguments:
        match one:
            case s.Positional(target) if count:
                count -= 1
                place = s.NameRef(left.pop(0))
                yield s.Assignment(place, call_of(IN_FRAME, target, user, of), span=node.span)
                arguments.append(replace(one, value=place))
            case s.Option(name) if name.lower() == OPTION:
                continue
            case _:
                arguments.append(one)
    yield replace(node, arguments=tuple(arguments))
