"""Show programs, drawings and cells: the commands `simulate`, `view`, `info` and `scene`.

`view --live` serves a page that follows a controller until Ctrl-C or until the controller is lost;
it only reads. `scene` prints the bodies of a cell, or writes them as a cell file or glTF.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
import webbrowser
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, Severity, error, fold, has_errors, worst
from assistant.base.termination import is_ctrl_c
from assistant.cli.command import argument, command, option
from assistant.cli.controller_session import Session, connected, robot_of_cell, state_lines
from assistant.cli.options import (
    NO_PAGE,
    PAGE_SUFFIXES,
    AccelerationOption,
    CellOption,
    DrawingOptions,
    FormatOption,
    ReaderOptions,
    RobotOption,
    Source,
    UnitOption,
    WrittenOptions,
    with_project_defaults,
)
from assistant.cli.presentation import (
    Format,
    print_answer,
    print_findings,
    print_json,
    say,
    working,
)
from assistant.cli.report_pages import page_name, solved_sheet
from assistant.cli.simulation import report_errors, solved_source
from assistant.cli.source_input import keep_sources
from assistant.view.sheets import shown_sheet

if TYPE_CHECKING:
    from assistant.cell.scene import Scene as CellScene
    from assistant.compiler.retarget import Solved
    from assistant.controllers.states import Position, Sample
    from assistant.robots import Robot
    from assistant.view.live_page import LivePage
    from assistant.view.page_contents import Shown


@command
class View:
    """Show a program in its cell: arm, bodies, path and contacts over time. Nothing moves."""

    program: Source
    robot: RobotOption
    cell: CellOption
    html: Path | None = option("File for the page, which needs no other; default it is opened.")
    live: str | None = option(
        "Controller that the page follows until Ctrl-C; it is only looked at.", metavar="CONTROLLER"
    )
    acceleration: AccelerationOption
    reader: DrawingOptions
    written: WrittenOptions
    format: FormatOption

    def run(self) -> int:
        """1 if the robot cannot run the program, or not without contact, else 0."""
        from assistant.findings.formats import records_of
        from assistant.view.page import page

        if self.html is not None and (
            self.html.suffix.lower() not in PAGE_SUFFIXES or not self.html.stem
        ):
            raise Refused(NO_PAGE(name=self.html), exit_status=2)
        if self.html is not None and self.live is not None:
            raise Refused(_LIVE_NOT_WRITTEN(), exit_status=2)
        options = with_project_defaults(self.program, self)
        with working(f"looking at {self.program}"):
            ready = solved_source(
                self.program,
                options.reader,
                robot=options.robot,
                cell=options.cell,
                written=options.written,
            )
            robot = ready.solution.robot
            if has_errors(ready.findings):
                return report_errors(self.program, robot, ready.findings, self.format, "shown")
            shown = _view_contents(options, ready)
            path = (
                None
                if self.live is not None
                else _write_view(self.program, options.cell, self.html, page(shown))
            )
        findings = [shown.places.finding(one).within(self.program) for one, _ in shown.findings]
        records = records_of(findings)
        answer: dict[str, Any] = {"source": self.program, "robot": robot.name, "findings": records}
        if self.format is not Format.JSON:
            print_findings(fold(findings), explained=True)
        if self.live is not None:
            following = partial(_live_page, shown)
            _run_live(self.live, robot, following, answer, self.format)
        elif self.format is Format.JSON:
            print_json(answer | {"written": [str(path)]})
        else:
            say(f"wrote {path}")
        return 1 if has_errors(findings) else 0


@command
class Info:
    """Tell what is in a drawing: unit, size, layers, contours, blocks, and what would be used."""

    drawing: Path = argument("A DXF drawing.")
    reader: ReaderOptions
    format: FormatOption

    def run(self) -> int:
        """0; 1 if something of the drawing is not in order."""
        from assistant.base.length_units import known_unit
        from assistant.findings.severities import apply_severities
        from assistant.report import drawings as report
        from assistant.sources import process_of
        from assistant.sources.drawing.survey import survey
        from assistant.sources.process import NO_PROCESS
        from assistant.sources.process.placement import DRAWING_SUFFIXES

        if self.drawing.suffix.lower() not in DRAWING_SUFFIXES:
            raise Refused(_NOT_DRAWN(path=str(self.drawing), name=self.drawing.name), exit_status=2)
        left = list[Diagnostic]()
        try:
            chosen, stated = (
                process_of(self.drawing, self.reader.process),
                "as the process file says",
            )
        except (
            Refused
        ) as refused:  # one that is not finished yet; the drawing is there all the same
            if self.reader.process is not None:
                raise
            chosen, stated, left = NO_PROCESS, "", [*refused.findings]
        if self.reader.unit is not None:
            chosen, stated = replace(chosen, unit=known_unit(self.reader.unit)), "as --unit says"
        with working(f"reading {self.drawing}"):
            found = survey(self.drawing, chosen, stated)
        told = [
            finding.within(str(self.drawing))
            for finding in (*left, *chosen.findings, *found.findings)
        ]
        findings = apply_severities(told).left
        answer = {"drawing": str(self.drawing), **report.record(found)}
        shown = findings if self.format is Format.JSON else fold(findings)
        print_answer(self.format, answer, report.lines(found), shown)
        return 1 if worst(findings) in (Severity.ERROR, Severity.WARNING) else 0


@command
class Scene:
    """List the contents of a cell, body by body, or write it as another file."""

    file: Path = argument("Cell file, or a drawing of the cell.")
    output: Path | None = option(
        "Cell file (.toml) or glTF (.glb) to write instead.", "--output", "-o"
    )
    unit: UnitOption
    format: FormatOption

    def run(self) -> int:
        """0; unit: of a drawing, whatever that says."""
        from assistant.report import scenes as report

        if self.output is not None and (
            self.output.suffix.lower() not in (_SCENE_SUFFIXES, _GLTF_SUFFIX)
            or not self.output.stem
        ):
            raise Refused(_NO_SCENE(name=self.output), exit_status=2)
        as_text = self.output is not None and self.output.suffix.lower() == _SCENE_SUFFIXES
        with working(f"reading {self.file}"):
            try:
                scene, found, others = _read_scene(self.file, self.unit, as_text)
                told = report.record(scene)  # refuses what stands in nothing
            except Refused as refused:
                at = (finding.within(str(self.file)) for finding in refused.findings)
                raise Refused(*at, exit_status=refused.exit_status) from None
            files = {} if self.output is None else _scene_files(scene, self.output)
            if as_text:
                found += _left_out_tables(others)
            written = _write_scene(self.file, files)
        findings = [finding.within(str(self.file)) for finding in found]
        shown = findings if self.format is Format.JSON else fold(findings)
        lines = report.lines(scene) if self.output is None else ()
        print_answer(self.format, {"cell": str(self.file), **told}, lines, shown, written)
        return 0


_NO_BROWSER = error(
    "CL035",
    "no browser could be opened here",
    "write the page with --html FILE.html, and open that",
)
_LIVE_NOT_WRITTEN = error(
    "CL046",
    "a page that follows a controller is served, and cannot be written to a file",
    "leave out --html or --live",
)


def _view_contents(options: View, ready: Solved) -> Shown:
    """Return the page contents of a program without errors, with the findings about its motion.

    Raises Refused for a cell without its robot.
    """
    from assistant.checks import robot_rules
    from assistant.checks.clearances import no_robot

    solution = ready.solution
    if ready.scene is not None:
        from assistant.cell.clearances import robot_of

        try:
            robot_of(ready.scene, solution.robot)
        except LookupError:
            raise Refused(no_robot(solution.robot, ready.scene), exit_status=2) from None
    found = robot_rules.check(solution)
    sheet = solved_sheet(options.program, ready, options.reader, options.acceleration, found)
    return shown_sheet(replace(sheet, plan=False))


def _live_page(shown: Shown, name: str) -> str:
    from assistant.view.page import page

    return page(replace(shown, live=name))


def _write_view(source: str, cell: Path | None, html: Path | None, text: str) -> Path:
    from assistant.base.file_sets import write_all, write_files

    if html is not None:
        keep_sources([source, *([] if cell is None else [str(cell)])], [html])
        (path,) = write_all({html: text.encode()})
        return path
    folder = tempfile.mkdtemp(prefix="robot-assistant-view-")
    (path,) = write_files({f"{page_name(source)}.html": text.encode()}, folder)
    if not webbrowser.open(path.as_uri()):
        shutil.rmtree(folder, ignore_errors=True)
        raise Refused(_NO_BROWSER(), exit_status=2)
    return path


_OTHER_ROBOT: Final = error(
    "CL047",
    "`{name}` moves a {there} by the project, and the program is shown on a {robot}",
    "name the controller of that robot, or the robot of this one with --robot",
)
_OTHER_AXES: Final = error(
    "CL048",
    "`{name}` tells of the axes {there}, and a {robot} has {own}",
    "name the robot that it moves with --robot",
)
_NOT_SERVED: Final = error(
    "CL049", "the page cannot be served on this computer: {reason}", "try it again"
)
_LIVE_PERIOD: Final = 0.1
"""Seconds between two looks at the controller."""
_ARM_AXES: Final = 6
"""Axes that a controller assigns to the arm; later ones are additional axes."""


def _run_live(
    address: str, robot: Robot, page: Callable[[str], str], answer: dict[str, Any], format: Format
) -> None:
    """Serve a page until Ctrl-C or until the controller is lost, and send it the positions of the
    arm.

    page: its text, from the name of the controller. answer: the program's part of `--format json`.
    Raises Refused for a controller that cannot be reached or moves another robot.
    """
    from assistant.view.live_page import LivePage

    with connected(address, "view --live") as there:
        name = there.one.name
        _check_robot(there, robot)
        _check_axes(name, robot, there.controller.position())
        served = LivePage(page(name))
        try:
            served.__enter__()
        except OSError as failed:
            reason = failed.strerror or str(failed)
            raise Refused(_NOT_SERVED(reason=reason)) from None
        try:
            _announce_page(name, served, answer, format)
            _follow_controller(there, robot, served)
        except KeyboardInterrupt as caught:
            if not is_ctrl_c(caught):
                raise
        except Refused as refused:
            served.tell("lost", {"text": refused.findings[0].message})
            raise
        finally:
            served.__exit__(None, None, None)


def _announce_page(name: str, served: LivePage, answer: dict[str, Any], format: Format) -> None:
    if format is Format.JSON:
        print_json(answer | {"follows": name, "address": served.address})
    else:
        say(f"following {name} on {served.address}, listening there until Ctrl-C")
    sys.stdout.flush()
    # A browser of the terminal would come back only when it is closed.
    Thread(target=webbrowser.open, args=(served.address,), daemon=True).start()


def _follow_controller(there: Session, robot: Robot, served: LivePage) -> None:
    before = 0.0
    for sample in there.controller.watch(_LIVE_PERIOD):
        joints = _arm_joints(robot, sample.position)
        if joints is not None:
            interval = max(_LIVE_PERIOD, sample.seconds - before)
            served.tell("sample", _state_record(there.one.name, robot, joints, sample, interval))
            before = sample.seconds


def _state_record(
    name: str, robot: Robot, joints: list[float], sample: Sample, interval: float
) -> dict[str, Any]:
    import numpy as np

    from assistant.base.source_text import visible

    return {
        "joints": robot.chained(np.array([joints]))[0].tolist(),
        "state": visible(f"{name}: {'; '.join(state_lines(sample.state))}"),
        "interval": interval,
    }


def _check_robot(there: Session, robot: Robot) -> None:
    said = robot_of_cell(there.one)
    if said is not None and said.name != robot.name:
        finding = _OTHER_ROBOT(name=there.one.name, there=said.title, robot=robot.title)
        raise Refused(finding, exit_status=2)


def _check_axes(name: str, robot: Robot, position: Position) -> None:
    there = [i for i, joint in enumerate(position.joints) if joint is not None]
    if [i for i in there if i < max(_ARM_AXES, len(robot.axes))] != list(robot.places):
        told = ", ".join(f"J{i + 1}" for i in there) or "none"
        own = ", ".join(robot.axes)
        finding = _OTHER_AXES(name=name, there=told, robot=robot.title, own=own)
        raise Refused(finding, exit_status=2)


def _arm_joints(robot: Robot, position: Position) -> list[float] | None:
    """The joints of the arm's axes, None if one is not told at the moment."""
    import numpy as np

    joints = [position.joints[i] for i in robot.places if i < len(position.joints)]
    known = [joint for joint in joints if joint is not None and np.isfinite(joint)]
    return known if len(known) == len(robot.axes) else None


