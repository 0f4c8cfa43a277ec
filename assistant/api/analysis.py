"""Check and simulate from Python: findings of programs, times and motion on a robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from os import fspath
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, FailOn, Refused, fold, has_errors
from assistant.base.source_text import path_of
from assistant.checks.clearances import clearances
from assistant.compiler.arms import open_cell, robot_of
from assistant.compiler.checker import Checked, check_files, check_program
from assistant.compiler.compilation import Compiled
from assistant.compiler.loader import Loaded, with_entry
from assistant.compiler.program_files import load
from assistant.compiler.retarget import solve
from assistant.findings.severities import apply_severities
from assistant.lazy import pictured
from assistant.program.program import Program
from assistant.report.figures import new_figure, picture
from assistant.robots import Robot
from assistant.robots.timing import Simulation
from assistant.robots.timing import simulate as timed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Source = str | FilePath | Program | Loaded | Compiled


@dataclass(frozen=True, slots=True, repr=False)
class Check:
    """Result of a check.

    findings: after the settings of the project are applied. ignored: findings suppressed by
    comments in programs. files: the files checked. unreadable: something could not be read.
    """

    findings: tuple[Diagnostic, ...]
    ignored: tuple[Diagnostic, ...] = ()
    files: tuple[str, ...] = ()
    unreadable: bool = False

    @property
    def ok(self) -> bool:
        """True if everything was read and neither errors nor warnings were found."""
        return FailOn.WARNING.status(self.findings, unreadable=self.unreadable) == 0

    def __repr__(self) -> str:
        count = len(self.findings)
        return f"<Check {'ok' if self.ok else 'not ok'}: {count} finding{'s' * (count != 1)}>"

    def _repr_html_(self) -> str:
        return pictured(self)


def check(
    source: Source | Sequence[Source],
    *,
    robot: str | Robot | None = None,
    process: str | FilePath | None = None,
    unit: str | None = None,
    cell: str | FilePath | None = None,
    language: str | None = None,
) -> Check:
    """Check files, folders and programs that are not files, as the command `check` does.

    source: one or several; of a `Compiled` or a `Loaded`, its program is checked. robot: reach,
    limits and configurations are checked for it; default the robot that the program names. process:
    process file of drawings and tables. unit: length unit of drawings. cell: file of the cell that
    the programs run in. language: of robot programs, if neither suffix nor text identifies it.
    Raises Refused for invalid options; faults of a source are findings.
    """
    several = isinstance(source, Sequence) and not isinstance(source, str | bytes)
    given: list[Source] = list(source) if several else [source]  # type: ignore[arg-type, list-item]
    stands = open_cell(cell, robot)
    checked = Checked(list(stands.findings))
    paths = [fspath(one) for one in given if isinstance(one, str | FilePath)]
    for one in given:
        if isinstance(one, str | FilePath):
            continue
        if not isinstance(one, Program | Loaded | Compiled):
            path_of(one)
        loaded = one if isinstance(one, Loaded) else None
        program = one if isinstance(one, Program) else one.program
        checked.findings += loaded.findings if loaded else ()
        checked.findings += check_program(program, stands, loaded.text if loaded else None)
    if paths:
        more = check_files(paths, process=process, unit=unit, cell=stands, language=language)
        checked.findings += more.findings
        checked.texts |= more.texts
        checked.paths += more.paths
        checked.unreadable |= more.unreadable
    settled = apply_severities(checked.findings, checked.texts)
    return Check(settled.left, settled.ignored, tuple(checked.paths), checked.unreadable)


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
        """Return the duration of the program on the path through it that takes the longest."""
        return self.simulation.seconds

    @property
    def ok(self) -> bool:
        """True if there is no contact."""
        return not has_errors(self.findings)

    def __repr__(self) -> str:
        robot, count = self.simulation.robot.name, len(self.findings)
        told = f"{count} finding{'s' * (count != 1)}"
        return f"<Simulated {self.name} on {robot}: {self.seconds:.2f} s, {told}>"

    def _repr_html_(self) -> str:
        return pictured(self)

    def _repr_png_(self) -> bytes | None:
        """Joints and speed of the tool over time; None without matplotlib."""
        try:
            return picture(self.plot())
        except Refused:
            return None

    def plot(self) -> Figure:
        """Return a figure of matplotlib with joints and speed of the tool over time.

        Raises Refused, naming the extra, without matplotlib.
        """
        return _motion_figure(self.simulation)


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
    """Simulate a program on a robot: its duration and its motion over time.

    source: a file or a program. robot: default that of the program or its cell. acceleration: mm/s²
    of the tool on lines and arcs, default what the axes allow. period: seconds between samples.
    process, unit, language: of the file; from_robot: the arm that it was written for. entry: the
    procedure that it starts with. cell: file of the cell that it runs in. Raises Refused with all
    findings if the robot cannot run the program.
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


_MOST_PICTURE_ROWS: Final = 4000
"""Most samples drawn; of more, only every second, third … is drawn."""


def _motion_figure(simulation: Simulation) -> Figure:
    drawn = new_figure(7.0, 3.5)
    samples, robot = simulation.samples, simulation.robot
    every = slice(None, None, max(1, len(samples) // _MOST_PICTURE_ROWS))
    upper, lower = drawn.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    for name, unit, joint in zip(robot.axes, robot.units, samples.joints.T, strict=True):
        upper.plot(samples.t[every], joint[every], label=f"{name}, {unit}", lw=1.2)
    lower.plot(samples.t[every], samples.tcp_speed[every], color="0.3", lw=1.2)
    lower.set(xlabel="seconds", ylabel="tool, mm/s")
    upper.set_ylabel("joints")
    upper.legend(fontsize=7, ncols=3)
    for axes in (upper, lower):
        axes.grid(alpha=0.3)
    return drawn
