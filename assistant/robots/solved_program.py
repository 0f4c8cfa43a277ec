"""A program that is solved for a robot: the joints and configurations of every move."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.program.geometry import FLANGE, Tool
from assistant.program.program import Program
from assistant.program.statements import Follow, Moving
from assistant.robots.motion.run import Run
from assistant.robots.robot import Robot


@dataclass(frozen=True, slots=True, eq=False)
class SolvedRun:
    """A solved run.

    joints: (n, a) deg, NaN if missing. configurations: (n, 6). number: of the run, in the order in
    which the runs are solved.
    """

    run: Run
    joints: Floats
    configurations: NDArray[np.int8]
    number: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """Motion of one motion statement.

    solved_run: the run that it is part of, with these of its rows; None for a move to joints, and
    for a target that is known only when the program runs. joints: (m, a) deg at its targets, NaN if
    missing. before: (a,) deg at its start, None if unknown.
    """

    statement: Moving
    solved_run: SolvedRun | None
    rows: slice
    joints: Floats
    before: Floats | None


@dataclass(frozen=True, slots=True, eq=False)
class SolvedProgram:
    """A program with its configurations filled in, solved for a robot.

    legs: name of a procedure → its motion statements in order of text, nested ones included.
    """

    program: Program
    robot: Robot
    legs: Mapping[str, tuple[Leg, ...]]
    findings: tuple[Diagnostic, ...]

    @property
    def solved_runs(self) -> tuple[SolvedRun, ...]:
        """Every run once, in the order in which they were solved."""
        runs = (leg.solved_run for legs in self.legs.values() for leg in legs)
        found = {id(solved_run): solved_run for solved_run in runs if solved_run is not None}
        return tuple(sorted(found.values(), key=lambda one: one.number))

    @property
    def tools(self) -> dict[str, Tool]:
        """The declared tools that moves name, in order of the declarations."""
        named: set[str] = set()
        for statement in (leg.statement for legs in self.legs.values() for leg in legs):
            if isinstance(statement, Follow):
                named.update(map(str.lower, statement.path.tools))
            else:
                named.add(statement.motion.tool.lower())
        tools = self.program.tools.items()
        return {name: tool for name, tool in tools if name.lower() in named and name != FLANGE}
