"""Speeds, blends and accelerations of moves: by value or by name, and corners without a size."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, Final, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from assistant.base.diagnostics import Span
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE, FLANGE
from assistant.program.motion import FINE, MAXIMUM_SPEED, Blend, Kind, Path, Speed, ValueNames
from assistant.program.passes.legalisation import Corners, Legalisation, Rewording
from assistant.program.passes.legalisation import Motions as MotionTable
from assistant.program.passes.paths import reported_at_lines, table_of
from assistant.program.program import Program, identifier
from assistant.program.rewriting import rewrite
from assistant.program.statements import ComputedBlend, ComputedSpeed, Motion

T = TypeVar("T")

_OF_AXES: Final = {
    "rotation": "deg/s of reorientation",
    "external_linear": "mm/s of external axes",
    "external_rotary": "deg/s of external axes",
}
"""Parts of a speed beside that of the tool's tip and of joint moves → what they state."""


def declared_value(value: T | e.Name, declared: Mapping[str, T]) -> T | e.Name:
    """A value, or what its name stands for; the name itself if that is nothing."""
    if not isinstance(value, e.Name):
        return value
    return next((v for n, v in declared.items() if n.lower() == value.name.lower()), value)


def with_stated_motions(program: Program) -> Program:
    """The program with the values of speeds and blends for the names that are declared."""

    def stated(part: Any) -> Any:
        if not isinstance(part, Motion):
            return part
        speed, blend = part.speed, part.blend
        if not isinstance(speed, ComputedSpeed):
            speed = declared_value(speed, program.speeds)
        if not isinstance(blend, ComputedBlend):
            blend = declared_value(blend, program.blends)
        return replace(part, speed=speed, blend=blend)

    return replace(rewrite(program, stated), speeds={}, blends={})


def _without_axes(speed: Speed) -> tuple[Speed, list[str]]:
    """The speed's tcp and joint parts, and what the others state that is not usual."""
    usual = MAXIMUM_SPEED
    parts = [
        text for name, text in _OF_AXES.items() if getattr(speed, name) != getattr(usual, name)
    ]
    return Speed(speed.tcp, joint=speed.joint), parts


def joint_percent(tcp: float, most: float) -> float:
    """Return whole percent of joint speed for a speed in mm/s, rounded down, at least 1.

    most: mm/s that count as 100 percent.
    """
    if math.isinf(tcp):
        return 100.0
    return float(math.floor(min(100.0, max(1.0, 100.0 * tcp / most))))


class NamedValues(Generic[T]):
    """Speeds or blends of a program by name; filled as moves request them.

    sayable: returns the part of a value that the language can express; takes its name, None for an
    unnamed value. longest: characters of a name.
    """

    def __init__(
        self,
        words: ValueNames[T],
        given: Mapping[str, T],
        sayable: Callable[[T, str | None], T],
        longest: int,
    ) -> None:
        self._words, self._sayable, self._longest = words, sayable, longest
        self._values = {n: sayable(v, n) for n, v in given.items()}

    def table(self) -> dict[str, T]:
        """Return the values with separate names: one that has the standard name of its value is
        that value.
        """
        return self._words.named(self._values)

    def said(self, value: T | e.Name) -> T | e.Name:
        """Return a value, or a name if it has a separate one or its standard name would be too
        long.
        """
        if isinstance(value, e.Name):
            known = {n.lower(): v for n, v in self._values.items()}
            return self._words.meant(value.name, known) or value
        said = self._sayable(value, None)
        if len(self._words.name(said)) <= self._longest:
            return said
        for name, known_value in self._values.items():
            if known_value == said:
                return e.Name(name)
        name = identifier(f"{self._words.kind}_1", {*self._values})
        self._values[name] = said
        return e.Name(name)


