"""Free turns of tools, chosen for the arm that runs a program and the cell that it stands in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assistant.base.diagnostics import Diagnostic
from assistant.program.program import Program

if TYPE_CHECKING:
    from assistant.cell.scene import Scene
    from assistant.robots import Robot
    from assistant.robots.free_turns import ClearTest


def has_free_turns(program: Program) -> bool:
    """Whether the turn of any of its tools is free."""
    return any(tool.free_turn for tool in program.tools.values())


def with_chosen_turns(
    program: Program, arm: Robot | None, scene: Scene | None = None
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """A program whose tools have the turns that suit an arm best, where they are free.

    scene: of the cell, None without one: then nothing is there to be touched.
    """
    from assistant.robots.findings import NO_ARM
    from assistant.robots.free_turns import with_chosen_turns, without_free_turns

    if not has_free_turns(program):
        return program, ()
    if arm is None:
        return without_free_turns(program), (NO_ARM(),)
    return with_chosen_turns(program, arm, () if scene is None else _clear_of_scene(scene, arm))


def _clear_of_scene(scene: Scene, arm: Robot) -> tuple[ClearTest, ...]:
    """What keeps the margins of a scene, and what touches nothing in it, while all else stands."""
    from assistant.cell.clearances import robot_of
    from assistant.cell.planning.space import Space

    try:
        placed = robot_of(scene, arm)
    except LookupError:  # which the check of the cell tells
        return ()
    return Space(scene, placed).clear, Space(scene, placed, margin=0.0).clear
