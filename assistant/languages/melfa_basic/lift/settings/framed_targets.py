"""Targets that are multiplied by their frames: `Mvs PTABLE*P1` is a move to P1 in a frame."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from assistant.languages.melfa_basic.lift.settings.held import FRAME
from assistant.languages.melfa_basic.tables.words import ARC_START
from assistant.languages.melfa_basic.text.header import Header
from assistant.languages.melfa_basic.tree import syntax as s


def without_frame_product(
    node: s.Motion, values: tuple[Any, ...], header: Header
) -> tuple[s.Motion, tuple[Any, ...]]:
    """The move with plain targets, and its settings with their frame, where a heading says so."""
    if not header.products:
        return node, values
    frames = set()
    plain: list[s.Expression | None] = []
    targets = 3 if node.keyword == "Mvr" else 1
    for at, argument in enumerate(node.arguments):
        key, target = _frame_and_target(argument, header)
        if at < targets and not _is_arc_start(argument):
            frames.add(key)
        plain.append(target if at < targets else argument)
    if len(frames) != 1 or (frame := frames.pop()) is None:
        return node, values
    name = header.names["frame"][frame]
    made = (*values[:FRAME], name, *values[FRAME + 1 :])
    return replace(node, arguments=tuple(plain)), made


def _frame_and_target(
    argument: s.Expression | None, header: Header
) -> tuple[str | None, s.Expression | None]:
    match argument:
        case s.Binary("*", s.Variable(arguments=None, component="") as frame, target) if (
            frame.key in header.names["frame"]
        ):
            return frame.key, target
    return None, argument


def _is_arc_start(argument: s.Expression | None) -> bool:
    """Whether it is the place that an arc starts at, as read from the robot."""
    return isinstance(argument, s.Variable) and argument.key == ARC_START
