"""Simulating from Python: how long a program takes on a robot."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path as FilePath

from assistant.api.checking import Source
from assistant.base.diagnostics import Diagnostic, Refused, fold, has_errors
from assistant.checks.clearances import clearances
from assistant.compiler.arms import open_cell, robot_of
from assistant.compiler.compilation import Compiled
from assistant.compiler.loader import Loaded, with_entry
from assistant.compiler.program_files import load
from assistant.compiler.retarget import solve
from assistant.lazy import pictured
from assistant.program.program import Program
from assistant.robots import Robot
from assistant.robots.timing import Simulation
from assistant.robots.timing import simulate as timed


@dataclass(frozen=True, slots=True, repr=False)
class Simulated:
    """A program as an arm runs it.

    name: of the program. simulation: its times, moves and samples. findings: about the program,
    and, in a cell, of what it touches.
    """

    name: str
    simulation: Simulation
    findings: tuple[Diagnostic, ...]

    @property
    def seconds(self) -> float:
        """How long the program takes, on the way through it that takes the longest."""
        return self.simulation.seconds

    @property
    def ok(self) -> bool:
        """Whether nothing is touched."""
        return not has_errors(self.findings)

    def __repr__(self) -> str:
        robot, count = self.simulation.robot.name, len(self.findings)
        told = f"{count} finding{'s' * (count != 1)}"
        return f"<Simulated {self.name} on {robot}: {self.seconds:.2f} s, {told}>"

    def _repr_html_(self) -> str:
        return pictured(self)

    def _repr_png_(self) -> bytes | None:
        """Joints and speed of the tool over time; None without matplotlib."""
        from assistant.api.motion_picture import motion_png

        return motion_png(self.simulation)


def simulate(
    source: Source,
    *,
    robot: str | Robot | None = None,
    process: str | FilePath | None = None,
    unit: str | None = None,
    cell: str | FilePath | None = None,
    language: str | None = None,
    from_robot: str | Robot | None = None,
    entry: str | None = None,
    acceleration: float | None = None,
    period: float | None = None,
) -> Simulated:
    """How long a program takes on a robot, and its motion over time.

    source: a file, or a program. robot: without one that of the program or its cell. acceleration:
    mm/s² of the tool on lines and arcs, without one what the axes allow. period: seconds between
    samples. process, unit, language: of the file; from_robot: the arm that it was written for.
    entry: the procedure that it begins with. cell: file of the cell that it runs in.
    Raises Refused with all findings if the robot cannot run it.
    """
    stands = open_cell(cell, robot)
    reader = robot_of(from_robot) or stands.robot
    name = None
    if isinstance(source, Program):
        loaded = Loaded(source)
    elif isinstance(source, Compiled):
        loaded = Loaded(source.program)
    elif isinstance(source, Loaded):
        loaded = source
    else:
        name = str(source)
        loaded = load(
            source,
            process=process,
            robot=reader,
            language=language,
            unit=unit,
            around=stands.around,
        )
    loaded = replace(loaded, program=with_entry(loaded.program, entry))
    ready = solve(loaded, stands, name, from_robot)
    if has_errors(ready.findings):
        raise Refused(*ready.findings)
    done = timed(ready.solution, period=period, acceleration=acceleration)
    near = clearances(ready.solution, ready.scene, done)
    told = (*ready.findings, *fold(ready.places.finding(one).within(name) for one in near))
    return Simulated(loaded.program.name, done, told)
