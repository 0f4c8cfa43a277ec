"""The rules that need a robot."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

from assistant.base.diagnostics import Diagnostic, fold
from assistant.checks.corners import corners
from assistant.checks.cycles import cycle_of, cycles
from assistant.checks.external_axes import external_axes
from assistant.checks.joint_speeds import joint_speeds
from assistant.checks.loads import loads
from assistant.checks.reorientations import reorientations
from assistant.checks.singularities import singularities
from assistant.checks.views import ProgramView
from assistant.robots import SolvedProgram

RULES: Final[tuple[Callable[[ProgramView], Iterator[Diagnostic]], ...]] = (
    singularities,
    joint_speeds,
    reorientations,
    corners,
    cycles,
    loads,
    external_axes,
)


def check(solution: SolvedProgram, cycle: float | None = None) -> tuple[Diagnostic, ...]:
    """See `assistant.checks.with_robot`."""
    view = ProgramView(solution, cycle_of(solution.robot) if cycle is None else cycle)
    return fold(finding for rule in RULES for finding in rule(view))
