"""Targets that leave out the value of an external axis that those around them state."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.base.diagnostics import Diagnostic, warning
from assistant.checks.views import ProgramView

MISSING_AXIS_VALUE: Final = warning(
    "CK341",
    "the value of external axis {axis} is missing, which {others} targets around state",
    "state it there as well: a controller that drives the axis stops without it (40512)",
)


def external_axes(view: ProgramView) -> Iterator[Diagnostic]:
    for run_view in view.run_views:
        stated = np.isfinite(run_view.moves.run.external)
        count = stated.sum(axis=0)
        for axis in np.flatnonzero((count > 0) & (count < len(stated))):
            rows = np.flatnonzero(~stated[:, axis])
            for group, _ in run_view.groups(rows, np.zeros(len(rows))):
                yield MISSING_AXIS_VALUE(
                    about=run_view.moves.run.what(group),
                    span=run_view.span(int(group[0])),
                    axis=axis + 1,
                    others=count[axis],
                )
