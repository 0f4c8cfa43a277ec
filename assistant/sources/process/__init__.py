"""Contents of a process file: what a drawing or table leaves open.

`Process` holds the defaults of motion, tools, frames, signals, lines and a `Layer` for each layer
whose contours are followed. The records of a layer: `Shaping` (side, starts, leads, passes),
`SpeedProfile`, `OutputSwitching` and `ContourTravel`. `Surroundings` is what a source asks of the
cell: how long travel takes, and from where the tool can reach a place;
`cell.planning.approaches` implements it. Lengths are mm, speeds mm/s, times seconds,
angles degrees.

`SeenSettings` is the table of frames that cameras locate; each key may be left out:

    [seen]
    ask = "192.168.0.5:10010"     # the program asks there while it runs; or listen:ADDRESS:PORT
    found = "found.toml"          # beside this file: objects found before the program is written
    oldest = 600                  # seconds for which a sight is valid
    sigma_mm = 1.0                # largest uncertainty of a position, one standard deviation
    sigma_deg = 1.0
    confidence = 0.8              # 0 to 1, least confidence that it is the object
    within = 300                  # mm that an answer may be off the usual position
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import field
from functools import cache
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Any, Final, Literal, Protocol

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, error
from assistant.program import settings_tables
from assistant.program.expressions import Name
from assistant.program.geometry import BASE, FLANGE, Frame, Pose, Tool, Vector
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import Interface, Signal
from assistant.program.settings_tables import Read, Table, Wrong, kind_of, shown
from assistant.program.statements import Motion
from assistant.program.undeclared_names import ChannelLine
from assistant.sources.seen_settings import NO_SEEN_SETTINGS, PoseServer, SeenSettings, Trust

_NO_DEPTH = error("CT330", "`passes` needs a depth that they share", "give `depth` in mm as well")
_DEPTH_WITHOUT_RETRACT = error(
    "CT331",
    "with `depth` the tool is in the work: it needs ways in and out of it",
    "give `approach` and `retract` of more than 0 mm",
)
_NO_SIDE = error(
    "CT332", "`side` says where the tool is, but nothing on this layer asks for it", "{cure}"
)

_MOST_PASSES: Final = 1000
_QUARTER_TURN: Final = 90.0
_LEAD_FORMS: Final = "write {arc = 5, angle = 90}, {line = 5, angle = 60} or {tangent = 5}"


@dataclass(frozen=True, slots=True)
class Lead:
    """A way onto or off a contour, on the side where the tool is.

    line: mm in a line that meets the contour at an angle in degrees, 0 along it. arc: mm of the
    radius of an arc that touches the contour, over an angle in degrees.
    """

    kind: Literal["line", "arc"]
    size: float
    angle: float = _QUARTER_TURN


@dataclass(frozen=True, slots=True)
class Shaping:
    """offset: mm from the contour to the centre of the tool, 0 for the contour itself.

    side: where the tool is: `nesting` is outside of outlines and inside of holes; left and right
    are as an open contour is drawn. way_round: None for as drawn where it is closed, and as
    travel is shortest where it is open. start: of closed contours. overlap: mm that a closed
    contour goes on over its own start. depth: mm below the drawing, along the tool, reached in
    equal `passes`. allowances: mm more than the offset, once around for each.
    """

    offset: float = 0.0
    side: Literal["nesting", "inside", "outside", "left", "right"] = "nesting"
    way_round: Literal["climb", "conventional", "clockwise", "anticlockwise", "drawn"] | None = None
    start: Literal["nearest", "corner", "longest", "point"] = "nearest"
    lead_in: Lead | None = None
    lead_out: Lead | None = None
    overlap: float = 0.0
    depth: float = 0.0
    passes: int = 1
    allowances: tuple[float, ...] = (0.0,)

    @property
    def leads(self) -> tuple[Lead, ...]:
        return tuple(lead for lead in (self.lead_in, self.lead_out) if lead)

    @property
    def sided(self) -> bool:
        """True if the side of a closed contour on which the tool runs matters."""
        return self.sided_open or bool(self.leads)

    @property
    def sided_open(self) -> bool:
        """The same of an open one, which runs on along its tangents without cutting into itself."""
        moved = self.offset > 0.0 or any(self.allowances)
        turned = self.way_round in ("climb", "conventional")
        return moved or turned or any(lead.angle > 0.0 for lead in self.leads)

    @property
    def depths(self) -> tuple[float, ...]:
        """Mm below the drawing of each pass."""
        return tuple(self.depth * (i + 1) / self.passes for i in range(self.passes))


_AS_DRAWN: Final = Shaping()


def _read_lead(value: Any) -> Lead:
    if not isinstance(value, dict):
        raise Wrong(f"is {kind_of(value)}", _LEAD_FORMS)
    kinds = [kind for kind in ("arc", "line", "tangent") if kind in value]
    other = next((key for key in value if key not in ("arc", "line", "tangent", "angle")), None)
    if other is not None:
        raise Wrong(f"has no key {shown(other)}", _LEAD_FORMS)
    if len(kinds) != 1:
        raise Wrong("is not one of arc, line and tangent", _LEAD_FORMS)
    (kind,) = kinds
    if kind == "tangent" and "angle" in value:
        raise Wrong("runs along the tangent and has no angle", "leave out the angle, or write line")
    try:
        size: float = settings_tables.number("mm", above=0.0)(value[kind])
        angle: float = _QUARTER_TURN
        if "angle" in value:
            most = 180.0 if kind == "arc" else 150.0
            angle = settings_tables.number("degrees", above=0.0, most=most)(value["angle"])
    except Wrong as wrong:
        raise Wrong(f"has a number that {wrong.what}", wrong.cure) from None
    if kind == "tangent":
        return Lead("line", size, 0.0)
    return Lead("arc" if kind == "arc" else "line", size, angle)


def _read_allowances(value: Any) -> tuple[float, ...]:
    cure = "write mm in brackets, falling to what the last one leaves: [0.5, 0]"
    if not isinstance(value, list) or not value:
        raise Wrong(f"is {kind_of(value)}" if value != [] else "is empty", cure)
    read = settings_tables.number("mm", least=0.0)
    found = tuple(read(entry) for entry in value)
    if any(later >= earlier for earlier, later in pairwise(found)):
        raise Wrong("does not fall", cure)
    return found


SHAPING_KEYS: Final[Mapping[str, Read]] = {
    "offset": settings_tables.number("mm", above=0.0),
    "side": settings_tables.choice("nesting", "inside", "outside", "left", "right"),
    "way_round": settings_tables.choice(
        "climb", "conventional", "clockwise", "anticlockwise", "drawn"
    ),
    "start": settings_tables.choice("nearest", "corner", "longest", "point"),
    "lead_in": _read_lead,
    "lead_out": _read_lead,
    "overlap": settings_tables.number("mm", least=0.0),
    "depth": settings_tables.number("mm", least=0.0),
    "passes": settings_tables.whole(1, _MOST_PASSES),
    "allowances": _read_allowances,
}


def shaping_of(table: Table, found: dict[str, Any]) -> Shaping:
    """From the values of a layer's table, which it takes out of them."""
    stated = "side" in found
    shaping = Shaping(**{key: found.pop(key) for key in SHAPING_KEYS if key in found})
    if "passes" in table.content and not shaping.depth:
        table.say(_NO_DEPTH, "passes")
    if shaping.depth and not all(found.get(key, 1.0) > 0.0 for key in ("approach", "retract")):
        table.say(_DEPTH_WITHOUT_RETRACT, "depth")
    if stated and not shaping.sided:
        cure = "give `offset`, a lead, or `way_round`; or delete `side`"
        table.say(_NO_SIDE, "side", cure=cure)
    return shaping


