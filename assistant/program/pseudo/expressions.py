"""Expressions, poses, targets, speeds, blends, tools and frames, to text and from it.

Brackets are written only where the priorities of operators require them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, TypeAlias, TypeVar, assert_never, cast

from lark import Token, Tree

from assistant.base.diagnostics import Refused
from assistant.program.expressions import (
    FUNCTIONS,
    Aggregate,
    Apply,
    Binary,
    BinaryOperator,
    Elapsed,
    Expression,
    Here,
    Index,
    JointValue,
    Member,
    Name,
    Number,
    PoseValue,
    TargetValue,
    Text,
    Truth,
    Unary,
    UnaryOperator,
    Verbatim,
)
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
from assistant.program.pseudo.words import (
    COUNT,
    MOST_DEEP,
    NO_PLACE,
    NOT_FINITE,
    NOT_UNIT,
    QUADRANT,
    TOO_DEEP,
    Node,
    Wrong,
    name_text,
    number_text,
    numbers_text,
    quoted,
    read_integer,
    read_name,
    read_number,
    read_numbers,
    read_word,
    unquoted,
    word_text,
)

UNIT_TOLERANCE: Final = 1e-3
"""Largest deviation of a quaternion's length from 1."""

Part = TypeVar("Part")
Turns: TypeAlias = tuple[Part, Part, Part]
"""Rotation speed (deg/s), and speeds of external axes (mm/s and deg/s)."""

_USUAL: Final = Speed(0.0)
_USUAL_TURNS: Final = (_USUAL.rotation, _USUAL.external_linear, _USUAL.external_rotary)
_ZERO: Final = "[0, 0, 0]"
_NO_TURN: Final = "[1, 0, 0, 0]"


# ------------------------------------------------------------------------- poses and targets


def pose_text(pose: Pose) -> str:
    """`[x, y, z] [w, x, y, z]`, the latter only if it turns anything."""
    position, turn = numbers_text(pose.position), numbers_text(pose.quaternion)
    return position if turn == _NO_TURN else f"{position} {turn}"


def _read_pose(tree: Node | None) -> Pose:
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
    return " ".join(parts + _external_text(target.external))


def read_target(tree: Node) -> Target:
    position, turn, configuration, external = tree.children
    pose = Pose(read_vector(position), read_quaternion(turn))
    branch = read_configuration(configuration) if configuration is not None else None
    return Target(pose, cast("Configuration | None", branch), read_external(external))


def joints_text(target: JointTarget) -> str:
    return " ".join([numbers_text(target.joints), *_external_text(target.external)])


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


def _external_text(external: tuple[float, ...]) -> list[str]:
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
    # The negation refuses NaN as well.
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
        _read_pose(None if tip is None else _tree(tip)),
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
        _read_pose(None if user is None else _tree(user)),
        _read_pose(None if object_ is None else _tree(object_)),
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


COMPARISON, MINUS, _POWER, _LITERAL, ATOM = 5, 8, 9, 10, 11

_PRIORITIES: Final[dict[str, int]] = {
    "or": 1, "xor": 2, "and": 3, "not": 4,
    "=": COMPARISON, "<>": COMPARISON, "<": COMPARISON, "<=": COMPARISON,
    ">": COMPARISON, ">=": COMPARISON,
    "+": 6, "-": 6, "*": 7, "/": 7, "@": 7, "div": 7, "mod": 7, "^": _POWER,
}  # fmt: skip
"""Operators, the loosest first. `^` groups from the right, comparisons not at all, the rest
from the left. A sign binds looser than `^`."""


def expression_text(expression: Expression, least: int = 0) -> str:
    """Raises Refused for an expression of more levels than can be read back."""
    try:
        text = _text(expression, least)
    except RecursionError:
        text = None
    # Short texts cannot be deep: the count of levels is left out.
    if text is None or (len(text) > MOST_DEEP and _is_deeper(expression, MOST_DEEP - 10)):
        raise Refused(TOO_DEEP(what="expression", cure="split it into several"))
    return text


def assignable_text(expression: Expression) -> str:
    """An expression as it stands on the left of `=`."""
    return expression_text(expression, ATOM)


def arguments_text(items: tuple[Expression, ...]) -> str:
    return ", ".join(map(expression_text, items))


def read_expression(tree: object) -> Expression:
    """The expression of a tree; raises Wrong."""
    assert isinstance(tree, Tree)
    return _READERS[tree.data](tree)


def read_arguments(tree: object) -> tuple[Expression, ...]:
    assert isinstance(tree, Tree)
    return tuple(read_expression(child) for child in tree.children if child is not None)


# ------------------------------------------------------------------------------------- to text


def _text(expression: Expression, least: int) -> str:
    """In brackets if the expression binds looser than `least`."""
    text, priority = _text_and_priority(expression)
    return f"({text})" if priority < least else text


