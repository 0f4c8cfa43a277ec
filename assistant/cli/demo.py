"""`demo`: a trajectory and a drawing on two virtual controllers, and a page of both."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, Severity
from assistant.cli.compiling import working
from assistant.cli.demo_cells import ABB, MITSUBISHI, Cell, start_cells
from assistant.cli.presentation import print_findings, say
from assistant.resources import resource

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.compiler import Compiled
    from assistant.program.program import Program
    from assistant.program.se3 import Unit
    from assistant.report.points import Poses
    from assistant.view.sheets import Sheet

DRAWING: Final = "plate.dxf"
TRAJECTORY: Final = "positioning.csv"
"""Poses of `ctraj`, for where it is not installed."""
POSES: Final = 35
TOOL: Final = "GRIPPER"
ROBOTS: Final = (ABB, MITSUBISHI)
SHOWN_IN_CELL: Final = (DRAWING, ABB)
"""What is shown in the cell of `CELL`."""
CELL: Final = "stand.toml"
REPORT: Final = "report.html"


@dataclass(frozen=True, slots=True)
class Source:
    """Source of a program.

    name: that is shown. given: file or program that is compiled. played: if the arms follow it.
    """

    name: str
    given: Path | Program
    played: bool = False


def run_demo(output: Path, unit: Unit) -> int:
    from assistant.cli.pages import PageRequest, write_page

    sheets: list[Sheet] = []
    with ExitStack() as stack:
        there = start_cells(stack)
        for source in (Source(DRAWING, _sample_path(DRAWING)), trajectory()):
            sheets += _run_on_each_robot(output, source, there, unit)
    with working("drawing the page"):
        (report,), _ = write_page(PageRequest(output / REPORT), sheets, (), "demo")
    say(f"to be looked at in a browser: {report}")
    return 0


def _sample_path(name: str) -> Path:
    return Path(str(resource("samples", name)))


def trajectory() -> Source:
    """Return a Cartesian trajectory of the Robotics Toolbox; without it, its poses in a table."""
    import assistant
    from assistant.robots.arms.toolbox import toolbox_library

    try:
        with working("loading roboticstoolbox"):
            toolbox = toolbox_library("computing the trajectory with `ctraj`")
    except Refused as refused:
        (missing,) = refused.findings
        say(f"{missing.message}: the demo takes it from {TRAJECTORY}; {missing.cure}")
        return Source(TRAJECTORY, _sample_path(TRAJECTORY), played=True)
    from spatialmath import SE3

    start = SE3(0.25, -0.08, 0.3) * SE3.RPY(180, 0, 60, unit="deg")
    end = SE3(0.3, 0.08, 0.24) * SE3.RPY(180, 0, 150, unit="deg")
    say(f"ctraj of roboticstoolbox {toolbox.__version__}: {POSES} poses between two SE3")
    program = assistant.from_poses(
        toolbox.ctraj(start, end, POSES),
        unit="m",
        name=Path(TRAJECTORY).stem,
        speed=150,
        blend=100,
        tool=TOOL,
        process=_sample_path("positioning.process.toml"),
    )
    return Source(f"{program.name} by ctraj", program, played=True)


def _run_on_each_robot(
    output: Path, source: Source, there: Mapping[str, Cell], unit: Unit
) -> Iterator[Sheet]:
    """A source for each robot, as it is installed and played there, with a plot of it."""
    from assistant import robots
    from assistant.cli.sheets import compiled_sheet, drawing_lines
    from assistant.report.track import track

    given = source.given
    drawn = drawing_lines(str(given), None, None) if isinstance(given, Path) else ()
    passed: dict[str, Poses] = {}
    for robot in ROBOTS:
        compiled = _compile_source(source, robot)
        notes = [_install(output, compiled, there[robot])]
        if source.played:
            passed[robot], note = _run_and_compare(compiled, there[robot])
            notes.append(note)
        elif robot == ROBOTS[0]:
            from assistant.report import plots

            title = f"{source.name}: the TCP over its way"
            _write_pose_plot(output, source, plots.pose_plot(track(compiled.program), title, unit))
        scene = _demo_scene(robot) if (source.name, robot) == SHOWN_IN_CELL else None
        found = (
            replace(one, path=source.name if one.path == str(given) else one.path)
            for one in compiled.found
        )  # of a file that somebody else installed
        compiled = replace(compiled, found=tuple(found))
        sheet = compiled_sheet(source.name, compiled, scene, robots.get(robot), drawn)
        yield replace(sheet, notes=(*sheet.notes, *notes))
    if passed:
        from assistant.report.points import point_plot

        title = f"{source.name}: the TCP at its {POSES} points"
        _write_pose_plot(
            output, source, point_plot(_program_points(compiled), passed, title, unit=unit)
        )


def _write_pose_plot(output: Path, source: Source, plot: bytes) -> None:
    from assistant.base.file_sets import write_files

    given = source.given
    stem = given.stem if isinstance(given, Path) else given.name
    (png,) = write_files({f"{stem}.png": plot}, output)
    say(f"  plot: {png}")


def _program_points(compiled: Compiled) -> Poses:
    """The points of a program, in the order of its statements."""
    from assistant.report.points import Poses
    from assistant.report.track import track

    way = track(compiled.program)
    return Poses(way.positions, way.quaternions)


def _run_and_compare(compiled: Compiled, cell: Cell) -> tuple[Poses, str]:
    """Run the program; returns the poses at which the arm passed its points, and a note on them."""
    from assistant.report.points import passed_poses

    tool = compiled.program.tools[TOOL]
    name = cell.programs.name_for(next(iter(compiled.files)))
    with working(f"playing {name} on the virtual controller"):
        seen = cell.seen(name, tool.tip)
    points = _program_points(compiled)
    there = passed_poses(points, seen)
    apart, turned = points.deviation(there)
    near = f"within {apart:.2f} mm and {turned:.2f} degrees"
    note = f"played: {len(points)} points passed {near}, by {len(seen)} looks at the arm"
    say(f"  {note}")
    return there, note


def _demo_scene(robot: str) -> Scene | None:
    """The cell; nothing where the library for cells is not installed."""
    from assistant.cell.findings import NO_LIBRARY
    from assistant.compiler.arms import open_cell

    try:
        return open_cell(str(resource("samples", f"cell/{CELL}")), robot).scene
    except Refused as refused:
        if {finding.code for finding in refused.findings} != {NO_LIBRARY.code}:
            raise
        return None


def _compile_source(source: Source, robot: str) -> Compiled:
    from assistant import robots
    from assistant.compiler import compile

    language = robots.get(robot).languages[0]
    with working(f"compiling {source.name} for {robot}"):
        compiled = compile(source.given, language=language, robot=robot)
    asked = (f for f in compiled.findings if f.severity is not Severity.INFO)
    print_findings(f.within(source.name) for f in asked)
    say(f"{source.name} for {robot}: {compiled.proof.line()}")
    if not compiled.ok:
        raise Refused(*compiled.findings)
    return compiled


def _install(output: Path, compiled: Compiled, cell: Cell) -> str:
    """Installs a program on a controller; what was done, in a line."""
    from assistant import deploy
    from assistant.base.file_sets import write_files

    paths = write_files(compiled.files, output)
    say(f"  written: {', '.join(str(path) for path in paths)}")
    history = output / "deployments"
    done = deploy.deploy(deploy.plan(paths, cell.programs, history=history), history=history)
    if not done.ok:
        raise Refused(*done.findings)
    say(f"  {done.summary}")
    return done.summary
