"""Values that are written out: numbers, targets, external axes, and runs of plain rows.

Neighbouring plain declarations and moves become one columnar node, however they came about: the
reader of runs and the grammar must give the same tree for the same lines, and a built tree must
equal the one that its text is read as; so all three go through `gathered`.

A cell may state that an external axis, or a mechanical unit that carries a work object, stands
still: `eax_a_stands` is TRUE. Other languages have two axes at most beside those of the arm, and no
components for them.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Rows
from assistant.base.diagnostics import Span
from assistant.languages.rapid.tables.constants import LONGEST_NAME, UNUSED
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.syntax import (
    CIRCULAR,
    FEWEST_IN_RUN,
    PLAIN_MOVES,
    TARGET_PARTS,
    MotionNames,
    MoveRow,
    MoveRun,
    TargetRun,
)
from assistant.languages.rapid.tree.walk import nodes
from assistant.languages.runs import columns as alike
from assistant.program.undeclared_names import BASE_FRAME_SUFFIX

_PLAIN_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)


def gathered(nodes: Iterable[Any]) -> tuple[Any, ...]:
    """The nodes, with every stretch of at least FEWEST_IN_RUN plain rows as one node."""
    listed = list(nodes)
    # Nothing precedes the first comment, so it trails no statement.
    if listed and isinstance(listed[0], s.CommentLine) and listed[0].trailing:
        listed[0] = replace(listed[0], trailing=False)
    # A run has no place for a comment between its rows, so a row with one stays a separate node.
    commented = [isinstance(n, s.CommentLine) and n.trailing for n in (*listed[1:], None)]
    rows = (None if commented[at] else plain_row(node) for at, node in enumerate(listed))
    return tuple(alike.gather_runs(listed, rows, _run_of_rows, _run_node, FEWEST_IN_RUN))


def plain_row(node: Any) -> alike.Row | None:
    """Return the group that a declaration or a move can join, and its row or rows; None for other
    nodes.
    """
    match node:
        case s.TargetRunNode(scope, run):
            return ("targets", scope), run
        case s.MoveRunNode(run):
            return ("moves", run.values is not None), run
        case s.Data(scope=scope, name=name):
            values = _target_values(node)
            return None if values is None else (("targets", scope), (name, values))
        case s.ProcedureCall():
            move = _plain_move(node)
            return None if move is None else (("moves", move.is_written), move)
    return None


def _run_of_rows(rows: list[Any]) -> TargetRun | MoveRun:
    return MoveRun.of(rows) if isinstance(rows[0], MoveRow) else TargetRun.of(rows)


def _run_node(stretch: Sequence[Any], run: TargetRun | MoveRun) -> s.TargetRunNode | s.MoveRunNode:
    first, last = stretch[0].span, stretch[-1].span
    span = Span(first.start, last.end) if first and last else None
    rows = None if span is None else _joined_spans(stretch, span.start)
    if isinstance(run, MoveRun):
        return s.MoveRunNode(run, rows=rows, span=span)
    return s.TargetRunNode(stretch[0].scope, run, rows=rows, span=span)


def _joined_spans(stretch: Sequence[Any], start: int) -> Rows | None:
    """Spans of the rows of several nodes, counted from `start`; None if a node has none."""
    parts: list[Rows] = []
    for node in stretch:
        if node.span is None or (isinstance(node, s.RunNode) and node.rows is None):
            return None
        own = node.rows if isinstance(node, s.RunNode) else [[0, node.span.end - node.span.start]]
        parts.append(np.asarray(own, dtype=np.intp) + (node.span.start - start))
    return np.concatenate(parts)


def _target_values(node: s.Data) -> list[float] | None:
    """The 17 numbers of a plain declared robtarget, None for any other declaration."""
    if (
        node.storage != "CONST"
        or node.type != "robtarget"
        or node.scope not in ("", "LOCAL")
        or node.dimensions
        or not _plain_name(node.name)
    ):
        return None
    return literal_target(node.value)


def literal_target(value: s.Expression | None) -> list[float] | None:
    """The 17 numbers of a robtarget that is written out, None for anything else."""
    if not isinstance(value, s.AggregateNode) or len(value.items) != len(TARGET_PARTS):
        return None
    numbers: list[float] = []
    for part, (start, stop) in zip(value.items, TARGET_PARTS, strict=True):
        if not isinstance(part, s.AggregateNode) or len(part.items) != stop - start:
            return None
        for item in part.items:
            if (number := literal_number(item)) is None or not np.isfinite(number):
                return None
            numbers.append(number)
    return numbers


def literal_number(node: s.Expression) -> float | int | None:
    """A signed number, None for anything else; infinite where a float does not reach it."""
    if isinstance(node, s.Prefix) and isinstance(node.operand, s.NumberLiteral):
        value = literal_number(node.operand)
        if value is None or node.operator == "NOT":
            return None
        return -value if node.operator == "-" else value
    if not isinstance(node, s.NumberLiteral):
        return None
    text = node.text.lower()
    if text[:2] in _NUMBER_BASES:
        digits, base = text[2:], _NUMBER_BASES[text[:2]]
        # `int` refuses very long decimal texts; those beyond the range of a float are infinite
        # anyway.
        if base == _DECIMAL_BASE and math.isinf(float(digits)):
            return math.inf
        value = int(digits, base)
        return value if value <= sys.float_info.max else math.inf
    # Up to 15 digits a whole number is exact as a float too.
    return int(text) if text.isdigit() and len(text) < 16 else float(text)


_DECIMAL_BASE: Final = 10
_NUMBER_BASES: Final = {"0x": 16, "0o": 8, "0b": 2, "0d": _DECIMAL_BASE}


def _plain_name(name: str) -> bool:
    return len(name) <= LONGEST_NAME and _PLAIN_NAME.fullmatch(name) is not None


def _plain_move(node: s.ProcedureCall) -> MoveRow | None:
    r"""`MoveL p,v,z,t\WObj:=w;` or `MoveL [[…],…],v,z,t;`, None for any other call."""
    if node.name not in PLAIN_MOVES:
        return None
    kind, given, frame = PLAIN_MOVES.index(str(node.name)), node.arguments, ""
    if given and isinstance(option := given[-1], s.Option) and option.name == "WObj":
        given, frame = given[:-1], _plain_reference(option.value)
        if not frame:
            return None
    values = [a.value for a in given if isinstance(a, s.Positional) and a.name is None]
    arc = kind == CIRCULAR
    if len(values) != len(given) or len(values) != 4 + arc:
        return None
    # Padded in front, so that a move without a circle point unpacks alike.
    via, to, speed, zone, tool = ["", *map(_plain_reference, values)][-5:]
    # An arc has to name its targets: runs hold one written target a row.
    target = to or (None if arc else literal_target(values[0]))
    if target is None or not (speed and zone and tool) or (arc and not via):
        return None
    return MoveRow(kind, target, via, MotionNames(speed, zone, tool, frame))


def _plain_reference(value: s.Expression | None) -> str:
    """The name that an expression is, empty for any other."""
    return value.name if isinstance(value, s.NameRef) and _plain_name(value.name) else ""


def literal_values(node: s.Expression | None) -> Any:
    """The values of a literal, see `records`."""
    match node:
        case s.AggregateNode(items):
            return [literal_values(i) for i in items]
        case s.BoolLiteral(value) | s.StringLiteral(value):
            return value
        case None:
            return None
    return literal_number(node)


_POSED: Final = frozenset(("tooldata", "wobjdata", "robtarget"))


def has_no_value(data: s.Data) -> bool:
    """True for persistent data with an orientation whose value another module or task states."""
    plain = data.storage == "PERS" and data.value is None and not data.dimensions
    return plain and data.scope != "LOCAL" and data.type.lower() in _POSED


EXTERNAL_COMPONENT: Final = "extax"
EXTERNAL_AXES: Final = tuple(f"eax_{letter}" for letter in "abcdef")
FIRST_EXTERNAL_COLUMN: Final = 11
"""Column of the first external axis in the 17 numbers of a target."""
_MOST_EXTERNAL_AXES: Final = 2
"""Axes that other languages have."""
_TARGET_SHAPES: Final = ([3, 4, 4, 6], [6, 6])


def _is_target(node: Any) -> bool:
    """True if a node is a target or joint target in brackets."""
    return isinstance(node, s.AggregateNode) and _bracket_shape(node.items) in _TARGET_SHAPES


def _bracket_shape(items: Sequence[s.Expression]) -> list[int]:
    return [len(item.items) if isinstance(item, s.AggregateNode) else 0 for item in items]


def stated_axes(node: Any) -> frozenset[str]:
    """The axes that a target in brackets, or one of a run of targets or moves, gives a place."""
    match node:
        case s.TargetRunNode(run=run) | s.MoveRunNode(run):
            if run.values is None:
                return frozenset()
            # 9E9 marks an axis that the target does not use.
            given = np.asarray(run.values)[:, FIRST_EXTERNAL_COLUMN:] < UNUSED
            return frozenset(EXTERNAL_AXES[column] for column in np.flatnonzero(given.any(axis=0)))
        case s.AggregateNode(items) if _is_target(node):
            last: Any = items[-1]
            numbers = map(literal_number, last.items)
            pairs = zip(EXTERNAL_AXES, numbers, strict=True)
            # A computed place counts as stated.
            return frozenset(axis for axis, n in pairs if n is None or n < UNUSED)
    return frozenset()


def used_axes(modules: Sequence[s.Module]) -> frozenset[str]:
    """Those that any target which is written out gives a place."""
    return frozenset().union(*map(stated_axes, nodes(tuple(modules))))


def still_axis_name(axis: str) -> str:
    """The name of what says whether an axis stands still."""
    return axis + BASE_FRAME_SUFFIX


def axes_to_ask(modules: Sequence[s.Module]) -> list[str]:
    """Return the axes that the cell has to describe, as other languages cannot express their
    use.
    """
    used = used_axes(modules)
    if not used:
        return []
    found = [axis for axis in EXTERNAL_AXES if axis in used]
    # Other languages count their additional axes from the first, without a gap.
    most = len(found) > _MOST_EXTERNAL_AXES or found != list(EXTERNAL_AXES[: len(found)])
    parts = (
        isinstance(node, s.Component) and node.name.lower() == EXTERNAL_COMPONENT
        for node in nodes(tuple(modules))
    )
    return found if most or any(parts) else []


def still_axes(modules: Sequence[s.Module]) -> frozenset[str]:
    """Axes that data of the modules say to stand still."""
    names = {still_axis_name(axis): axis for axis in EXTERNAL_AXES}
    return frozenset(
        names[item.name.lower()]
        for module in modules
        for item in module.items
        if isinstance(item, s.Data)
        and item.name.lower() in names
        and item.value == s.BoolLiteral(True)
    )


_CONVEYOR_INSTRUCTIONS: Final = frozenset(("waitwobj", "dropwobj"))
"""Instructions that follow a work object on a conveyor (option Conveyor Tracking)."""


def carrying_unit(value: Any) -> str:
    """The unit that carries the work object which a value in brackets is, empty if none does."""
    match value:
        case s.AggregateNode(
            (
                s.BoolLiteral(False),
                s.BoolLiteral(False),
                s.StringLiteral(name),
                s.AggregateNode(),
                s.AggregateNode(),
            )
        ):
            return name
    return ""


def still_frame_name(unit: str) -> str:
    """The name of a work object that is where a unit stands."""
    return unit + BASE_FRAME_SUFFIX


def units_can_stand(modules: Sequence[s.Module]) -> bool:
    """True if no statement waits for an object on a unit, as with a conveyor."""
    return not any(
        isinstance(node, s.ProcedureCall)
        and isinstance(node.name, str)
        and node.name.lower() in _CONVEYOR_INSTRUCTIONS
        for node in nodes(tuple(modules))
    )
