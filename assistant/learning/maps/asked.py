"""What somebody wants learnt, as an experiment: robot, joints, points, cameras and space."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.learning.maps.experiments import TOOL_POINTS, Experiment, over_box, over_ranges
from assistant.learning.maps.extended_map import JOINTS_OF_POINTS, ExtendedMap, MapTask
from assistant.learning.maps.goals import (
    InBox,
    InRanges,
    ToolRule,
    check_box,
    check_ranges,
    ranges_about_home,
)
from assistant.learning.maps.rules import (
    BAD_HELD_JOINT,
    INCOMPLETE_TOOL_RULE,
    NO_AXIS,
    OTHER_MAP_TASK,
)
from assistant.learning.maps.seen_arm import observed_arm
from assistant.robots import Robot
from assistant.vision.cameras.camera import Camera


@dataclass(frozen=True, slots=True, eq=False)
class ExperimentSettings:
    """held: joints that stay where they are, degrees. points: (k, 3) mm of the tool on the flange,
    None for as many of `MARKS` as tell the joints. ranges: of joints by name, instead of those
    about home. box: (3, 2) mm, None for wherever the joints bring the tool. cameras: none for a
    pair that is put up. free: the orientation of the tool is free; the joints that the points leave
    open are learnt nearest to the middle of their ranges.
    """

    robot: Robot
    held: Mapping[str, float] = field(default_factory=dict)
    points: Floats | None = None
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    box: Floats | None = None
    rule: ToolRule = "any"
    turn: tuple[float, float] = (0.0, 0.0)
    cameras: tuple[Camera, ...] = ()
    free: bool = False


def experiment_of(asked: ExperimentSettings, net: ExtendedMap | None = None) -> Experiment:
    """net: a map that goes on learning, in whose ranges targets are then drawn.

    Raises Refused for what does not fit together.
    """
    robot = asked.robot
    for name in (*asked.held, *asked.ranges):
        if name not in robot.axes:
            finding = NO_AXIS(robot=robot.title, axis=name, known=", ".join(robot.axes))
            raise Refused(finding, exit_status=2)
    moves = tuple(name for name in robot.axes if name not in asked.held)
    rest = _rest_joints(asked)
    alone = asked.free or (asked.box is not None and asked.rule == "any")
    count = 1 if alone else _points_to_determine(len(moves))
    points = np.array(TOOL_POINTS[:count]) if asked.points is None else asked.points
    arm = observed_arm(robot, asked.cameras, points.tolist(), moves, rest)
    arm = replace(arm, free=asked.free)
    if asked.rule == "any" and any(asked.turn):
        raise Refused(INCOMPLETE_TOOL_RULE(rule="by", what="its turn alone"), exit_status=2)
    if asked.rule != "any" and (asked.box is None or asked.held):
        what = "without a box" if asked.box is None else f"while {', '.join(asked.held)} stays"
        raise Refused(INCOMPLETE_TOOL_RULE(rule=asked.rule, what=what), exit_status=2)
    if asked.box is not None:
        if asked.rule == "any" and len(points) != 1:
            what = f"at {len(points)} points in a box"
            raise Refused(INCOMPLETE_TOOL_RULE(rule="anyhow", what=what), exit_status=2)
        found = over_box(arm, InBox(check_box(asked.box), asked.rule, asked.turn))
        ranges = _stated_ranges(asked, moves, found.ranges)
        made = Experiment(found.arm, found.space, ranges, found.dimensions)
    else:
        about = ranges_about_home(robot, moves)
        if net is not None and net.task.axes == moves:
            about = np.column_stack([net.scale.low, net.scale.high])
        made = over_ranges(arm, check_ranges(robot, moves, _stated_ranges(asked, moves, about)))
    if net is not None:
        _check_task(net, made)
    return made


def _rest_joints(asked: ExperimentSettings) -> Floats:
    """Joints of the whole robot where it is at home, and held ones where they are to stay."""
    robot, rest = asked.robot, asked.robot.home.copy()
    for name, value in asked.held.items():
        at = robot.axes.index(name)
        least, most = robot.limits[at].tolist()
        reason = ""
        if not least <= value <= most:
            reason = f"a {robot.title} has it between {least:g} and {most:g}"
        elif name in asked.ranges:
            reason = "it learns in a range as well"
        elif len(asked.held) == len(robot.axes):
            reason = "no joint is left that moves"
        if reason:
            raise Refused(BAD_HELD_JOINT(axis=name, value=value, reason=reason), exit_status=2)
        rest[at] = value
    return rest


def _points_to_determine(joints: int) -> int:
    return next((points for points, most in JOINTS_OF_POINTS.items() if joints <= most), 3)


def _stated_ranges(asked: ExperimentSettings, moves: tuple[str, ...], ranges: Floats) -> Floats:
    out = ranges.copy()
    for name, (low, high) in asked.ranges.items():
        if name in moves:
            out[moves.index(name)] = low, high
    return check_ranges(asked.robot, moves, out)


def _check_task(net: ExtendedMap, made: Experiment) -> None:
    """Raises Refused unless a map has learnt what is asked for."""
    asked = made.arm.task
    if net.task != asked:
        raise Refused(
            OTHER_MAP_TASK(learnt=_task_text(net.task), asked=_task_text(asked)), exit_status=2
        )
    if isinstance(made.space, InRanges):
        inside = (made.ranges[:, 0] >= net.scale.low) & (made.ranges[:, 1] <= net.scale.high)
        if not inside.all():
            names = ", ".join(np.array(asked.axes)[~inside].tolist())
            learnt = f"narrower ranges of {names}"
            raise Refused(OTHER_MAP_TASK(learnt=learnt, asked="wider ones"), exit_status=2)


def _task_text(task: MapTask) -> str:
    cameras, points = ", ".join(task.cameras), "point" if task.points == 1 else "points"
    axes = ", ".join(task.axes)
    return f"{axes} of {task.robot} by {task.points} {points} in {cameras}"
