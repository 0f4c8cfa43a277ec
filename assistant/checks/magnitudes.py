"""Speeds and corner radii that nobody means: a unit was mistaken, or a digit lost."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.base.diagnostics import Declared, Diagnostic, error
from assistant.program.expressions import Name
from assistant.program.motion import Blend, Speed
from assistant.program.program import Program
from assistant.program.rewriting import head, records
from assistant.program.statements import Follow

SLOWEST_SPEED: Final = 0.01
FASTEST_SPEED: Final = 20_000.0
"""mm/s. Below the one a controller's own printing leaves nothing; above the other no arm is."""
SMALLEST_RADIUS: Final = 0.01
LARGEST_RADIUS: Final = 5_000.0
"""mm of corner radius that a program can print, and that fits into a cell."""

IMPLAUSIBLE_SPEED = error(
    "CK201", "a speed of {value:g} mm/s cannot be meant", "state speeds in mm/s, from 0.01 to 20000"
)
IMPLAUSIBLE_BLEND = error(
    "CK202",
    "a corner radius of {value:g} mm cannot be meant",
    "state it in mm, from 0.01 to 5000, or stop at the target with `fine`",
)


def magnitudes(program: Program) -> Iterator[Diagnostic]:
    """Every speed and blend that the program states, named ones and those of paths as well.

    Those of a path without lines are reported once each.
    """
    moved: set[str] = set()
    for statement in program.statements():
        if isinstance(statement, Follow):
            yield from _magnitudes_of_path(statement)
            tables = (*statement.path.speeds, *statement.path.blends)
            moved.update(v.name.lower() for v in tables if isinstance(v, Name))
            continue
        stated: dict[Speed | Blend, None] = {}
        for part in records(head(statement)):
            if isinstance(part, Speed | Blend):
                stated[part] = None
            elif isinstance(part, Name):
                moved.add(part.name.lower())
        for value in stated:
            yield from _implausible(value, span=statement.span)
    for name, speed in program.speeds.items():
        if name.lower() in moved or not _is_of_other_axes(speed):
            yield from _implausible(speed, about=Declared(name, "speeds"))
    for name, blend in program.blends.items():
        yield from _implausible(blend, about=Declared(name, "blends"))


def _magnitudes_of_path(statement: Follow) -> Iterator[Diagnostic]:
    """Findings on speeds and blends of a path, at each of its rows that has a line."""
    path = statement.path
    for table, column in ((path.speeds, path.speed), (path.blends, path.blend)):
        for number, value in enumerate(table):
            found = (
                () if isinstance(value, Name) else tuple(_implausible(value, span=statement.span))
            )
            if not found or path.places is None:
                yield from found
                continue
            rows = np.flatnonzero(column == number).tolist()
            for span in dict.fromkeys(map(statement.row_span, rows)):
                yield from (replace(one, span=span) for one in found)


def _implausible(value: Speed | Blend, **place: Any) -> Iterator[Diagnostic]:
    if isinstance(value, Speed):
        if math.isfinite(value.tcp) and not SLOWEST_SPEED <= value.tcp <= FASTEST_SPEED:
            yield IMPLAUSIBLE_SPEED(value=value.tcp, **place)
        return
    radii = [r for r in (value.radius, value.exit) if r is not None and math.isfinite(r)]
    yield from (
        IMPLAUSIBLE_BLEND(value=r, **place)
        for r in radii
        if not SMALLEST_RADIUS <= r <= LARGEST_RADIUS
    )


def _is_of_other_axes(speed: Speed) -> bool:
    """True for a speed at which only external axes or the tool's rotation move."""
    return speed.tcp == 0 and any((speed.rotation, speed.external_linear, speed.external_rotary))
