"""Speeds and corner radii that nobody means: a unit was mistaken, or a digit lost."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

from assistant.program.diagnostics import Diagnostic, error
from assistant.program.expressions import Name
from assistant.program.motion import Blend, Speed
from assistant.program.path import Path
from assistant.program.program import Program
from assistant.program.rewriting import rewrite
from assistant.program.subjects import Declared

SLOWEST: Final = 0.01
FASTEST: Final = 20_000.0
"""mm/s. Below the one a controller's own printing leaves nothing; above the other no arm is."""
SMALLEST: Final = 0.01
LARGEST: Final = 5_000.0
"""mm of corner radius that a program can print, and that fits into a cell."""

SPEED = error(
    "CK201", "a speed of {value:g} mm/s cannot be meant", "state speeds in mm/s, from 0.01 to 20000"
)
BLEND = error(
    "CK202",
    "a corner radius of {value:g} mm cannot be meant",
    "state it in mm, from 0.01 to 5000, or stop at the target with `fine`",
)


def magnitudes(program: Program) -> Iterator[Diagnostic]:
    """Every speed and blend that the program states, named ones and those of paths as well."""
    stated: dict[tuple[Speed | Blend, Declared | None], None] = {}
    moved: set[str] = set()

    def note(part: Any) -> Any:
        if isinstance(part, Speed | Blend):
            stated[part, None] = None
        elif isinstance(part, Path):
            values = (*part.speeds, *part.blends)
            stated.update(((v, None), None) for v in values if isinstance(v, Speed | Blend))
            moved.update(v.name.lower() for v in values if isinstance(v, Name))
        elif isinstance(part, Name):
            moved.add(part.name.lower())
        return part

    rewrite(replace(program, speeds={}, blends={}), note)
    for name, speed in program.speeds.items():
        if name.lower() in moved or not _is_of_other_axes(speed):
            stated[speed, Declared(name, "speeds")] = None
    for name, blend in program.blends.items():
        stated[blend, Declared(name, "blends")] = None
    for value, about in stated:
        if isinstance(value, Speed):
            if math.isfinite(value.tcp) and not SLOWEST <= value.tcp <= FASTEST:
                yield SPEED(value=value.tcp, about=about)
        else:
            radii = [r for r in (value.radius, value.exit) if r is not None and math.isfinite(r)]
            wrong = [r for r in radii if not SMALLEST <= r <= LARGEST]
            yield from (BLEND(value=r, about=about) for r in wrong)


def _is_of_other_axes(speed: Speed) -> bool:
    """True for a speed at which only external axes or the tool's rotation move."""
    return speed.tcp == 0 and any((speed.rotation, speed.external_linear, speed.external_rotary))
