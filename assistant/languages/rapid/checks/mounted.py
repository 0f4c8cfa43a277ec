"""Rules of tools and work objects: values that no controller moves with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from assistant.base.diagnostics import Severity
from assistant.languages.checks.registry import Found
from assistant.languages.rapid.checks import plain_rules as rules
from assistant.languages.rapid.checks.module_view import RuleContext, Task
from assistant.languages.rapid.checks.motions import MOVE_WORDS
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import name_of, option, positional
from assistant.languages.rapid.tree.gather import literal_values
from assistant.languages.rapid.tree.walk import nodes, root
from assistant.languages.records import shape
from assistant.languages.signatures import Signature

TOOL: Final = "tooldata"
FRAME: Final = "wobjdata"
LOAD: Final = "loaddata"
EQUIPMENT_SHAPES: Final[Mapping[str, str]] = {
    TOOL: "b[[nnn][nnnn]][n[nnn][nnnn]nnn]",
    FRAME: "bbt[[nnn][nnnn]][[nnn][nnnn]]",
    LOAD: "n[nnn][nnnn]nnn",
}
"""By type the form of a value that is written out."""
FLANGE: Final = "tool0"
BASE: Final = "wobj0"
_HOLDS: Final = frozenset(("gripload",))
"""Instructions, beside moves, that take a load and leave it as it is."""


def equipment_values(look: RuleContext) -> Found:
    """Tools, work objects and loads with values that no controller takes.

    Data that a program gives other values is left out: it may begin with anything.
    """
    given = look.task.once(_given_values)
    moved = look.task.once(_moved_equipment)
    for data in look.all(s.Data):
        type = data.type.lower()
        if type not in EQUIPMENT_SHAPES or data.value is None or data.name.lower() in given:
            continue
        used = data.name.lower() in moved
        for node, value in _equipment_records(data.value, len(data.dimensions)):
            if shape(value) == EQUIPMENT_SHAPES[type]:
                yield from _equipment_value(look, data, node, type, value, used)


def _equipment_value(
    look: RuleContext, data: s.Data, node: s.Node, type: str, value: list[Any], used: bool
) -> Found:
    if not all(map(any, _equipment_orientations(type, value))):
        severity = Severity.ERROR if used else Severity.WARNING
        yield look.finding(rules.NO_ORIENTATION, node, name=data.name, more="", severity=severity)
    if type == FRAME and not value[1] and not value[2]:
        yield look.finding(rules.NO_UNIT, node, name=data.name)
    if type == TOOL and value[2][0] <= 0:
        yield look.finding(rules.NO_MASS, node, name=data.name, mass=value[2][0])


def _equipment_orientations(type: str, value: list[Any]) -> list[list[float]]:
    match type:
        case "tooldata":
            return [value[1][1], value[2][2]]
        case "wobjdata":
            return [value[3][1], value[4][1]]
    return [value[2]]


def _equipment_records(value: s.Expression, depth: int) -> Iterator[tuple[s.Node, Any]]:
    """A value, or those of an array, with the node that each is written at."""
    if depth and isinstance(value, s.AggregateNode):
        for item in value.items:
            yield from _equipment_records(item, depth - 1)
    elif not depth and isinstance(value, s.AggregateNode):
        yield value, literal_values(value)


def held_pairs(look: RuleContext) -> Found:
    """Moves with a tool and a work object that the robot both holds, or neither of which.

    The first move of each pair.
    """
    given = look.task.once(_given_values)
    seen: set[tuple[str, str]] = set()
    for routine in look.routines:
        for node in nodes(routine):
            for row, tool, frame in _tools_and_frames(node):
                pair = (tool.lower(), frame.lower() or BASE)
                if pair in seen or not given.isdisjoint(pair):
                    continue
                seen.add(pair)
                held = [
                    _robot_holds(look, routine, *one)
                    for one in zip(pair, (TOOL, FRAME), strict=True)
                ]
                if None not in held and held[0] == held[1]:
                    rule = rules.HELD_TWICE if held[0] else rules.HELD_NOWHERE
                    yield look.finding(rule, node, row=row, tool=tool, frame=frame or BASE)


def _tools_and_frames(node: s.Node) -> Iterator[tuple[int, str, str]]:
    """Names of the tool and the work object that a statement moves with, empty for wobj0.

    Tools and work objects of a run of moves, with the first row of each.
    """
    match node:
        case s.MoveRunNode(run):
            chosen, rows = np.unique(run.motions.index, return_index=True)
            for at in np.argsort(rows):
                motion = run.motions.table[int(chosen[at])]
                yield int(rows[at]), motion.tool, motion.frame
        case s.ProcedureCall(str(word)) if word.lower() in MOVE_WORDS:
            plain, wobj = positional(node), option(node, "wobj")
            tool = name_of(plain[-1]) if plain else ""
            frame = name_of(wobj.value) if wobj else ""
            if tool and (frame or not wobj):
                yield 0, tool, frame


def _robot_holds(look: RuleContext, routine: s.Routine, name: str, type: str) -> bool | None:
    """True if the robot holds a tool or work object, None if that is not known."""
    found = look.find(name, routine)
    if found is None:
        return {FLANGE: True, BASE: False}.get(name)
    data = found.node
    if not isinstance(data, s.Data) or data.type.lower() != type or data.dimensions:
        return None
    value = literal_values(data.value)
    return bool(value[0]) if shape(value) == EQUIPMENT_SHAPES[type] else None


def _moved_equipment(task: Task) -> set[str]:
    """Lower-case names of the tools, work objects and loads that some instruction uses."""
    found: set[str] = set()
    for node in nodes(task.modules):
        match node:
            case s.MoveRunNode(run):
                found |= {name.lower() for m in run.motions.table for name in (m.tool, m.frame)}
            case s.ProcedureCall() if _leaves_equipment(node):
                found |= _argument_names(node)
    return found


def _given_values(task: Task) -> set[str]:
    """Lower-case names that are assigned to, or handed over to what may change them."""
    found: set[str] = set()
    for node in nodes(task.modules):
        match node:
            case s.Assignment(target):
                data = root(target)
                found |= set() if data is None else {data.name.lower()}
            case s.ProcedureCall() if not _leaves_equipment(node):
                found |= _argument_names(node)
            case s.FunctionCall(word) if signature(word) is None:
                found |= _argument_names(node)
            case s.StringLiteral(value):  # SetDataVal finds data by name
                found.add(value.lower())
    return found


def _leaves_equipment(call: s.ProcedureCall) -> bool:
    """True for a move, or another instruction that leaves its tool, work object and load alone."""
    if not isinstance(call.name, str):
        return False
    low = call.name.lower()
    if low in MOVE_WORDS or low in _HOLDS:
        return True
    routine = signature(low)
    return routine is not None and {"speeddata", TOOL} <= set(
        _parameter_types(routine)
    )  # a process moves


def _parameter_types(routine: Signature) -> Iterator[str]:
    for slot in routine.slots:
        yield from (one.type for one in slot.alternatives)


def _argument_names(call: s.ProcedureCall | s.FunctionCall) -> set[str]:
    found = set()
    for one in call.arguments:
        value = getattr(one, "value", None)
        data = root(value) if value is not None else None
        if data is not None:
            found.add(data.name.lower())
    return found
