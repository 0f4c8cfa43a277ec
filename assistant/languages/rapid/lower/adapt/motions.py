"""Speeds, blends, motions and paths as RAPID can say them, with a finding for each change."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Generic

import numpy as np

from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.expressions import frame_name, tool_name
from assistant.languages.rapid.lower.adapt.findings import Findings
from assistant.languages.rapid.tables.motions import (
    BLENDS,
    SPEEDS,
    T,
    Words,
    corner_of,
    sayable_blend,
    sayable_speed,
    speed_name,
    zone_name,
)
from assistant.languages.rapid.tables.words import LONGEST_NAME, UNUSED
from assistant.languages.rapid.tree.runs import JOINT_PLACES
from assistant.program import expressions as e
from assistant.program import rotations
from assistant.program import statements as p
from assistant.program.motion import Blend, Speed
from assistant.program.path import UNSTATED, Kind, Path
from assistant.program.program import Program, identifier
from assistant.program.subjects import Declared


class Motions:
    """The motions of a program. speeds, blends: what moves call them, filled as they are met."""

    def __init__(self, program: Program, findings: Findings) -> None:
        self._findings, self._given = findings, program
        overrides = (s.percent for s in program.statements() if isinstance(s, p.SetOverride))
        self._slowed = any(percent != e.Number(100) for percent in overrides)
        self.speeds = Named(SPEEDS, program.speeds, self._speed)
        self.blends = Named(BLENDS, program.blends, self._blend)

    def motion(self, motion: p.Motion) -> p.Motion:
        blend = self._sized(motion.blend, motion.speed)
        speed, blend = self.speeds.said(motion.speed), self.blends.said(blend)
        return p.Motion(speed, blend, tool_name(motion.tool), frame_name(motion.frame))

    def path(self, path: Path) -> Path:
        path = self._with_sizes(path)
        via = path.kinds == Kind.VIA
        if (via[:-1] != (path.kinds[1:] == Kind.END)).any() or (
            len(path) and (via[-1] or path.kinds[0] == Kind.END)
        ):
            self._findings.cannot(
                f"an arc of path `{path.name}` without its end", "give both points"
            )
        bad = ~np.isfinite(path.positions).all(axis=1) | ~np.isfinite(path.quaternions).all(axis=1)
        bad |= ~(np.linalg.norm(path.quaternions, axis=1) > 0.5)
        if bad.any():
            row = int(np.flatnonzero(bad)[0]) + 1
            self._findings.append(
                rules.NOT_FINITE(
                    what=f"target {row} of path `{path.name}`", about=Declared(path.name, "paths")
                )
            )
            return path
        configurations = path.configurations
        unstated = configurations[:, 0] == UNSTATED
        if unstated.any():
            self._findings.append(
                rules.NO_CONFIGURATION(place=f"{int(unstated.sum())} targets of `{path.name}`")
            )
            configurations = np.where(unstated[:, None], np.int8(0), configurations)
        rows = np.arange(len(path)) + via  # an arc has the motion of its end
        rows = np.minimum(rows, len(path) - 1)
        external = np.array(path.external)
        np.round(external, JOINT_PLACES, out=external)
        external[external >= UNUSED] = np.nan
        return replace(
            path,
            quaternions=rotations.canonical(path.quaternions),
            configurations=configurations,
            external=external,
            speed=path.speed[rows],
            blend=path.blend[rows],
            tool=path.tool[rows],
            frame=path.frame[rows],
            speeds=tuple(self.speeds.said(v) for v in path.speeds),
            blends=tuple(self.blends.said(v) for v in path.blends),
            tools=tuple(tool_name(t) for t in path.tools),
            frames=tuple(frame_name(f) for f in path.frames),
        )

    def _sized(self, blend: Blend | e.Name, speed: Speed | e.Name) -> Blend | e.Name:
        """A corner that the controller is to choose, in the size that it has at a speed."""
        meant = _meant(blend, self._given.blends)
        if not isinstance(meant, Blend) or meant.radius is None or math.isfinite(meant.radius):
            return blend
        fast = _meant(speed, self._given.speeds)
        if not isinstance(fast, Speed) or not math.isinf(meant.radius):
            return blend
        radius = min(corner_of(fast), math.inf if meant.exit is None else meant.exit)
        said = Blend(radius)
        cure = "state one radius in mm"
        self._findings.changed("a corner without size", zone_name(said), cure)
        return said

    def _with_sizes(self, path: Path) -> Path:
        """A path whose corners without a size have that of their row's speed."""
        open_ = [
            isinstance(b, Blend) and b.radius is not None and math.isinf(b.radius)
            for b in (_meant(b, self._given.blends) for b in path.blends)
        ]
        rows = np.flatnonzero(np.array(open_, dtype=bool)[path.blend]) if any(open_) else ()
        if not len(rows):
            return path
        pairs, at = np.unique(
            np.stack([path.blend[rows], path.speed[rows]], axis=1), axis=0, return_inverse=True
        )
        more = tuple(self._sized(path.blends[b], path.speeds[s]) for b, s in pairs)
        blend = path.blend.copy()
        blend[rows] = len(path.blends) + at.reshape(-1)
        kept = (more[0] if o else b for o, b in zip(open_, path.blends, strict=True))
        return replace(path, blend=blend, blends=(*kept, *more))

    def _speed(self, speed: Speed, name: str | None) -> Speed:
        said, changed = sayable_speed(speed)
        about = None if name is None else Declared(name, "speeds")
        if self._only_percent(speed):
            cure = "name both arms, or state `joint_speed` (mm/s) in the process file"
            self._findings.cannot(f"a joint speed of {speed.joint:g} % alone", cure, about)
        elif changed:
            self._findings.changed(changed, speed_name(said), "state a speed in mm/s", about)
        if not all(v > 0 for v in (said.tcp, said.rotation)) or said.tcp != said.tcp:
            self._findings.cannot(f"a speed of {said.tcp} mm/s", "state a speed above 0", about)
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
            self._findings.changed(changed, zone_name(said), "state one radius in mm", about)
        if said.radius is not None and not said.radius >= 0:
            what = f"a corner radius of {said.radius} mm"
            self._findings.cannot(what, "state 0 or more", about)
        return said


class Named(Generic[T]):
    """The speeds of a program by name, or its blends.

    sayable: what RAPID can say of a value; given its name, None for one that has none.
    """

    def __init__(
        self,
        words: Words[T],
        given: Mapping[str, T],
        sayable: Callable[[T, str | None], T],
    ) -> None:
        self._words, self._sayable = words, sayable
        self._values = {n: sayable(v, n) for n, v in given.items()}

    def table(self) -> dict[str, T]:
        """Those with names of their own: one that is called as its own value would be is that."""
        return self._words.named(self._values)

    def said(self, value: T | e.Name) -> T | e.Name:
        """A value, or a name where it has one of its own or its own would be too long."""
        if isinstance(value, e.Name):
            known = {n.lower(): v for n, v in self._values.items()}
            return self._words.meant(value.name, known) or value
        said = self._sayable(value, None)
        if len(self._words.name(said)) <= LONGEST_NAME:
            return said
        for name, known_value in self._values.items():
            if known_value == said:
                return e.Name(name)
        name = identifier(f"{self._words.kind}_1", {*self._values})
        self._values[name] = said
        return e.Name(name)


def _meant(value: T | e.Name, given: Mapping[str, T]) -> T | e.Name:
    """A value, or what its name stands for."""
    if not isinstance(value, e.Name):
        return value
    return next((v for n, v in given.items() if n.lower() == value.name.lower()), value)
