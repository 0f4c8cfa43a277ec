"""Checks on a pseudo-program, one file a rule; the robot's own are in `assistant.robots`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

from assistant.checks.arcs import arcs
from assistant.checks.magnitudes import magnitudes
from assistant.program.diagnostics import Diagnostic, fold
from assistant.program.program import Program

RULES: Final[tuple[Callable[[Program], Iterator[Diagnostic]], ...]] = (arcs, magnitudes)


def check(program: Program) -> tuple[Diagnostic, ...]:
    """Findings of every rule, those that differ only in their place folded."""
    return fold(finding for rule in RULES for finding in rule(program))
