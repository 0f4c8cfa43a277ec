"""Work objects that a mechanical unit carries, as their values in brackets name it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.undeclared_names import BASE_FRAME_SUFFIX

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
    """Whether no statement waits for what a unit brings, as a conveyor does."""
    return not any(
        isinstance(node, s.ProcedureCall)
        and isinstance(node.name, str)
        and node.name.lower() in _CONVEYOR_INSTRUCTIONS
        for node in nodes(tuple(modules))
    )
