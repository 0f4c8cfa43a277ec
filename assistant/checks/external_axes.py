"""Targets that leave out the value of an external axis that those around them state."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.checks.tour import Tour
from assistant.program.diagnostics import Diagnostic, Rule, Severity

MISSING: Final = Rule(
    "CK341",
    Severity.WARNING,
    "the value of external axis {axis} is missing, which {others} targets around state",
    "state it there as well: a controller that drives the axis stops without it (40512)",
)


def external_axes(tour: Tour) -> Iterator[Diagnostic]:
    for stage in tour.stages:
        stated = np.isfinite(stage.moves.run.external)
        count = stated.sum(axis=0)
        for axis in np.flatnonzero((count > 0) & (count < len(stated))):
            rows = np.flatnonzero(~stated[:, axis])
            for group, _ in stage.groups(rows, np.zeros(len(rows))):
                yield MISSING(
                    about=stage.moves.run.what(group),
                    span=stage.span(int(group[0])),
                    axis=axis + 1,
                    others=count[axis],
                )
