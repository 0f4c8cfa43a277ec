"""The demo: a trajectory and a drawing on two virtual controllers, and a page of both.

Each source is compiled for an ABB and a Mitsubishi robot, installed on its virtual controller and
run there. The poses at which the arm passed its points are plotted beside those of the source.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Severity
from assistant.cli.command import command, option
from assistant.cli.options import PageOptions, ReaderOptions
from assistant.cli.presentation import LengthUnit, print_findings, say, working
from assistant.resources import resource

if TYPE_CHECKING:
    from assistant.base.arrays import Floats
    from assistant.cell.scene import Scene
    from assistant.compiler import Compiled
    from assistant.controllers import Controller, Programs
    from assistant.controllers.mitsubishi.data_link import Joints
    from assistant.program.geometry import Pose
    from assistant.program.program import Program
    from assistant.program.se3 import Unit
    from assistant.report.figures import Poses
    from assistant.view.sheets import Sheet
    from assistant.virtual.cr import VirtualCr


@command
class Demo:
    """A drawing and a trajectory to programs on two embedded virtual controllers, with a report."""

    output: Path = option("Folder for what it makes.", "--output", "-o", default=Path("out/demo"))
    unit: LengthUnit = option("Unit of the positions that are drawn.", default=LengthUnit.MM)

    def run(self) -> int:
        from assistant.cli.report_pages import write_page

        sheets: list[Sheet] = []
        with ExitStack() as stack:
            there = _start_cells(stack)
            for source in (_Source(_DRAWING, _sample_path(_DRAWING)), _trajectory()):
                sheets += _run_on_each_robot(self.output, source, there, self.unit.value)
        with working("drawing the page"):
            (report,), _ = write_page(PageOptions(report=self.output / _REPORT), sheets, (), "demo")
        say(f"to be looked at in a browser: {report}")
        for line in _next_steps():
            say(line)
        return 0


def _next_steps() -> Iterator[str]:
    """Yield the first steps of the studio, the installation too where it lacks its libraries."""
    from importlib.util import find_spec

    from assistant.base.installation import install_command

    yield "next: a drawing of yours, in one window of the browser:"
    if any(find_spec(name) is None for name in ("starlette", "uvicorn", "websockets")):
        yield f"  {install_command('studio')}"
    yield "  robot-assistant init cell samples/plate.dxf"
    yield "  robot-assistant studio cell"


ABB: Final = "irb1200-7-0.7"
_MITSUBISHI: Final = "rv-2aj"
TIME_FACTOR: Final = 2.0
"""Simulated seconds for each real one."""
_LOOK_PERIOD: Final = 0.01
"""Seconds between two looks at an arm."""
_JOINT_SENDER: Final = b"""10 WAIT M_RUN(1)=1
20 OPEN "COM2:" AS #1
30 PRINT #1,J_CURR
40 DLY 0.02
50 IF M_RUN(1)=1 THEN 30
60 PRINT #1,J_CURR
70 PRINT #1,"END"
80 CLOSE #1
90 END
"""
"""Sends the joints on a data link while slot 1 runs, as a second task."""


@dataclass(frozen=True, slots=True)
class Cell:
    """A virtual controller with its arm.

    programs: where programs are installed. play: starts the program of a name, and returns the
    joints (n, a) that the arm had until its end.
    """

    robot: str
    programs: Programs
    play: Callable[[str], Floats]

    def seen(self, name: str, tip: Pose) -> Poses:
        """Return the poses of the tip of a tool while the program of that name runs."""
        import numpy as np

        from assistant import robots
        from assistant.base import rotations
        from assistant.report.figures import Poses

        flange, turns = robots.get(self.robot).fk(self.play(name))
        tips = flange + rotations.rotate(turns, np.array(tip.position))
        return Poses(tips, rotations.multiply(turns, np.array(tip.quaternion)))


def _start_cells(stack: ExitStack) -> Mapping[str, Cell]:
    """Start a controller for each robot, both empty, until `stack` is closed."""
    from assistant.controllers import connect
    from assistant.virtual.cr import VirtualCr
    from assistant.virtual.irc5 import VirtualIrc5

    home = stack.enter_context(tempfile.TemporaryDirectory(prefix="robot-assistant-home-"))
    irc5 = stack.enter_context(VirtualIrc5(home, rate=TIME_FACTOR / 2.0))  # it is seen more seldom
    cr = stack.enter_context(VirtualCr(_MITSUBISHI, pace=TIME_FACTOR))

    def play_rapid(name: str) -> Floats:
        with connect(irc5.rws_address, password=irc5.password) as controller:
            return _run_and_watch(cast("Controller", controller), name)

    return {
        ABB: Cell(ABB, connect(irc5.address, password=irc5.password), play_rapid),
        _MITSUBISHI: Cell(
            _MITSUBISHI, connect(cr.address), lambda name: _run_and_receive(cr, name)
        ),
    }


def _run_and_watch(controller: Controller, name: str) -> Floats:
    """Run a program and ask for the joints, by the line that it was started on."""
    import numpy as np

    controller.load(name)
    controller.motors(True)
    controller.start()
    rows = []
    for sample in controller.watch(_LOOK_PERIOD):
        rows.append(sample.position.joints)
        if not sample.state.running:
            break
    controller.motors(False)
    return np.array(rows, dtype=np.float64)


def _run_and_receive(cr: VirtualCr, name: str) -> Floats:
    """Run a program, and have a second one send the joints on a data link meanwhile.

    The line of the commands answers five times a second, and a data link as often as is sent.
    """
    import numpy as np

    from assistant import robots
    from assistant.controllers import connect
    from assistant.controllers.mitsubishi.data_link import DataLink, Form

    form = Form.parse("J_CURR")
    host, port = cr.data_ports["COM2:"]
    rows = []
    with cast("Controller", connect(cr.address)) as controller:
        controller.write("STATUS", _JOINT_SENDER)
        controller.load("STATUS", task="2")
        controller.load(name)
        controller.motors(True)
        controller.start("2")
        with DataLink(f"{host}:{port}") as line:
            controller.start("1")
            while (text := line.receive()) != "END":
                (joints,) = form.read(text)
                rows.append(cast("Joints", joints).values)
        controller.motors(False)
    return np.array(rows, dtype=np.float64)[:, list(robots.get(_MITSUBISHI).places)]


_DRAWING: Final = "plate.dxf"
_TRAJECTORY: Final = "positioning.csv"
"""Poses of `ctraj`, for where it is not installed."""
POSES: Final = 35
TOOL: Final = "GRIPPER"
ROBOTS: Final = (ABB, _MITSUBISHI)
_SHOWN_IN_CELL: Final = (_DRAWING, ABB)
"""Drawing and robot shown in the cell of `CELL`."""
CELL: Final = "stand.toml"
_REPORT: Final = "report.html"


@dataclass(frozen=True, slots=True)
class _Source:
    """Source of a program.

    name: that is shown. given: file or program that is compiled. played: if the arms follow it.
    """

    name: str
    given: Path | Program
    played: bool = False


def _sample_path(name: str) -> Path:
    return Path(str(resource("samples", name)))


def _trajectory() -> _Source:
    """Return a Cartesian trajectory of the Robotics Toolbox; without it, its poses in a table."""
    import assistant
    from assistant.robots.arms.toolbox import toolbox_library

    try:
        with working("loading roboticstoolbox"):
            toolbox = toolbox_library("computing the trajectory with `ctraj`")
    except Refused as refused:
        (missing,) = refused.findings
        say(f"{missing.message}: the demo takes it from {_TRAJECTORY}; {missing.cure}")
        return _Source(_TRAJECTORY, _sample_path(_TRAJECTORY), played=True)
    from spatialmath import SE3

    start = SE3(0.25, -0.08, 0.3) * SE3.RPY(180, 0, 60, unit="deg")
    end = SE3(0.3, 0.08, 0.24) * SE3.RPY(180, 0, 150, unit="deg")
    say(f"ctraj of roboticstoolbox {toolbox.__version__}: {POSES} poses between two SE3")
    program = assistant.from_poses(
        toolbox.ctraj(start, end, POSES),
        unit="m",
        name=Path(_TRAJECTORY).stem,
        speed=150,
        blend=100,
        tool=TOOL,
        process=_sample_path("positioning.process.toml"),
    )
    return _Source(f"{program.name} by ctraj", program, played=True)


def _run_on_each_robot(
    output: Path, source: _Source, there: Mapping[str, Cell], unit: Unit
) -> Iterator[Sheet]:
    """A source for each robot, as it is installed and played there, with a plot of it."""
    from assistant import robots
    from assistant.cli.report_pages import compiled_sheet, drawing_lines
    from assistant.report.track import track

    given = source.given
    drawn = drawing_lines(str(given), ReaderOptions()) if isinstance(given, Path) else ()
    passed: dict[str, Poses] = {}
    for robot in ROBOTS:
        compiled = _compile_source(source, robot)
        notes = [_install(output, compiled, there[robot])]
        if source.played:
            passed[robot], note = _run_and_compare(compiled, there[robot])
            notes.append(note)
        elif robot == ROBOTS[0]:
            from assistant.report import figures

            title = f"{source.name}: the TCP over its way"
            _write_pose_plot(
                output, source, figures.pose_plot(track(compiled.program), title, unit)
            )
        scene = _demo_scene(robot) if (source.name, robot) == _SHOWN_IN_CELL else None
        found = (
            replace(one, path=source.name if one.path == str(given) else one.path)
            for one in compiled.found
        )  # of a file that somebody else installed
        compiled = replace(compiled, found=tuple(found))
        sheet = compiled_sheet(source.name, compiled, scene, robots.get(robot), drawn)
        yield replace(sheet, notes=(*sheet.notes, *notes))
    if passed:
        from assistant.report.figures import point_plot

        title = f"{source.name}: the TCP at its {POSES} points"
        _write_pose_plot(
            output, source, point_plot(_program_points(compiled), passed, title, unit=unit)
        )


def _write_pose_plot(output: Path, source: _Source, plot: bytes) -> None:
    from assistant.base.file_sets import write_files

    given = source.given
    stem = given.stem if isinstance(given, Path) else given.name
    (png,) = write_files({f"{stem}.png": plot}, output)
    say(f"  plot: {png}")


def _program_points(compiled: Compiled) -> Poses:
    """The points of a program, in the order of its statements."""
    from assistant.report.figures import Poses
    from assistant.report.track import track

    way = track(compiled.program)
    return Poses(way.positions, way.quaternions)


def _run_and_compare(compiled: Compiled, cell: Cell) -> tuple[Poses, str]:
    """Run the program; returns the poses at which the arm passed its points, and a note on them."""
    from assistant.report.figures import passed_poses

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


def _compile_source(source: _Source, robot: str) -> Compiled:
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
