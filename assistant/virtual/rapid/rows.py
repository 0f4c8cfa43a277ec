"""Long runs of declarations and moves, whose tree is columns, as plain nodes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.syntax import MoveRun, TargetRun

MOVE_NAMES: Final = ("MoveJ", "MoveL", "MoveC")
CIRCULAR_MOVE: Final = 2
TARGET_PARTS: Final = ((0, 3), (3, 7), (7, 11), (11, 17))


def target_data(node: s.TargetRunNode) -> Iterator[s.Data]:
    run: TargetRun = node.run
    for row in range(len(run)):
        name = run.names.name(row)
        yield s.Data(node.scope, "CONST", "robtarget", name, (), _target_data(run.values[row]))


def move_calls(run: MoveRun) -> Iterator[s.ProcedureCall]:
    for row in range(len(run)):
        kind, how = int(run.kinds[row]), run.motions[row]
        arguments: list[s.Argument] = []
        if kind == CIRCULAR_MOVE:
            arguments.append(s.Positional(s.NameRef(run.vias.name(row))))
        to = s.NameRef(run.names.name(row)) if run.values is None else _target_data(run.values[row])
        arguments.append(s.Positional(to))
        arguments += [s.Positional(s.NameRef(n)) for n in (how.speed, how.zone, how.tool)]
        if how.frame:
            arguments.append(s.Option("WObj", s.NameRef(how.frame)))
        yield s.ProcedureCall(MOVE_NAMES[kind], tuple(arguments))


def _target_data(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> s.AggregateNode:
    return s.AggregateNode(
        tuple(
            s.AggregateNode(tuple(_row_number(float(value)) for value in values[start:stop]))
            for start, stop in TARGET_PARTS
        )
    )


def _row_number(value: float) -> s.Expression:
    literal = s.NumberLiteral(repr(abs(value)))
    return s.Prefix("-", literal) if value < 0 else literal