_NOT_DRAWN = error(
    "CL050",
    "`{name}` is no drawing",
    "name a DXF file; `show` prints what programs and tables say",
)


_NO_SCENE = error(
    "CL045",
    "a scene is not written as `{name}`",
    "end the name in .toml for a cell file, or in .glb for glTF",
)
_SCENE_SUFFIXES, _GLTF_SUFFIX = ".toml", ".glb"
_WORLD_TABLES: Final = ("world", "robots", "bodies", "frames")
"""Tables of a cell file that a scene holds."""


def _read_scene(
    cell: Path, unit: str | None, as_text: bool
) -> tuple[CellScene, tuple[Diagnostic, ...], tuple[str, ...]]:
    """Return the scene of a cell file or of a drawing, its findings, and its other tables.

    as_text: without the explored space of charts, which the text only names.
    """
    from assistant.base.budgets import SETTINGS_FILE
    from assistant.base.length_units import known_unit, unit_stated
    from assistant.base.source_text import decode, read_bytes
    from assistant.cell.cell_file import parse_scene
    from assistant.cell.drawing_bodies import read_drawing
    from assistant.cell.scene import Scene as CellScene
    from assistant.program.settings_tables import ENCODINGS, read_toml
    from assistant.sources.process.placement import DRAWING_SUFFIXES

    if unit is not None:
        known_unit(unit)
    if cell.suffix.lower() in DRAWING_SUFFIXES:
        drawn = read_drawing(cell, unit)
        return CellScene(drawn.bodies), drawn.findings, ()
    source = decode(read_bytes(cell, most=SETTINGS_FILE), str(cell), ENCODINGS)
    found: tuple[Diagnostic, ...] = () if unit is None else (unit_stated(str(cell), unit),)
    scene, said = parse_scene(source, cell.parent, explored=not as_text)
    others = tuple(key for key in read_toml(source).content if key not in _WORLD_TABLES)
    return scene, (*found, *said), others


def _scene_files(scene: CellScene, output: Path) -> dict[Path, bytes]:
    from assistant.cell.scene_export import cell_files, gltf

    if output.suffix.lower() == _GLTF_SUFFIX:
        return {output: gltf(scene)}
    files = cell_files(scene, output.stem, output.parent)
    text = files.pop(f"{output.stem}.toml")
    return {output: text, **{output.parent / name: data for name, data in files.items()}}


def _left_out_tables(others: tuple[str, ...]) -> tuple[Diagnostic, ...]:
    from assistant.cell.findings import TABLE_LEFT_OUT
    from assistant.program.settings_tables import shown

    return tuple(TABLE_LEFT_OUT(table=shown(name)) for name in others)


def _write_scene(cell: Path, files: dict[Path, bytes]) -> tuple[Path, ...]:
    from assistant.base.file_sets import write_all

    keep_sources([str(cell)], list(files))
    return write_all(files) if files else ()
