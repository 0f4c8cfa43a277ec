"""Moves: what they make of the arm, and the event of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.geometry import IDENTITY, Pose, Vector
from assistant.robots.configurations import from_flags
from assistant.virtual.events import How, Moved
from assistant.virtual.melfa import appended, expressions, pausing, poses
from assistant.virtual.melfa.arm import OPTIMUM, Arm
from assistant.virtual.melfa.circles import circle_about, circle_through
from assistant.virtual.melfa.stops import Failed, Unknown
from assistant.virtual.melfa.values import Bare, Joints, Position, Value, position

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine

AXES: Final = 6
"""Places of the arm's own in a position or joint position; behind them additional axes stand."""
SAME_RADIUS: Final = 0.01
"""mm by which the two radii of Mvr3 may differ (COSIROP: MVR3)."""


def move(m: Machine, node: s.Motion) -> None:
    """Runs a motion with what is appended to it; raises Unknown for a kind not simulated."""
    word = node.keyword.upper()
    if not m.world.arm.servo:
        raise Failed(2000, "the servo is off")
    if word in m.world.commands:
        m.world.given(word, expressions.values(m, node.arguments))
        return
    kind = MOVE_KINDS.get(word)
    if kind is None:
        raise Unknown(f"the motion {node.keyword}")
    m.world.needs_mechanism("a motion")
    pausing.before_motion(m.world)
    if node.append is None:
        kind(m, node)
        return
    if appended.is_watched_condition(m, node.append):
        appended.watch_condition(m, node.append, lambda: kind(m, node))
        return
    m.world.on_way, m.world.appended = appended.begin_wth(m, node.append), False
    try:
        kind(m, node)
    finally:
        m.world.on_way = None


# ------------------------------------------------------------------------ straight and by joints


def _joint(m: Machine, node: s.Motion) -> None:
    goal = _move_goal(m, node)
    if isinstance(goal, Joints):
        _to_joints(m, goal)
    else:
        flange = _goal_flange(m, goal)
        _command_motion(m, _motion_event(m, "joint", flange, at=goal), goal.flags)


def _to_joints(m: Machine, goal: Joints) -> None:
    arm, joints = m.world.arm, _goal_axes(goal)
    before = arm.flange
    arm.at_joints(joints)
    m.world.go(_motion_event(m, "joint", arm.flange, joints=joints[:AXES], at=goal), before)


def _goal_axes(goal: Joints) -> tuple[float, ...]:
    """The joints up to the last that is defined."""
    count = max((i + 1 for i, v in enumerate(goal.values) if v is not None), default=0)
    joints = tuple(v for v in goal.values[:count] if v is not None)
    if len(joints) != count or not count:
        raise Failed(2802, "a joint position with elements that are not defined")
    return joints


def _linear(m: Machine, node: s.Motion) -> None:
    goal = _move_goal(m, node)
    _straight(m, _joints_position(m, goal) if isinstance(goal, Joints) else goal, _agree(m, node))


def _agree(m: Machine, node: s.Motion) -> bool:
    """Whether the structure flags of both ends must be the same: not with `Type 0,1` or `0,2`."""
    return node.type is None or expressions.integer(m, node.type[1], "the type") == 0


def _joints_position(m: Machine, joints: Joints) -> Position:
    """Where the tip stands at joints, with the tool and the base that hold."""
    arm = m.world.arm
    if arm.robot is None:
        raise Unknown("where the arm stands at joints")
    there = Arm(arm.robot, tip=arm.tip, foot=arm.foot)
    there.at_joints(_goal_axes(joints))
    return there.shown()


def _straight(m: Machine, goal: Position, agree: bool = True) -> None:
    """agree: whether the structure flags of both ends must be the same."""
    if agree:
        _same_posture(m.world.arm.flags[0], goal.flags[0])
    flange = _goal_flange(m, goal)
    _command_motion(m, _motion_event(m, "linear", flange, at=goal), goal.flags)