OrderKind = Literal["travel", "drawing", "text"]
"""Order of contours: for the shortest travel, as drawn, or by the numbers next to them."""


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """Speeds along a contour where they are not the layer's; None for that one.

    corner: where it turns by `angle` degrees or more, and on arcs of up to `radius` mm that do,
    from `length` mm before to `length` mm behind. start, end: over the first and the last mm.
    """

    corner: Speed | None = None
    angle: float = 30.0
    radius: float = 0.0
    length: float = 5.0
    start: Speed | None = None
    start_length: float = 5.0
    end: Speed | None = None
    end_length: float = 5.0

    @property
    def even(self) -> bool:
        """True if the complete contour has one speed."""
        return self.corner is None and self.start is None and self.end is None


@dataclass(frozen=True, slots=True)
class SwitchPoint:
    """A position on the path and a time, mm and seconds before or after the start or the end."""

    mm: float = 0.0
    seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class OutputSwitching:
    """When outputs are set, None for at the start and the end themselves, where the tool stops."""

    on_before: SwitchPoint | None = None
    on_after: SwitchPoint | None = None
    off_before: SwitchPoint | None = None
    off_after: SwitchPoint | None = None


@dataclass(frozen=True, slots=True)
class ContourTravel:
    """Travel between contours.

    height: mm above the highest point of the layer, None for the approach and retract of each
    contour. blend: of the places above the work. kind: None for lines, and joint moves where a
    tool that follows the contours would wind up.
    """

    height: float | None = None
    blend: Blend = FINE
    kind: Literal["joint", "linear"] | None = None


