"""Motions of a pseudo-program: to targets, to joints, and along paths."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Final, Literal

import numpy as np

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, UNSTATED, Blend, Kind, Path, Speed, configuration_row
from assistant.program.rewriting import records
from assistant.robots.configurations import BACK
from assistant.robots.motion.run import to_flange
from assistant.virtual.events import How, Moved, OnWay, Switched
from assistant.virtual.pseudo.expressions import condition, evaluate, numeric, truth_or
from assistant.virtual.pseudo.machine import Fault, Machine, NotRun
from assistant.virtual.triggers import move_until, ordered_triggers

_Way = Literal["joint", "linear", "circular"]
_KINDS: Final[dict[int, _Way]] = {
    Kind.JOINT: "joint",
    Kind.LINEAR: "linear",
    Kind.END: "circular",
}


def move(m: Machine, node: p.Move | p.MoveCircular) -> None:
    """To a target, on its own way or on an arc."""
    tool, frame = m.tool(node.motion.tool), m.frame(node.motion.frame)
    target = _target(evaluate(m, node.target))
    via, kind = None, "circular"
    if isinstance(node, p.MoveCircular):
        via = _flange(_target(evaluate(m, node.via)).pose, tool, frame)
    else:
        kind = node.kind
    moved = _moved(
        m,
        _KINDS_BY_NAME[kind],
        _flange(target.pose, tool, frame),
        (tool, frame),
        _pace(m, node.motion),
        via=via,
        configuration=configuration_row(target.configuration),
        external=target.external,
    )
    _go(m, moved, node)


_KINDS_BY_NAME: Final[dict[str, _Way]] = {way: way for way in _KINDS.values()}


def move_joints(m: Machine, node: p.MoveJoints) -> None:
    target = evaluate(m, node.target)
    if not isinstance(target, JointTarget):
        raise Fault("a motion to joints leads to something else")
    tool, frame = m.tool(node.motion.tool), m.frame(node.motion.frame)
    # NaN marks an axis that the arm lacks; the arm's model needs a number.
    joints = tuple(0.0 if math.isnan(j) else j for j in target.joints)
    pace = _pace(m, node.motion)
    flange = flange_at(m, joints)
    moved = _moved(m, "joint", flange, (tool, frame), pace, joints=joints, external=target.external)
    _go(m, moved, node)


def follow(m: Machine, path: Path) -> Iterator[None]:
    """Along the rows of a path; stops before each, to be counted."""
    tools, frames = [m.tool(t) for t in path.tools], [m.frame(f) for f in path.frames]
    p_, q = np.empty_like(path.positions), np.empty_like(path.quaternions)
    both = np.stack([path.tool, path.frame], axis=1)
    # Each pair of tool and frame is converted at once: a path has many rows and few pairs.
    for t, f in np.unique(both, axis=0).tolist():
        rows = np.flatnonzero((path.tool == t) & (path.frame == f))
        p_[rows], q[rows] = to_flange(
            path.positions[rows], path.quaternions[rows], tools[t], frames[f]
        )
    via: Pose | None = None
    for row, kind in enumerate(path.kinds.tolist()):
        flange = Pose.of(p_[row], q[row])
        # A via point is no motion of its own: it goes with the end of its arc.
        if kind == Kind.VIA:
            via = flange
            continue
        yield
        pace = m.speed(path.speeds[path.speed[row]]), m.blend(path.blends[path.blend[row]])
        mount = tools[path.tool[row]], frames[path.frame[row]]
        stated = tuple(path.configurations[row].tolist())
        moved = _moved(m, _KINDS[kind], flange, mount, pace, via=via, configuration=stated)
        places = tuple(path.external[row].tolist())
        moved = replace(moved, external=_stated(places))
        via = None
        _go(m, moved)


def flange_at(m: Machine, joints: tuple[float, ...]) -> Pose | None:
    """Return the flange pose at joints; None without a robot."""
    if m.robot is None:
        return None
    own = m.robot.own_joints((*joints, *(0.0,) * 6)[: max(6, len(joints))])
    if len(own) != len(m.robot.axes):
        raise Fault(f"{len(joints)} joints for {len(m.robot.axes)} axes")
    position, quaternion = m.robot.flange_poses(np.array([own]))
    return Pose.of(position[0], quaternion[0])


def _pace(m: Machine, motion: p.Motion) -> tuple[Speed, Blend]:
    """Speed and blend of a move that begins now."""
    speed, blend = motion.speed, motion.blend
    return (
        _speed(m, speed) if isinstance(speed, p.ComputedSpeed) else m.speed(speed),
        _blend(m, blend) if isinstance(blend, p.ComputedBlend) else m.blend(blend),
    )


def _speed(m: Machine, speed: p.ComputedSpeed) -> Speed:
    made = Speed(
        math.inf if speed.tcp is None else numeric(m, speed.tcp, "the speed"),
        numeric(m, speed.rotation, "the speed of reorientation"),
        numeric(m, speed.external_linear, "the speed of external axes"),
        numeric(m, speed.external_rotary, "the speed of external axes"),
        None if speed.joint is None else numeric(m, speed.joint, "the joint speed"),
    )
    stated = made.tcp if made.joint is None else min(made.tcp, made.joint)
    if not stated > 0.0:
        raise Fault(f"a motion at a speed of {stated:g}")
    return made


def _blend(m: Machine, blend: p.ComputedBlend) -> Blend:
    if blend.stops is not None and condition(m, blend.stops):
        return FINE
    radius = numeric(m, blend.radius, "the radius of a corner")
    if radius < 0.0:
        raise Fault(f"a corner of {radius:g} mm")
    return Blend(radius)


def _target(value: object) -> Target:
    if isinstance(value, Pose):
        return Target(value)
    if not isinstance(value, Target):
        raise Fault("a motion leads to what is no position")
    return value


def _flange(pose: Pose, tool: Tool, frame: Frame) -> Pose:
    position, quaternion = to_flange(
        np.array([pose.position]), np.array([pose.quaternion]), tool, frame
    )
    return Pose.of(position[0], quaternion[0])


def _moved(
    m: Machine,
    kind: _Way,
    flange: Pose | None,
    mount: tuple[Tool, Frame],
    pace: tuple[Speed, Blend],
    *,
    via: Pose | None = None,
    joints: tuple[float, ...] | None = None,
    configuration: tuple[int, ...] | None = None,
    external: tuple[float, ...] = (),
) -> Moved:
    (tool, frame), (speed, blend) = mount, pace
    held = tool.held and not frame.held
    percent = None if speed.joint is None or kind != "joint" else speed.joint * m.override
    # UNSTATED marks a configuration that the target leaves open.
    if configuration is not None and configuration[BACK] == UNSTATED:
        configuration = None
    return Moved(
        kind,
        flange,
        tool.tip if held else Pose(),
        via,
        joints,
        speed=speed.tcp * m.override if math.isfinite(speed.tcp) else None,
        percent=percent,
        blend=blend.radius or 0.0,
        frame=frame.pose if held else tool.tip,
        how=How(
            configuration=configuration,
            rotation=speed.rotation * m.override,
            acceleration=m.acceleration,
            deceleration=m.deceleration,
            behind=blend.exit,
            mass=None if tool.load is None else tool.load.mass,
        ),
        external=_stated(external),
    )


def _stated(external: tuple[float, ...]) -> tuple[float | None, ...]:
    return tuple(None if math.isnan(place) else place for place in external)


def _go(m: Machine, moved: Moved, node: p.MoveStatement | None = None) -> None:
    triggers, until = ((), None) if node is None else (node.triggers, node.until)
    changes = [change for one in triggers for change in _changes(m, one)]
    before, motion = m.flange, m.task.kernel.motion

    def go() -> None:
        m.flange, m.joints = moved.flange, moved.joints
        motion.go(m.task, moved, ordered_triggers(moved, before, changes))

    if until is None:
        go()
        return
    asks = until
    # Time and the arm's position can make a condition true without any event.
    timed = any(isinstance(part, e.Elapsed | e.Here) for part in records(asks))
    m.broken_off = move_until(m.task, lambda: condition(m, asks), go, timed=timed)
    standing = motion.where() if m.broken_off else None
    if standing is not None:
        m.flange, m.joints = standing


def _changes(m: Machine, trigger: p.Trigger) -> Iterator[Switched]:
    if trigger.pulse is not None:
        raise NotRun("a pulse on the way of a motion")
    ahead = 0.0 if trigger.ahead is None else numeric(m, trigger.ahead, "the time ahead")
    at = OnWay(trigger.measure, numeric(m, trigger.amount, "the place on the way"), ahead)
    yield Switched(trigger.signal.lower(), truth_or(evaluate(m, trigger.value)), at)
