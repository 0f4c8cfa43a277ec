"""Percentages of speed and acceleration that one cycle of a program leaves to the next."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import Dataflow
from assistant.program.analysis.graph import EXIT, ControlFlowGraph
from assistant.program.contents import records_in_procedures
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import records

Setting = p.SetOverride | p.SetAcceleration
USUAL_SETTINGS: Final[tuple[Setting, ...]] = (
    p.SetOverride(e.Number(100)),
    p.SetAcceleration(e.Number(100), e.Number(100)),
)
"""As a controller begins: nothing is slowed down."""
_BEGUN, _USUAL, _OTHER = "begun", "usual", "other"
SettingValues = frozenset[str]
"""What a setting may be at a place: as the cycle began, as usual, or another."""


def left_settings(program: Program, entry: Procedure) -> tuple[Setting, ...]:
    """Which of `USUAL` a cycle may end without, while one begins with moves that it holds for."""
    set_ones = list(records_in_procedures(program, p.SetOverride, p.SetAcceleration))
    return tuple(
        usual
        for usual in USUAL_SETTINGS
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


def _either_value(one: SettingValues, other: SettingValues) -> SettingValues:
    return one | other


@dataclass(slots=True)
class _SettingAlongPaths:
    """One setting along all ways. used: whether a move may run with what a cycle began with."""

    program: Program
    usual: Setting
    used: bool = False
    _known: dict[tuple[str, SettingValues], SettingValues] = field(default_factory=dict)

    def is_left(self, entry: Procedure) -> bool:
        ends = self.behind(entry, frozenset((_BEGUN,)))
        return self.used and _OTHER in ends

    def behind(self, procedure: Procedure, values: SettingValues) -> SettingValues:
        """What may hold where a procedure ends that began with some; empty if it never does."""
        key = procedure.name.lower(), values
        if key not in self._known:
            self._known[key] = values  # for one that calls itself
            graph = ControlFlowGraph(procedure.body)

            def effect(node: int, held: SettingValues) -> SettingValues | None:
                for part in graph.runs[node]:
                    held = self._ran(part, held)
                return held or None

            flow: Dataflow[int, SettingValues] = Dataflow(graph.after, effect, _either_value)
            flow.spread([(graph.start, values)])
            self._known[key] = flow.found.get(EXIT, frozenset())
        return self._known[key]

    def _ran(self, part: Any, held: SettingValues) -> SettingValues:
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