_EVEN_SPEED: Final = SpeedProfile()
_SWITCHED_AT_ENDS: Final = OutputSwitching()
_TRAVEL_BY_APPROACH: Final = ContourTravel()


def _read_address(value: Any) -> PoseServer:
    return PoseServer.parse(settings_tables.text(value))


def _read_file_beside(value: Any) -> str:
    """The name of a file, in the same folder."""
    given = settings_tables.text(value)
    if re.search(r"[/\\:\x00-\x1f]", given) or given in (".", ".."):
        raise Wrong(f'is "{shown(given)}"', "write the name of a file beside this one, no folder")
    return given


SEEN_KEYS: Final[Mapping[str, Read]] = {
    "ask": _read_address,
    "found": _read_file_beside,
    "oldest": settings_tables.number("seconds", above=0.0),
    "sigma_mm": settings_tables.number("mm", above=0.0),
    "sigma_deg": settings_tables.number("degrees", above=0.0),
    "confidence": settings_tables.number("", least=0.0, most=1.0),
    "within": settings_tables.number("mm", above=0.0),
}


def seen_of(said: Mapping[str, Any], path: str | None) -> SeenSettings:
    """Build the settings from the given values of KEYS. path: of the file that states them."""
    trust = {key: value for key, value in said.items() if key not in ("ask", "found")}
    found = str(FilePath(path or "").parent / said["found"]) if "found" in said else ""
    return SeenSettings(said.get("ask"), Trust(**trust), found)


@dataclass(frozen=True, slots=True)
class ProgramStyle:
    """Form of the program of a drawing or table; None for the default of a field.

    procedures: one for each contour, called by that of its layer; one for each layer; or none but
    the main one. comments: what each layer and contour is, above its statements. points: of paths,
    each a target, an offset of the start of its contour, or an element of an array. constants:
    heights, speeds and blends that are used often have names.
    """

    procedures: Literal["contour", "layer", "none"] | None = None
    comments: bool | None = None
    points: Literal["targets", "offsets", "arrays"] | None = None
    constants: bool | None = None

    def completed(self, other: ProgramStyle) -> ProgramStyle:
        """Return the style with what another one states where this one states nothing."""
        return ProgramStyle(
            self.procedures or other.procedures,
            other.comments if self.comments is None else self.comments,
            self.points or other.points,
            other.constants if self.constants is None else self.constants,
        )

    @property
    def commented(self) -> bool:
        return self.comments is not False


NO_STYLE: Final = ProgramStyle()

STYLE_KEYS: Final[Mapping[str, Read]] = {
    "procedures": settings_tables.choice("contour", "layer", "none"),
    "comments": settings_tables.truth,
    "points": settings_tables.choice("targets", "offsets", "arrays"),
    "constants": settings_tables.truth,
}


ALONG_TOOL: Vector = (0.0, 0.0, -1.0)
"""Back from a place along the tool, in the tool's own axes."""


def travel_seconds(one: tuple[float, ...], other: tuple[float, ...]) -> float:
    """Return the seconds of a joint move between two of `Surroundings.places`: the axes move
    together.
    """
    return max(abs(a - b) for a, b in zip(one, other, strict=True))


@dataclass(frozen=True, slots=True)
class WayIn:
    """Direction of an approach or a retract. direction: of unit length, in the tool's axes, from
    the target to where the tool starts or goes. findings: findings about it.
    """

    direction: Vector = ALONG_TOOL
    findings: tuple[Diagnostic, ...] = ()


class Surroundings(Protocol):
    """Poses are those of the tip in the base of the robot, tools the tip in the flange."""

    def places(self, positions: Floats, quaternions: Floats, tool: Pose) -> Floats | None:
        """Tips (n, 3), (n, 4) → (n, k), of which two are as many seconds apart as a joint move
        between them takes at full speed: the largest of their differences. None if one of them is
        out of reach.
        """

    def way_in(self, pose: Pose, tool: Pose, distance: float, place: str) -> WayIn:
        """From where the tool can come to a pose in a line of `distance` mm, touching nothing.

        place: the pose, for findings.
        """


SurroundingsByRobot = Callable[[str | None], Surroundings | None]
"""The surroundings by the robot that a source names, if it names one."""


DEFAULT_SPEED: Final = Speed(100.0)
DEFAULT_TRAVEL_SPEED: Final = Speed(200.0)


