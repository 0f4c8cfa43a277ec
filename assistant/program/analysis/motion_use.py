"""Use of motion settings: speeds and blends that moves state, their lengths, percentages left over.

Lengths are in mm, of straight moves whose start the text gives. A cycle of a program may leave
percentages of speed and acceleration to the next one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Ints
from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import EXIT, ControlFlowGraph, Dataflow
from assistant.program.geometry import Target, Vector
from assistant.program.motion import Blend, Speed, configuration_row
from assistant.program.program import Procedure, Program, bodies
from assistant.program.rewriting import records
from assistant.program.statement_index import records_in_procedures


def stated_motions(program: Program) -> Iterator[tuple[Speed | e.Name, Blend | e.Name]]:
    """Every speed and blend that a move states, each table entry of a path once."""
    for statement in program.statements():
        if isinstance(statement, p.MoveStatement):
            yield statement.motion.fixed
        elif isinstance(statement, p.Follow):
            path = statement.path
            used = (
                [path.speeds[i] for i in np.unique(path.speed)],
                [path.blends[i] for i in np.unique(path.blend)],
            )
            most = max(len(u) for u in used)
            for i in range(most):
                yield used[0][min(i, len(used[0]) - 1)], used[1][min(i, len(used[1]) - 1)]


def branches_by_frame(
    program: Program, coded: Callable[[NDArray[np.int8]], Ints]
) -> dict[str, dict[tuple[int, ...], None]]:
    """Arm branches of the targets in each frame (lower case), in the order of their first use.

    Those of a path by their numbers. coded: branches (n, 6) as the numbers (n, k) of a language.
    """
    found: dict[str, dict[tuple[int, ...], None]] = {}
    targets = {name.lower(): target for name, target in program.targets.items()}

    def use(frame: str, branches: Ints) -> None:
        found.setdefault(frame.lower(), {}).update(dict.fromkeys(map(tuple, branches.tolist())))

    for node in program.statements():
        if isinstance(node, p.Follow):
            path = node.path
            codes = coded(path.configurations)
            for row, name in enumerate(path.frames):
                use(name, np.unique(codes[path.frame == row], axis=0))
        elif isinstance(node, p.Move | p.MoveCircular):
            for value in records((node.target, getattr(node, "via", None))):
                target = value.target if isinstance(value, e.TargetValue) else None
                if isinstance(value, e.Name):
                    target = targets.get(value.name.lower())
                if target is not None:
                    branch = [configuration_row(target.configuration)]
                    use(node.motion.frame, coded(np.array(branch, dtype=np.int8)))
    return found


_KnownPosition = tuple[Vector, str, str] | None
"""A position in mm with the tool and frame, lower case, that it is of; None if it is not known."""


def straight_lengths(program: Program) -> dict[int, float]:
    """Return the mm of straight moves that set outputs on their way, by statement identity.

    Only moves that begin at the end of the statement before, in the same tool and frame.
    """
    targets = {name.lower(): target for name, target in program.targets.items()}
    found: dict[int, float] = {}
    # A procedure's own variables hide targets of the same name.
    for procedure in program.procedures:
        known = {k: t for k, t in targets.items() if k not in _own_names(procedure)}
        _measure_body(procedure.body, known, found)
    return found


def _own_names(procedure: Procedure) -> set[str]:
    named = (*procedure.variables, *(q.name for q in procedure.parameters))
    return {name.lower() for name in named}


def _measure_body(
    body: tuple[p.Statement, ...], targets: Mapping[str, Target], found: dict[int, float]
) -> None:
    here: _KnownPosition = None
    for node in body:
        before, here = here, _position_after(node, here, targets)
        straight = isinstance(node, p.Move) and node.kind == "linear" and node.triggers
        if straight and before is not None and here is not None and before[1:] == here[1:]:
            found[id(node)] = math.dist(before[0], here[0])
        for inner in bodies(node):
            _measure_body(inner, targets, found)


def _position_after(
    node: p.Statement, here: _KnownPosition, targets: Mapping[str, Target]
) -> _KnownPosition:
    # A search move ends wherever its condition holds.
    if isinstance(node, p.MoveStatement) and node.until is not None:
        return None
    match node:
        case p.Move(target=value, motion=motion) | p.MoveCircular(target=value, motion=motion):
            target = value.target if isinstance(value, e.TargetValue) else None
            if isinstance(value, e.Name):
                target = targets.get(value.name.lower())
            if target is None:
                return None
            return target.pose.position, motion.tool.lower(), motion.frame.lower()
        case p.Follow(path) if len(path):
            x, y, z = path.positions[-1].tolist()
            tool, frame = path.tools[path.tool[-1]], path.frames[path.frame[-1]]
            return (x, y, z), tool.lower(), frame.lower()
    # Statements that do not move leave the robot where it is.
    return here if p.trait(node) in ("sets", "says", "waits") else None


Setting = p.SetOverride | p.SetAcceleration
_USUAL_SETTINGS: Final[tuple[Setting, ...]] = (
    p.SetOverride(e.Number(100)),
    p.SetAcceleration(e.Number(100), e.Number(100)),
)
"""Settings at the start of a controller: full speed and acceleration."""
_BEGUN, _USUAL, _OTHER = "begun", "usual", "other"
_SettingValues = frozenset[str]
"""Possible values of a setting at a position: as the cycle began, as usual, or another."""


def left_settings(program: Program, entry: Procedure) -> tuple[Setting, ...]:
    """Which of `USUAL` a cycle may end without, while one begins with moves that it holds for."""
    set_ones = list(records_in_procedures(program, p.SetOverride, p.SetAcceleration))
    return tuple(
        usual
        for usual in _USUAL_SETTINGS
        if any(
            isinstance(one, type(usual)) and not _is_same_setting(one, usual) for one in set_ones
        )
        and _SettingAlongPaths(program, usual).is_left(entry)
    )


def _is_same_setting(one: Setting, other: Setting) -> bool:
    match one, other:
        case p.SetOverride(percent), p.SetOverride(usual):
            return percent == usual
        case p.SetAcceleration(up, down), p.SetAcceleration(usual, same):
            return (up, down) == (usual, same)
    return False


def _either_value(one: _SettingValues, other: _SettingValues) -> _SettingValues:
    return one | other


@dataclass(slots=True)
class _SettingAlongPaths:
    """One setting along all ways. used: whether a move may run with what a cycle began with."""

    program: Program
    usual: Setting
    used: bool = False
    _known: dict[tuple[str, _SettingValues], _SettingValues] = field(default_factory=dict)

    def is_left(self, entry: Procedure) -> bool:
        ends = self.behind(entry, frozenset((_BEGUN,)))
        return self.used and _OTHER in ends

    def behind(self, procedure: Procedure, values: _SettingValues) -> _SettingValues:
        """Return the values possible at the end of a procedure; empty if it never ends.

        values: those possible at its start.
        """
        key = procedure.name.lower(), values
        if key not in self._known:
            # A procedure that calls itself changes nothing further.
            self._known[key] = values  # for one that calls itself
            graph = ControlFlowGraph(procedure.body)

            def effect(node: int, held: _SettingValues) -> _SettingValues | None:
                for part in graph.runs[node]:
                    held = self._ran(part, held)
                return held or None

            flow: Dataflow[int, _SettingValues] = Dataflow(graph.after, effect, _either_value)
            flow.spread([(graph.start, values)])
            self._known[key] = flow.found.get(EXIT, frozenset())
        return self._known[key]

    def _ran(self, part: Any, held: _SettingValues) -> _SettingValues:
        match part:
            case p.SetOverride() | p.SetAcceleration():
                if isinstance(part, type(self.usual)):
                    return frozenset((_USUAL if _is_same_setting(part, self.usual) else _OTHER,))
            case p.Move() | p.MoveCircular() | p.MoveJoints() | p.Follow():
                self.used = self.used or _BEGUN in held
        for record in records(part):
            if isinstance(record, p.Call | e.Apply):
                name = record.procedure if isinstance(record, p.Call) else record.function
                callee = self.program.procedure(name)
                held = held if callee is None else self.behind(callee, held)
        return held
