"""`demo`: a trajectory and a drawing on two virtual controllers, and a page of both."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.cli.compiling import working
from assistant.cli.presentation import print_findings, say
from assistant.program.diagnostics import Refused, Severity
from assistant.resources import resource

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.compiler import Compiled
    from assistant.controllers import Programs
    from assistant.view.sheets import Sheet

SOURCES: Final = ("plate.dxf", "positioning.csv")
ROBOTS: Final = ("irb1200-7-0.7", "rv-2aj")
"""Each has its virtual controller."""
IN_CELL: Final = ("plate.dxf", "irb1200-7-0.7")
"""What is shown in the cell of `CELL`."""
CELL: Final = "stand.toml"
REPORT: Final = "report.html"


def run_demo(output: Path) -> int:
    from assistant.cli.pages import Asked, write_page

    sheets: list[Sheet] = []
    with ExitStack() as stack:
        controllers = _controllers(stack)
        for name in SOURCES:
            sheets += _sheets(output, Path(str(resource("samples", name))), controllers)
    with working("drawing the page"):
        (report,), _ = write_page(Asked(output / REPORT), sheets, (), "demo")
    say(f"to be looked at in a browser: {report}")
    return 0


def _controllers(stack: ExitStack) -> Mapping[str, Programs]:
    """A client of a running virtual controller for each robot; both are empty at first."""
    from assistant.controllers import connect
    from assistant.virtual.cr import VirtualCr
    from assistant.virtual.irc5 import VirtualIrc5

    home = stack.enter_context(tempfile.TemporaryDirectory(prefix="robot-assistant-home-"))
    irc5 = stack.enter_context(VirtualIrc5(home))
    cr = stack.enter_context(VirtualCr("rv-2aj"))
    return {
        "irb1200-7-0.7": connect(irc5.address, password=irc5.password),
        "rv-2aj": connect(cr.address),
    }


def _sheets(output: Path, source: Path, controllers: Mapping[str, Programs]) -> Iterator[Sheet]:
    """A source for each robot, as it is installed there, with a plot of it."""
    from assistant import robots
    from assistant.cli.sheets import compiled_sheet, lines_of_drawing
    from assistant.program.system.writing import write_files
    from assistant.report import plots
    from assistant.report.track import track

    drawn = lines_of_drawing(str(source), None, None)
    for robot in ROBOTS:
        compiled = _compiled(source, robot)
        installed = _installed(output, compiled, controllers[robot])
        if robot == ROBOTS[0]:
            way = track(compiled.program)
            plot = plots.pose_plot(way, f"{source.name}: the TCP over its way")
            (png,) = write_files({f"{source.stem}.png": plot}, output)
            say(f"  plot: {png}")
        scene = _scene(robot) if (source.name, robot) == IN_CELL else None
        found = (
            replace(one, path=source.name if one.path == str(source) else one.path)
            for one in compiled.found
        )  # of a file that somebody else installed
        compiled = replace(compiled, found=tuple(found))
        sheet = compiled_sheet(source.name, compiled, scene, robots.get(robot), drawn)
        yield replace(sheet, notes=(*sheet.notes, installed))


def _scene(robot: str) -> Scene | None:
    """The cell; nothing where the library for cells is not installed."""
    from assistant.cell.rules import NO_LIBRARY
    from assistant.compiler.scenes import in_cell

    try:
        return in_cell(str(resource("samples", f"cell/{CELL}")), robot).scene
    except Refused as refused:
        if {finding.code for finding in refused.findings} != {NO_LIBRARY.code}:
            raise
        return None


def _compiled(source: Path, robot: str) -> Compiled:
    from assistant import robots
    from assistant.compiler import compile

    language = robots.get(robot).languages[0]
    with working(f"compiling {source.name} for {robot}"):
        compiled = compile(source, language=language, robot=robot)
    asked = (f for f in compiled.findings if f.severity is not Severity.INFO)
    print_findings(f.within(source.name) for f in asked)
    say(f"{source.name} for {robot}: {compiled.proof.line()}")
    if not compiled.ok:
        raise Refused(*compiled.findings)
    return compiled


def _installed(output: Path, compiled: Compiled, controller: Programs) -> str:
    """Installs a program on a controller; what was done, in a line."""
    from assistant import deploy
    from assistant.program.system.writing import write_files

    paths = write_files(compiled.files, output)
    say(f"  written: {', '.join(str(path) for path in paths)}")
    history = output / "deployments"
    done = deploy.deploy(deploy.plan(paths, controller, history=history), history=history)
    if not done.ok:
        raise Refused(*done.findings)
    say(f"  {done.summary}")
    return done.summary