def _same_posture(one: int | None, other: int | None) -> None:
    if one is not None and other is not None and one != other:
        raise Failed(2810, "the posture flags of start and end differ")


def _move_goal(m: Machine, node: s.Motion) -> Position | Joints:
    """The target of Mov and Mvs, moved along the tool by the distance behind it."""
    target, *more = node.arguments
    goal = m.world.arm.shown() if target is None else _target_value(expressions.value(m, target))
    if not more or more[0] is None:
        return goal
    distance = expressions.plain(m, more[0], "the distance")
    if isinstance(goal, Joints):
        goal = _joints_position(m, goal)
    away = poses.pose_of(goal, m.world.arm.robot).offset(z=distance)
    return poses.position_of(away, goal, m.world.arm.robot)


def _target_value(value: Value) -> Position | Joints:
    if isinstance(value, Bare):
        raise Unknown("a move to a constant that may be a position or joints")
    if not isinstance(value, Position | Joints):
        raise Failed(3810, "a move to what is no position")
    return value


def _goal_flange(m: Machine, goal: Position) -> Pose:
    return m.world.arm.placed(goal)


def _command_motion(m: Machine, moved: Moved, flags: tuple[int | None, int | None]) -> None:
    """A motion to a position. flags: of the posture and of turns at its end."""
    arm = m.world.arm
    before = arm.flange
    assert moved.flange is not None
    arm.at_position(moved.flange, flags)
    if flags[0] is not None:
        stated = _flags_configuration(flags[0], flags[1] or 0)
        moved = replace(moved, how=replace(moved.how, configuration=stated))
    m.world.go(moved, before)


@lru_cache(256)
def _flags_configuration(one: int, two: int) -> tuple[int, ...]:
    return tuple(from_flags([[one, two]])[0].tolist())


def _motion_event(
    m: Machine,
    kind: str,
    flange: Pose | None,
    via: Pose | None = None,
    joints: tuple[float, ...] | None = None,
    at: Position | Joints | None = None,
) -> Moved:
    """The event of a motion with the speed and the corner that hold. at: where it ends."""
    arm, held = m.world.arm, m.world.settings
    speed = percent = None
    if kind == "joint":
        percent = held.override * held.joint_override / 100.0
    elif held.speed != OPTIMUM:
        speed = held.override * held.speed / 100.0
    made: Moved = Moved(
        kind,  # type: ignore[arg-type] # one of its three
        flange,
        arm.tip,
        via=via,
        joints=joints,
        speed=speed,
        percent=percent,
        blend=held.corner,
        frame=arm.foot.inverse(),
        how=How(
            acceleration=held.acceleration[0] / 100.0,
            deceleration=held.acceleration[1] / 100.0,
            mass=0.0 if arm.tip == IDENTITY else None,
        ),
        external=() if at is None else tuple(at.values[AXES:]),
    )
    return made


# ------------------------------------------------------------------------------------- arcs


def _three_positions(m: Machine, node: s.Motion) -> tuple[Position, Position, Position]:
    if len(node.arguments) < 3 or None in node.arguments[:3]:
        raise Failed(3120, f"{node.keyword} takes three positions")
    given = [expressions.value(m, a) for a in node.arguments[:3]]
    first, second, third = (
        _joints_position(m, v) if isinstance(v, Joints) else position(v, "a place of an arc")
        for v in given
    )
    return first, second, third


def _to_start(m: Machine, start: Position) -> None:
    """An arc that begins elsewhere is reached by a straight move first (COSIROP: MVR)."""
    arm = m.world.arm
    flange = arm.placed(start)
    if arm.flange is None:
        raise Unknown("where an arc begins")
    tip = arm.flange @ arm.tip
    if not poses.same_place(tip, flange @ arm.tip, START_DISTANCE):
        _straight(m, start)


