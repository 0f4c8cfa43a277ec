"""Speeds, blends, motions and paths as RAPID can say them, with a finding for each change."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.diagnostics import Declared, Span
from assistant.languages.legalisation import PartLegaliser
from assistant.languages.rapid.lift.expressions import frame_name, tool_name
from assistant.languages.rapid.tables.capabilities import CORNERS
from assistant.languages.rapid.tables.motions import (
    BLENDS,
    SPEEDS,
    sayable_blend,
    sayable_speed,
    speed_name,
    zone_name,
)
from assistant.languages.rapid.tables.words import LONGEST_NAME
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Blend, Path, Speed
from assistant.program.passes.legalisation import Legalisation
from assistant.program.passes.motions import CornerSizes, NamedValues
from assistant.program.passes.paths import reported_at_lines

PERCENT_CURE: Final = (
    "name both arms, or state `joint_speed` (mm/s) in the process file or the cell file (--cell)"
)
"""Speed in mm/s that corresponds to one percent."""


class MotionAdapter:
    """The motions of a program. speeds, blends: what moves call them, filled as they are met."""

    def __init__(self, job: Legalisation, written: PartLegaliser) -> None:
        self._job, self._written, self._sizing = job, written, CornerSizes(job, CORNERS)
        program = job.program
        overrides = (s.percent for s in program.statements() if isinstance(s, p.SetOverride))
        self._slowed = any(percent != e.Number(100) for percent in overrides)
        self.speeds = NamedValues(SPEEDS, program.speeds, self._speed, LONGEST_NAME)
        self.blends = NamedValues(BLENDS, program.blends, self._blend, LONGEST_NAME)

    def motion(self, motion: p.Motion) -> p.Motion:
        speed, blend = motion.speed, motion.blend
        if not isinstance(blend, p.ComputedBlend):
            known = Speed(0.0) if isinstance(speed, p.ComputedSpeed) else speed
            blend = self.blends.said(self._sizing.blend(blend, known))
        if not isinstance(speed, p.ComputedSpeed):
            speed = self.speeds.said(speed)
        elif speed.tcp is None or speed.joint is not None:
            cure = PERCENT_CURE
            self._job.cannot("a joint speed in percent that is worked out", cure)
        return p.Motion(speed, blend, tool_name(motion.tool), frame_name(motion.frame))

    def path(self, path: Path, line: Callable[[int], Span | None]) -> Path:
        """line: where the move to a row is in the source text."""
        path = self._written.path(self._sizing.path(path))

        def said(index: NDArray[np.int32], table: Sequence[Any], names: NamedValues[Any]) -> Any:
            used = set(np.unique(index).tolist())
            return tuple(
                reported_at_lines(
                    self._job.findings, line, index, lambda i: names.said(table[i]), entry
                )
                if entry in used
                else names.said(table[entry])
                for entry in range(len(table))
            )

        return replace(
            path,
            speeds=said(path.speed, path.speeds, self.speeds),
            blends=said(path.blend, path.blends, self.blends),
            tools=tuple(tool_name(t) for t in path.tools),
            frames=tuple(frame_name(f) for f in path.frames),
        )

    def _speed(self, speed: Speed, name: str | None) -> Speed:
        said, changed = sayable_speed(speed)
        about = None if name is None else Declared(name, "speeds")
        if self._only_percent(speed):
            cure = PERCENT_CURE
            self._job.cannot(f"a joint speed of {speed.joint:g} % alone", cure, about)
        elif changed:
            self._job.changed(changed, speed_name(said), "state a speed in mm/s", about)
        if not all(v > 0 for v in (said.tcp, said.rotation)) or said.tcp != said.tcp:
            self._job.cannot(f"a speed of {said.tcp} mm/s", "state a speed above 0", about)
        return said

    def _only_percent(self, speed: Speed) -> bool:
        """Whether it is less than all that the axes can, which is no speed of RAPID.

        Also by an override: that of RAPID lessens the speed of the tool alone.
        """
        if speed.joint is None or math.isfinite(speed.tcp):
            return False
        return speed.joint < 100.0 or self._slowed

    def _blend(self, blend: Blend, name: str | None) -> Blend:
        said, changed = sayable_blend(blend)
        about = None if name is None else Declared(name, "blends")
        if changed:
            self._job.changed(changed, zone_name(said), "state one radius in mm", about)
        if said.radius is not None and not said.radius >= 0:
            what = f"a corner radius of {said.radius} mm"
            self._job.cannot(what, "state 0 or more", about)
        return said
