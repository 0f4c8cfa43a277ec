"""What the commands of `reach` do."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, error, has_errors
from assistant.cli.compiling import NO_FILE_NAME, keep_sources, working
from assistant.cli.presentation import Format, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.cell.reach_map import NumberRange, ReachMap
    from assistant.cell.scene import PlacedRobot, Scene
    from assistant.program.geometry import Pose
    from assistant.robots import Robot

NO_ARM = error(
    "CL036",
    "nobody says which robot it is about",
    "name one with --robot, as the cell file does or of the catalogue; `robot-assistant robots` "
    "lists these",
)
UNKNOWN_RESULT = error("CL037", "this is not written as `{name}`", "end the name in {known}")
NOT_A_TIP = error(
    "CL038", "`{given}` is no tip", "write x,y,z or x,y,z,w,x,y,z: mm and a quaternion"
)
BAD_MARGIN = error("CL039", "{given:g} is no margin", "write mm, 0 or more")
DEFAULT_STEP: Final = 100.0
"""mm of a region that nobody states."""


@dataclass(frozen=True, slots=True)
class ReachTool:
    """The arm, and what it holds. turns: about the tool that are tried. margin: mm."""

    robot: str | None
    cell: Path | None
    tip: str | None = None
    turns: int = 1
    margin: float | None = None


@dataclass(frozen=True, slots=True)
class PlacedArm:
    """The arm in its scene. bodies: whether anything may be touched there."""

    scene: Scene
    placed: PlacedRobot
    tip: Pose
    bodies: bool
    findings: tuple[Diagnostic, ...]


def run_map(
    tool: ReachTool,
    ranges: Mapping[str, str | None],
    directions: Sequence[str],
    outputs: Sequence[str],
    format: Format,
) -> int:
    """0; what is not reached is an answer."""
    from assistant.cell.findings import NOTHING_REACHED
    from assistant.cell.reach_map import grid, parse_directions, reach_map
    from assistant.report import reach_map as report

    files = output_files(outputs, MAP_WRITERS)
    turned = parse_directions(directions, tool.turns)
    with working("looking at what is reached"):
        there = placed_arm(tool)
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
        written = write_reach(
            tool, {path: MAP_WRITERS[path.suffix.lower()](found, title) for path in files}
        )
    findings = list(there.findings)
    if not found.reached.any():
        findings.append(NOTHING_REACHED(why=_likely_obstacles(there, found)))
    if format is Format.JSON:
        print_reach(
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


def print_reach(
    answer: Mapping[str, Any], findings: Sequence[Diagnostic], written: Sequence[Path]
) -> None:
    from assistant.findings.formats import finding_record

    found = [finding_record(finding) for finding in findings]
    print_json({**answer, "findings": found, "written": [str(path) for path in written]})


def placed_arm(tool: ReachTool, known: Robot | None = None) -> PlacedArm:
    """The arm, alone in the world if no cell is told. known: that of a program.

    Raises Refused if no arm is named, or none that stands in the cell.
    """
    from assistant.cell import link_bodies
    from assistant.cell.clearances import robot_of
    from assistant.cell.scene import Scene
    from assistant.checks.clearances import no_robot
    from assistant.compiler.arms import open_cell

    tip = _tip_pose(tool.tip)
    if tool.margin is not None and not 0.0 <= tool.margin < float("inf"):
        raise Refused(BAD_MARGIN(given=tool.margin), exit_status=2)
    found = open_cell(tool.cell, tool.robot)
    robot, scene = found.robot or known, found.scene
    if scene is None:
        if robot is None:
            raise Refused(NO_ARM(), exit_status=2)
        alone = link_bodies.place_robot("robot", robot)
        return PlacedArm(Scene(robots=(alone,)), alone, tip, False, found.findings)
    if robot is None and len(scene.robots) == 1:
        return PlacedArm(scene, scene.robots[0], tip, True, found.findings)
    if robot is None:
        raise Refused(NO_ARM(), exit_status=2)
    try:
        return PlacedArm(scene, robot_of(scene, robot), tip, True, found.findings)
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
        raise Refused(NOT_A_TIP(given=given), exit_status=2)
    turn = numbers[3:] if len(numbers) == 7 else np.array([1.0, 0.0, 0.0, 0.0])
    if not np.linalg.norm(turn) > 0.0:
        raise Refused(NOT_A_TIP(given=given), exit_status=2)
    return Pose.of(numbers[:3], rotations.canonical(turn))


def _axis_range(there: PlacedArm, axis: str, text: str | None) -> NumberRange:
    """What is stated, or all that the arm could reach."""
    import numpy as np

    from assistant.cell.reach_map import NumberRange, parse_range

    if text is not None:
        return parse_range(text, axis)
    middle = there.placed.base.position["xyz".index(axis)]
    lengths = np.linalg.norm(there.placed.robot.arm.whole_chain.along(
        there.placed.robot.chained(there.placed.robot.home)).origins[0, 0])  # fmt: skip
    most = there.placed.robot.reach + float(lengths) + float(np.linalg.norm(there.tip.position))
    steps = np.ceil(most / DEFAULT_STEP)
    return NumberRange(middle - steps * DEFAULT_STEP, middle + steps * DEFAULT_STEP, DEFAULT_STEP)


def _likely_obstacles(there: PlacedArm, found: ReachMap) -> str:
    """What keeps an arm from everything, as far as it is plain."""
    from assistant.base import rotations

    if found.touching.any():
        (one, other), *_ = found.nearest
        return f": `{one}` is mostly too near to `{other}`"
    robot = there.placed.robot
    z = rotations.to_matrix(robot.fk(robot.home)[1])[0, :, 2].round(2) + 0.0
    return f"; at home the flange of the arm points to {tuple(z.tolist())} of its base"


def output_files(outputs: Sequence[str], writers: Mapping[str, Any]) -> list[Path]:
    """The files that are to be written; raises Refused for a name that tells no kind."""
    for output in outputs:
        if Path(output).suffix.lower() not in writers:
            known = ", ".join(writers)
            raise Refused(UNKNOWN_RESULT(name=output, known=known), exit_status=2)
        if not Path(output).stem:
            raise Refused(NO_FILE_NAME(path=output, name=output), exit_status=2)
    return list(dict.fromkeys(map(Path, outputs)))


def write_reach(tool: ReachTool, files: Mapping[Path, bytes], *sources: str) -> list[Path]:
    from assistant.base.file_sets import write_all

    keep_sources([*sources, *([] if tool.cell is None else [str(tool.cell)])], list(files))
    return list(write_all(files)) if files else []


def _map_csv(found: ReachMap, title: str) -> bytes:  # noqa: ARG001 (each writer is given both)
    from assistant.report.reach_map import map_csv

    return map_csv(found)


def _map_npz(found: ReachMap, title: str) -> bytes:  # noqa: ARG001
    from assistant.report.reach_map import map_npz

    return map_npz(found)


def _map_picture(format: str) -> Callable[[ReachMap, str], bytes]:
    def draw(found: ReachMap, title: str) -> bytes:
        from assistant.report.reach_map import map_picture

        return map_picture(found, title, format)

    return draw


MAP_WRITERS: Final[dict[str, Callable[[ReachMap, str], bytes]]] = {
    ".csv": _map_csv,
    ".npz": _map_npz,
    ".png": _map_picture("png"),
    ".svg": _map_picture("svg"),
}
