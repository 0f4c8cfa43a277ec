"""Statements on the arm: moves with `Wth` and `WthIf`, tools, servo, hands, softness.

Each move makes one event. An output of `Wth` is placed on the path of its move; the condition of
`WthIf` is watched while the arm moves.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from assistant.base.arrays import Floats
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program.geometry import IDENTITY, Pose, Vector
from assistant.robots.configurations import from_flags
from assistant.virtual.events import How, Moved, OnWay, Switched
from assistant.virtual.melfa import arm_state, expressions, interrupts
from assistant.virtual.melfa.arm_state import OPTIMUM, Arm
from assistant.virtual.melfa.options import Frame
from assistant.virtual.melfa.positions import circle_about, circle_through
from assistant.virtual.melfa.values import (
    ORIGIN,
    Bare,
    Failed,
    Joints,
    Position,
    Unknown,
    Value,
    eight,
    holds,
    open_point,
    out_of_range,
    position,
    whole,
)

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine


_PATH_MEASURES: Final[Mapping[str, tuple[Literal["end", "share"], str]]] = {
    "M_RDST": ("end", "<"),
    "M_RATIO": ("share", ">"),
}
"""Variables that measure the progress of a motion, and the comparison with a later position on its
path.
"""
_PATH_START: Final = OnWay("start", 0.0)
_MIRRORED: Final = {"<": ">", ">": "<"}


def _begin_wth(m: Machine, append: s.Append) -> list[Switched]:
    """Return the outputs set on the path of the next motion; inputs stay the same until it ends."""
    from assistant.virtual.melfa.statements import execute

    condition = append.condition
    place = _PATH_START
    if condition is not None and _reads_position(condition):
        place = _trigger_place(m, condition)
    elif condition is not None and not holds(expressions.value(m, condition)):
        return []
    # Outputs are collected instead of being set: the motion sets them on its way.
    m.world.held = []
    try:
        execute(m, append.statement)
        return [replace(change, at=place) for change in m.world.held]
    finally:
        m.world.held = None


class _Skipped(Exception):
    """A motion is broken off."""


def _is_watched_condition(m: Machine, append: s.Append) -> bool:
    """True if the appended statement waits for its condition while the motion runs."""
    condition = append.condition
    if not isinstance(append.statement, s.Assign):
        return True
    if condition is None or _reads_position(condition):
        return False
    on_way = _reads_any(condition, interrupts.ON_WAY)
    if m.world.task.kernel.motion.where() is None:
        if on_way:
            raise Unknown("where on its way a motion meets a condition")
        return False
    return on_way or not holds(expressions.value(m, condition))


def _watch_condition(m: Machine, append: s.Append, run: Callable[[], None]) -> None:
    """Runs a motion that `Skip` ends where the arm is, or `Hlt` holds, or on whose way an output is
    set, as soon as a condition is met (COSIROP: SKIP, HLT, WTHIF).
    """
    world, condition = m.world, append.condition
    motion = world.task.kernel.motion
    word = append.statement.keyword.upper() if isinstance(append.statement, s.Command) else ""
    if word not in ("SKIP", "HLT") and not isinstance(append.statement, s.Assign):
        raise Unknown(f"{word or 'such a statement'} on the way of a motion")
    timed = motion.where() is not None
    on_way = condition is not None and _reads_any(condition, interrupts.ON_WAY)
    if on_way and not timed:
        raise Unknown("where a motion is when it is broken off")
    # The condition is met before the motion begins: `Skip` leaves it out, `Hlt` holds before it.
    if condition is None or (not on_way and holds(expressions.value(m, condition))):
        if word == "SKIP":
            motion.settle(world.task)
            world.skipped = True
        else:
            world.halt()
            run()
        return

    def monitor() -> None:
        if holds(expressions.value(m, condition)):
            # Only once: what happens may look at conditions again.
            world.monitor = None
            _act_on_condition(m, append.statement, word)

    # Only a motion with `Skip` changes M_SkipCq.
    world.skipped = world.skipped and word != "SKIP"
    world.monitor = monitor if timed else None
    interrupts.attend(m, condition)
    try:
        run()
        if word == "SKIP" and not timed:  # a motion without time is whole as it is broken off
            world.skipped = holds(expressions.value(m, condition))
    except _Skipped:
        arm_state.cut_motion(world)
        world.skipped = True
    finally:
        world.monitor = None
        interrupts.attend(m)


def _act_on_condition(m: Machine, statement: s.Statement, word: str) -> None:
    """The condition of what is appended is met while the motion runs."""
    from assistant.virtual.melfa.statements import execute

    if word == "SKIP":
        raise _Skipped
    if word == "HLT":
        paused = arm_state.pause_arm(m.world, late=False)
        m.world.halt()
        if paused:
            arm_state.resume_arm(m.world)
    else:
        execute(m, statement)


def _reads_any(condition: s.Expression, names: Container[str]) -> bool:
    return any(isinstance(x, s.Variable) and x.key in names for x in nodes(condition))


def _reads_position(condition: s.Expression) -> bool:
    return _reads_any(condition, _PATH_MEASURES)


def _trigger_place(m: Machine, condition: s.Expression) -> OnWay:
    """Return the position on the path where a condition becomes true; raises Unknown for all but
    plain comparisons.
    """
    # A path has no single place at which a value becomes different.
    if isinstance(condition, s.Binary) and "<>" not in condition.operator:
        compared = condition.operator[:1]
        sides = (
            (condition.left, compared, condition.right),
            (condition.right, _MIRRORED.get(compared, ""), condition.left),
        )
        for place, way, bound in sides:
            if (
                isinstance(place, s.Variable)
                and place.key in _PATH_MEASURES
                and not place.arguments
            ):
                measure, reached = _PATH_MEASURES[place.key]
                if way == reached and not _reads_position(bound):
                    return OnWay(measure, expressions.plain(m, bound, "a place on the way"))
    raise Unknown("where on its way a motion meets a condition")


AXES: Final = 6
"""Elements for the arm's axes in a position or joint position; additional axes follow them."""
_SAME_RADIUS: Final = 0.01
"""mm by which the two radii of Mvr3 may differ (COSIROP: MVR3)."""


