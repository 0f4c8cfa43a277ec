"""Reach of an arm: maps of it, the best places of base and work piece, and swept space.

`reach map` covers a region; `reach base` and `reach place` try places for the targets of a program
or of a table; `reach swept` adds up the space that an arm sweeps. Regions are LOW:HIGH:STEP in mm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, error, fold, has_errors, info
from assistant.cli.command import Option, argument, command_group, command_of, option, options
from assistant.cli.options import (
    CellOption,
    EntryOption,
    FormatOption,
    FromLanguage,
    ReaderOptions,
    RobotOption,
    Source,
    WrittenOptions,
)
from assistant.cli.presentation import print_answer, working
from assistant.cli.simulation import report_errors, solved_source
from assistant.cli.source_input import NO_FILE_NAME, keep_sources

if TYPE_CHECKING:
    from assistant.cell import placement
    from assistant.cell.placement import Places
    from assistant.cell.reach_map import NumberRange, ReachMap
    from assistant.cell.scene import PlacedRobot, Scene
    from assistant.cell.swept_space import SweptSpace
    from assistant.program.geometry import Pose
    from assistant.robots import Robot


reach: Final = command_group(
    "What an arm reaches, where things stand best, which space a program sweeps."
)
_RANGE_FORM: Final = "LOW:HIGH:STEP"
_WorldRange = Annotated[str | None, Option("mm of the world.", metavar=_RANGE_FORM)]
_OffsetRange = Annotated[str | None, Option("mm from where it is.", metavar=_RANGE_FORM)]
TipOption = Annotated[
    str | None, Option("x,y,z[,w,x,y,z] of the tip on the flange, mm; default the flange itself.")
]
MarginOption = Annotated[
    float | None, Option("mm to keep from everything; default those of the cell file.")
]


_NO_ARM = error(
    "CL036",
    "nobody says which robot it is about",
    "name one with --robot, as the cell file does or of the catalogue; `robot-assistant robots` "
    "lists these",
)
_UNKNOWN_RESULT = error("CL037", "this is not written as `{name}`", "end the name in {known}")
_NOT_A_TIP = error(
    "CL038", "`{given}` is no tip", "write x,y,z or x,y,z,w,x,y,z: mm and a quaternion"
)
_BAD_MARGIN = error("CL039", "{given:g} is no margin", "write mm, 0 or more")
_DEFAULT_STEP: Final = 100.0
"""mm of a region that nobody states."""


@dataclass(frozen=True, slots=True)
class _PlacedArm:
    """The arm in its scene. bodies: whether anything may be touched there."""

    scene: Scene
    placed: PlacedRobot
    tip: Pose
    bodies: bool
    findings: tuple[Diagnostic, ...]


@command_of(reach)
class Map:
    """Tell which part of a region an arm reaches, with which directions of its tool."""

    robot: RobotOption
    cell: CellOption
    x: _WorldRange
    y: _WorldRange
    z: _WorldRange
    direction: tuple[str, ...] = option(
        "Of the tool's z axis: down, up, x,y,z, or with /DEGREES a cone; repeatable."
    )
    turns: int = option(
        "Turns of the tool about its z axis that are tried; 1 if its turn counts.", default=12
    )
    tip: TipOption
    margin: MarginOption
    output: tuple[str, ...] = option(
        "File to write: .csv, .npz, .png or .svg; repeatable.", "--output", "-o"
    )
    format: FormatOption

    def run(self) -> int:
        """0; what is not reached is an answer."""
        from assistant.cell.findings import NOTHING_REACHED
        from assistant.cell.reach_map import grid, parse_directions, reach_map
        from assistant.report import workspace as report

        files = _output_files(self.output, (".csv", ".npz", ".png", ".svg"))
        directions = self.direction or ("down",)
        turned = parse_directions(directions, self.turns)
        with working("looking at what is reached"):
            there = _placed_arm(self.cell, self.robot, self.tip, self.margin)
            ranges = {"x": self.x, "y": self.y, "z": self.z}
            points = grid([_axis_range(there, axis, text) for axis, text in ranges.items()])
            found = reach_map(
                there.scene,
                there.placed,
                points,
                turned,
                tip=there.tip,
                bodies=there.bodies,
                margin=self.margin,
            )
            title = f"{there.placed.robot.title}, {', '.join(directions)}"
            written = _write_reach(
                self.cell, {file: _map_data(found, title, file) for file in files}
            )
        findings = list(there.findings)
        if not found.reached.any():
            findings.append(NOTHING_REACHED(why=_likely_obstacles(there, found)))
        print_answer(
            self.format,
            {"robot": there.placed.robot.name, **report.map_record(found)},
            (f"{there.placed.robot.title}: {len(points):,} points", "", *report.map_lines(found)),
            findings,
            written,
        )
        return 1 if has_errors(findings) else 0


def _map_data(found: ReachMap, title: str, file: Path) -> bytes:
    from assistant.report import workspace as report

    match file.suffix.lower():
        case ".csv":
            return report.map_csv(found)
        case ".npz":
            return report.map_npz(found)
        case suffix:
            return report.map_picture(found, title, suffix[1:])


def _placed_arm(
    cell: Path | None,
    named: str | None,
    given_tip: str | None = None,
    margin: float | None = None,
    known: Robot | None = None,
) -> _PlacedArm:
    """Return the arm, alone in the world if no cell is given. known: that of a program.

    Raises Refused if no arm is named, or it is not in the cell.
    """
    from assistant.cell import link_bodies
    from assistant.cell.clearances import robot_of
    from assistant.cell.scene import Scene
    from assistant.checks.clearances import no_robot
    from assistant.compiler.arms import open_cell

    tip = _tip_pose(given_tip)
    if margin is not None and not 0.0 <= margin < float("inf"):
        raise Refused(_BAD_MARGIN(given=margin), exit_status=2)
    found = open_cell(cell, named)
    robot, scene = found.robot or known, found.scene
    if scene is None:
        if robot is None:
            raise Refused(_NO_ARM(), exit_status=2)
        alone = link_bodies.place_robot("robot", robot)
        return _PlacedArm(Scene(robots=(alone,)), alone, tip, False, found.findings)
    if robot is None and len(scene.robots) == 1:
        return _PlacedArm(scene, scene.robots[0], tip, True, found.findings)
    if robot is None:
        raise Refused(_NO_ARM(), exit_status=2)
    try:
        return _PlacedArm(scene, robot_of(scene, robot), tip, True, found.findings)
    except LookupError:
        raise Refused(no_robot(robot, scene), exit_status=2) from None


def _tip_pose(given: str | None) -> Pose:
    import numpy as np

    from assistant.base import rotations
    from assistant.program.geometry import IDENTITY, Pose

    if given is None:
        return IDENTITY
    try:
        numbers = np.array([float(part) for part in given.split(",")])
    except ValueError:
        numbers = np.zeros(0)
    if len(numbers) not in (3, 7) or not np.isfinite(numbers).all():
        raise Refused(_NOT_A_TIP(given=given), exit_status=2)
    turn = numbers[3:] if len(numbers) == 7 else np.array([1.0, 0.0, 0.0, 0.0])
    if not np.linalg.norm(turn) > 0.0:
        raise Refused(_NOT_A_TIP(given=given), exit_status=2)
    return Pose.of(numbers[:3], rotations.canonical(turn))


def _axis_range(there: _PlacedArm, axis: str, text: str | None) -> NumberRange:
    """Return the stated range, or all that the arm could reach."""
    import numpy as np

    from assistant.cell.reach_map import NumberRange, parse_range

    if text is not None:
        return parse_range(text, axis)
    middle = there.placed.base.position["xyz".index(axis)]
    lengths = np.linalg.norm(there.placed.robot.arm.whole_chain.along(
        there.placed.robot.chained(there.placed.robot.home)).origins[0, 0])  # fmt: skip
    most = there.placed.robot.reach + float(lengths) + float(np.linalg.norm(there.tip.position))
    steps = np.ceil(most / _DEFAULT_STEP)
    return NumberRange(
        middle - steps * _DEFAULT_STEP, middle + steps * _DEFAULT_STEP, _DEFAULT_STEP
    )


def _likely_obstacles(there: _PlacedArm, found: ReachMap) -> str:
    """Return a likely reason why an arm reaches nothing, as far as it is plain."""
    from assistant.base import rotations

    if found.touching.any():
        (one, other), *_ = found.nearest
        return f": `{one}` is mostly too near to `{other}`"
    robot = there.placed.robot
    z = rotations.to_matrix(robot.fk(robot.home)[1])[0, :, 2].round(2) + 0.0
    return f"; at home the flange of the arm points to {tuple(z.tolist())} of its base"


def _output_files(outputs: Sequence[str], suffixes: Sequence[str]) -> list[Path]:
    """The files that are to be written; raises Refused for a name that tells no kind."""
    for output in outputs:
        if Path(output).suffix.lower() not in suffixes:
            known = ", ".join(suffixes)
            raise Refused(_UNKNOWN_RESULT(name=output, known=known), exit_status=2)
        if not Path(output).stem:
            raise Refused(NO_FILE_NAME(path=output, name=output), exit_status=2)
    return list(dict.fromkeys(map(Path, outputs)))


def _write_reach(cell: Path | None, files: Mapping[Path, bytes], *sources: str) -> list[Path]:
    from assistant.base.file_sets import write_all

    keep_sources([*sources, *([] if cell is None else [str(cell)])], list(files))
    return list(write_all(files)) if files else []


_NO_CELL = error(
    "CL040", "where `{name}` stands is not said", "name the cell file that has it with --cell"
)
_TIP_TWICE = error(
    "CL041", "the program says the tips of its tools", "leave --tip out, or the program"
)
_UNKNOWN_TARGETS = info(
    "CL042",
    "{count} moves go to what only running the program tells; they are left out",
    "nothing; look at these places by themselves",
)
_DEFAULT_PLACE_RANGE: Final = "-200:200:50"
"""Default range of x and y."""


@options
class PlaceSearch:
    """Places that are tried, and targets to be reached from them."""

    program: str | None = argument(
        "Program whose targets are to be reached; default locations of bodies.", default=None
    )
    robot: RobotOption
    cell: CellOption
    x: _OffsetRange
    y: _OffsetRange
    z: _OffsetRange
    turn: str | None = option("Degrees about z.", metavar=_RANGE_FORM)
    turns: int = option(
        "Turns of the tool about its z axis that are tried; default its own alone.", default=1
    )
    tip: TipOption
    margin: MarginOption
    reader: ReaderOptions
    from_language: FromLanguage
    output: tuple[str, ...] = option(
        "File to write: .csv, .png or .svg; repeatable.", "--output", "-o"
    )
    format: FormatOption

    def places(self, body: str | None) -> int:
        """1 if everything is reached at no place, else 0. body: None for the base of the robot."""
        from assistant.cell import placement
        from assistant.cell.findings import NO_PLACE
        from assistant.cell.reach_map import grid, parse_range
        from assistant.report import workspace as report

        files = _output_files(self.output, (".csv", ".png", ".svg"))
        ranges = _place_ranges({"x": self.x, "y": self.y, "z": self.z, "turn": self.turn})
        offsets = grid([parse_range(text, axis) for axis, text in ranges.items()])
        if body is not None and self.cell is None:
            raise Refused(_NO_CELL(name=body), exit_status=2)
        with working("looking at places"):
            there, targets, findings = self._targets(body)
            given = there.scene, there.placed
            if body is None:
                name, of = there.placed.name, "robots"
                found = placement.best_base(
                    *given, offsets, targets, bodies=there.bodies, margin=self.margin
                )
            else:
                name, of = body, "bodies"
                found = placement.best_place(*given, body, offsets, targets, margin=self.margin)
            title = f"{name}, for {there.placed.robot.title}"
            drawn = {path: _place_data(found, title, path) for path in files if found.places}
            sources = () if self.program is None else (self.program,)
            written = _write_reach(self.cell, drawn, *sources)
        findings += found.findings
        if found.best is None and found.places:
            first = found.places[0]
            findings.append(
                NO_PLACE(
                    count=len(offsets),
                    best=report.place_text(first),
                    reached=first.reached,
                    total=found.total,
                    first=first.worst,
                )
            )
        lines = [f"{title}; places: {len(offsets):,}; targets: {found.total:,}", ""]
        lines += report.place_lines(found)
        if found.best is not None and there.bodies:
            lines += ["", f"[{of}.{name}]", *report.pose_text(found.best.pose)]
        answer = {"robot": there.placed.robot.name, "moved": name, **report.places_record(found)}
        print_answer(self.format, answer, lines, findings, written)
        return 1 if has_errors(findings) or found.best is None else 0

    def _targets(
        self, body: str | None
    ) -> tuple[_PlacedArm, Sequence[placement.Goals], list[Diagnostic]]:
        from assistant.cell.placement import locations, standing_body
        from assistant.cell.reach_map import check_turns

        check_turns(self.turns)
        if self.program is not None:
            return self._program_targets(body, self.program)
        there = _placed_arm(self.cell, self.robot, self.tip, self.margin)
        if body is not None:
            standing_body(there.scene, body)
        targets = locations(there.scene, body, there.tip, self.turns)
        return there, (targets,), list(there.findings)

    def _program_targets(
        self, body: str | None, program: str
    ) -> tuple[_PlacedArm, Sequence[placement.Goals], list[Diagnostic]]:
        """Return the arm and the targets of a program; targets out of its present reach are not
        findings here.
        """
        from assistant.cell.placement import targets_of

        if self.tip is not None:
            raise Refused(_TIP_TWICE(), exit_status=2)
        ready = solved_source(
            program,
            self.reader,
            robot=self.robot,
            cell=self.cell,
            written=WrittenOptions(from_language=self.from_language),
        )
        solution = ready.solution
        there = _placed_arm(self.cell, self.robot, None, self.margin, solution.robot)
        found = targets_of(solution, there.placed, self.turns, carried=body is None)
        findings = list(there.findings)
        if found.unknown:
            findings.append(_UNKNOWN_TARGETS(count=found.unknown))
        return there, found.goals, findings


@command_of(reach)
class Base:
    """Find where the base of a robot stands best, for targets that stay where they are."""

    search: PlaceSearch

    def run(self) -> int:
        return self.search.places(None)


@command_of(reach)
class Place:
    """Find where a work piece stands best, for targets that move with it."""

    body: str = argument("Body of the cell; what stands on it is moved too.")
    search: PlaceSearch

    def run(self) -> int:
        return self.search.places(self.body)


def _place_data(found: Places, title: str, file: Path) -> bytes:
    from assistant.report.workspace import places_csv, places_picture

    suffix = file.suffix.lower()
    return places_csv(found) if suffix == ".csv" else places_picture(found, title, suffix[1:])


def _place_ranges(ranges: Mapping[str, str | None]) -> dict[str, str]:
    stated = {axis: text for axis, text in ranges.items() if text is not None}
    return dict.fromkeys(ranges, "0") | (
        stated or {"x": _DEFAULT_PLACE_RANGE, "y": _DEFAULT_PLACE_RANGE}
    )


@command_of(reach)
class Swept:
    """Tell which space the arm sweeps in a program, with its tool and what it carries."""

    program: Source
    robot: RobotOption
    cell: CellOption
    size: float = option("How wide the cells of the grid are, mm.", default=20.0)
    reader: ReaderOptions
    from_language: FromLanguage
    entry: EntryOption
    output: tuple[str, ...] = option(
        "File: .csv, .npz, .glb, .png or .svg; repeatable.", "--output", "-o"
    )
    format: FormatOption

    def run(self) -> int:
        """1 if the robot cannot run the program, else 0; contacts are for `check` to find."""
        from assistant.cell.clearances import CarriedBodies
        from assistant.cell.findings import NOT_SWEPT
        from assistant.cell.swept_space import swept_space
        from assistant.report import workspace as report
        from assistant.robots.timing import simulate

        files = _output_files(self.output, (".csv", ".npz", ".glb", ".png", ".svg"))
        with working(f"sweeping with {self.program}"):
            ready = solved_source(
                self.program,
                self.reader,
                robot=self.robot,
                cell=self.cell,
                written=WrittenOptions(from_language=self.from_language, entry=self.entry),
            )
            robot = ready.solution.robot
            if has_errors(ready.findings):
                return report_errors(self.program, robot, ready.findings, self.format, "swept")
            there = _placed_arm(self.cell, self.robot, known=robot)
            holding = CarriedBodies.at_first(there.scene, there.placed)
            done = simulate(ready.solution, carried=holding if holding.places else None)
            found = swept_space(done, there.scene, there.placed, self.size)
            title = f"{Path(self.program).name} on {robot.title}, cells of {self.size:g} mm"
            drawn = {path: _swept_data(found, title, path) for path in files}
            written = _write_reach(self.cell, drawn, self.program)
        lost = (
            f"only running the program tells where `{name}` is after a while"
            for name in sorted(holding.doubts.lost)
        )
        untimed = (str(unknown) for unknown in done.unknown if "not timed" in unknown.what)
        findings = [*ready.findings, *(NOT_SWEPT(what=what) for what in (*lost, *untimed))]
        answer = {"source": self.program, "robot": robot.name, **report.swept_record(found)}
        lines = (title, "", *report.swept_lines(found))
        print_answer(self.format, answer, lines, list(fold(findings)), written)
        return 0


def _swept_data(found: SweptSpace, title: str, file: Path) -> bytes:
    from assistant.report import workspace as report

    match file.suffix.lower():
        case ".csv":
            return report.swept_csv(found)
        case ".npz":
            return report.swept_npz(found)
        case ".glb":
            return report.swept_glb(found)
        case suffix:
            return report.swept_picture(found, title, suffix[1:])