@dataclass(frozen=True, slots=True)
class Defaults:
    """Default motion for a source that does not state it.

    kind: `travel` for motions that are planned through the cell, between single targets and between
    contours. speed is deliberately slow: 100 mm/s. blend: None for a stop at single targets, and on
    paths for corners that are rounded within the tolerance. approach, retract: mm along the tool
    axis in a line to single targets of a drawing, and away from them. travel: speed of the move to
    the first point of a path, and between the contours of a layer that states none.
    """

    kind: Literal["joint", "linear", "travel"] = "linear"
    speed: Speed | Name = DEFAULT_SPEED
    blend: Blend | Name | None = None
    tool: str = FLANGE
    frame: str = BASE
    approach: float = 0.0
    retract: float = 0.0
    travel: Speed = DEFAULT_TRAVEL_SPEED

    @property
    def travels(self) -> bool:
        return self.kind == "travel"

    @property
    def motion(self) -> Motion:
        """Return the motion of single targets."""
        return Motion(self.speed, self.blend or FINE, self.tool, self.frame)


DEFAULT_MOTION: Final = Defaults()


@dataclass(frozen=True, slots=True)
class Layer:
    """Process along the contours of a layer (gluing, painting, cutting …).

    process: name for people. motion: along the contour; the blend holds between its pieces.
    on, off: signals and the values they get at the start and at the end of each contour.
    approach, retract: mm along the tool axis above the first and last point.
    travel: speed of the moves between contours. direction: where the tool points, in the
    drawing's frame (0, 0, -1: down). tangential: the tool's x axis follows the contour.
    delay: seconds after switching on. inside_first: contours that lie inside closed ones are run
    before them. rounded: the file states no blend, and corners are rounded within the tolerance.
    own_blend: the layer's table states the blend.
    shaping: offset of the tool from a contour, and its leads.
    order: of the contours. pace, switching, above: where speed and outputs change, and the motion
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
    own_blend: bool = False
    shaping: Shaping = _AS_DRAWN
    order: OrderKind = "travel"
    pace: SpeedProfile = _EVEN_SPEED
    switching: OutputSwitching = _SWITCHED_AT_ENDS
    above: ContourTravel = _TRAVEL_BY_APPROACH


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A part of a layer's curves that is not wanted; one of the last five says which.

    layer: on which, None for all. line_type, block: its name, `*` being any letters. at: mm in the
    drawing's world, a point on a contour or in it. number: of a contour in the picture of the
    order. group: of contours that stand apart from others.
    """

    layer: str | None = None
    line_type: str | None = None
    block: str | None = None
    at: tuple[float, float] | None = None
    number: int | None = None
    group: int | None = None

    def concerns(self, layer: str) -> bool:
        """True if it is about that layer."""
        return self.layer is None or self.layer.casefold() == layer.casefold()

    @property
    def text(self) -> str:
        """As it is written in a process file."""
        given = ((name, getattr(self, name)) for name in LEFT_OUT_KEYS)
        rows = (f"{key} = {_toml_text(value)}" for key, value in given if value is not None)
        return "{" + ", ".join(rows) + "}"


def _toml_text(value: str | int | tuple[float, float]) -> str:
    if isinstance(value, str):
        return f'"{shown(value)}"'
    if isinstance(value, tuple):
        return "[" + ", ".join(f"{round(x, 3) + 0.0:g}" for x in value) + "]"
    return str(value)


_LEFT_OUT_FORMS: Final = (
    'write the name of a layer in quotes, {line_type = "CENTER"}, {layer = "CUT", at = [12, 30]},'
    " {number = 3} or {group = 2}"
)
LEFT_OUT_KEYS: Final[Mapping[str, Read]] = {
    "layer": settings_tables.text,
    "line_type": settings_tables.text,
    "block": settings_tables.text,
    "at": settings_tables.point,
    "number": settings_tables.whole(1, 1_000_000),
    "group": settings_tables.whole(1, 1_000_000),
}


def read_left_out(value: Any) -> tuple[str | LeftOut, ...]:
    """The entries of `leave_out`: names of layers, and tables of what is left out on a layer."""
    if not isinstance(value, list):
        raise Wrong(
            f"is {kind_of(value)}", f"write texts in brackets, or tables; {_LEFT_OUT_FORMS}"
        )
    return tuple(map(_read_left_out_entry, value))