def move(m: Machine, node: s.Motion) -> None:
    """Runs a motion with what is appended to it; raises Unknown for a kind not simulated."""
    word = node.keyword.upper()
    if not m.world.arm.servo:
        raise Failed(2000, "the servo is off")
    if word in m.world.commands:
        m.world.given(word, expressions.values(m, node.arguments))
        return
    kind = _MOVE_KINDS.get(word)
    if kind is None:
        raise Unknown(f"the motion {node.keyword}")
    m.world.needs_mechanism("a motion")
    arm_state.before_motion(m.world)
    if node.append is None:
        kind(m, node)
        return
    if _is_watched_condition(m, node.append):
        _watch_condition(m, node.append, lambda: kind(m, node))
        return
    m.world.on_way, m.world.appended = _begin_wth(m, node.append), False
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
        _command_motion(m, _motion_event(m, "joint", flange, at=goal), goal)


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
    """True if the structure flags of both ends must be the same: not with `Type 0,1` or `0,2`."""
    return node.type is None or expressions.integer(m, node.type[1], "the type") == 0


def _joints_position(m: Machine, joints: Joints) -> Position:
    """Return the position of the tip at joints, with the active tool and base."""
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
    _command_motion(m, _motion_event(m, "linear", flange, at=goal), goal)


def _same_posture(one: int | None, other: int | None) -> None:
    if one is not None and other is not None and one != other:
        raise Failed(2810, "the posture flags of start and end differ")


def _move_goal(m: Machine, node: s.Motion) -> Position | Joints:
    """Return the target of Mov and Mvs, moved along the tool by the distance that follows it."""
    target, *more = node.arguments
    goal = m.world.arm.shown() if target is None else _target_value(expressions.value(m, target))
    if not more or more[0] is None:
        return goal
    distance = expressions.plain(m, more[0], "the distance")
    if isinstance(goal, Joints):
        goal = _joints_position(m, goal)
    away = arm_state.pose_of(goal, m.world.arm.robot).offset(z=distance)
    return arm_state.position_of(away, goal, m.world.arm.robot)


def _target_value(value: Value) -> Position | Joints:
    if isinstance(value, Bare):
        raise Unknown("a move to a constant that may be a position or joints")
    if not isinstance(value, Position | Joints):
        raise Failed(3810, "a move to what is no position")
    return value


def _goal_flange(m: Machine, goal: Position) -> Pose:
    return m.world.arm.placed(goal)


def _command_motion(m: Machine, moved: Moved, goal: Position) -> None:
    """A motion to a position."""
    arm, flags = m.world.arm, goal.flags
    before = arm.flange
    assert moved.flange is not None
    arm.at_position(moved.flange, flags)
    arm.corner = goal.corner
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
    # At the optimum speed the controller chooses how fast the arm is.
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
            # Without a tool nothing hangs on the flange; what a tool weighs is not known.
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
    # What was read in a corner is nowhere but where a motion led that went there.
    read = start.corner is not arm.corner
    if read or not arm_state.same_place(tip, flange @ arm.tip, _START_DISTANCE):
        _straight(m, start)


