"""Reach of an arm: maps of it, the best places of base and work piece, and swept space.

`reach map` covers a region; `reach base` and `reach place` try places for the targets of a program
or of a table; `reach swept` adds up the space that an arm sweeps. Regions are LOW:HIGH:STEP in mm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from assistant.base.diagnostics import Diagnostic, Refused, error, fold, has_errors, info
from assistant.cli.compilation import NO_FILE_NAME, keep_sources, working
from assistant.cli.options import (
    CellOption,
    EntryOption,
    FormatOption,
    FromLanguage,
    ProcessOption,
    RobotOption,
    Source,
    UnitOption,
)
from assistant.cli.presentation import Format, print_findings, print_json, say
from assistant.cli.simulation import SimulationOptions, report_errors, solved_source

if TYPE_CHECKING:
    from assistant.cell import placement
    from assistant.cell.placement import Places
    from assistant.cell.reach_map import NumberRange, ReachMap
    from assistant.cell.scene import PlacedRobot, Scene
    from assistant.cell.swept_space import SweptSpace
    from assistant.program.geometry import Pose
    from assistant.robots import Robot


reach: Final = typer.Typer(
    help="What an arm reaches, where things stand best, which space a program sweeps.",
    no_args_is_help=True,
    rich_markup_mode=None,
    add_completion=False,
)
_RANGE_FORM: Final = "LOW:HIGH:STEP"
TipOption = Annotated[
    str | None,
    typer.Option(help="x,y,z[,w,x,y,z] of the tip on the flange, mm; default the flange itself."),
]
_TurnsOption = Annotated[
    int,
    typer.Option(help="Turns of the tool about its z axis that are tried; 1 if its turn counts."),
]
_OutputOption = Annotated[
    list[str] | None,
    typer.Option("--output", "-o", help="File to write: .csv, .npz, .png or .svg; repeatable."),
]
PlacesOption = Annotated[
    list[str] | None,
    typer.Option("--output", "-o", help="File to write: .csv, .png or .svg; repeatable."),
]
GoalsArgument = Annotated[
    str | None,
    typer.Argument(help="Program whose targets are to be reached; default locations of bodies."),
]
FewTurnsOption = Annotated[
    int,
    typer.Option(help="Turns of the tool about its z axis that are tried; default its own alone."),
]
MarginOption = Annotated[
    float | None, typer.Option(help="mm to keep from everything; default those of the cell file.")
]
SweptOption = Annotated[
    list[str] | None,
    typer.Option("--output", "-o", help="File: .csv, .npz, .glb, .png or .svg; repeatable."),
]


@reach.command("map")
def _map_reach(
    robot: RobotOption = None,
    cell: CellOption = None,
    x: Annotated[str | None, typer.Option(metavar=_RANGE_FORM, help="mm of the world.")] = None,
    y: Annotated[str | None, typer.Option(metavar=_RANGE_FORM, help="mm of the world.")] = None,
    z: Annotated[str | None, typer.Option(metavar=_RANGE_FORM, help="mm of the world.")] = None,
    direction: Annotated[
        list[str] | None,
        typer.Option(
            help="Of the tool's z axis: down, up, x,y,z, or with /DEGREES a cone; repeatable."
        ),
    ] = None,
    turns: _TurnsOption = 12,
    tip: TipOption = None,
    margin: MarginOption = None,
    output: _OutputOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell which part of a region an arm reaches, with which directions of its tool."""
    ranges = {"x": x, "y": y, "z": z}
    tool = _ReachTool(robot, cell, tip, turns, margin)
    raise typer.Exit(_run_map(tool, ranges, direction or ["down"], output or (), format))


