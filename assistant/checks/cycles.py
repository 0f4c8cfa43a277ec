"""Targets that are passed faster than the controller commands places."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.base.diagnostics import Diagnostic, info
from assistant.checks.views import ProgramView, figure
from assistant.robots import Robot

SETPOINT_CYCLES: Final = {"CR800": 0.0035, "CR1": 0.00711, "CR2B": 0.00711, "CR750": 0.00711}
"""Controller → seconds between two places that it commands: the cycle of its real-time external
control (Mitsubishi manuals A3379 and of the CR800)."""
IRC5_CYCLE: Final = 0.004
"""The same of an IRC5: the cycle of its externally guided motion (option 689-1)."""
LEAST_IN_A_ROW: Final = 10
"""So many such moves must follow each other: a few among longer ones are planned ahead."""

TOO_DENSE: Final = info(
    "CK323",
    "targets {way} mm apart are passed every {passed} ms, which is less than the "
    "{cycle} ms in which the controller commands a place{worst}",
    "leave targets out, or state a lower speed",
)


def cycle_of(robot: Robot) -> float:
    """Seconds between two places that the controller of a robot commands."""
    return SETPOINT_CYCLES.get(robot.controller, IRC5_CYCLE)


def cycles(view: ProgramView) -> Iterator[Diagnostic]:
    for run_view in view.run_views:
        moves, seconds = run_view.moves, run_view.seconds
        if not len(moves):
            continue
        begins, ends = moves.through
        with np.errstate(invalid="ignore"):
            dense = begins & ends & (seconds < view.cycle) & (moves.length > 0.0)
        dense &= np.isfinite(moves.tcp)
        chain = np.cumsum(~dense)  # counts up where a row of them ends
        rows = np.flatnonzero(dense & (np.bincount(chain, dense)[chain] >= LEAST_IN_A_ROW))
        for group, worst in run_view.groups(moves.rows[rows], -seconds[rows]):
            at = rows[worst]
            yield run_view.told(
                TOO_DENSE,
                group,
                int(moves.rows[at]),
                way=figure(moves.length[at]),
                passed=figure(1000.0 * seconds[at]),
                cycle=figure(1000.0 * view.cycle),
            )