_START_DISTANCE: Final = 0.05
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
    # From start through the reference to the end; from there on to the start is the other side.
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
    if abs(radii[0] - radii[1]) > _SAME_RADIUS or circle is None:
        raise Failed(2803, "the centre of an arc")
    if _agree(m, node):
        _same_posture(start.flags[0], end.flags[0])
    _move_by_point(m, circle.middle(a, b), end)


_PASSING_SPEED: Final = 1.0
"""mm of the corner half-way round a whole circle, which goes on without a stop."""


def _whole_circle(m: Machine, node: s.Motion) -> None:
    """Mvc: start and two places on the way, back to the start; the posture stays."""
    start, first, second = _three_positions(m, node)
    _to_start(m, start)
    a, b, c = (_tool_point(m, p) for p in (start, first, second))
    circle = circle_through(a, b, c)
    if circle is None:
        raise Failed(2803, "the places of a circle")
    kept = arm_state.pose_of(start, m.world.arm.robot)
    half = arm_state.position_of(Pose(_tuple_of(c), kept.quaternion), start)
    # An arc has an end apart from its start, so the circle is two arcs with a corner between them.
    _move_by_point(m, circle.middle(a, c), half, passing=_PASSING_SPEED)
    _move_by_point(m, circle.middle(c, a), start)


def _tuple_of(place: Floats) -> Vector:
    x, y, z = (float(v) for v in place)
    return x, y, z


def _tool_point(m: Machine, value: Position) -> Floats:
    return np.array(arm_state.pose_of(value, m.world.arm.robot).position)


def _move_by_point(m: Machine, middle: Floats, end: Position, passing: float = 0.0) -> None:
    """An arc through a place that is worked out, turned as at its end.

    passing: mm of the corner at the end of an arc that goes on without a stop.
    """
    turned = arm_state.pose_of(end, m.world.arm.robot).quaternion
    via = arm_state.position_of(Pose(_tuple_of(middle), turned), end)
    _move_on_arc(m, _goal_flange(m, via), end, passing)


def _move_on_arc(m: Machine, via: Pose, end: Position, passing: float = 0.0) -> None:
    moved = _motion_event(m, "circular", _goal_flange(m, end), via, at=end)
    _command_motion(m, replace(moved, blend=max(moved.blend, passing)), end)


_MOVE_KINDS: Final[Mapping[str, Callable[[Machine, s.Motion], None]]] = {
    "MOV": _joint,
    "MVS": _linear,
    "MVR": _through,
    "MVR2": _round_other_side,
    "MVR3": _about,
    "MVC": _whole_circle,
}


# ------------------------------------------------------------------------------------ frames


def _set_tool_statement(m: Machine, node: s.Expression) -> None:
    """Holds at once, also for P_Curr."""
    found = expressions.value(m, node)
    if isinstance(found, bool | int | float):
        choose_tool(m, whole(found))
    else:
        _set_tool(m.world.arm, position(found, "a tool"), None)


def choose_tool(m: Machine, number: int) -> None:
    """A tool by its number, as the parameters MEXTL1 and so on give it."""
    # The positions of the program come before the options of the run, as its cell states them.
    kept = _parameter_position(m, f"MEXTL{number}")
    _set_tool(m.world.arm, kept or _numbered_frame(m.world.options.tools, number, "tool"), number)


def _parameter_position(m: Machine, parameter: str) -> Position | None:
    """Return the value of a parameter from a program's list of positions for its cell.

    The list has it as a position whose name is P and the name of the parameter.
    """
    place = m.main.places.get(f"P{parameter}")
    value = place.get() if place is not None and place.is_set() else None
    return value if isinstance(value, Position) else None


def _set_tool(arm: Arm, tool: Position, number: int | None) -> None:
    arm.tool, arm.tip, arm.tool_number = tool, arm_state.pose_of(tool), number


def _set_base(m: Machine, node: s.Expression) -> None:
    """The robot's base seen from where positions are counted."""
    arm, found, number = m.world.arm, expressions.value(m, node), None
    if isinstance(found, bool | int | float):
        number = whole(found)
        kept = _parameter_position(m, f"WK{number}CORD")
        base = kept or _numbered_frame(m.world.options.bases, number, "base")
        if kept is None and number and m.world.options.bases_are is None:
            raise open_point("from where a numbered base is seen", "bases_are")
        if kept is not None or m.world.options.bases_are == "seen":
            base = arm_state.inverse(base, None)
    else:
        base = position(found, "a base")
    arm.base, arm.foot, arm.base_number = base, arm_state.pose_of(base), number