START_DISTANCE: Final = 0.05
"""mm between where the arm stands and where an arc begins: rounding of positions."""


def _through(m: Machine, node: s.Motion) -> None:
    """Mvr: start, a place on the way, end."""
    start, via, end = _three_positions(m, node)
    _to_start(m, start)
    if circle_through(*(_tool_point(m, p) for p in (start, via, end))) is None:
        _straight(m, end)
        return
    if _agree(m, node):
        _same_posture(start.flags[0], end.flags[0])
    _move_on_arc(m, _goal_flange(m, via), end)


def _round_other_side(m: Machine, node: s.Motion) -> None:
    """Mvr2: start, end, a place of the circle that is not on the way."""
    start, end, reference = _three_positions(m, node)
    _to_start(m, start)
    a, b, c = (_tool_point(m, p) for p in (start, end, reference))
    circle = circle_through(a, c, b)
    if circle is None:
        _straight(m, end)
        return
    if _agree(m, node):
        _same_posture(start.flags[0], end.flags[0])
    _move_by_point(m, circle.middle(b, a), end)


def _about(m: Machine, node: s.Motion) -> None:
    """Mvr3: start, end, centre; less than half a turn."""
    start, end, centre = _three_positions(m, node)
    _to_start(m, start)
    a, b, c = (_tool_point(m, p) for p in (start, end, centre))
    if np.array_equal(a, b):
        _straight(m, end)
        return
    radii = np.linalg.norm(a - c), np.linalg.norm(b - c)
    circle = circle_about(a, b, c)
    if abs(radii[0] - radii[1]) > SAME_RADIUS or circle is None:
        raise Failed(2803, "the centre of an arc")
    if _agree(m, node):
        _same_posture(start.flags[0], end.flags[0])
    _move_by_point(m, circle.middle(a, b), end)


PASSING_SPEED: Final = 1.0
"""mm of the corner half-way round a whole circle, which goes on without a stop."""


def _whole_circle(m: Machine, node: s.Motion) -> None:
    """Mvc: start and two places on the way, back to the start; the posture stays."""
    start, first, second = _three_positions(m, node)
    _to_start(m, start)
    a, b, c = (_tool_point(m, p) for p in (start, first, second))
    circle = circle_through(a, b, c)
    if circle is None:
        raise Failed(2803, "the places of a circle")
    kept = poses.pose_of(start, m.world.arm.robot)
    half = poses.position_of(Pose(_tuple_of(c), kept.quaternion), start)
    _move_by_point(m, circle.middle(a, c), half, passing=PASSING_SPEED)
    _move_by_point(m, circle.middle(c, a), start)


def _tuple_of(place: Floats) -> Vector:
    x, y, z = (float(v) for v in place)
    return x, y, z


def _tool_point(m: Machine, value: Position) -> Floats:
    return np.array(poses.pose_of(value, m.world.arm.robot).position)


def _move_by_point(m: Machine, middle: Floats, end: Position, passing: float = 0.0) -> None:
    """An arc through a place that is worked out, turned as at its end.

    passing: mm of the corner at the end of an arc that goes on without a stop.
    """
    turned = poses.pose_of(end, m.world.arm.robot).quaternion
    via = poses.position_of(Pose(_tuple_of(middle), turned), end)
    _move_on_arc(m, _goal_flange(m, via), end, passing)


def _move_on_arc(m: Machine, via: Pose, end: Position, passing: float = 0.0) -> None:
    moved = _motion_event(m, "circular", _goal_flange(m, end), via, at=end)
    _command_motion(m, replace(moved, blend=max(moved.blend, passing)), end.flags)


MOVE_KINDS: Final[Mapping[str, Callable[[Machine, s.Motion], None]]] = {
    "MOV": _joint,
    "MVS": _linear,
    "MVR": _through,
    "MVR2": _round_other_side,
    "MVR3": _about,
    "MVC": _whole_circle,
}
