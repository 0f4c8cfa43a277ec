"""Statements of one line to text and from it; `parser` has those that hold others.

The speed and blend of a move may be computed: `computed (v / 2) mm/s`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from keyword import iskeyword
from typing import Any, Final, NamedTuple

from lark import Tree

from assistant.base.diagnostics import Span
from assistant.program.expressions import Binary, Expression, Index, Member, Name, Verbatim
from assistant.program.geometry import BASE, FLANGE
from assistant.program.motion import (
    USUAL_LINEAR,
    USUAL_ROTARY,
    USUAL_ROTATION,
    Blend,
    ComputedBlend,
    ComputedSpeed,
    Speed,
)
from assistant.program.pseudo.expressions import (
    ATOM,
    Turns,
    arguments_text,
    assignable_text,
    blend_text,
    expression_text,
    read_arguments,
    read_blend,
    read_expression,
    read_speed,
    read_speed_parts,
    speed_parts_text,
    speed_text,
)
from assistant.program.pseudo.words import (
    NOT_ASSIGNABLE,
    Node,
    Wrong,
    comment_text,
    name_text,
    read_integer,
    read_name,
)
from assistant.program.statements import (
    Assign,
    Attach,
    Call,
    Comment,
    Detach,
    Goto,
    Gripper,
    Interrupt,
    Label,
    Measure,
    Message,
    Motion,
    Move,
    MoveCircular,
    MoveJoints,
    Return,
    Send,
    SetAcceleration,
    SetOverride,
    SetSignal,
    StartTimer,
    Statement,
    Stop,
    SwitchInterrupt,
    SwitchInterrupts,
    Travel,
    Trigger,
    Wait,
    WaitSignal,
    WaitUntil,
)

_USUAL: Final[Turns[Expression]] = (USUAL_ROTATION, USUAL_LINEAR, USUAL_ROTARY)


def move_speed_text(speed: Speed | ComputedSpeed | Name) -> str:
    """`150 mm/s`, or `computed (v / 2) mm/s`, and whatever differs from a usual speed."""
    if not isinstance(speed, ComputedSpeed):
        return speed_text(speed)
    turns = speed.rotation, speed.external_linear, speed.external_rotary
    return f"computed {speed_parts_text(speed.tcp, turns, speed.joint, _USUAL, _inner)}"


def read_move_speed(tree: object) -> Speed | ComputedSpeed | Name:
    if not isinstance(tree, Tree) or tree.data != "computed_speed":
        return read_speed(tree)
    tcp, turns, joint = read_speed_parts(tree, _USUAL, read_expression)
    return ComputedSpeed(tcp, *turns, joint)


def move_blend_text(blend: Blend | ComputedBlend | Name) -> str:
    """`10 mm`, or `computed (r) mm`, and what else it states."""
    if not isinstance(blend, ComputedBlend):
        return blend_text(blend)
    parts = [f"computed {_inner(blend.radius)} mm"]
    if blend.stops is not None:
        parts.append(f"stops {_inner(blend.stops)}")
    if blend.details is not None:
        parts.append(f"details [{arguments_text(blend.details)}]")
    return " ".join(parts)


def read_move_blend(tree: object) -> Blend | ComputedBlend | Name:
    if not isinstance(tree, Tree) or tree.data != "computed_blend":
        return read_blend(tree)
    radius, stops, details = tree.children
    return ComputedBlend(
        read_expression(radius),
        None if stops is None else read_expression(stops),
        None if details is None else read_arguments(details),
    )


def _inner(expression: Expression) -> str:
    return f"({expression_text(expression)})"


# -------------------------------------------------------------------------------- parts of lines


def motion_text(motion: Motion) -> str:
    parts = [f"speed {move_speed_text(motion.speed)} blend {move_blend_text(motion.blend)}"]
    parts += [f"tool {name_text(motion.tool)}"] if motion.tool != FLANGE else []
    parts += [f"frame {name_text(motion.frame)}"] if motion.frame != BASE else []
    return " ".join(parts)


def read_motion(tree: object) -> Motion:
    assert isinstance(tree, Tree)
    speed, blend, tool, frame = tree.children
    return Motion(
        read_move_speed(speed),
        read_move_blend(blend),
        FLANGE if tool is None else read_name(tool),
        BASE if frame is None else read_name(frame),
    )


_MEASURES: Final[Mapping[Measure, str]] = {
    "start": "mm from start",
    "end": "mm before end",
    "time": "s before end",
    "share": "%",
}


def trigger_text(trigger: Trigger) -> str:
    pulse, ahead = _SLOTS["pulse"].text(trigger.pulse), _SLOTS["ahead"].text(trigger.ahead)
    place = f"{expression_text(trigger.amount)} {_MEASURES[trigger.measure]}"
    return f"set {name_text(trigger.signal)} = {_value(trigger.value)}{pulse} at {place}{ahead}"


def _read_triggers(tree: Node) -> tuple[Trigger, ...]:
    return tuple(map(_read_trigger, tree.children))


def _read_trigger(tree: Any) -> Trigger:
    signal, value, pulse, amount, measure, ahead = tree.children
    return Trigger(
        read_name(signal),
        read_expression(value),
        read_expression(amount),
        measure.data,
        _SLOTS["pulse"].read(pulse),
        _SLOTS["ahead"].read(ahead),
    )


def _value(value: Expression) -> str:
    """Return the text after a `=`; a comparison for equality is in brackets, for legibility."""
    equality = isinstance(value, Binary) and value.operator == "="
    return expression_text(value, ATOM if equality else 0)


def _optional(before: str = " ", after: str = "") -> _Slot:
    """An expression that may be missing, with the words around it."""
    return _Slot(
        lambda value: "" if value is None else f"{before}{expression_text(value)}{after}",
        lambda tree: None if tree is None else read_expression(tree),
    )


def _wrapped(before: str, after: str) -> _Slot:
    """Return an optional expression with a separate grammar rule."""
    plain = _optional(before, after)
    return _Slot(plain.text, lambda tree: plain.read(tree and tree.children[0]))


def _arguments(arguments: tuple[Expression, ...]) -> str:
    return f"({arguments_text(arguments)})" if arguments else ""


class _Slot(NamedTuple):
    """A slot of a line: its text, and its value from the tree."""

    text: Callable[[Any], str]
    read: Callable[[Any], Any]


_SLOTS: Final[dict[str, _Slot]] = {
    "": _Slot(expression_text, read_expression),
    "side": _Slot(_value, read_expression),
    "name": _Slot(name_text, read_name),
    "word": _Slot(str, str),
    "integer": _Slot(str, read_integer),
    "motion": _Slot(motion_text, read_motion),
    "optional": _optional(),
    "pulse": _optional(" pulse ", " s"),
    "timeout": _wrapped(" timeout ", " s"),
    "ends": _wrapped(" ends where ", ""),
    "until": _wrapped(" until ", ""),
    "tilt": _wrapped(" tilt ", " deg"),
    "search": _wrapped(" search ", " s"),
    "ahead": _wrapped(" ahead ", " s"),
    "triggers": _Slot(
        lambda triggers: "".join(f" {trigger_text(one)}" for one in triggers), _read_triggers
    ),
    "unit": _Slot(
        lambda name: "" if name is None else f" unit {name_text(name)}",
        lambda tree: None if tree is None else read_name(tree),
    ),
    "arguments": _Slot(_arguments, lambda tree: () if tree is None else read_arguments(tree)),
    "procedure": _Slot(lambda call: name_text(call.procedure), lambda tree: Call(read_name(tree))),
    "parts": _Slot(lambda parts: f" {arguments_text(parts)}".rstrip(), read_arguments),
}


class _Form:
    """The line of a plain statement: words, and fields in braces, with their slot behind a colon.

    The rule of the grammar that reads it is named like the record, and has its fields in the order
    of the line.
    """

    def __init__(self, record: type, line: str) -> None:
        parts = re.split(r"\{(\w+)(?::(\w+))?\}", line)
        words, fields = parts[::3], list(zip(parts[1::3], parts[2::3], strict=True))
        self.record, self.first = record, words[0]
        self.places = [
            (field, _SLOTS[slot or ""], word)
            for (field, slot), word in zip(fields, words[1:], strict=True)
        ]
        rule = re.sub(r"(?<!^)(?=[A-Z])", "_", record.__name__).lower()
        self.rule = f"{rule}_" if iskeyword(rule) else rule

    def text(self, statement: Any) -> str:
        found = [self.first]
        for field, slot, word in self.places:
            found += (slot.text(getattr(statement, field)), word)
        return "".join(found)

    def read(self, *children: Any, span: Span) -> Statement:
        places = zip(self.places, children, strict=True)
        fields = {field: slot.read(tree) for (field, slot, _), tree in places}
        made: Statement = self.record(**fields, span=span)
        return made


_FORMS: Final = (
    _Form(Move, "move {kind:word} {target} {motion:motion}{triggers:triggers}{until:until}"),
    _Form(
        MoveCircular,
        "move circular via {via} to {target} {motion:motion}{triggers:triggers}{until:until}",
    ),
    _Form(MoveJoints, "move absolute {target} {motion:motion}{triggers:triggers}{until:until}"),
    _Form(Travel, "travel to {target} {motion:motion}{tilt:tilt}{search:search}"),
    _Form(Wait, "wait {seconds} s"),
    _Form(WaitSignal, "wait for {signal:name} = {value:side}{timeout:timeout}"),
    _Form(WaitUntil, "wait until {condition}{timeout:timeout}"),
    _Form(StartTimer, "restart timer {timer:name}"),
    _Form(SetSignal, "set {signal:name} = {value:side}{pulse:pulse}"),
    _Form(Gripper, "{action:word} hand {hand:integer}"),
    _Form(SetAcceleration, "acceleration {acceleration} % deceleration {deceleration} %"),
    _Form(SetOverride, "override {percent} %"),
    _Form(Call, "call {procedure:name}{arguments:arguments}{unit:unit}"),
    _Form(Return, "return{value:optional}"),
    _Form(Label, "label {name:name}"),
    _Form(Goto, "goto {label:name}"),
    _Form(Message, "message{parts:parts}"),
    _Form(Attach, "attach {channel:name} to {kind:word}{place:parts} for {mode:word}"),
    _Form(Detach, "detach {channel:name}"),
    _Form(Interrupt, "interrupt {name:name} when {condition} calls {call:procedure}{ends:ends}"),
    _Form(SwitchInterrupt, "interrupt {name:name} {state:word}"),
    _Form(SwitchInterrupts, "interrupts {state:word}"),
    _Form(Send, "send {channel:name} {kind:word}{parts:parts}"),
)
"""A plain statement is one row here, a rule in the grammar, and a record."""


def _read_assign(place: Node, value: Node, span: Span) -> Statement:
    target = read_expression(place)
    if not isinstance(target, Name | Member | Index | Verbatim):
        raise Wrong(NOT_ASSIGNABLE, place)
    return Assign(target, read_expression(value), span=span)


_TEXTS: Final[dict[type, Callable[[Any], str]]] = {
    **{form.record: form.text for form in _FORMS},
    Assign: lambda s: f"{assignable_text(s.target)} = {_value(s.value)}",
    Stop: lambda s: "exit" if s.end else "stop",
    Comment: lambda s: comment_text(s.text),
}
_READERS: Final[dict[str, Callable[..., Statement]]] = {
    **{form.rule: form.read for form in _FORMS},
    "assign": _read_assign,
    "stop": lambda span: Stop(span=span),
    "exit": lambda span: Stop(end=True, span=span),
}


def statement_text(statement: Statement) -> str | None:
    """The line of a statement; None for those of `blocks`."""
    text = _TEXTS.get(type(statement))
    return text(statement) if text else None


def read_statement(tree: Node, span: Span) -> Statement | None:
    """The statement of a line; None if it is one of `blocks`. Raises Wrong."""
    reader = _READERS.get(tree.data)
    return reader(*tree.children, span=span) if reader else None