class ByValue:
    """Motions whose speeds and blends are numbers instead of names.

    named: how many names became numbers. Tools and frames get the spelling of their declarations.
    """

    def __init__(self, job: Legalisation, can: MotionTable) -> None:
        self.job, self.can, self.program = job, can, job.program
        self.named = 0

    def motion(self, motion: Motion, joint_move: bool) -> Motion:
        tool, frame = self.tool(motion.tool), self.frame(motion.frame)
        speed, blend = motion.speed, motion.blend
        return Motion(
            self.computed(speed, joint_move)
            if isinstance(speed, ComputedSpeed)
            else self.speed(speed, joint_move),
            self.corner(blend) if isinstance(blend, ComputedBlend) else self.blend(blend),
            tool,
            frame,
        )

    def computed(self, speed: ComputedSpeed, joint_move: bool) -> ComputedSpeed:
        """The same of a speed that is worked out."""
        usual = ComputedSpeed(None)
        # Parts of other axes have no words in the language: reported, then dropped.
        parts = [x for name, x in _OF_AXES.items() if getattr(speed, name) != getattr(usual, name)]
        self.job.findings.extend(self.can.speed_part(part=part) for part in parts)
        if not joint_move:
            return ComputedSpeed(speed.tcp)
        # A percent that is stated counts before one that is worked out.
        if speed.joint is not None or speed.tcp is None:
            return ComputedSpeed(None, joint=speed.joint or e.Number(100))
        self.job.findings.append(self.can.computed_percent(tcp=self.can.fastest))
        fastest = e.number_of(self.can.fastest)
        share = e.Binary("/", e.Binary("*", speed.tcp, e.Number(100)), fastest)
        # From 1 to 100 percent, as `joint_percent` gives.
        most = e.Apply("min", (e.Number(100), e.Apply("floor", (share,))))
        return ComputedSpeed(None, joint=e.Apply("max", (e.Number(1), most)))

    def corner(self, blend: ComputedBlend) -> ComputedBlend:
        """Return a computed blend without the parts that the language cannot express."""
        if blend.details is not None:
            self.job.findings.append(self.can.blend_part())
        return replace(blend, details=None)

    def path(self, path: Path, line: Callable[[int], Span | None] = lambda _: None) -> Path:
        """A path with tables of such values, each once and in the order of their first use.

        line: where the move to a row is in the source text.
        """

        def table(index: NDArray[Any], value: Callable[[int], Any]) -> Any:
            return table_of(
                index, partial(reported_at_lines, self.job.findings, line, index, value)
            )

        # A speed means another percent for joint moves, so both make one entry.
        pairs = path.speed.astype(np.int64) * 2 + (path.kinds == Kind.JOINT)
        speeds, speed = table(pairs, lambda i: self.speed(path.speeds[i // 2], bool(i % 2)))
        blends, blend = table(path.blend, lambda i: self.blend(path.blends[i]))
        tools, tool = table(path.tool, lambda i: self.tool(path.tools[i]))
        frames, frame = table(path.frame, lambda i: self.frame(path.frames[i]))
        return replace(
            path, speeds=speeds, speed=speed, blends=blends, blend=blend,
            tools=tools, tool=tool, frames=frames, frame=frame,
        )  # fmt: skip

    def speed(self, speed: Speed | e.Name, joint_move: bool) -> Speed:
        """The speed by value, with its percentage for joint moves only."""
        known = self._meant(speed, self.program.speeds, "the speed")
        if known is None:
            # A joint move at a speed nobody knows is made as slowly as possible.
            return Speed(math.inf, joint=1.0) if joint_move else Speed(100.0)
        known, parts = _without_axes(known)
        self.job.findings.extend(self.can.speed_part(part=part) for part in parts)
        if not joint_move:
            return replace(known, joint=None)
        if known.joint is not None:
            return Speed(math.inf, joint=min(100.0, max(1.0, known.joint)))
        percent = joint_percent(known.tcp, self.can.fastest)
        tcp = "the most" if math.isinf(known.tcp) else f"{known.tcp:g}"
        self.job.findings.append(self.can.percent(tcp=tcp, percent=percent))
        return Speed(math.inf, joint=percent)

    def blend(self, blend: Blend | e.Name) -> Blend:
        known = self._meant(blend, self.program.blends, "the blend")
        if known is None:
            return FINE
        if known.details is not None:
            self.job.findings.append(self.can.blend_part())
            known = replace(known, details=None)
        # An exit without a radius, or equal to it, states nothing.
        open_ = known.radius is None or math.isinf(known.radius)
        return replace(known, exit=None) if open_ or known.exit == known.radius else known

    def tool(self, name: str) -> str:
        return self._spelled(name, self.program.tools, FLANGE, "the tool")

    def frame(self, name: str) -> str:
        return self._spelled(name, self.program.frames, BASE, "the frame")

    def _meant(self, value: T | e.Name, declared: Mapping[str, T], what: str) -> T | None:
        known = declared_value(value, declared)
        if isinstance(known, e.Name):
            self.job.findings.append(self.can.unknown(what=what, name=known.name))
            return None
        self.named += known is not value
        return known

    def _spelled(self, name: str, declared: Mapping[str, Any], default: str, what: str) -> str:
        if name.lower() == default:
            return default
        known = next((n for n in declared if n.lower() == name.lower()), None)
        if known is None:
            self.job.findings.append(self.can.unknown(what=what, name=name))
        return known or name


class CornerSizes:
    """A size for each corner that the controller is to choose: what it has at a move's speed."""

    def __init__(self, job: Legalisation, can: Corners) -> None:
        self.job, self.can = job, can

    def is_open(self, blend: Blend | e.Name) -> bool:
        known = declared_value(blend, self.job.program.blends)
        return isinstance(known, Blend) and known.radius is not None and math.isinf(known.radius)

    def blend(self, blend: Blend | e.Name, speed: Speed | e.Name) -> Blend | e.Name:
        known, fast = (
            declared_value(blend, self.job.program.blends),
            declared_value(speed, self.job.program.speeds),
        )
        if not (self.is_open(blend) and isinstance(known, Blend) and isinstance(fast, Speed)):
            return blend
        said = Blend(min(self.can.size(fast), math.inf if known.exit is None else known.exit))
        self.job.changed("a corner without size", self.can.name(said), "state one radius in mm")
        return said

    def path(self, path: Path) -> Path:
        """A path whose corners without a size have that of their row's speed."""
        open_ = np.array([self.is_open(blend) for blend in path.blends], dtype=bool)
        rows = np.flatnonzero(open_[path.blend]) if open_.any() else ()
        if not len(rows):
            return path
        # Each pair of corner and speed gives one size.
        pairs, at = np.unique(
            np.stack([path.blend[rows], path.speed[rows]], axis=1), axis=0, return_inverse=True
        )
        more = tuple(self.blend(path.blends[b], path.speeds[s]) for b, s in pairs)
        blend = path.blend.copy()
        blend[rows] = len(path.blends) + at.reshape(-1)
        kept = (more[0] if o else b for o, b in zip(open_, path.blends, strict=True))
        # Entries that no row uses any more need a value that can be written.
        return replace(path, blend=blend, blends=(*kept, *more))


def one_acceleration(r: Rewording, node: p.SetAcceleration) -> Iterator[p.Statement]:
    """The smaller of two values for both, not less than the language takes."""
    one, two, can = node.acceleration, node.deceleration, r.job.can.acceleration
    if can is None:
        yield node
        return
    value = one
    # Only numbers can be compared here.
    if isinstance(one, e.Number) and isinstance(two, e.Number):
        least = max(min(one.value, two.value), can.least)
        if (least, least) != (one.value, two.value):
            r.job.changed(
                f"acceleration {one.value} and deceleration {two.value} percent",
                f"{least} percent for both",
                can.cure_of_least,
            )
        value = e.Number(least)
    elif one != two:
        r.job.changed("the deceleration", "the acceleration", can.cure)
    yield replace(node, acceleration=value, deceleration=value)
