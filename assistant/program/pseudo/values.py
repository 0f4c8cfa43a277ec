"""Poses, targets, speeds, blends, tools and frames, as text and back."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, TypeAlias, TypeVar, cast

from lark import Token, Tree

from assistant.program.expressions import Name
from assistant.program.geometry import (
    NO_EXTERNAL,
    UNUSED_AXIS,
    Configuration,
    Frame,
    JointTarget,
    Load,
    Pose,
    Quaternion,
    Target,
    Tool,
    Vector,
)
from assistant.program.motion import Blend, Speed
from assistant.program.pseudo.findings import COUNT, NOT_FINITE, NOT_UNIT, QUADRANT, Wrong
from assistant.program.pseudo.words import (
    Node,
    name_text,
    number_text,
    numbers_text,
    read_integer,
    read_name,
    read_number,
    read_numbers,
)

UNIT_TOLERANCE: Final = 1e-3
"""How far from 1 the length of a quaternion may be."""

Part = TypeVar("Part")
Turns: TypeAlias = tuple[Part, Part, Part]
"""How fast a speed turns (deg/s), and how fast external axes move (mm/s) and turn (deg/s)."""

_USUAL: Final = Speed(0.0)
_USUAL_TURNS: Final = (_USUAL.rotation, _USUAL.external_linear, _USUAL.external_rotary)
_ZERO: Final = "[0, 0, 0]"
_NO_TURN: Final = "[1, 0, 0, 0]"


# ------------------------------------------------------------------------- poses and targets


def pose_text(pose: Pose) -> str:
    """`[x, y, z] [w, x, y, z]`, the latter only if it turns anything."""
    position, turn = numbers_text(pose.position), numbers_text(pose.quaternion)
    return position if turn == _NO_TURN else f"{position} {turn}"


def read_pose(tree: Node | None) -> Pose:
    if tree is None:
        return Pose()
    position, turn = tree.children
    if turn is None:
        return Pose(read_vector(position))
    return Pose(read_vector(position), read_quaternion(turn))


def target_text(target: Target) -> str:
    parts = [numbers_text(target.pose.position), numbers_text(target.pose.quaternion)]
    if target.configuration is not None:
        parts.append(configuration_text(target.configuration))
    return " ".join(parts + external_text(target.external))


def read_target(tree: Node) -> Target:
    position, turn, configuration, external = tree.children
    pose = Pose(read_vector(position), read_quaternion(turn))
    branch = read_configuration(configuration) if configuration is not None else None
    return Target(pose, cast("Configuration | None", branch), read_external(external))


def joints_text(target: JointTarget) -> str:
    return " ".join([numbers_text(target.joints), *external_text(target.external)])


def read_joints(tree: Node) -> JointTarget:
    joints, external = tree.children
    return JointTarget(read_numbers(_tree(joints)), read_external(external))


def configuration_text(configuration: Configuration) -> str:
    """The words of an arm branch and the quadrants of axes 1, 4 and 6."""
    c = configuration
    words = (
        "back" if c.back else "front",
        "down" if c.down else "up",
        "flip" if c.flip else "noflip",
    )
    return " ".join([*words, *map(str, c.quadrants)])


def read_configuration(tree: object) -> Configuration:
    """Raises Wrong for a quadrant that no column of a path can hold."""
    arm, elbow, wrist, *quadrants = cast("list[Token]", _tree(tree).children)
    one, four, six = map(read_integer, quadrants)
    for token, number in zip(quadrants, (one, four, six), strict=True):
        if not -128 <= number <= 127:
            raise Wrong(QUADRANT, token, number=number)
    return Configuration(arm == "back", elbow == "down", wrist == "flip", (one, four, six))


def external_text(external: tuple[float, ...]) -> list[str]:
    """Nothing if no axis is used; else the axes up to the last that is."""
    used = [i for i, value in enumerate(external) if value == value]
    return [f"external {numbers_text(external[: used[-1] + 1])}"] if used else []


def read_external(tree: object) -> tuple[float, ...]:
    if tree is None:
        return NO_EXTERNAL
    values = read_numbers(_tree(tree))
    if len(values) > len(NO_EXTERNAL):
        raise Wrong(COUNT, _tree(tree), count=len(values), s="s", expected="at most 6")
    return values + (UNUSED_AXIS,) * (len(NO_EXTERNAL) - len(values))


def read_vector(tree: object) -> Vector:
    """Three finite numbers; raises Wrong."""
    values = read_numbers(_tree(tree), 3)
    if not all(map(math.isfinite, values)):
        raise Wrong(NOT_FINITE, _tree(tree), what="a coordinate")
    return cast(Vector, values)


def read_quaternion(tree: object) -> Quaternion:
    """Four numbers of unit length, exactly as they stand; raises Wrong."""
    values = read_numbers(_tree(tree), 4)
    length = math.hypot(*values)
    if not abs(length - 1.0) <= UNIT_TOLERANCE:
        raise Wrong(NOT_UNIT, _tree(tree), length=length)
    return cast(Quaternion, values)


# ---------------------------------------------------------------------------- speed and blend


def speed_text(speed: Speed | Name) -> str:
    """`150 mm/s`, and whatever differs from a usual speed."""
    if isinstance(speed, Name):
        return name_text(speed.name)
    return speed_parts_text(
        None if speed.tcp == math.inf else speed.tcp,
        (speed.rotation, speed.external_linear, speed.external_rotary),
        speed.joint,
        _USUAL_TURNS,
        number_text,
    )


def read_speed(tree: object) -> Speed | Name:
    node = _tree(tree)
    if node.data == "name":
        return Name(read_name(node))
    tcp, turns, joint = read_speed_parts(node, _USUAL_TURNS, lambda part: read_number(_token(part)))
    return Speed(math.inf if tcp is None else tcp, *turns, joint)


def speed_parts_text(
    tcp: Part | None,
    turns: Turns[Part],
    joint: Part | None,
    usual: Turns[Part],
    text: Callable[[Part], str],
) -> str:
    """A speed whose parts are numbers, or are worked out: what `text` writes of one of them.

    tcp: None for the robot's own maximum. Parts that are usual are not written.
    """
    parts = ["maximum" if tcp is None else f"{text(tcp)} mm/s"]
    if turns[0] != usual[0]:
        parts.append(f"rotation {text(turns[0])} deg/s")
    if turns[1:] != usual[1:]:
        parts.append(f"external {text(turns[1])} mm/s {text(turns[2])} deg/s")
    if joint is not None:
        parts.append(f"joint {text(joint)} %")
    return " ".join(parts)


def read_speed_parts(
    node: Node, usual: Turns[Part], read: Callable[[object], Part]
) -> tuple[Part | None, Turns[Part], Part | None]:
    """The speed along the path, of turns and external axes, and of joints, each by `read`."""
    tcp, rotation, external, joint = node.children
    linear, rotary = external.children if isinstance(external, Tree) else (None, None)
    turned, moved, spun = (
        whole if part is None else read(part)
        for part, whole in zip((rotation, linear, rotary), usual, strict=True)
    )
    return (
        None if tcp == "maximum" else read(tcp),
        (turned, moved, spun),
        None if joint is None else read(joint),
    )


def blend_text(blend: Blend | Name) -> str:
    """`fine`, `full`, or `10 mm`, and what else it states."""
    if isinstance(blend, Name):
        return name_text(blend.name)
    if blend.radius is None:
        parts = ["fine"]
    else:
        parts = ["full" if blend.radius == math.inf else f"{number_text(blend.radius)} mm"]
    if blend.exit is not None:
        parts.append(f"exit {number_text(blend.exit)} mm")
    if blend.details is not None:
        parts.append(f"details {numbers_text(blend.details)}")
    return " ".join(parts)


def read_blend(tree: object) -> Blend | Name:
    node = _tree(tree)
    if node.data == "name":
        return Name(read_name(node))
    radius, leave, details = node.children
    said = _token(radius)
    return Blend(
        None if said == "fine" else math.inf if said == "full" else read_number(said),
        None if leave is None else read_number(_token(leave)),
        None
        if details is None
        else cast("tuple[float, float, float, float, float]", read_numbers(_tree(details), 5)),
    )


# ---------------------------------------------------------------------------- tools and frames


def tool_text(tool: Tool) -> str:
    """`tip … mass … stationary free turn`, as far as they are not usual."""
    parts = _pose_parts("tip", tool.tip)
    if tool.load is not None:
        load = tool.load
        parts.append(f"mass {number_text(load.mass)} kg")
        for word, values, usual in (
            ("centre", load.centre, _ZERO),
            ("axes", load.axes, _NO_TURN),
            ("inertia", load.inertia, _ZERO),
        ):
            text = numbers_text(values)
            parts += [] if text == usual else [f"{word} {text}"]
    parts += [] if tool.held else ["stationary"]
    return " ".join(parts + (["free turn"] if tool.free_turn else []))


def read_tool(tip: object, load: object, stationary: object, free: object) -> Tool:
    return Tool(
        read_pose(None if tip is None else _tree(tip)),
        None if load is None else _read_load(_tree(load)),
        held=stationary is None,
        free_turn=free is not None,
    )


def frame_text(frame: Frame) -> str:
    """`user … object … held mechanism … seen …`, as far as they are not usual."""
    parts = _pose_parts("user", frame.user) + _pose_parts("object", frame.object)
    parts += ["held"] if frame.held else []
    parts += [f"mechanism {name_text(frame.mechanism)}"] if frame.mechanism else []
    parts += [f"seen {name_text(frame.seen)}"] if frame.seen else []
    return " ".join(parts)


def read_frame(
    user: object, object_: object, held: object, mechanism: object, seen: object
) -> Frame:
    return Frame(
        read_pose(None if user is None else _tree(user)),
        read_pose(None if object_ is None else _tree(object_)),
        held is not None,
        "" if mechanism is None else read_name(_tree(mechanism)),
        "" if seen is None else read_name(_tree(seen)),
    )


def _pose_parts(word: str, pose: Pose) -> list[str]:
    text = pose_text(pose)
    return [] if text == _ZERO else [f"{word} {text}"]


def _read_load(tree: Node) -> Load:
    mass, centre, axes, inertia = tree.children
    usual = Load(0.0)
    return Load(
        read_number(_token(mass)),
        usual.centre if centre is None else read_vector(centre),
        usual.axes if axes is None else read_quaternion(axes),
        usual.inertia if inertia is None else read_vector(inertia),
    )


# --------------------------------------------------------------------------- parts of a tree


def _tree(part: object) -> Node:
    assert isinstance(part, Tree)
    return part


def _token(part: object) -> Token:
    assert isinstance(part, Token)
    return part