def _text_and_priority(expression: Expression) -> tuple[str, int]:
    match expression:
        case Number(value):
            text = _number_text(value)
            return text, MINUS if text.startswith("-") else _LITERAL
        case Truth(value):
            return "true" if value else "false", ATOM
        case Text(value):
            return quoted(value), ATOM
        case Name(name):
            return name_text(name), ATOM
        case TargetValue(target):
            return f"target {target_text(target)}", _LITERAL
        case JointValue(joints):
            return f"joints {joints_text(joints)}", _LITERAL
        case PoseValue(pose):
            return f"pose {pose_text(pose)}", _LITERAL
        case Aggregate(items):
            return f"[{_list(items)}]", ATOM
        case Member(value, field):
            return f"{_text(value, ATOM)}.{name_text(field)}", ATOM
        case Index(value, indices):
            return f"{_text(value, ATOM)}[{_list(indices)}]", ATOM
        case Unary(operator, operand):
            return _unary_text(operator, operand)
        case Binary(operator, left, right):
            return _binary_text(operator, left, right)
        case Apply(function, arguments):
            return f"{name_text(function)}({_list(arguments)})", ATOM
        case Elapsed(timer):
            return f"elapsed({name_text(timer)})", ATOM
        case Here(tool, frame):
            return f"here({name_text(tool)}, {name_text(frame)})", ATOM
        case Verbatim(language, text):
            return f"verbatim {word_text(language)} {quoted(text)}", ATOM
    assert_never(expression)


def _list(items: tuple[Expression, ...]) -> str:
    return ", ".join(_text(item, 0) for item in items)


def _is_deeper(expression: Expression, most: int) -> bool:
    """True if the expression has more levels; works without recursion."""
    level: list[Expression] = [expression]
    # Level by level: recursion could exceed the stack of Python.
    for _ in range(most):
        level = [part for whole in level for part in _parts(whole)]
        if not level:
            return False
    return True


def _parts(expression: Expression) -> tuple[Expression, ...]:
    match expression:
        case Aggregate(items) | Apply(arguments=items):
            return items
        case Member(value):
            return (value,)
        case Index(value, indices):
            return (value, *indices)
        case Unary(operand=operand):
            return (operand,)
        case Binary(left=left, right=right):
            return (left, right)
    return ()


def _number_text(value: float) -> str:
    """An int as digits, a float with its point, so that either comes back as what it was."""
    return str(int(value)) if isinstance(value, int) else repr(float(value))


def _unary_text(operator: UnaryOperator, operand: Expression) -> tuple[str, int]:
    if operator == "not":
        return f"not {_text(operand, _PRIORITIES['not'])}", _PRIORITIES["not"]
    # `-5` is read as a number, so a sign before a number needs brackets.
    text = _text(operand, MINUS)
    bare = isinstance(operand, Number) and not text.startswith("-")
    return (f"-({text})" if bare else f"-{text}"), MINUS  # `-5` is the number, `-(5)` its sign


def _binary_text(operator: BinaryOperator, left: Expression, right: Expression) -> tuple[str, int]:
    priority = _PRIORITIES[operator]
    if operator == "^":
        # `^` groups from the right, and a sign binds looser than it.
        first, second = _LITERAL, MINUS
    else:
        # Comparisons do not group: brackets on both sides.
        first, second = priority + (priority == COMPARISON), priority + 1
    return f"{_text(left, first)} {operator} {_text(right, second)}", priority


# ----------------------------------------------------------------------------------- from text


def _read_number(tree: Node) -> Expression:
    token = cast(Token, tree.children[0])
    return Number(read_integer(token) if token.isdigit() else read_number(token))


def _read_unary(tree: Node) -> Expression:
    operator, operand = tree.children
    inner = read_expression(operand)
    # A minus before a bare number is part of it.
    if operator == "-" and cast(Node, operand).data == "number":
        return Number(-cast(Number, inner).value)
    return Unary(cast(UnaryOperator, str(operator)), inner)


def _read_binary(tree: Node) -> Expression:
    left, operator, right = tree.children
    return Binary(
        cast(BinaryOperator, str(operator)), read_expression(left), read_expression(right)
    )


def _read_apply(tree: Node) -> Expression:
    function, given = read_name(_child(tree)), read_arguments(_child(tree, 1))
    # Functions of the language have one spelling in any case.
    function = function.lower() if function.lower() in FUNCTIONS else function
    match function, given:
        case "elapsed", (Name(timer),):
            return Elapsed(timer)
        case "here", (Name(tool), Name(frame)):
            return Here(tool, frame)
        case "here", _:
            raise Wrong(NO_PLACE, tree)
    return Apply(function, given)


def _child(tree: Node, index: int = 0) -> Any:
    return tree.children[index]


_READERS: Final[dict[str, Callable[[Node], Expression]]] = {
    "number": _read_number,
    "truth": lambda tree: Truth(_child(tree) == "true"),
    "text": lambda tree: Text(unquoted(_child(tree))),
    "variable_value": lambda tree: Name(read_name(_child(tree))),
    "target_value": lambda tree: TargetValue(read_target(_child(tree))),
    "joint_value": lambda tree: JointValue(read_joints(_child(tree))),
    "pose_value": lambda tree: PoseValue(_read_pose(_child(tree))),
    "aggregate": lambda tree: Aggregate(read_arguments(_child(tree))),
    "group": lambda tree: read_expression(_child(tree)),
    "member": lambda tree: Member(read_expression(_child(tree)), read_name(_child(tree, 1))),
    "index": lambda tree: Index(read_expression(_child(tree)), read_arguments(_child(tree, 1))),
    "unary": _read_unary,
    "binary": _read_binary,
    "apply": _read_apply,
    "verbatim": lambda tree: Verbatim(read_word(_child(tree)), unquoted(_child(tree, 1))),
}
