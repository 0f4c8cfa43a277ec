"""Checks on a pseudo-program; those of the robot itself are in `assistant.robots`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Final

from assistant.base.budgets import MEANING, staged
from assistant.base.diagnostics import Diagnostic, fold
from assistant.checks.program_rules import arcs, group_values, magnitudes, outputs, shared_numbers
from assistant.program.program import Program

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.robots import SolvedProgram

RULES: Final[tuple[Callable[[Program], Iterator[Diagnostic]], ...]] = (
    arcs,
    magnitudes,
    outputs,
    shared_numbers,
    group_values,
)


@staged(MEANING, Program.size)
def check(program: Program) -> tuple[Diagnostic, ...]:
    """Findings of every rule, those that differ only in their place folded."""
    return fold(finding for rule in RULES for finding in rule(program))


def with_robot(
    solution: SolvedProgram, *, cycle: float | None = None, scene: Scene | None = None
) -> tuple[Diagnostic, ...]:
    """Return the findings of the rules about how a robot executes a program.

    scene: the cell around the robot; None if it is unknown, then only the arm with its base and
    tools is checked. cycle: seconds between two positions that the controller commands; None for
    the known value of the robot. Targets that cannot be reached at all are findings of the solution
    itself.
    """
    from assistant.checks import robot_rules
    from assistant.checks.clearances import clearances

    return (*robot_rules.check(solution, cycle), *fold(clearances(solution, scene)))
