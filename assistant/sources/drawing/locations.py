"""Locations of a drawing: points and inserts with attributes, as poses with motion.

A location's axes are those of its insert, or of the extrusion of its point. Angles and quaternions
turn the tool in these axes; without any, the tool's z points against theirs (a drawing seen from
above gives a tool that points down), or as the process of the layer states. Where blocks around it
are mirrored or unevenly scaled, the tool's z and x are taken as the drawing shows them, and y
completes a right-handed frame. The scale of a location's own insert is that of its symbol: only
its sign, a mirroring, counts.

Motion that is not stated is that of the layer's process, else the default one. The drawing's world
is the default frame of the process file, or is placed in it; a location that names another frame
is expressed in that one, and stays where it was drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from typing import TYPE_CHECKING, Any, Final, Literal, cast

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule
from assistant.program.geometry import BASE, FLANGE, Frame, Pose, Tool, Vector
from assistant.program.motion import Speed
from assistant.program.statements import Motion
from assistant.sources.drawing.attributes import ANGLES, QUATERNION, LocationValues, Tags, texts_of
from assistant.sources.drawing.document import library_errors
from assistant.sources.drawing.entities import check_coordinates, check_stated
from assistant.sources.drawing.findings import (
    BAD_ENTITY,
    FACING,
    FACING_UP,
    IGNORED,
    MIRRORED,
    MOVING_FRAME,
    NO_QUATERNION,
    PARTIAL,
    REPAIRED_QUATERNION,
    SKEWED,
    TWO_ORIENTATIONS,
    UNUSED_TAG,
    Tally,
    shown,
)
from assistant.sources.drawing.transforms import (
    direction,
    insert_axes,
    insert_origin,
    mirrors,
    ocs_axes,
    point,
    right_handed,
    skews,
)
from assistant.sources.process import Process

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.insert import Insert

    from assistant.sources.drawing.traversal import PlacedEntity


_NOTED_LENGTH: Final = 1e-6
"""A quaternion this near to unit length has only been rounded, and is not worth a warning."""

_REPAIRED_LENGTH: Final = 1e-3
"""Deviation from unit length beyond which a quaternion counts as a mistake, not as rounding."""

_TOOL_DOWN: Final = rotations.about((1.0, 0.0, 0.0), 180.0)
"""Tool against the axes of the location: half a turn about x."""

_UPWARDS: Final[Vector] = (0.0, 0.0, 1.0)
_UPRIGHT_COSINE: Final = 1e-9
"""1 - cosine up to which an axis counts as upright; 0.003 degrees."""


@dataclass(frozen=True, slots=True)
class Location:
    """given: name as drawn, blank if none; stem: for a name then.

    kind, order: None if not stated.
    """

    given: str
    stem: str
    pose: Pose
    kind: Literal["joint", "linear", "travel"] | None
    motion: Motion
    order: float | None
    place: str


@dataclass(slots=True)
class LocationReader:
    """Reads one location after the other; `findings` and `tally` fill while it goes.

    attached: they are of bodies, so that only poses count, in the drawing's world whatever frame
    they name; names of tools and frames, speeds and orders are for who reads the motion.
    """

    document: Drawing
    path: str
    tags: Tags
    process: Process
    tally: Tally
    attached: bool = False
    findings: list[Diagnostic] = field(default_factory=list)
    tools: Mapping[str, Tool] = field(default_factory=dict)
    frames: Mapping[str, Frame] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.tools = {FLANGE: Tool(), **self.process.tools}
        self.frames = {BASE: Frame(), **self.process.frames}

    def read(self, placed: PlacedEntity) -> Location | None:
        """The location that a point or insert stands for; None if it cannot be had."""
        try:
            with np.errstate(all="ignore"):  # what overflows is found not to be finite
                if placed.entity.dxftype() == "POINT":
                    return self._of_point(placed)
                return self._of_insert(placed)
        except library_errors() as error:
            kind = placed.entity.dxftype()
            self._say(BAD_ENTITY, placed.place, kind=kind, reason=shown(str(error)))
            return None

    def _of_point(self, placed: PlacedEntity) -> Location:
        check_stated(placed.entity)
        dxf = placed.entity.dxf
        if dxf.get("thickness", 0) or dxf.get("angle", 0):
            self._ignored(placed)
        axes = ocs_axes(dxf.extrusion)
        pose = self._pose(placed, dxf.location, axes, None, placed.layer)
        motion = self._usual(placed.layer)
        pose = self._into_frame(placed, pose, motion.frame)
        return Location("", placed.layer, pose, None, motion, None, placed.place)

    def _of_insert(self, placed: PlacedEntity) -> Location | None:
        insert = cast("Insert", placed.entity)
        values = LocationValues(self.tags, self.path, placed.place)
        values.take(texts_of(insert, self.document))
        kind = values.kind()
        motion = self._motion(values, self._usual(placed.layer))
        order = values.number("order")
        turn = self._turn(values)
        given, block = values.text("name"), insert.dxf.name
        origin = insert_origin(insert, placed.cell)
        pose = self._pose(placed, origin, insert_axes(insert), turn, given or block)
        pose = self._into_frame(placed, pose, motion.frame)
        for tag in values.unused:
            reason = "an attribute that means nothing here"
            self.tally.add(UNUSED_TAG, shown(tag), placed.layer, reason, insert.dxf.handle or "")
        self.findings += values.findings
        return Location(given, block, pose, kind, motion, order, placed.place)

    def _usual(self, layer: str) -> Motion:
        """Motion of a location that does not state it."""
        for name, process in self.process.layers.items():
            if name.casefold() == layer.casefold():
                return process.motion
        return self.process.defaults.motion

    def _motion(self, values: LocationValues, usual: Motion) -> Motion:
        if self.attached:
            return usual
        speed, blend = values.speed(), values.blend()
        base = usual.speed if isinstance(usual.speed, Speed) else Speed(1.0)
        return Motion(
            usual.speed if speed is None else replace(base, tcp=speed),
            usual.blend if blend is None else blend,
            values.name_of("tool", self.tools) or usual.tool,
            values.name_of("frame", self.frames) or usual.frame,
        )

    def _turn(self, values: LocationValues) -> Floats | None:
        """Quaternion in the axes of the insert; None if no orientation is stated."""
        angles = [m for m in ANGLES if m in values.texts]
        parts = [m for m in QUATERNION if m in values.texts]
        if angles and parts:
            values.say(TWO_ORIENTATIONS)
            return None
        wanted = ANGLES if angles else QUATERNION if parts else ()
        missing = [self.tags.tag(m) for m in wanted if m not in values.texts]
        if missing:
            everything = ", ".join(self.tags.tag(m) for m in wanted)
            values.say(PARTIAL, missing=", ".join(missing), all=everything)
            return None
        numbers = values.numbers(wanted)
        if not numbers:
            return None
        if parts:
            return self._unit(values, np.array(numbers))
        order = values.convention()
        x, y, z = numbers
        return rotations.from_euler((z, y, x) if order == "ZYX" else (x, y, z), order)

    def _unit(self, values: LocationValues, quaternion: Floats) -> Floats | None:
        length = float(np.linalg.norm(quaternion))
        if not abs(length - 1.0) <= _REPAIRED_LENGTH:
            values.say(NO_QUATERNION, length=length)
            return None
        if abs(length - 1.0) > _NOTED_LENGTH:
            values.say(REPAIRED_QUATERNION, length=length)
        return rotations.canonical(quaternion)

    def _pose(
        self, placed: PlacedEntity, at: Any, axes: Floats, turn: Floats | None, name: str
    ) -> Pose:
        """In the drawing's world, of a location at `at` with `axes` in its layout.

        Raises ValueError if it lies nowhere or its axes fall together.
        """
        position = point(placed.matrix, at)
        check_coordinates(position)
        stated = turn is not None
        tool = axes @ rotations.to_matrix(_TOOL_DOWN if turn is None else turn)
        x, z = direction(placed.matrix, tool[:, 0]), direction(placed.matrix, tool[:, 2])
        if skews(placed.matrix):
            self._say(SKEWED, placed.place, name=shown(name))
        if mirrors(placed.matrix) != (np.linalg.det(axes) < 0):
            self._say(MIRRORED, placed.place, name=shown(name))
        rotation = right_handed(x, z)
        if not stated:
            rotation = self._facing(placed, rotation, name)
        return Pose.of(position, rotations.from_matrix(rotation))

    def _facing(self, placed: PlacedEntity, rotation: Floats, name: str) -> Floats:
        """Return the tool orientation of a location that states no orientation.

        The layer's process states it, unless the location is drawn on a slope; without such a
        process the tool points against the location's axes.
        """
        kind, handle = placed.entity.dxftype(), placed.entity.dxf.handle or ""
        upwards = np.array(self.process.placed(_UPWARDS))
        slope = 1.0 - abs(float(rotation[:, 2] @ upwards)) > _UPRIGHT_COSINE
        for layer, process in self.process.layers.items():
            if layer.casefold() == placed.layer.casefold() and not slope:
                self.tally.add(FACING, kind, placed.layer, "as the layer's process says", handle)
                z = np.asarray(self.process.placed(process.direction), dtype=np.float64)
                steep = abs(float(z @ rotation[:, 0])) > (1.0 - _UPRIGHT_COSINE) * np.linalg.norm(z)
                return right_handed(rotation[:, 1] if steep else rotation[:, 0], z)
        self.tally.add(FACING, kind, placed.layer, "against their own z axis", handle)
        if not slope and rotation[:, 2] @ upwards > 0:
            self._say(FACING_UP, placed.place, name=shown(name))
        return rotation

    def _into_frame(self, placed: PlacedEntity, pose: Pose, name: str) -> Pose:
        """A pose of the drawing's world in the frame of that name, at the same place."""
        drawing = self.process.defaults.frame
        if name == drawing or self.attached:
            return pose
        frames = self.frames[drawing], self.frames[name]
        if any(f.held or f.mechanism or f.seen for f in frames):
            self._say(MOVING_FRAME, placed.place, drawing=drawing, frame=name)
            return pose
        return frames[1].pose.inverse() @ frames[0].pose @ pose

    def _ignored(self, placed: PlacedEntity) -> None:
        handle = placed.entity.dxf.handle or ""
        self.tally.add(IGNORED, "POINT", placed.layer, "thickness or angle", handle)

    def _say(self, rule: Rule, place: str, **fields: Any) -> None:
        self.findings.append(rule(path=self.path, place=place, **fields))
