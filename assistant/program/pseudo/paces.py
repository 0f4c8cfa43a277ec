"""Speeds and blends of moves as text and back, also those that are worked out."""

from __future__ import annotations

from typing import Final

from lark import Tree

from assistant.program.expressions import Expression, Name
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
    arguments_text,
    expression_text,
    read_arguments,
    read_expression,
)
from assistant.program.pseudo.values import (
    Turns,
    blend_text,
    read_blend,
    read_speed,
    read_speed_parts,
    speed_parts_text,
    speed_text,
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
