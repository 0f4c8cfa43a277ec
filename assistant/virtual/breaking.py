"""Motions that end as soon as something holds, for every language that has them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from assistant.virtual.kernel.task import Task

LOOK_PERIOD: Final = 0.0071
"""Seconds between two looks at what changes with time alone, as controllers of MELFA-BASIC do."""


class _ConditionMet(Exception):
    """What a motion is broken off for has come to hold."""


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
        if before[0] is not None:
            before[0]()
        kernel.looking = True
        try:
            look()
        finally:
            kernel.looking = False

    task.looks = both
    if timed and task.sampling is None:
        task.sampling = LOOK_PERIOD
    try:
        go()
    finally:
        task.looks, task.sampling = before
