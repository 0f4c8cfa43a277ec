"""Link lengths of a vertical jointed arm."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Lengths:
    """Link lengths in mm, all axes at the zero of the common chain (arm straight up).

    d1: floor to axis 2. a1: axis 1 to axis 2, forward. a2: axis 2 to axis 3.
    a3: axis 3 to the axis of the forearm, forward (negative: backward).
    d4: axis 3 to the wrist centre along the forearm. d6: wrist centre to the flange.
    """

    d1: float
    a1: float
    a2: float
    a3: float
    d4: float
    d6: float
