"""Simulate a program on a robot: its time, and its motion over time as files.

Also the program of a source, solved for the robot that runs it, for commands that need the motion:
`view`, `explore`, `reach`, `fmu`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, error, fold, has_errors
from assistant.cli.compilation import NO_FILE_NAME, STANDARD, keep_sources, load_given, working
from assistant.cli.options import with_project_defaults
from assistant.cli.presentation import Format, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.compiler.arms import InCell
    from assistant.compiler.retarget import Solved
    from assistant.robots import Robot
    from assistant.robots.timing import Simulation
    from assistant.sources.process.placement import DrawingPlacement
    from assistant.sources.sights import Seeing


_NO_RESULT = error(
    "CL011",
    "a simulation is not written as `{name}`",
    "end the name in .csv, .npz, .png or .svg, or name a folder",
)
_FILE_SUFFIXES: Final = (".motion.csv", ".moves.csv", ".motion.npz", ".motion.png", ".motion.svg")
"""Suffixes of all files of a simulation, appended to the name of the program."""


@dataclass(frozen=True, slots=True)
class SimulationOptions:
    """Source and options of a simulation. acceleration: mm/s² of the tool. period: seconds."""

    robot: str | None
    process: Path | None
    unit: str | None
    from_language: str | None
    from_robot: str | None
    acceleration: float | None
    period: float | None
    entry: str | None = None
    cell: Path | None = None
    placement: DrawingPlacement | None = None
    seeing: Seeing | None = None


def run_simulate(
    source: str,
    options: SimulationOptions,
    outputs: Sequence[str],
    format: Format,
    page: Callable[[str, SimulationOptions, Solved, list[Diagnostic]], Sequence[Path]]
    | None = None,
) -> int:
    """Run a simulation; return 0 if it succeeds, 1 if the robot cannot run the program, or not
    without contact.

    page: writes a page of the simulation, and adds its findings to the list.
    """
    from assistant.checks.clearances import clearances
    from assistant.report import timing as report
    from assistant.robots.timing import simulate

    options = with_project_defaults(source, options)
    with working(f"simulating {source}"):
        wanted = _output_files(source, outputs)
        ready = solved_source(source, options)
        solution, findings = ready.solution, ready.findings
        pages = () if page is None else page(source, options, ready, findings)
        if has_errors(findings):
            return report_errors(source, solution.robot, findings, format, pages=pages)
        done = simulate(solution, period=options.period, acceleration=options.acceleration)
        found = clearances(solution, ready.scene, done)
        near = fold(ready.places.finding(finding).within(source) for finding in found)
        findings += near
        files = {path: _simulation_files(path.name, done, source) for path in wanted}
        written = [*_write_simulation(source, files), *pages]
    if format is Format.JSON:
        from assistant.findings.formats import finding_record

        answer: dict[str, Any] = {"source": source, **report.record(done)}
        answer["findings"] = [finding_record(finding) for finding in findings]
        print_json(answer | {"written": [str(path) for path in written]})
        return 1 if has_errors(near) else 0
    print_findings(findings, explained=True)
    say(f"{source} on {done.robot.title}")
    say("")
    for line in report.lines(done):
        say(line)
    for path in written:
        say(f"wrote {path}")
    return 1 if has_errors(near) else 0


def solved_source(source: str, options: SimulationOptions, stands: InCell | None = None) -> Solved:
    """The program of a file, for the arm that runs it. Raises Refused if nobody names one.

    stands: the cell, where it has been read already.
    """
    from assistant.compiler.arms import open_cell
    from assistant.compiler.retarget import solve

    stands = stands or open_cell(options.cell, options.robot)
    stands = stands if options.seeing is None else replace(stands, seeing=options.seeing)
    reader = options.from_robot or stands.robot
    given = (options.process, options.unit, options.from_language, options.entry)
    loaded = load_given(source, reader, *given, stands.around, options.placement)
    return solve(loaded, stands, source, options.from_robot)


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
    if format is Format.JSON:
        from assistant.findings.formats import finding_record

        found = [finding_record(finding) for finding in findings]
        print_json(
            {
                "source": source,
                "robot": robot.name,
                "findings": found,
                "written": list(map(str, pages)),
            }
        )
    else:
        print_findings(findings, explained=True)
        say(f"{source} is not {done}: {robot.title} cannot run it")
        for path in pages:
            say(f"wrote {path}")
    return 1


def _output_files(source: str, outputs: Sequence[str]) -> list[Path]:
    """The files that are to be written; raises Refused for a name that tells no kind."""
    stem = "program" if source == STANDARD else Path(source).stem
    found = []
    for output in outputs:
        path = Path(output)
        if path.is_dir() or not path.suffix:
            found += [path / f"{stem}{end}" for end in _FILE_SUFFIXES]
        elif path.suffix.lower() not in _WRITERS:
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
    if name.lower().endswith(".moves.csv"):
        from assistant.report.timing import moves_csv

        return moves_csv(done)
    return _WRITERS[Path(name).suffix.lower()](done, source)


def _csv(done: Simulation, source: str) -> bytes:  # noqa: ARG001 (each writer is given both)
    from assistant.report.timing import motion_csv

    return motion_csv(done)


def _npz(done: Simulation, source: str) -> bytes:  # noqa: ARG001
    from assistant.report.timing import motion_npz

    return motion_npz(done)


def _picture(format: str) -> Callable[[Simulation, str], bytes]:
    def draw(done: Simulation, source: str) -> bytes:
        from assistant.report.figures import motion_plot

        return motion_plot(done, f"{Path(source).name} on {done.robot.title}", format)

    return draw


_WRITERS: Final[dict[str, Callable[[Simulation, str], bytes]]] = {
    ".csv": _csv,
    ".npz": _npz,
    ".png": _picture("png"),
    ".svg": _picture("svg"),
}
