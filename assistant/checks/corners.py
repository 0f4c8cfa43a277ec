"""Corners that are rounded more than the way to the next target lets them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Rows, norms
from assistant.base.diagnostics import Diagnostic, info
from assistant.checks.moves import Moves
from assistant.checks.views import ProgramView, figure
from assistant.program.motion import Kind

TURN_ON_SPOT: Final = 0.1
"""mm of way below which a move is a turn on the spot, which no corner is measured by."""
LEAST_CUT: Final = 0.1
"""mm by which the path must come nearer to a target than its corner says. A corner of r mm where
the path turns by a passes the target at r / 2 · sin(a / 2), as a parabola does. One that is larger
than the way counts as long as that: on a dense path it just says not to stop."""

CORNER_TOO_LARGE: Final = info(
    "CK321",
    "the corner of {radius:g} mm is more than half of the {way} mm to the next or the last "
    "target, so a controller rounds it by {half} mm at most{worst}",
    "state a smaller corner, or put the targets further apart",
)
TARGETS_WITHIN_CORNER: Final = info(
    "CK322",
    "targets lie {way} mm apart, nearer than their corner of {radius:g} mm, which a controller "
    "rounds by {half} mm at most{worst}",
    "state a smaller corner, or leave targets out",
)


def corners(view: ProgramView) -> Iterator[Diagnostic]:
    for run_view in view.run_views:
        found = _rounded_rows(run_view.moves)
        with np.errstate(invalid="ignore"):
            meant = np.minimum(found.radius, found.way)
            lost = (meant - found.way / 2.0) * np.sin(found.angle / 2.0) / 2.0
            closer = found.radius > found.way
        for rule, chosen in ((CORNER_TOO_LARGE, ~closer), (TARGETS_WITHIN_CORNER, closer)):
            at = np.flatnonzero(chosen & (lost > LEAST_CUT))
            for group, worst in run_view.groups(found.rows[at], lost[at]):
                here = at[worst]
                way = float(found.way[here])
                yield run_view.told(
                    rule,
                    group,
                    int(found.rows[here]),
                    radius=found.radius[here],
                    way=figure(way),
                    half=figure(way / 2.0),
                )


@dataclass(frozen=True, slots=True)
class _RoundedRows:
    """k rows of a run that are passed in a corner.

    radius: (k,) mm. way: (k,) mm, the shorter of the ways to and from the row; NaN where one of
    them is not known. angle: (k,) radians by which the path turns there.
    """

    rows: Rows
    radius: Floats
    way: Floats
    angle: Floats


def _rounded_rows(moves: Moves) -> _RoundedRows:
    run = moves.run
    radius = moves.radii[run.pace.blend]
    # Of a move the row that it ends at; the via point of an arc is none.
    rows = np.flatnonzero((run.kinds != Kind.VIA) & np.isfinite(radius) & (radius > 0.0))
    rows = rows[rows + 1 < len(run)]
    if not len(rows):
        nothing = np.empty(0)
        return _RoundedRows(rows, nothing, nothing, nothing)
    after = np.where(run.kinds[rows + 1] == Kind.VIA, rows + 2, rows + 1)
    rows, after = rows[after < len(run)], after[after < len(run)]
    before = np.where(run.kinds[rows] == Kind.END, rows - 2, rows - 1)
    here, there, back = (moves.positions[at + 1] for at in (rows, after, np.maximum(before, -1)))
    arriving, leaving = here - back, there - here
    came, goes = norms(arriving), norms(leaving)
    arcs = np.flatnonzero(moves.arcs)
    for ends, ways, directions, at_end in (
        (rows, came, arriving, True),
        (after, goes, leaving, False),
    ):
        own = arcs[np.isin(moves.rows[arcs], ends)]
        if len(own):
            place = np.searchsorted(ends, moves.rows[own])
            ways[place] = moves.length[own]
            directions[place] = moves.tangents(own, at_end=at_end)
    same = run.mounting.unchanged()
    apart = (
        ~same[after] | ~(same[rows] | (rows == 0)) | (came < TURN_ON_SPOT) | (goes < TURN_ON_SPOT)
    )
    came[apart] = np.nan
    cross = norms(np.cross(arriving, leaving))
    angle = np.arctan2(cross, np.einsum("ij,ij->i", arriving, leaving))
    return _RoundedRows(rows, radius[rows], np.minimum(came, goes), angle)
