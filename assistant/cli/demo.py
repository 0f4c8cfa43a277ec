"""`demo`: a trajectory and a drawing on two virtual controllers, with a report and a scene."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.cli.compiling import working
from assistant.cli.presentation import print_findings, say
from assistant.program.diagnostics import Refused, Severity
from assistant.resources import resource

if TYPE_CHECKING:
    from assistant.compiler import Compiled
    from assistant.controllers import Programs
    from assistant.report.page import Program, Section

SOURCES: Final = {
    "positioning.csv": "A trajectory of 35 poses",
    "plate.dxf": "A drawing with locations and contours",
}
ROBOTS: Final = ("irb1200-7-0.7", "rv-2aj")
"""Each has its virtual controller."""
IN_CELL: Final = "plate.dxf"
"""What is shown in the cell of `CELL`."""
CELL: Final = "stand.toml"
REPORT: Final = "report.html"


def run_demo(output: Path) -> int:
    from assistant.report import page

    with ExitStack() as stack:
        controllers = _controllers(stack)
        sections = [
            _section(output, Path(str(resource("samples", name))), title, controllers)
            for name, title in SOURCES.items()
        ]
    _seen(output, Path(str(resource("samples", IN_CELL))))
    from assistant.program.system.writing import write_files

    html = page.page("robot-assistant demo", sections)
    (report,) = write_files({REPORT: html.encode()}, output)
    say(f"the report is {report}")
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


def _section(
    output: Path, source: Path, title: str, controllers: Mapping[str, Programs]
) -> Section:
    from assistant.report import page, plots
    from assistant.report.drawn import drawn_lines
    from assistant.report.track import track

    programs = []
    for robot in ROBOTS:
        compiled = _compiled(source, robot)
        programs.append(_installed(output, source, robot, compiled, controllers[robot]))
    way = track(compiled.program)
    plot = plots.pose_plot(way, f"{source.name}: the TCP over its way")
    from assistant.program.system.writing import write_files

    (png,) = write_files({f"{source.stem}.png": plot}, output)
    say(f"  plot: {png}")
    drawn = [line.points for line in drawn_lines(source)]
    return page.Section(title, tuple(programs), page.plan_view(drawn, way), plot)


def _seen(output: Path, source: Path) -> None:
    """The page of a program in its cell; where the library for cells is not installed, alone."""
    from assistant.cell.rules import NO_LIBRARY
    from assistant.cli.simulating import Options, solved
    from assistant.cli.viewing import shown_of
    from assistant.program.system.writing import write_files
    from assistant.view.page import page

    alone = Options(ROBOTS[0], None, None, None, None, None, None)
    with working(f"looking at {source.name}"):
        try:
            options = replace(alone, cell=Path(str(resource("samples", f"cell/{CELL}"))))
            ready = solved(str(source), options)
        except Refused as refused:
            if {finding.code for finding in refused.findings} != {NO_LIBRARY.code}:
                raise
            options, ready = alone, solved(str(source), alone)
        text = page(shown_of(str(source), options, ready))
    (path,) = write_files({f"{source.stem}.html": text.encode()}, output)
    say(f"  to be looked at in a browser: {path}")


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


def _installed(
    output: Path, source: Path, robot: str, compiled: Compiled, controller: Programs
) -> Program:
    from assistant import deploy, languages
    from assistant.program.system.writing import write_files
    from assistant.report import page

    paths = write_files(compiled.files, output)
    say(f"  written: {', '.join(str(path) for path in paths)}")
    history = output / "deployments"
    done = deploy.deploy(deploy.plan(paths, controller, history=history), history=history)
    if not done.ok:
        raise Refused(*done.findings)
    say(f"  {done.summary}")
    language = languages.get(compiled.language)
    texts = {name: language.decode(data).text for name, data in compiled.files.items()}
    return page.Program(
        source.name,
        language.title,
        robot,
        compiled.proof.line(),
        done.summary,
        tuple(texts.items()),
    )
