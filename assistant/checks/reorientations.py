"""Moves that turn the tool for longer than their TCP speed would let them take."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.base.diagnostics import Diagnostic, info
from assistant.checks.views import ProgramView, figure
from assistant.robots.programming import has

LEAST_LENGTH: Final = 1.0
"""mm below which a move turns on the spot, and no speed of the TCP is expected of it."""
LEAST_SLOWDOWN: Final = 1.1
"""Times that a move must take longer to be told of,"""
LEAST_DELAY: Final = 0.1
"""and seconds: less is lost in accelerating."""

TURN_BINDS: Final = info(
    "CK312",
    "the tool turns by {turn:.0f} degrees on {length:.0f} mm: at {rotation:g} degrees/s of "
    "reorientation the TCP moves at {real} mm/s instead of {tcp:g}{worst}",
    "state a higher speed of reorientation, or spread the turn over a longer way",
)


def reorientations(view: ProgramView) -> Iterator[Diagnostic]:
    """Only of controllers that take such a speed from the program."""
    if not has(view.robot, "turning-speed"):
        return
    for run_view in view.run_views:
        moves = run_view.moves
        with np.errstate(invalid="ignore", divide="ignore"):
            alone = moves.length / moves.tcp
            turning = moves.turn / moves.rotation
        binds = (turning > LEAST_SLOWDOWN * alone) & (turning > alone + LEAST_DELAY)
        binds &= (moves.tcp > 0.0) & (moves.rotation > 0.0)  # others cannot be meant: CK201
        rows = np.flatnonzero(binds & (moves.length >= LEAST_LENGTH) & np.isfinite(moves.tcp))
        for group, worst in run_view.groups(moves.rows[rows], turning[rows] - alone[rows]):
            at = rows[worst]
            yield run_view.told(
                TURN_BINDS,
                group,
                int(moves.rows[at]),
                turn=moves.turn[at],
                length=moves.length[at],
                rotation=moves.rotation[at],
                real=figure(moves.length[at] / turning[at]),
                tcp=moves.tcp[at],
            )
