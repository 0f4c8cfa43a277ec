"""Speeds and blends of moves as text and back, also those that are worked out."""

from __future__ import annotations

from typing import Final

from lark import Token, Tree

from assistant.program.expressions import Expression, Name
from assistant.program.motion import Blend, Speed
from assistant.program.pseudo.expressions import (
    arguments_text,
    expression_text,
    read_arguments,
    read_expression,
)
from assistant.program.pseudo.values import blend_text, read_blend, read_speed, speed_text
from assistant.program.statements import ComputedBlend, ComputedSpeed

_USUAL: Final = ComputedSpeed(None)


def pace_text(speed: Speed | ComputedSpeed | Name) -> str:
    """`150 mm/s`, or `computed (v / 2) mm/s`, and whatever differs from a usual speed."""
    if not isinstance(speed, ComputedSpeed):
        return speed_text(speed)
    parts = ["computed", "maximum" if speed.tcp is None else f"{_inner(speed.tcp)} mm/s"]
    if speed.rotation != _USUAL.rotation:
        parts.append(f"rotation {_inner(speed.rotation)} deg/s")
    external = speed.external_linear, speed.external_rotary
    if external != (_USUAL.external_linear, _USUAL.external_rotary):
        linear, rotary = map(_inner, external)
        parts.append(f"external {linear} mm/s {rotary} deg/s")
    if speed.joint is not None:
        parts.append(f"joint {_inner(speed.joint)} %")
    return " ".join(parts)


def read_pace(tree: object) -> Speed | ComputedSpeed | Name:
    if not isinstance(tree, Tree) or tree.data != "computed_speed":
        return read_speed(tree)
    tcp, rotation, external, joint = tree.children
    linear, rotary = external.children if isinstance(external, Tree) else (None, None)
    return ComputedSpeed(
        None if isinstance(tcp, Token) else read_expression(tcp),
        _USUAL.rotation if rotation is None else read_expression(rotation),
        _USUAL.external_linear if linear is None else read_expression(linear),
        _USUAL.external_rotary if rotary is None else read_expression(rotary),
        None if joint is None else read_expression(joint),
    )


def corner_text(blend: Blend | ComputedBlend | Name) -> str:
    """`10 mm`, or `computed (r) mm`, and what else it states."""
    if not isinstance(blend, ComputedBlend):
        return blend_text(blend)
    parts = [f"computed {_inner(blend.radius)} mm"]
    if blend.stops is not None:
        parts.append(f"stops {_inner(blend.stops)}")
    if blend.details is not None:
        parts.append(f"details [{arguments_text(blend.details)}]")
    return " ".join(parts)


def read_corner(tree: object) -> Blend | ComputedBlend | Name:
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
