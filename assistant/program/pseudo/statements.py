"""Statements of one line as text and back; `blocks` has those that hold others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, cast

from lark import Token, Tree

from assistant.program.diagnostics import Span
from assistant.program.expressions import Binary, Expression, Index, Member, Name, Verbatim
from assistant.program.geometry import BASE, FLANGE
from assistant.program.pseudo.expressions import (
    ATOM,
    arguments_text,
    assignable_text,
    expression_text,
    read_arguments,
    read_expression,
)
from assistant.program.pseudo.findings import NOT_ASSIGNABLE, Wrong
from assistant.program.pseudo.values import blend_text, read_blend, read_speed, speed_text
from assistant.program.pseudo.words import (
    Node,
    comment_text,
    name_text,
    read_integer,
    read_name,
)
from assistant.program.statements import (
    Assign,
    Call,
    Comment,
    Goto,
    Gripper,
    Label,
    Message,
    Motion,
    Move,
    MoveCircular,
    MoveJoints,
    Return,
    SetAcceleration,
    SetOverride,
    SetSignal,
    StartTimer,
    Statement,
    Stop,
    Wait,
    WaitSignal,
    WaitUntil,
)

# ------------------------------------------------------------------------------------- to text


def statement_text(statement: Statement) -> str | None:
    """The line of a statement; None for those of `blocks`."""
    printer = _PRINTERS.get(type(statement))
    return printer(statement) if printer else None


def motion_text(motion: Motion) -> str:
    parts = [f"speed {speed_text(motion.speed)} blend {blend_text(motion.blend)}"]
    parts += [f"tool {name_text(motion.tool)}"] if motion.tool != FLANGE else []
    parts += [f"frame {name_text(motion.frame)}"] if motion.frame != BASE else []
    return " ".join(parts)


def _value(value: Expression) -> str:
    """What stands behind a `=`; a comparison for equality in brackets, for the eye."""
    equality = isinstance(value, Binary) and value.operator == "="
    return expression_text(value, ATOM if equality else 0)


def _timeout(timeout: Expression | None) -> str:
    return "" if timeout is None else f" timeout {expression_text(timeout)} s"


def _set_signal(s: SetSignal) -> str:
    pulse = "" if s.pulse is None else f" pulse {expression_text(s.pulse)} s"
    return f"set {name_text(s.signal)} = {_value(s.value)}{pulse}"


def _call(s: Call) -> str:
    arguments = f"({arguments_text(s.arguments)})" if s.arguments else ""
    unit = "" if s.unit is None else f" unit {name_text(s.unit)}"
    return f"call {name_text(s.procedure)}{arguments}{unit}"


def _circular(s: MoveCircular) -> str:
    points = f"via {expression_text(s.via)} to {expression_text(s.target)}"
    return f"move circular {points} {motion_text(s.motion)}"


def _wait_signal(s: WaitSignal) -> str:
    awaited = f"{name_text(s.signal)} = {_value(s.value)}"
    return f"wait for {awaited}{_timeout(s.timeout)}"


def _acceleration(s: SetAcceleration) -> str:
    rates = expression_text(s.acceleration), expression_text(s.deceleration)
    return f"acceleration {rates[0]} % deceleration {rates[1]} %"


_PRINTERS: Final[dict[type, Callable[[Any], str]]] = {
    Move: lambda s: f"move {s.kind} {expression_text(s.target)} {motion_text(s.motion)}",
    MoveCircular: _circular,
    MoveJoints: lambda s: f"move absolute {expression_text(s.target)} {motion_text(s.motion)}",
    Wait: lambda s: f"wait {expression_text(s.seconds)} s",
    WaitSignal: _wait_signal,
    WaitUntil: lambda s: f"wait until {expression_text(s.condition)}{_timeout(s.timeout)}",
    SetSignal: _set_signal,
    Gripper: lambda s: f"{s.action} hand {s.hand}",
    SetAcceleration: _acceleration,
    SetOverride: lambda s: f"override {expression_text(s.percent)} %",
    Call: _call,
    StartTimer: lambda s: f"restart timer {name_text(s.timer)}",
    Assign: lambda s: f"{assignable_text(s.target)} = {_value(s.value)}",
    Stop: lambda s: "exit" if s.end else "stop",
    Return: lambda s: "return" if s.value is None else f"return {expression_text(s.value)}",
    Comment: lambda s: comment_text(s.text),
    Label: lambda s: f"label {name_text(s.name)}",
    Goto: lambda s: f"goto {name_text(s.label)}",
    Message: lambda s: f"message {arguments_text(s.parts)}".rstrip(),
}


# ----------------------------------------------------------------------------------- from text


def read_statement(tree: Node, span: Span) -> Statement | None:
    """The statement of a line; None if it is one of `blocks`. Raises Wrong."""
    reader = _READERS.get(tree.data)
    return reader(*tree.children, span=span) if reader else None


def read_motion(tree: object) -> Motion:
    assert isinstance(tree, Tree)
    speed, blend, tool, frame = tree.children
    return Motion(
        read_speed(speed),
        read_blend(blend),
        FLANGE if tool is None else read_name(tool),
        BASE if frame is None else read_name(frame),
    )


def _or_none(tree: object) -> Expression | None:
    return None if tree is None else read_expression(tree)


def _read_timeout(tree: object) -> Expression | None:
    return None if tree is None else read_expression(cast(Node, tree).children[0])


def _read_assign(place: Node, value: Node, span: Span) -> Statement:
    target = read_expression(place)
    if not isinstance(target, Name | Member | Index | Verbatim):
        raise Wrong(NOT_ASSIGNABLE, place)
    return Assign(target, read_expression(value), span=span)


def _read_move(kind: Token, target: Node, motion: Node, span: Span) -> Statement:
    return Move(
        "joint" if kind == "joint" else "linear",
        read_expression(target),
        read_motion(motion),
        span=span,
    )


def _read_call(name: Node, arguments: Node | None, unit: Node | None, span: Span) -> Statement:
    return Call(
        read_name(name),
        () if arguments is None else read_arguments(arguments),
        None if unit is None else read_name(unit),
        span=span,
    )


_READERS: Final[dict[str, Callable[..., Statement]]] = {
    "move": _read_move,
    "move_circular": lambda via, target, motion, span: MoveCircular(
        read_expression(via), read_expression(target), read_motion(motion), span=span
    ),
    "move_joints": lambda target, motion, span: MoveJoints(
        read_expression(target), read_motion(motion), span=span
    ),
    "wait": lambda seconds, span: Wait(read_expression(seconds), span=span),
    "wait_signal": lambda signal, value, timeout, span: WaitSignal(
        read_name(signal), read_expression(value), _read_timeout(timeout), span=span
    ),
    "wait_until": lambda condition, timeout, span: WaitUntil(
        read_expression(condition), _read_timeout(timeout), span=span
    ),
    "start_timer": lambda timer, span: StartTimer(read_name(timer), span=span),
    "set_signal": lambda signal, value, pulse, span: SetSignal(
        read_name(signal), read_expression(value), _or_none(pulse), span=span
    ),
    "gripper": lambda action, hand, span: Gripper(
        "open" if action == "open" else "close", read_integer(hand), span=span
    ),
    "set_acceleration": lambda up, down, span: SetAcceleration(
        read_expression(up), read_expression(down), span=span
    ),
    "set_override": lambda percent, span: SetOverride(read_expression(percent), span=span),
    "call": _read_call,
    "assign": _read_assign,
    "stop": lambda span: Stop(span=span),
    "exit": lambda span: Stop(end=True, span=span),
    "return_": lambda value, span: Return(_or_none(value), span=span),
    "label": lambda name, span: Label(read_name(name), span=span),
    "goto": lambda name, span: Goto(read_name(name), span=span),
    "message": lambda parts, span: Message(read_arguments(parts), span=span),
}
