"""What is set on the way of a motion, told alike for every language and in the order of the way."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from assistant.program.geometry import Pose
from assistant.virtual.events import Moved, OnWay, Switched

AT_END = 1e-3
"""mm, or seconds, before the end that are none."""


def ordered_triggers(
    move: Moved, before: Pose | None, changes: Iterable[Switched]
) -> list[Switched]:
    """What is set on the way of a motion. before: the flange where it began, None if unknown.

    On a straight way every place but its start is told in mm before its end. What is set where
    the robot comes to stand is told as if the program had set it then.
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
    if at.measure == "share" and at.amount in (0.0, 100.0):
        at = replace(at, measure="start" if at.amount == 0.0 else "end", amount=0.0)
    if length and at.amount != 0.0 and at.measure in ("start", "share"):
        done = at.amount if at.measure == "start" else length * at.amount / 100.0
        at = replace(at, measure="end", amount=length - done)
    if at.measure in ("end", "time") and abs(at.amount) < AT_END:
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