def _numbered_frame(frames: Mapping[int, Frame], number: int, what: str) -> Position:
    """Return a numbered frame; number 0 is the origin unless the options set it (CR1D: Base,
    Tool).
    """
    if number == 0 and number not in frames:
        return ORIGIN
    if number not in frames:
        raise open_point(f"the {what} {number}, which stands in a parameter", f"{what}s")
    return Position(eight(frames[number]), (0, 0))


# -------------------------------------------------------------------------------------- servo


def _switch_servo(m: Machine, node: s.Expression, *mechanism: s.Expression | None) -> None:
    m.world.needs_mechanism("Servo")
    word = expressions.bare(node)
    if word not in ("On", "Off"):
        raise Failed(4220, "Servo without On or Off")
    if mechanism:
        raise Unknown("Servo of a mechanism by its number")
    m.world.stand()
    m.world.arm.servo = word == "On"


def _change_turns(m: Machine, node: s.Expression, axis: s.Expression | None = None) -> None:
    """JRC: the joint counts a turn more or less, and the arm stays where it is."""
    turns = expressions.integer(m, node, "the turns of JRC")
    which = _SIXTH_AXIS if axis is None else expressions.integer(m, axis, "the axis of JRC")
    if turns not in (-1, 0, 1):
        raise out_of_range(f"{turns} turns of JRC")
    if not m.world.options.joint_turns:
        m.world.note("JRC does nothing while the parameter JRCEXE is 0")
        return
    if which != _SIXTH_AXIS:
        raise Unknown("JRC of an axis whose turns a parameter gives")
    if turns == 0:
        raise Failed(3910, "JRC 0 of an axis of the arm")
    m.world.stand()
    arm = m.world.arm
    # Joints that are not solved yet would not get the turn.
    if arm.robot is not None and arm.flange is not None:
        arm.shown_joints()
    if arm.joints is not None:
        arm.joints = (*arm.joints[:5], arm.joints[5] + 360.0 * turns, *arm.joints[6:])
    one, two = arm.flags
    if two is not None:
        # `&` binds weaker than `+`: the sum is taken first, then its four bits.
        nibble = (two >> _TURN_SHIFT & 15) + turns & 15
        arm.flags = (one, two & ~(15 << _TURN_SHIFT) | nibble << _TURN_SHIFT)


_SIXTH_AXIS: Final = 6
_TURN_SHIFT: Final = 20
"""Shift of the four bits of joint 6 in FL2."""

# -------------------------------------------------------------------------------------- hands


def _move_hand(m: Machine, node: s.Expression, value: float) -> None:
    order_hand(m, expressions.integer(m, node, "the hand"), value)


def order_hand(m: Machine, hand: int, value: float) -> None:
    """An order to open (1) or to close (0) a hand."""
    if not 1 <= hand <= _MOST_HANDS:
        raise out_of_range(f"the hand {hand}")
    m.world.arm.hands[hand] = value
    m.world.task.switch(_HAND_SIGNAL.format(hand), value)


_MOST_HANDS: Final = 8
_HAND_SIGNAL: Final = "hand{}"
"""The event of a hand: 1 as it opens, 0 as it closes."""

# ----------------------------------------------------------------------------------- softness


def _set_softness(m: Machine, mode: s.Expression, axes: s.Expression | None = None) -> None:
    """Cmp: without a force on the arm it stays where it is sent."""
    word, arm = expressions.bare(mode), m.world.arm
    if word not in ("Jnt", "Pos", "Tool", "Off") or (axes is None) != (word == "Off"):
        raise Failed(4220, "Cmp without its kind and its axes")
    if axes is not None:
        expressions.integer(m, axes, "the axes of Cmp")
        if arm.soft not in ("", word):
            raise Failed(2700, f"Cmp {word} while Cmp {arm.soft} holds")
    arm.soft = "" if axes is None else word
    m.world.note("Cmp has no effect: nothing pushes the arm here")


ARM_WORDS: Final[Mapping[str, Callable[..., None]]] = {
    "TOOL": _set_tool_statement,
    "BASE": _set_base,
    "SERVO": _switch_servo,
    "JRC": _change_turns,
    "HOPEN": lambda m, hand, *_: _move_hand(m, hand, 1.0),
    "HCLOSE": lambda m, hand: _move_hand(m, hand, 0.0),
    "CMP": _set_softness,
}