def _read_left_out_entry(value: Any) -> str | LeftOut:
    if isinstance(value, str) and value.strip():
        return value
    if not isinstance(value, dict):
        raise Wrong(
            f"has {kind_of(value)}" if value != "" else "has an empty text", _LEFT_OUT_FORMS
        )
    other = next((key for key in value if key not in LEFT_OUT_KEYS), None)
    if other is not None:
        raise Wrong(f"has an entry with `{shown(other)}`", _LEFT_OUT_FORMS)
    if len(value.keys() - {"layer"}) != 1:
        raise Wrong(
            "has an entry that is not one of line_type, block, at, number and group",
            _LEFT_OUT_FORMS,
        )
    if "group" in value and "layer" in value:
        raise Wrong("has a `group` on one layer", "leave out `layer`: groups are of all layers")
    found = {}
    for key, given in value.items():
        try:
            found[key] = LEFT_OUT_KEYS[key](given)
        except Wrong as wrong:
            raise Wrong(f"has an entry whose `{key}` {wrong.what}", wrong.cure) from None
    return LeftOut(**found)


@dataclass(frozen=True, slots=True)
class Process:
    """Content of a process file.

    layers: by layer name, compared without case. tags: attribute tag by meaning (`name`,
    `x_rotation`, …), for locations in drawings. tolerance: mm for chaining, fitting, rounding.
    unit: short name of the unit of drawings, overriding theirs, and of arrays that state no unit.
    robot: name of the arm that joints were taught on and that runs the program, None if not stated.
    leave_out: layers that are not wanted, compared without case, `*` being any letters. left_out:
    line types and single contours that are not wanted. follow: layers, blocks and line types that
    are worked although their names mean drafting, spelled as in leave_out. assumed: what nobody
    measured, in words for people. placement: the drawing's world in the default frame, None where
    it is that frame. joint_speed: mm/s of joint moves of a
    robot program whose percentage has no equivalent in mm/s. joint_percent: of joint moves whose
    mm/s cannot be expressed, None for the share of the fastest. lines: by their numbers on the
    source's controller. interface: place of the program among other programs, None if not stated.
    undirected: names of signals without a stated direction, which are outputs unless a program says
    otherwise. home: degrees of the axes (mm of sliding ones) at which the program of a drawing
    begins and ends, None for the position of the arm. seen: for frames that are seen, the limits of
    trust in sights, and the server that a program asks. around: bodies around the work, which no
    process file states; None if they are unknown. merges: rows that repeat the pose of the row
    before are left out; no process file states it. style: form of the program of a drawing.
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
    left_out: tuple[LeftOut, ...] = ()
    follow: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    placement: Pose | None = None
    merges: bool = False
    joint_speed: float | None = None
    joint_percent: float | None = None
    lines: Mapping[int, ChannelLine] = field(default_factory=dict)
    interface: Interface | None = None
    undirected: frozenset[str] = frozenset()
    home: tuple[float, ...] | None = None
    seen: SeenSettings = NO_SEEN_SETTINGS
    around: Surroundings | None = None
    style: ProgramStyle = NO_STYLE
    findings: tuple[Diagnostic, ...] = ()

    def leaves_out(self, layer: str) -> bool:
        """True if a layer is left out; a layer with a separate table is never left out."""
        name = layer.casefold()
        if name in {one.casefold() for one in self.layers}:
            return False
        return matches_any(self.leave_out, name)

    def leaves_out_part(self, layer: str, line_type: str, blocks: tuple[str, ...] = ()) -> bool:
        """True if a line type, or one of the blocks around it, is left out on a layer."""
        for one in self.left_out:
            names = (line_type,) if one.line_type is not None else blocks
            wanted = one.block if one.line_type is None else one.line_type
            if wanted is not None and one.concerns(layer):
                if any(matches_any((wanted,), name) for name in names):
                    return True
        return False

    def standing_frame(self) -> Pose | None:
        """Return the pose of the frame of the moves; None if that is unknown or something carries
        it.
        """
        name = self.defaults.frame
        frame = Frame() if name == BASE else self.frames.get(name)
        return None if frame is None or frame.held or frame.mechanism else frame.pose

    def placed(self, direction: Vector) -> Vector:
        """Rotate a direction of the drawing into the default frame by the placement."""
        if self.placement is None:
            return direction
        x, y, z = rotations.rotate(
            np.array(self.placement.quaternion), np.array(direction, dtype=np.float64)
        ).tolist()
        return (x, y, z)


@cache
def matches_any(patterns: tuple[str, ...], name: str) -> bool:
    """True if a name matches a pattern, in which `*` matches any letters and all else is literal,
    compared without case.
    """
    spelled = name.casefold()
    return any(
        re.fullmatch(".*".join(map(re.escape, one.casefold().split("*"))), spelled, re.DOTALL)
        for one in patterns
    )


NO_PROCESS: Final = Process()