@reach.command()
def base(
    program: GoalsArgument = None,
    robot: RobotOption = None,
    cell: CellOption = None,
    x: Annotated[str | None, typer.Option(metavar=_RANGE_FORM, help="mm from where it is.")] = None,
    y: Annotated[str | None, typer.Option(metavar=_RANGE_FORM, help="mm from where it is.")] = None,
    z: Annotated[str | None, typer.Option(metavar=_RANGE_FORM, help="mm from where it is.")] = None,
    turn: Annotated[str | None, typer.Option(metavar=_RANGE_FORM, help="Degrees about z.")] = None,
    turns: FewTurnsOption = 1,
    tip: TipOption = None,
    margin: MarginOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    from_language: FromLanguage = None,
    output: PlacesOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Find where the base of a robot stands best, for targets that stay where they are."""
    tool = _ReachTool(robot, cell, tip, turns, margin)
    goals = _PlaceGoals(program, process, unit, from_language)
    ranges = {"x": x, "y": y, "z": z, "turn": turn}
    raise typer.Exit(_run_places(None, tool, goals, ranges, output or (), format))


@reach.command()
def place(
    body: Annotated[str, typer.Argument(help="Body of the cell; what stands on it is moved too.")],
    program: GoalsArgument = None,
    robot: RobotOption = None,
    cell: CellOption = None,
    x: Annotated[str | None, typer.Option(metavar=_RANGE_FORM, help="mm from where it is.")] = None,
    y: Annotated[str | None, typer.Option(metavar=_RANGE_FORM, help="mm from where it is.")] = None,
    z: Annotated[str | None, typer.Option(metavar=_RANGE_FORM, help="mm from where it is.")] = None,
    turn: Annotated[str | None, typer.Option(metavar=_RANGE_FORM, help="Degrees about z.")] = None,
    turns: FewTurnsOption = 1,
    tip: TipOption = None,
    margin: MarginOption = None,
    process: ProcessOption = None,
    unit: UnitOption = None,
    from_language: FromLanguage = None,
    output: PlacesOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Find where a work piece stands best, for targets that move with it."""
    tool = _ReachTool(robot, cell, tip, turns, margin)
    goals = _PlaceGoals(program, process, unit, from_language)
    ranges = {"x": x, "y": y, "z": z, "turn": turn}
    raise typer.Exit(_run_places(body, tool, goals, ranges, output or (), format))


@reach.command()
def swept(
    program: Source,
    robot: RobotOption = None,
    cell: CellOption = None,
    size: Annotated[float, typer.Option(help="How wide the cells of the grid are, mm.")] = 20.0,
    process: ProcessOption = None,
    unit: UnitOption = None,
    from_language: FromLanguage = None,
    entry: EntryOption = None,
    output: SweptOption = None,
    format: FormatOption = Format.TEXT,
) -> None:
    """Tell which space the arm sweeps in a program, with its tool and what it carries."""
    from assistant.cli.simulation import SimulationOptions

    options = SimulationOptions(
        robot, process, unit, from_language, None, None, None, entry=entry, cell=cell
    )
    raise typer.Exit(_run_swept(program, options, size, output or (), format))


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
class _ReachTool:
    """The arm, and what it holds. turns: about the tool that are tried. margin: mm."""

    robot: str | None
    cell: Path | None
    tip: str | None = None
    turns: int = 1
    margin: float | None = None


@dataclass(frozen=True, slots=True)
class _PlacedArm:
    """The arm in its scene. bodies: whether anything may be touched there."""

    scene: Scene
    placed: PlacedRobot
    tip: Pose
    bodies: bool
    findings: tuple[Diagnostic, ...]


def _run_map(
    tool: _ReachTool,
    ranges: Mapping[str, str | None],
    directions: Sequence[str],
    outputs: Sequence[str],
    format: Format,
) -> int:
    """0; what is not reached is an answer."""
    from assistant.cell.findings import NOTHING_REACHED
    from assistant.cell.reach_map import grid, parse_directions, reach_map
    from assistant.report import workspace as report

    files = _output_files(outputs, _MAP_WRITERS)
    turned = parse_directions(directions, tool.turns)
    with working("looking at what is reached"):
        there = _placed_arm(tool)
        points = grid([_axis_range(there, axis, text) for axis, text in ranges.items()])
        found = reach_map(
            there.scene,
            there.placed,
            points,
            turned,
            tip=there.tip,
            bodies=there.bodies,
            margin=tool.margin,
        )
        title = f"{there.placed.robot.title}, {', '.join(directions)}"
        written = _write_reach(
            tool, {path: _MAP_WRITERS[path.suffix.lower()](found, title) for path in files}
        )
    findings = list(there.findings)
    if not found.reached.any():
        findings.append(NOTHING_REACHED(why=_likely_obstacles(there, found)))
    if format is Format.JSON:
        _print_reach(
            {"robot": there.placed.robot.name, **report.map_record(found)}, findings, written
        )
        return 1 if has_errors(findings) else 0
    print_findings(findings, explained=True)
    say(f"{there.placed.robot.title}: {len(points):,} points")
    say("")
    for line in report.map_lines(found):
        say(line)
    for path in written:
        say(f"wrote {path}")
    return 1 if has_errors(findings) else 0


def _print_reach(
    answer: Mapping[str, Any], findings: Sequence[Diagnostic], written: Sequence[Path]
) -> None:
    from assistant.findings.formats import finding_record

    found = [finding_record(finding) for finding in findings]
    print_json({**answer, "findings": found, "written": [str(path) for path in written]})


def _placed_arm(tool: _ReachTool, known: Robot | None = None) -> _PlacedArm:
    """Return the arm, alone in the world if no cell is given. known: that of a program.

    Raises Refused if no arm is named, or it is not in the cell.
    """
    from assistant.cell import link_bodies
    from assistant.cell.clearances import robot_of
    from assistant.cell.scene import Scene
    from assistant.checks.clearances import no_robot
    from assistant.compiler.arms import open_cell

    tip = _tip_pose(tool.tip)
    if tool.margin is not None and not 0.0 <= tool.margin < float("inf"):
        raise Refused(_BAD_MARGIN(given=tool.margin), exit_status=2)
    found = open_cell(tool.cell, tool.robot)
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


def _output_files(outputs: Sequence[str], writers: Mapping[str, Any]) -> list[Path]:
    """The files that are to be written; raises Refused for a name that tells no kind."""
    for output in outputs:
        if Path(output).suffix.lower() not in writers:
            known = ", ".join(writers)
            raise Refused(_UNKNOWN_RESULT(name=output, known=known), exit_status=2)
        if not Path(output).stem:
            raise Refused(NO_FILE_NAME(path=output, name=output), exit_status=2)
    return list(dict.fromkeys(map(Path, outputs)))


def _write_reach(tool: _ReachTool, files: Mapping[Path, bytes], *sources: str) -> list[Path]:
    from assistant.base.file_sets import write_all

    keep_sources([*sources, *([] if tool.cell is None else [str(tool.cell)])], list(files))
    return list(write_all(files)) if files else []


def _map_csv(found: ReachMap, title: str) -> bytes:  # noqa: ARG001 (each writer is given both)
    from assistant.report.workspace import map_csv

    return map_csv(found)


def _map_npz(found: ReachMap, title: str) -> bytes:  # noqa: ARG001
    from assistant.report.workspace import map_npz

    return map_npz(found)


def _map_picture(format: str) -> Callable[[ReachMap, str], bytes]:
    def draw(found: ReachMap, title: str) -> bytes:
        from assistant.report.workspace import map_picture

        return map_picture(found, title, format)

    return draw


_MAP_WRITERS: Final[dict[str, Callable[[ReachMap, str], bytes]]] = {
    ".csv": _map_csv,
    ".npz": _map_npz,
    ".png": _map_picture("png"),
    ".svg": _map_picture("svg"),
}


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


@dataclass(frozen=True, slots=True)
class _PlaceGoals:
    """The program whose targets are to be reached, None for locations, and how it is read."""

    program: str | None
    process: Path | None
    unit: str | None
    from_language: str | None


def _run_places(
    body: str | None,
    tool: _ReachTool,
    goals: _PlaceGoals,
    ranges: Mapping[str, str | None],
    outputs: Sequence[str],
    format: Format,
) -> int:
    """1 if everything is reached at no place, else 0. body: None for the base of the robot."""
    from assistant.cell import placement
    from assistant.cell.findings import NO_PLACE
    from assistant.cell.reach_map import grid, parse_range
    from assistant.report import workspace as report

    files = _output_files(outputs, _PLACE_WRITERS)
    offsets = grid([parse_range(text, axis) for axis, text in _place_ranges(ranges).items()])
    if body is not None and tool.cell is None:
        raise Refused(_NO_CELL(name=body), exit_status=2)
    with working("looking at places"):
        there, targets, findings = _place_targets(body, tool, goals)
        given = there.scene, there.placed
        if body is None:
            name, of = there.placed.name, "robots"
            found = placement.best_base(
                *given, offsets, targets, bodies=there.bodies, margin=tool.margin
            )
        else:
            name, of = body, "bodies"
            found = placement.best_place(*given, body, offsets, targets, margin=tool.margin)
        title = f"{name}, for {there.placed.robot.title}"
        sources = () if goals.program is None else (goals.program,)
        drawn = {
            path: _PLACE_WRITERS[path.suffix.lower()](found, title)
            for path in files
            if found.places
        }
        written = _write_reach(tool, drawn, *sources)
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
    status = 1 if has_errors(findings) or found.best is None else 0
    if format is Format.JSON:
        answer = {"robot": there.placed.robot.name, "moved": name, **report.places_record(found)}
        _print_reach(answer, findings, written)
        return status
    print_findings(findings, explained=True)
    say(f"{title}; places: {len(offsets):,}; targets: {found.total:,}")
    say("")
    for line in report.place_lines(found):
        say(line)
    if found.best is not None and there.bodies:
        say("")
        say(f"[{of}.{name}]")
        for line in report.pose_text(found.best.pose):
            say(line)
    for path in written:
        say(f"wrote {path}")
    return status


def _place_ranges(ranges: Mapping[str, str | None]) -> dict[str, str]:
    stated = {axis: text for axis, text in ranges.items() if text is not None}
    return dict.fromkeys(ranges, "0") | (
        stated or {"x": _DEFAULT_PLACE_RANGE, "y": _DEFAULT_PLACE_RANGE}
    )


def _place_targets(
    body: str | None, tool: _ReachTool, goals: _PlaceGoals
) -> tuple[_PlacedArm, Sequence[placement.Goals], list[Diagnostic]]:
    from assistant.cell.placement import locations, standing_body
    from assistant.cell.reach_map import check_turns

    check_turns(tool.turns)
    if goals.program is not None:
        return _program_targets(body, tool, goals, goals.program)
    there = _placed_arm(tool)
    if body is not None:
        standing_body(there.scene, body)
    targets = locations(there.scene, body, there.tip, tool.turns)
    return there, (targets,), list(there.findings)


def _program_targets(
    body: str | None, tool: _ReachTool, goals: _PlaceGoals, program: str
) -> tuple[_PlacedArm, Sequence[placement.Goals], list[Diagnostic]]:
    """Return the arm and the targets of a program; targets out of its present reach are not
    findings here.
    """
    from assistant.cell.placement import targets_of
    from assistant.cli.simulation import SimulationOptions, solved_source

    if tool.tip is not None:
        raise Refused(_TIP_TWICE(), exit_status=2)
    given = (goals.process, goals.unit, goals.from_language, None)
    ready = solved_source(
        program, SimulationOptions(tool.robot, *given, None, None, cell=tool.cell)
    )
    solution = ready.solution
    there = _placed_arm(tool, solution.robot)
    found = targets_of(solution, there.placed, tool.turns, carried=body is None)
    findings = list(there.findings)
    if found.unknown:
        findings.append(_UNKNOWN_TARGETS(count=found.unknown))
    return there, found.goals, findings


def _places_csv(found: Places, title: str) -> bytes:  # noqa: ARG001 (each writer is given both)
    from assistant.report.workspace import places_csv

    return places_csv(found)


def _places_picture(format: str) -> Callable[[Places, str], bytes]:
    def draw(found: Places, title: str) -> bytes:
        from assistant.report.workspace import places_picture

        return places_picture(found, title, format)

    return draw


_PLACE_WRITERS: Final[dict[str, Callable[[Places, str], bytes]]] = {
    ".csv": _places_csv,
    ".png": _places_picture("png"),
    ".svg": _places_picture("svg"),
}


def _run_swept(
    source: str, options: SimulationOptions, size: float, outputs: Sequence[str], format: Format
) -> int:
    """1 if the robot cannot run the program, else 0; contacts are for `check` to find."""
    from assistant.cell.clearances import CarriedBodies
    from assistant.cell.findings import NOT_SWEPT
    from assistant.cell.swept_space import swept_space
    from assistant.report import workspace as report
    from assistant.robots.timing import simulate

    files = _output_files(outputs, _SWEPT_WRITERS)
    with working(f"sweeping with {source}"):
        ready = solved_source(source, options)
        solution = ready.solution
        if has_errors(ready.findings):
            return report_errors(source, solution.robot, ready.findings, format, "swept")
        tool = _ReachTool(options.robot, options.cell)
        there = _placed_arm(tool, solution.robot)
        holding = CarriedBodies.at_first(there.scene, there.placed)
        done = simulate(solution, carried=holding if holding.places else None)
        found = swept_space(done, there.scene, there.placed, size)
        title = f"{Path(source).name} on {solution.robot.title}, cells of {size:g} mm"
        drawn = {path: _SWEPT_WRITERS[path.suffix.lower()](found, title) for path in files}
        written = _write_reach(tool, drawn, source)
    findings = list(ready.findings)
    findings += [
        NOT_SWEPT(what=f"only running the program tells where `{name}` is after a while")
        for name in sorted(holding.doubts.lost)
    ]
    findings += [
        NOT_SWEPT(what=str(unknown)) for unknown in done.unknown if "not timed" in unknown.what
    ]
    findings = list(fold(findings))
    if format is Format.JSON:
        robot = solution.robot.name
        _print_reach(
            {"source": source, "robot": robot, **report.swept_record(found)}, findings, written
        )
        return 0
    print_findings(findings, explained=True)
    say(title)
    say("")
    for line in report.swept_lines(found):
        say(line)
    for path in written:
        say(f"wrote {path}")
    return 0


def _swept_csv(found: SweptSpace, title: str) -> bytes:  # noqa: ARG001 (each writer is given both)
    from assistant.report.workspace import swept_csv

    return swept_csv(found)


def _swept_npz(found: SweptSpace, title: str) -> bytes:  # noqa: ARG001
    from assistant.report.workspace import swept_npz

    return swept_npz(found)


def _swept_glb(found: SweptSpace, title: str) -> bytes:  # noqa: ARG001
    from assistant.report.workspace import swept_glb

    return swept_glb(found)


def _swept_picture(format: str) -> Callable[[SweptSpace, str], bytes]:
    def draw(found: SweptSpace, title: str) -> bytes:
        from assistant.report.workspace import swept_picture

        return swept_picture(found, title, format)

    return draw


_SWEPT_WRITERS: Final[dict[str, Callable[[SweptSpace, str], bytes]]] = {
    ".csv": _swept_csv,
    ".npz": _swept_npz,
    ".glb": _swept_glb,
    ".png": _swept_picture("png"),
    ".svg": _swept_picture("svg"),
}
