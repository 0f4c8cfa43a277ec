"""Rules of values that are written out: targets, frames, tools, work objects and loads.

Quaternions have unit length, `confdata` has whole quadrants and a cfx that an arm of six axes has;
tools have a mass; the robot holds either the tool or the work object of a move, never both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, Final, NamedTuple

import numpy as np

from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import Rule, Severity
from assistant.languages.checks.registry import Found, like_it
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks.motions import MOVE_WORDS
from assistant.languages.rapid.checks.rule_context import RuleContext, Task, Types
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number, literal_target, literal_values
from assistant.languages.rapid.tree.syntax import PLAIN_MOVES
from assistant.languages.rapid.tree.walk import name_of, nodes, option, positional, root
from assistant.languages.records import shape
from assistant.languages.signatures import Signature

_OFF_UNIT: Final = 1e-5
"""Most that the squares of a quaternion may miss 1 by; beyond it NOrient has to mend it."""
_NO_QUATERNION: Final = 1e-3
"""Beyond this it is no rounded quaternion: four decimals are off by 2e-4 at most."""
_MOST_TURNS: Final = 127
"""Quadrants are counted in turns of an axis, of which no arm has 32."""
_CFX_VALUES: Final = 8
"""Values of cfx of an arm with six axes, from 0."""
_SEVEN_AXIS_CODES: Final = (10, 9999)
"""An arm with seven axes has a code of up to four digits; those of one are as above."""

_MOST_TARGETS_REPORTED: Final = 100
"""Targets of one module with the same mistake that are reported one by one."""

_FindingFields = Callable[[int], dict[str, Any]]
"""Fields of the finding at a row; `severity` may be one of them."""


class _FaultyRows(NamedTuple):
    """Rows (k,) of a node that have a mistake. node: that is reported, or a run."""

    node: s.Node
    rows: Rows
    words: _FindingFields


class _WrittenTargets(NamedTuple):
    """Targets that are written out: values (n, 17) of a node, and what a row is called."""

    node: s.Node
    values: Floats
    name: Callable[[int], str]


def quaternion_lengths(look: RuleContext) -> Found:
    """They have unit length; all zero is a place holder that no robot can move to."""
    types = look.once(Types)
    written = [(one.node, one.values[:, 3:7], one.name) for one in look.once(_written_targets)]
    for data in look.all(s.Data):
        if isinstance(data.value, s.AggregateNode):
            depth = len(data.dimensions)
            target = data.storage == "CONST" and data.type.lower() == "robtarget"
            for one, numbers in _orientations(types, data.value, data.type, depth):
                # Only a constant that is a place holder is reported; other data may get its value
                # later.
                if target or any(numbers):
                    written.append((one, np.array([numbers]), _constant_name(data.name)))
    lengths: list[_FaultyRows] = []
    zeros: list[_FaultyRows] = []
    for node, q, name in written:
        off = np.abs((q * q).sum(axis=1) - 1.0)
        zero = ~q.any(axis=1)
        lengths.append(
            _FaultyRows(node, np.flatnonzero((off > _OFF_UNIT) & ~zero), _length_fields(name, off))
        )
        zeros.append(_FaultyRows(node, np.flatnonzero(zero), _name_fields(name)))

    def place(single: s.Node) -> s.Node:
        """The orientation of a declaration."""
        if not isinstance(single, s.Data) or not isinstance(single.value, s.AggregateNode):
            return _target_of(single)
        return next(node for node, _ in _orientations(types, single.value, single.type, 0))

    yield from _report_rows(look, rules.NOT_UNIT, lengths, place)
    yield from _report_rows(look, rules.NO_ORIENTATION, zeros, place)


def configurations(look: RuleContext) -> Found:
    """Quadrants and cfx are whole numbers, and cfx is one that an arm of six axes has."""
    written = list(look.once(_written_targets))
    for data in look.all(s.Data):
        if data.value is not None and data.type.lower() == "robtarget":
            for node, values in _target_rows(data.value):
                written.append(_WrittenTargets(node, values, _constant_name(data.name)))
    odd: list[_FaultyRows] = []
    unknown: list[_FaultyRows] = []
    for node, values, name in written:
        confdata = values[:, 7:11]
        whole = np.isfinite(confdata) & (confdata == np.round(confdata))
        quadrants = (whole[:, :3] & (np.abs(confdata[:, :3]) <= _MOST_TURNS)).all(axis=1)
        cfx = confdata[:, 3]
        known = ((cfx >= 0) & (cfx < _CFX_VALUES)) | (
            (cfx >= _SEVEN_AXIS_CODES[0]) & (cfx <= _SEVEN_AXIS_CODES[1])
        )
        sound, words = quadrants & whole[:, 3], _confdata_fields(name, confdata)
        odd.append(_FaultyRows(node, np.flatnonzero(~sound), words))
        unknown.append(_FaultyRows(node, np.flatnonzero(sound & ~known), words))
    yield from _report_rows(look, rules.NO_QUADRANTS, odd, _target_of)
    yield from _report_rows(look, rules.NO_CFX, unknown, _target_of)


def _written_targets(look: RuleContext) -> list[_WrittenTargets]:
    """Targets in runs, and those that moves are given."""
    found = [_WrittenTargets(n, n.run.values, n.run.names.name) for n in look.all(s.TargetRunNode)]
    for node in look.all(s.MoveRunNode):
        if node.run.values is not None:
            words = [PLAIN_MOVES[kind] for kind in node.run.kinds.tolist()]
            found.append(_WrittenTargets(node, node.run.values, words.__getitem__))
    for call in look.all(s.ProcedureCall):
        for argument in call.arguments:
            if isinstance(argument, s.Positional):
                of_call = _target_rows(argument.value)
                name = _constant_name(str(call.name))
                found += [_WrittenTargets(node, values, name) for node, values in of_call]
    return found


def _constant_name(name: str) -> Callable[[int], str]:
    return lambda _: name


def _name_fields(name: Callable[[int], str]) -> _FindingFields:
    return lambda row: {"name": name(row)}


def _length_fields(name: Callable[[int], str], off: Floats) -> _FindingFields:
    """off: (n,) by which the squares of each row miss 1."""

    def words(row: int) -> dict[str, Any]:
        severity = Severity.ERROR if off[row] > _NO_QUATERNION else Severity.WARNING
        return {"name": name(row), "off": float(off[row]), "severity": severity}

    return words


def _confdata_fields(name: Callable[[int], str], confdata: Floats) -> _FindingFields:
    """confdata: (n, 4) of the rows."""

    def words(row: int) -> dict[str, Any]:
        numbers = [f"{value:g}" for value in confdata[row]]
        return {"name": name(row), "numbers": ", ".join(numbers), "cfx": numbers[-1]}

    return words


def _target_rows(value: s.Expression) -> Iterator[tuple[s.Node, Floats]]:
    """A target, or those of an array, at its own place: (1, 17)."""
    numbers = literal_target(value)
    if numbers is not None:
        yield value, np.array([numbers])
    elif isinstance(value, s.AggregateNode):
        for item in value.items:
            if isinstance(item, s.AggregateNode):
                yield from _target_rows(item)


def _target_of(single: s.Node) -> s.Node:
    """The target that a line has."""
    match single:
        case s.ProcedureCall(_, (s.Positional(value), *_)):
            return value
        case s.Data(value=s.AggregateNode() as value):
            return value
    return single


def _report_rows(
    look: RuleContext, rule: Rule, faults: Sequence[_FaultyRows], place: Callable[[s.Node], s.Node]
) -> Found:
    """The rule's findings in the order of the text, the first MOST of them one by one.

    place: of a line of a run that is read alone, the node that is reported.
    """
    listed = [fault for fault in faults if len(fault.rows)]
    listed.sort(key=lambda fault: fault.node.span.start if fault.node.span else 0)
    # The count goes with the last finding that is reported one by one.
    count = sum(len(fault.rows) for fault in listed)
    each = ((fault, int(row)) for fault in listed for row in fault.rows)
    for number, (fault, row) in enumerate(islice(each, _MOST_TARGETS_REPORTED), 1):
        node = fault.node
        if isinstance(node, s.RunNode):
            node = place(look.single(node, row))
        more = like_it(count - _MOST_TARGETS_REPORTED if number == _MOST_TARGETS_REPORTED else 0)
        yield look.finding(rule, node, more=more, **fault.words(row))


def _orientations(
    types: Types, value: s.AggregateNode, type: str, depth: int
) -> Iterator[tuple[s.AggregateNode, list[float]]]:
    """Every orientation that is written out in a value of a type, arrays `depth` levels deep."""
    base = types.base(type) or ""
    if depth:
        inner = [(part, type, depth - 1) for part in value.items]
    elif base == "orient":
        numbers = [literal_number(item) for item in value.items]
        known = [float(n) for n in numbers if n is not None]
        if len(known) == len(numbers) == 4:
            yield value, known
        return
    else:
        components = types.components(base) or {}
        if len(components) != len(value.items):
            return
        inner = [(part, of, 0) for part, of in zip(value.items, components.values(), strict=True)]
    for part, of, left in inner:
        if isinstance(part, s.AggregateNode):
            yield from _orientations(types, part, of, left)


TOOL: Final = "tooldata"
FRAME: Final = "wobjdata"
LOAD: Final = "loaddata"
_EQUIPMENT_SHAPES: Final[Mapping[str, str]] = {
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
        # A value that the program replaces may be anything before.
        if type not in _EQUIPMENT_SHAPES or data.value is None or data.name.lower() in given:
            continue
        used = data.name.lower() in moved
        for node, value in _equipment_records(data.value, len(data.dimensions)):
            if shape(value) == _EQUIPMENT_SHAPES[type]:
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
                # Data that a program changes may have other values by then.
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
            # One row for each combination of settings, in the order of the text.
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
    return bool(value[0]) if shape(value) == _EQUIPMENT_SHAPES[type] else None


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
