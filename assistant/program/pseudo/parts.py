"""Parts of a program in words for people: as the text form says them, each on one line."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, Final, get_args

from assistant.program.diagnostics import Refused
from assistant.program.expressions import Expression
from assistant.program.geometry import Configuration, Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import Blend, Speed
from assistant.program.path import Path
from assistant.program.program import Parameter, Procedure, Signal, Variable
from assistant.program.pseudo.declarations import parameter_text, signal_text, variable_text
from assistant.program.pseudo.expressions import expression_text
from assistant.program.pseudo.paces import move_blend_text, move_speed_text
from assistant.program.pseudo.printer import block_text, procedure_text
from assistant.program.pseudo.statements import motion_text, statement_text, trigger_text
from assistant.program.pseudo.values import (
    blend_text,
    configuration_text,
    frame_text,
    joints_text,
    pose_text,
    speed_text,
    target_text,
    tool_text,
)
from assistant.program.pseudo.words import number_text
from assistant.program.statements import (
    Branch,
    Case,
    ComputedBlend,
    ComputedSpeed,
    Motion,
    Statement,
    Trigger,
)


def part_text(part: object) -> str:
    """Any part of a program; of what holds statements its first line."""
    try:
        return _printed_part(part) or _class_in_words(part)
    except (Refused, ValueError):  # what no text can say is named at least
        return _class_in_words(part)


def _printed_part(part: object) -> str:
    match part:
        case None:
            return "nothing"
        case bool():
            return "true" if part else "false"
        case int() | float():
            return number_text(part)
        case str():
            return f"`{part}`"
        case tuple():
            return ", ".join(map(part_text, part)) or "nothing"
        case Mapping():
            return ", ".join(f"{name} {part_text(value)}" for name, value in part.items())
        case Branch():
            return f"if {expression_text(part.condition)}"
        case Case():
            return "case " + ", ".join(map(expression_text, part.values))
        case _ if isinstance(part, get_args(Expression)):
            return f"`{expression_text(part)}`"
        case _ if isinstance(part, get_args(Statement)):
            return f"`{statement_text(part) or block_text(part)}`"
    printer = _PRINTERS.get(type(part))
    return printer(part) if printer else _class_in_words(part)


def _class_in_words(part: object) -> str:
    """`a wait until` of an object of the class `WaitUntil`."""
    words = re.sub(r"(?<!^)(?=[A-Z])", " ", type(part).__name__).lower()
    return f"an {words}" if words[0] in "aeiou" else f"a {words}"


_PRINTERS: Final[dict[type, Callable[[Any], str]]] = {
    Blend: blend_text,
    ComputedBlend: move_blend_text,
    ComputedSpeed: move_speed_text,
    Configuration: configuration_text,
    Frame: frame_text,
    JointTarget: joints_text,
    Motion: motion_text,
    Parameter: parameter_text,
    Path: lambda path: f"the path `{path.name}`",
    Pose: pose_text,
    Procedure: procedure_text,
    Signal: signal_text,
    Speed: speed_text,
    Target: target_text,
    Tool: tool_text,
    Trigger: trigger_text,
    Variable: variable_text,
}
