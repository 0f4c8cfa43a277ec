"""Work that stands at the robot's own base, because nobody has said yet where it stands."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, error, has_errors
from assistant.program.geometry import BASE
from assistant.program.program import Program, walk
from assistant.program.statements import Follow, Move, MoveCircular

if TYPE_CHECKING:
    from assistant.robots import Robot

PLACEMENT_CURE: Final = (
    "give the work its place: `position` of a frame that [motion] names, or of [placement], in the"
    " process file, or --place X,Y,Z for one run; --place 0,0,0 if it is drawn around the base"
)
FRAME_CURE: Final = (
    "give the work its place: `position` of a frame that [motion] names, in the process file"
)
UNPLACED: Final = error(
    "CO340", "nothing places the work, so it stands at the base of {arm}{codes}", "{cure}"
)
REACH_CODES: Final = ("RB", "CK3", "CK42")
"""Of the findings that tell what an arm cannot do somewhere."""
NEAR_AXIS_PART: Final = 0.15
"""Part of an arm's reach from its axis 1 in which nobody puts a work piece."""


def fold_unplaced_work(
    program: Program, arm: Robot, found: Iterable[Diagnostic]
) -> tuple[Diagnostic, ...]:
    """What was found of a program for an arm; of work that was never placed, in one finding.

    A drawing is drawn about its own origin, and without a frame that is the robot's: it is refused.
    Findings on reach, limits, singularities and speeds there have the same cause.
    """
    found = tuple(found)
    told = [one for one in found if one.code.startswith(REACH_CODES)]
    if program.placed is False and _is_in_base(program):
        return (
            _unplaced_finding(arm, told, PLACEMENT_CURE),
            *(other for other in found if other not in told),
        )
    if program.placed is not None:
        return found
    if not has_errors(told) or program.origin is not None or not _is_at_base(program, arm):
        return found
    return (
        _unplaced_finding(arm, told, FRAME_CURE),
        *(other for other in found if other not in told),
    )


def _unplaced_finding(arm: Robot, told: Sequence[Diagnostic], cure: str) -> Diagnostic:
    counts = Counter(one.code for one in told)
    codes = ", ".join(f"{code} ({n} times)" if n > 1 else code for code, n in counts.items())
    there = f", where it cannot do all of it: {codes}" if told else ""
    return UNPLACED(arm=arm.title, codes=there, cure=cure)


def _is_in_base(program: Program) -> bool:
    """True if it moves or has targets, and all of its moves are in the robot's base."""
    moving = [s for s in program.statements() if isinstance(s, Follow | Move | MoveCircular)]
    frames = {frame for statement in moving for frame in _frames_of(statement)}
    return bool(moving or program.targets) and not frames - {BASE}


def _is_at_base(program: Program, arm: Robot) -> bool:
    """Whether all of it is in the robot's base, and the axis that the arm turns about close by."""
    points = [target.pose.position for target in program.targets.values()]
    rows: list[Floats] = [np.reshape(points, (-1, 3))]
    for procedure in program.procedures:
        for statement in walk(procedure.body):
            if set(_frames_of(statement)) - {BASE}:
                return False
            if isinstance(statement, Follow):
                rows.append(statement.path.positions)
    way = np.concatenate(rows)[:, :2]
    if not len(way):
        return False
    off = np.maximum(np.maximum(way.min(axis=0), -way.max(axis=0)), 0.0)
    return bool(np.hypot(*off) < NEAR_AXIS_PART * arm.reach)


def _frames_of(statement: object) -> Iterator[str]:
    if isinstance(statement, Follow):
        yield from statement.path.frames
    elif isinstance(statement, Move | MoveCircular):
        yield statement.motion.frame
