"""Triggers on the path of a motion: outputs that are set along it, and conditions that end it.

Every interpreter orders the outputs of a motion by `ordered_triggers`, and ends a motion early by
`move_until`. Path triggers are measured in mm, percent of the path, or seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Final

from assistant.program.geometry import Pose
from assistant.virtual.events import Moved, OnWay, Switched
from assistant.virtual.kernel.task import Task

_AT_END = 1e-3
"""Distance in mm, or seconds, before the end that counts as zero."""


def ordered_triggers(
    move: Moved, before: Pose | None, changes: Iterable[Switched]
) -> list[Switched]:
    """Return the outputs set on the path of a motion, in order. before: the flange at its
    beginning, None if unknown.

    On a straight path every position but its start is given in mm before its end. An output set
    where the robot comes to rest is reported as if the program had set it then.
    """
    length = None
    if move.kind == "linear" and before is not None and move.flange is not None:
        ends = (before @ move.tool).position, (move.flange @ move.tool).position
        length = math.dist(*ends)
    found = [
        replace(x, at=None if x.at is None else _from_end(x.at, move, length)) for x in changes
    ]
    return sorted(found, key=_path_order)


def _from_end(at: OnWay, move: Moved, length: float | None) -> OnWay | None:
    # 0 and 100 % are the ends of the path, whatever its length.
    if at.measure == "share" and at.amount in (0.0, 100.0):
        at = replace(at, measure="start" if at.amount == 0.0 else "end", amount=0.0)
    # A known length turns each position into mm before
    # the end, so that measures of two languages compare.
    if length and at.amount != 0.0 and at.measure in ("start", "share"):
        done = at.amount if at.measure == "start" else length * at.amount / 100.0
        at = replace(at, measure="end", amount=length - done)
    if at.measure in ("end", "time") and abs(at.amount) < _AT_END:
        at = replace(at, measure="end", amount=0.0)
        return None if move.blend == 0.0 and at.ahead == 0.0 else at
    return at


def _path_order(change: Switched) -> tuple[int, float]:
    """Larger further along, where the way tells it; what is set at its end stands last."""
    match change.at:
        case None:
            return 3, 0.0
        case OnWay("start", amount):
            return 0, amount
        case OnWay("end", amount):
            return 2, -amount
    return 1, 0.0


_LOOK_PERIOD: Final = 0.0071
"""Seconds between two looks at what changes with time alone, as controllers of MELFA-BASIC do."""


class _ConditionMet(Exception):
    """The condition that ends a motion early has become true."""


def move_until(
    task: Task, holds: Callable[[], bool], go: Callable[[], None], *, timed: bool = False
) -> bool:
    """Makes a motion that ends where the arm is as soon as something holds; whether it did.

    It is not begun where that holds before it: the one before is made to its end. A motion that
    takes no time is made whole, and what has come to hold with it ends it all the same. timed:
    whether time alone may bring what ends it.
    """
    motion = task.kernel.motion
    if holds():
        motion.settle(task)
        return True
    # Motions that take no time have no path to stop on.
    if motion.where() is None:
        go()
        return holds()

    def look() -> None:
        if holds():
            raise _ConditionMet

    try:
        watched_move(task, look, go, timed=timed)
    except _ConditionMet:
        motion.cut(task)
        return True
    return False


def watched_move(
    task: Task, look: Callable[[], object], go: Callable[[], None], *, timed: bool = False
) -> None:
    """Makes a motion, and looks whether something is so as long as it lasts."""
    kernel, before = task.kernel, (task.looks, task.sampling)

    def both() -> None:
        # Interrupts of the program are checked first.
        if before[0] is not None:
            before[0]()
        # Readings of this check are not those of a program that polls, see `Kernel.looking`.
        kernel.looking = True
        try:
            look()
        finally:
            kernel.looking = False

    task.looks = both
    if timed and task.sampling is None:
        task.sampling = _LOOK_PERIOD
    try:
        go()
    finally:
        task.looks, task.sampling = before
