"""What a drawing or table leaves open: defaults of motion, tools, frames, signals, layers."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np

from assistant.base import rotations
from assistant.base.diagnostics import Diagnostic
from assistant.program.expressions import Name
from assistant.program.geometry import BASE, FLANGE, Frame, Pose, Tool, Vector
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Interface, Signal
from assistant.program.statements import Motion
from assistant.program.undeclared_names import ChannelLine
from assistant.sources.process.seen import NO_SEEN_SETTINGS, SeenSettings
from assistant.sources.process.shaping import AS_DRAWN, Shaping
from assistant.sources.process.ways import (
    EVEN_SPEED,
    SWITCHED_AT_ENDS,
    TRAVEL_BY_APPROACH,
    ContourTravel,
    OrderKind,
    OutputSwitching,
    SpeedProfile,
)
from assistant.sources.surroundings import Surroundings

DEFAULT_SPEED: Final = Speed(100.0)


@dataclass(frozen=True, slots=True)
class Defaults:
    """How a source moves where it does not say so itself.

    kind: `travel` for ways that are planned through the cell, between single targets and between
    contours. speed is deliberately slow: 100 mm/s. blend: None for a stop at single targets, and on
    paths for corners that are rounded within the tolerance. approach, retract: mm along the tool
    axis in a line to single targets of a drawing, and away from them.
    """

    kind: Literal["joint", "linear", "travel"] = "linear"
    speed: Speed | Name = DEFAULT_SPEED
    blend: Blend | Name | None = None
    tool: str = FLANGE
    frame: str = BASE
    approach: float = 0.0
    retract: float = 0.0

    @property
    def travels(self) -> bool:
        return self.kind == "travel"

    @property
    def motion(self) -> Motion:
        """Of single targets."""
        return Motion(self.speed, self.blend or FINE, self.tool, self.frame)


DEFAULT_MOTION: Final = Defaults()
DEFAULT_TRAVEL_SPEED: Final = Speed(200.0)


@dataclass(frozen=True, slots=True)
class Layer:
    """What is done along the contours of a layer (gluing, painting, cutting …).

    process: name for people. motion: along the contour; the blend holds between its pieces.
    on, off: signals and the values they get at the start and at the end of each contour.
    approach, retract: mm along the tool axis above the first and last point.
    travel: speed of the moves between contours. direction: where the tool points, in the
    drawing's frame (0, 0, -1: down). tangential: the tool's x axis follows the contour.
    delay: seconds after switching on. inside_first: contours that lie inside closed ones come
    before them. rounded: the file states no blend, and corners are rounded within the tolerance.
    shaping: where beside a contour the tool runs, and how it comes onto it.
    order: of the contours. pace, switching, above: where speed and outputs change, and the way
    between contours.
    """

    process: str
    motion: Motion
    on: tuple[tuple[str, float], ...] = ()
    off: tuple[tuple[str, float], ...] = ()
    approach: float = 50.0
    retract: float = 50.0
    travel: Speed = DEFAULT_TRAVEL_SPEED
    direction: Vector = (0.0, 0.0, -1.0)
    tangential: bool = False
    delay: float = 0.0
    inside_first: bool = True
    rounded: bool = False
    shaping: Shaping = AS_DRAWN
    order: OrderKind = "travel"
    pace: SpeedProfile = EVEN_SPEED
    switching: OutputSwitching = SWITCHED_AT_ENDS
    above: ContourTravel = TRAVEL_BY_APPROACH


@dataclass(frozen=True, slots=True)
class Process:
    """Everything a process file says.

    layers: by layer name, compared without case. tags: attribute tag by meaning (`name`,
    `x_rotation`, …), for locations in drawings. tolerance: mm for chaining, fitting, rounding.
    unit: short name of the unit of drawings, whatever they say, and of arrays that say none.
    robot: name of the arm that joints were taught on and that runs the program, None if not said.
    leave_out: layers that nobody wants, compared without case, `*` being any letters.
    placement: the drawing's world in the default frame, None where it is that frame.
    joint_speed: mm/s of joint moves of a robot program whose percentage cannot be said in mm/s.
    joint_percent: of joint moves whose mm/s cannot be said, None to take the share of the fastest.
    lines: by their numbers on the source's controller.
    interface: how the program stands among others, None if nothing is said of it.
    home: degrees of the axes (mm of sliding ones) at which the program of a drawing begins and
    ends, None for wherever the arm is.
    seen: of frames that are seen, how far sights are trusted, and whom a program asks.
    around: what stands around the work, which no process file says; None if nobody knows.
    merges: rows that repeat the place of the row before are left out; no process file says so.
    findings: warnings about the process file itself.
    """

    defaults: Defaults = DEFAULT_MOTION
    tools: Mapping[str, Tool] = field(default_factory=dict)
    frames: Mapping[str, Frame] = field(default_factory=dict)
    signals: Mapping[str, Signal] = field(default_factory=dict)
    layers: Mapping[str, Layer] = field(default_factory=dict)
    tags: Mapping[str, str] = field(default_factory=dict)
    tolerance: float = 0.05
    unit: str | None = None
    robot: str | None = None
    leave_out: tuple[str, ...] = ()
    placement: Pose | None = None
    merges: bool = False
    joint_speed: float | None = None
    joint_percent: float | None = None
    lines: Mapping[int, ChannelLine] = field(default_factory=dict)
    interface: Interface | None = None
    home: tuple[float, ...] | None = None
    seen: SeenSettings = NO_SEEN_SETTINGS
    around: Surroundings | None = None
    findings: tuple[Diagnostic, ...] = ()

    def leaves_out(self, layer: str) -> bool:
        """Whether nobody wants a layer; one with a table of its own is wanted."""
        name = layer.casefold()
        if name in {one.casefold() for one in self.layers}:
            return False
        return any(_matches_pattern(pattern.casefold(), name) for pattern in self.leave_out)

    def placed(self, direction: Vector) -> Vector:
        """A direction of the drawing as the drawing stands in the default frame."""
        if self.placement is None:
            return direction
        x, y, z = rotations.rotate(
            np.array(self.placement.quaternion), np.array(direction, dtype=np.float64)
        ).tolist()
        return (x, y, z)


def _matches_pattern(pattern: str, name: str) -> bool:
    """Whether a name is of a pattern, in which `*` stands for any letters and nothing else does."""
    return re.fullmatch(".*".join(map(re.escape, pattern.split("*"))), name, re.DOTALL) is not None


NO_PROCESS: Final = Process()
