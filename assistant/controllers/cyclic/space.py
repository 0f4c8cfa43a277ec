"""What the numbers of a trajectory are, and how fast they may change."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from assistant.base.arrays import Floats, norms, reals
from assistant.base.diagnostics import Refused
from assistant.controllers.cyclic.rules import BAD_LIMITS

Kind = Literal["joints", "poses"]
"""Rows of joints, degrees or mm each (or pulses); or of x, y, z in mm with w, x, y, z."""

POSE_COLUMNS: Final = 7
TO_FULL_SPEED: Final = 0.3
"""Seconds in which an axis may come to its full speed where no acceleration is given: cautious,
makers quote less for light loads."""


def sizes(kind: Kind, changes: Floats) -> Floats:
    """How large changes of rows (n, c) are in what has a limit.

    (n, c) a joint each; of poses (n, 2), mm and degrees.
    """
    if kind == "joints":
        return np.asarray(np.abs(changes))
    turn = 2.0 * np.degrees(norms(changes[:, 3:]))
    return np.column_stack([norms(changes[:, :3]), turn])


@dataclass(frozen=True, slots=True)
class ArmLimits:
    """What the joints of an arm may do while its tool is led along poses.

    joints: (n, 7) poses → (n, a) joints without jumps from row to row, of a robot of the caller's;
    it may raise Refused. speeds: (a,) a second.
    """

    joints: Callable[[Floats], Floats]
    speeds: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Limits:
    """What no cycle may exceed.

    speeds: of joints, each a second; of poses two, mm/s and deg/s. accelerations: likewise a
    second squared, None for a cautious `TO_FULL_SPEED`. lowest, highest: of joints, None for
    none. arm: of poses, what their joints may do; without it only the tool's speed is held.
    """

    speeds: tuple[float, ...]
    accelerations: tuple[float, ...] | None = None
    lowest: tuple[float, ...] | None = None
    highest: tuple[float, ...] | None = None
    arm: ArmLimits | None = None

    def columns(self, kind: Kind, width: int) -> tuple[Floats, Floats]:
        """Speeds and accelerations (k,) for rows of that kind; Refused if they do not fit."""
        count = width if kind == "joints" else 2
        try:
            speeds = reals(self.speeds)
            given = self.accelerations
            rises = speeds / TO_FULL_SPEED if given is None else reals(given)
        except ValueError as error:
            raise Refused(BAD_LIMITS(reason=error), exit_status=2) from None
        for what, values in (("speeds", speeds), ("accelerations", rises)):
            if values.shape != (count,):
                reason = f"{values.size} {what} for {count} {_of(kind)}"
                raise Refused(BAD_LIMITS(reason=reason), exit_status=2)
            if not (np.isfinite(values) & (values > 0.0)).all():
                raise Refused(BAD_LIMITS(reason=f"{what} {values.tolist()}"), exit_status=2)
        return speeds, rises

    def outside(self, kind: Kind, rows: Floats) -> str:
        """What of joints (n, a) lies outside its range, in words; "" for nothing."""
        if kind != "joints":
            return ""
        for bound, sign, word in ((self.lowest, -1.0, "below"), (self.highest, 1.0, "above")):
            if bound is None:
                continue
            if len(bound) != rows.shape[1]:
                reason = f"{len(bound)} ends of range for {rows.shape[1]} joints"
                raise Refused(BAD_LIMITS(reason=reason), exit_status=2)
            beyond = ~(sign * (rows - np.array(bound)) <= 1e-6)  # also where a bound is no number
            if beyond.any():
                row, joint = (int(v) for v in np.argwhere(beyond)[0])
                at = f"{rows[row, joint]:g} is {word} {bound[joint]:g}"
                return f"J{joint + 1} of point {row + 1}: {at}"
        return ""


def braked(room: float, rise: float, cycle: float) -> float:
    """The greatest speed for a cycle from which an axis still comes to rest within its room.

    With n more cycles of braking by `rise` behind it: v (n + 1) T - a T² n (n + 1) / 2 = room.
    """
    if not room > 0.0:
        return 0.0
    step = rise * cycle * cycle
    n = math.floor((math.sqrt(1.0 + 8.0 * room / step) - 1.0) / 2.0)
    return (room + step * n * (n + 1) / 2.0) / ((n + 1) * cycle)


def _of(kind: Kind) -> str:
    return "joints" if kind == "joints" else "limits of poses (mm/s, deg/s)"


def column_names(kind: Kind, width: int) -> tuple[str, ...]:
    """What the columns of rows are called in files and messages."""
    if kind == "joints":
        return tuple(f"J{i}" for i in range(1, width + 1))
    return ("x", "y", "z", "qw", "qx", "qy", "qz")


def checked_rows(rows: Sequence[Sequence[float]] | Floats) -> Floats:
    """Rows as (n, c) finite floats; raises ValueError with what is wrong."""
    values = reals(rows)
    if values.ndim != 2 or not len(values) or not values.shape[1]:
        raise ValueError(f"its shape is {values.shape}, not (points, columns)")
    if not np.isfinite(values).all():
        row = int(np.argwhere(~np.isfinite(values))[0, 0])
        raise ValueError(f"point {row + 1} holds a number that is not finite")
    return values
