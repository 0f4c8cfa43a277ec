"""Simulate a program on a robot: its time, and its motion over time as files.

Also the program of a source, solved for the robot that runs it, for commands that need the motion:
`view`, `explore`, `reach`, `fmu`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Diagnostic, Refused, error, fold, has_errors
from assistant.cli.command import command, option
from assistant.cli.options import (
    AccelerationOption,
    CellOption,
    DrawingOptions,
    FormatOption,
    PageOptions,
    ReaderOptions,
    RobotOption,
    SightOptions,
    Source,
    WrittenOptions,
    with_project_defaults,
)
from assistant.cli.presentation import Format, print_answer, working
from assistant.cli.source_input import NO_FILE_NAME, STANDARD, cell_of, keep_sources, load_given

if TYPE_CHECKING:
    from assistant.compiler.arms import InCell
    from assistant.compiler.retarget import Solved
    from assistant.robots import Robot
    from assistant.robots.timing import Simulation
    from assistant.sources.sights import Seeing


_NO_RESULT = error(
    "CL011",
    "a simulation is not written as `{name}`",
    "end the name in .csv, .npz, .png or .svg, or name a folder",
)
_FILE_SUFFIXES: Final = (".motion.csv", ".moves.csv", ".motion.npz", ".motion.png", ".motion.svg")
"""Suffixes of all files of a simulation, appended to the name of the program."""


@command
class Simulate:
    """Tell how long a program takes on a robot, and write its motion over time. Nothing moves."""

    program: Source
    robot: RobotOption
    output: tuple[str, ...] = option(
        "Folder for all files, or a .csv, .npz, .png or .svg; repeatable.", "--output", "-o"
    )
    acceleration: AccelerationOption
    period: float | None = option("Seconds between samples; default 0.01, or what fits.")
    reader: DrawingOptions
    cell: CellOption
    written: WrittenOptions
    sight: SightOptions
    page: PageOptions
    format: FormatOption

    def run(self) -> int:
        """Run a simulation; return 0 if it succeeds, 1 if the robot cannot run the program, or not
        without contact.

        page: writes a page of the simulation, and adds its findings to the list.
        """
        from assistant.checks.clearances import clearances
        from assistant.report import timing as report
        from assistant.robots.timing import simulate

        page = self.page
        page.check()
        options = with_project_defaults(self.program, self)
        with working(f"simulating {self.program}"):
            wanted = _output_files(self.program, self.output)
            ready = solved_source(
                self.program,
                options.reader,
                robot=options.robot,
                cell=options.cell,
                written=options.written,
                seeing=self.sight.seeing,
            )
            solution, findings = ready.solution, ready.findings
            pages = options._write_page(page, ready, findings) if page else ()
            if has_errors(findings):
                return report_errors(
                    self.program, solution.robot, findings, self.format, pages=pages
                )
            done = simulate(solution, period=self.period, acceleration=self.acceleration)
            found = clearances(solution, ready.scene, done)
            near = fold(ready.places.finding(finding).within(self.program) for finding in found)
            findings += near
            files = {path: _simulation_files(path.name, done, self.program) for path in wanted}
            written = [*_write_simulation(self.program, files), *pages]
        lines = (f"{self.program} on {done.robot.title}", "", *report.lines(done))
        answer = {"source": self.program, **report.record(done)}
        print_answer(self.format, answer, lines, findings, written)
        return 1 if has_errors(near) else 0

    def _write_page(
        self, page: PageOptions, ready: Solved, findings: list[Diagnostic]
    ) -> Sequence[Path]:
        """Write the page and add its findings to the list."""
        from assistant.checks import robot_rules
        from assistant.cli.report_pages import page_name, solved_sheet, write_page

        found = robot_rules.check(ready.solution)
        sheet = solved_sheet(self.program, ready, self.reader, self.acceleration, found)
        read = [self.program, *map(str, filter(None, (self.cell, self.reader.process)))]
        written, told = write_page(page, [sheet], read, page_name(self.program))
        findings += told
        return written


def solved_source(
    source: str,
    reader: ReaderOptions,
    *,
    written: WrittenOptions,
    robot: str | None = None,
    cell: Path | None = None,
    seeing: Seeing | None = None,
    stands: InCell | None = None,
) -> Solved:
    """The program of a file, for the arm that runs it. Raises Refused if nobody names one.

    stands: the cell, where it has been read already.
    """
    from assistant.compiler.arms import open_cell
    from assistant.compiler.cell_defaults import with_stated_values
    from assistant.compiler.retarget import solve

    stands = stands or open_cell(cell, robot)
    stands = stands if seeing is None else replace(stands, seeing=seeing)
    arm = written.from_robot or stands.robot
    named, entry = written.from_language, written.entry
    loaded = load_given(source, arm, reader, named, entry, stands.around)
    values = (cell or cell_of(source)) if loaded.language is not None else None
    if values is not None:
        loaded = with_stated_values(loaded, values)
    return solve(loaded, stands, source, written.from_robot)


def report_errors(
    source: str,
    robot: Robot,
    findings: Sequence[Diagnostic],
    format: Format,
    done: str = "simulated",
    pages: Sequence[Path] = (),
) -> int:
    """Tells why a program is not gone through; 1. done: what is not done with it. pages: that were
    written all the same.
    """
    answer = {"source": source, "robot": robot.name}
    lines = (f"{source} is not {done}: {robot.title} cannot run it",)
    print_answer(format, answer, lines, findings, pages)
    return 1


def _output_files(source: str, outputs: Sequence[str]) -> list[Path]:
    """The files that are to be written; raises Refused for a name that tells no kind."""
    stem = "program" if source == STANDARD else Path(source).stem
    found = []
    for output in outputs:
        path = Path(output)
        if path.is_dir() or not path.suffix:
            found += [path / f"{stem}{end}" for end in _FILE_SUFFIXES]
        elif path.suffix.lower() not in (".csv", ".npz", ".png", ".svg"):
            raise Refused(_NO_RESULT(name=output), exit_status=2)
        elif not path.stem:
            raise Refused(NO_FILE_NAME(path=output, name=output), exit_status=2)
        else:
            found.append(path)
    return list(dict.fromkeys(found))


def _write_simulation(source: str, files: Mapping[Path, bytes]) -> list[Path]:
    from assistant.base.file_sets import write_all

    keep_sources([source], list(files))
    return list(write_all(files))


def _simulation_files(name: str, done: Simulation, source: str) -> bytes:
    from assistant.report import timing as report

    if name.lower().endswith(".moves.csv"):
        return report.moves_csv(done)
    match Path(name).suffix.lower():
        case ".csv":
            return report.motion_csv(done)
        case ".npz":
            return report.motion_npz(done)
        case suffix:
            from assistant.report.figures import motion_plot

            return motion_plot(done, f"{Path(source).name} on {done.robot.title}", suffix[1:])
