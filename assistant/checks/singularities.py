"""Linear and circular moves that come near a singularity on their extremes.

There a joint has to turn far for a small move of the tool, so a controller slows down or stops.
Whether a joint gets too fast at the programmed speed is told of by itself (CK311), and a move
straight through the singularity of the wrist by the robot (RB115).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.base.diagnostics import Diagnostic, info, warning
from assistant.checks.views import ProgramView

WRIST_ANGLE: Final = 3.0
"""degrees of axis 5: to turn the tool by 20 deg/s beside it, axis 4 needs 20 / sin 3° = 380 deg/s,
about what the axes of the catalogue can do."""
ELBOW_ANGLE: Final = 3.0
"""degrees from the stretched arm: at full speed of axis 3 the wrist still comes out at about
50 mm/s (links of 350 mm, 300 deg/s)."""
SHOULDER_DISTANCE: Final = 20.0
"""mm from axis 1: past it at 100 mm/s, axis 1 needs 100 / 20 = 5 rad/s = 290 deg/s, about what the
axes of the catalogue can do."""

NEAR_WRIST: Final = info(
    "CK301",
    "a linear or circular move takes axis 5 to {angle:.1f} degrees from the singularity of the "
    "wrist{worst}",
    "tilt the tool or the work piece so that axis 5 stays away from 0, or use a joint move",
)
THROUGH_WRIST: Final = warning(
    "CK304",
    "between its ends, a linear or circular move goes straight through the singularity of the "
    "wrist, where axes 4 and 6 would have to turn by half a turn at once{worst}",
    "move the work piece, tilt the tool a little, or use a joint move",
)
NEAR_ELBOW: Final = info(
    "CK302",
    "a linear or circular move takes the elbow to {angle:.1f} degrees from the stretched "
    "arm{worst}",
    "move the work piece nearer to the robot, or use a joint move",
)
NEAR_SHOULDER: Final = info(
    "CK303",
    "a linear or circular move takes the wrist centre to {distance:.0f} mm from axis 1{worst}",
    "move the work piece away from the axis, tilt the tool, or use a joint move",
)


def singularities(view: ProgramView) -> Iterator[Diagnostic]:
    for run_view in view.run_views:
        extremes, rows = run_view.extremes, run_view.moves.rows
        wrist = np.where(extremes.crossed, np.inf, extremes.wrist)
        within = np.flatnonzero(extremes.crossed & ~extremes.by_ends)
        for group, worst in run_view.groups(rows[within], -extremes.wrist[within]):
            yield run_view.told(THROUGH_WRIST, group, int(rows[within[worst]]))
        for rule, value, least, field in (
            (NEAR_WRIST, wrist, WRIST_ANGLE, "angle"),
            (NEAR_ELBOW, extremes.elbow, ELBOW_ANGLE, "angle"),
            (NEAR_SHOULDER, extremes.shoulder, SHOULDER_DISTANCE, "distance"),
        ):
            near = np.flatnonzero(value < least)
            for group, worst in run_view.groups(rows[near], -value[near]):
                at = near[worst]
                yield run_view.told(rule, group, int(rows[at]), **{field: value[at]})
