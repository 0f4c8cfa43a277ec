"""Speeds and corner radii that nobody means: a unit was mistaken, or a digit lost."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final

from assistant.program.diagnostics import Diagnostic, error
from assistant.program.motion import Blend, Speed
from assistant.program.path import Path
from assistant.program.program import Program
from assistant.program.rewriting import rewrite

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
    stated: dict[Speed | Blend, None] = {}

    def note(part: Any) -> Any:
        if isinstance(part, Speed | Blend):
            stated[part] = None
        elif isinstance(part, Path):
            values = (*part.speeds, *part.blends)
            stated.update((v, None) for v in values if isinstance(v, Speed | Blend))
        return part

    rewrite(program, note)
    for value in stated:
        if isinstance(value, Speed):
            if math.isfinite(value.tcp) and not SLOWEST <= value.tcp <= FASTEST:
                yield SPEED(value=value.tcp)
        else:
            radii = [r for r in (value.radius, value.exit) if r is not None and math.isfinite(r)]
            yield from (BLEND(value=r) for r in radii if not SMALLEST <= r <= LARGEST)
