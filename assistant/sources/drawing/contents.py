"""Contents of a drawing that a robot can use: curves, locations and numbering texts, in mm.

Entities that are not used are counted and reported. Everything is where the process file places the
drawing.
"""

from __future__ import annotations

from datetime import date
from functools import cache
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.budgets import INSERTING, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import BASE, FLANGE, Vector
from assistant.program.statements import Motion
from assistant.sources.contours.contour_order import LayerText
from assistant.sources.contours.curves import Curve, vector
from assistant.sources.drawing.attributes import Tags
from assistant.sources.drawing.document import library_errors, open_drawing, saved_on, unit_of
from assistant.sources.drawing.drafting import Drafting
from assistant.sources.drawing.entities import Degenerate, ignored_properties, primitives
from assistant.sources.drawing.findings import (
    BAD_ENTITY,
    DEGENERATE,
    IGNORED,
    OTHER_UCS,
    UNKNOWN_DEFAULT,
    Tally,
    shown,
)
from assistant.sources.drawing.locations import Location, LocationReader
from assistant.sources.drawing.transforms import affine, ocs_matrix, point, scaling
from assistant.sources.drawing.traversal import PlacedEntity, Traversal
from assistant.sources.process import Process

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.dxfgfx import DXFGraphic


_TEXT_TYPES: Final = frozenset(("TEXT", "MTEXT"))


def is_number_text(entity: DXFGraphic) -> bool:
    """True if an entity is a text that is a number."""
    return (
        entity.dxftype() in _TEXT_TYPES
        and _layer_text_at(entity, (0.0, 0.0, 0.0)).number is not None
    )


def layer_text(entity: DXFGraphic, matrix: Floats, layer: str) -> LayerText:
    """A text at its insertion point. matrix: (4, 4), to the drawing's world in mm."""
    text = cast("Any", entity)
    if entity.dxftype() == "MTEXT":
        point = text.dxf.insert.xyz
    else:
        aligned = text.dxf.get("halign", 0) or text.dxf.get("valign", 0)
        chosen = text.dxf.align_point if aligned and text.dxf.hasattr("align_point") else None
        point = (chosen or text.dxf.insert).xyz
        point = (ocs_matrix(text.dxf.extrusion.xyz) @ (*point, 1.0))[:3]
    return _layer_text_at(entity, vector((matrix @ (*point, 1.0))[:3]), layer)


def _layer_text_at(
    entity: DXFGraphic, at: tuple[float, float, float], layer: str = ""
) -> LayerText:
    text = cast("Any", entity)
    return LayerText(text.plain_text(), at, layer, entity.dxf.handle or "")


@dataclass(frozen=True, slots=True)
class Contents:
    """Curves and locations in order of drawing, in mm, where the process places the drawing.

    marks: points that are not locations but state where the contours of their layer start. texts:
    of the layers whose contours are numbered by them. aside: curves that are drafting, or whose
    line types or blocks the process file leaves out. drafting: what was found to be drafting.
    saved: day on which the drawing was saved.
    """

    unit: str
    curves: tuple[Curve, ...]
    locations: tuple[Location, ...]
    findings: tuple[Diagnostic, ...]
    marks: tuple[tuple[str, Vector], ...] = ()
    texts: tuple[LayerText, ...] = ()
    aside: tuple[Curve, ...] = ()
    drafting: Drafting | None = None
    saved: date | None = None


def read_contents(path: FilePath, process: Process) -> Contents:
    """Read everything in a drawing; raises Unreadable or Refused if it cannot be traversed.

    Faults of single entities are in the findings, with severity error if a robot might miss the
    entity.
    """
    name = str(path)
    _check_defaults(process, name)
    tags = Tags.of(process.tags, name)
    document, opened = open_drawing(path)
    unit, factor, units = unit_of(document, name, process.unit)
    tally = Tally()
    unwanted = cache(process.leaves_out)
    ordered = {layer.casefold() for layer, one in process.layers.items() if one.order == "text"}
    traversal = Traversal(
        document,
        name,
        tags,
        tally,
        numbering=lambda entity, layer: layer.casefold() in ordered and is_number_text(entity),
        unwanted=unwanted,
        unwanted_block=lambda layer, block: process.leaves_out_part(layer, "", (block,)),
    )
    locations = LocationReader(document, name, tags, process, tally)
    curves: list[Curve] = []
    found: list[Location] = []
    marks: list[tuple[str, Vector]] = []
    marked = {n.lower() for n, layer in process.layers.items() if layer.shaping.start == "point"}
    texts: list[LayerText] = []
    aside: list[Curve] = []
    drafting = Drafting.of(document, process)
    with within(INSERTING, name, traversal.count()):
        for placed in traversal.model(root_of(process, factor)):
            kind = placed.entity.dxftype()
            if kind == "POINT" and placed.layer.lower() in marked:
                at = vector(point(placed.matrix, placed.entity.dxf.location))
                marks.append((placed.layer, at))
            elif kind in ("POINT", "INSERT"):
                if unwanted(placed.layer) or (kind == "POINT" and drafting.leaves_out(placed)):
                    continue
                location = locations.read(placed)
                found += [location] if location else []
            elif placed.entity.dxftype() in _TEXT_TYPES:
                texts.append(layer_text(placed.entity, placed.matrix, placed.layer))
            else:
                off = drafting.leaves_out(placed)
                counted_in = Tally() if off or unwanted(placed.layer) else tally
                (aside if off else curves).extend(curves_of(placed, counted_in, traversal))
        borders = drafting.borders(curves, aside, traversal.annotations)
        aside += [curves[row] for row in borders]
        curves = [curve for row, curve in enumerate(curves) if row not in borders]
        traversal.paper()
    counted = (f.within(name) for f in tally.findings())
    findings = (*opened, *units, *ucs_of(document, name), *traversal.findings, *locations.findings)
    said = (*findings, *counted, *(f.within(name) for f in drafting.findings()))
    return Contents(
        *(unit, tuple(curves), tuple(found), said, tuple(marks), tuple(texts), tuple(aside)),
        drafting,
        saved_on(document),
    )


def root_of(process: Process, factor: float) -> Floats:
    """Drawing units to mm where the process places the drawing."""
    if process.placement is None:
        return scaling(factor)
    turn = rotations.to_matrix(np.array(process.placement.quaternion))
    return np.asarray(affine(turn, np.array(process.placement.position)) @ scaling(factor))


def curves_of(placed: PlacedEntity, tally: Tally, traversal: Traversal) -> list[Curve]:
    """The curves of an entity; what has no length is counted, what is broken is a finding."""
    entity, layer = placed.entity, placed.layer
    kind, handle = entity.dxftype(), entity.dxf.handle or ""
    curves: list[Curve] = []
    try:
        with np.errstate(all="ignore"):  # what overflows is found not to be finite
            for what in ignored_properties(entity):
                tally.add(IGNORED, kind, layer, what, handle)
            for piece in primitives(entity):
                try:
                    curves.append(piece.moved(placed.matrix).curve(layer, handle))
                except Degenerate as reason:
                    tally.add(DEGENERATE, kind, layer, str(reason), handle)
    except Degenerate as reason:
        tally.add(DEGENERATE, kind, layer, str(reason), handle)
    except library_errors() as error:
        reason_shown = shown(str(error) or type(error).__name__)
        traversal.findings.append(
            BAD_ENTITY(path=traversal.path, place=placed.place, kind=kind, reason=reason_shown)
        )
    return curves


def _check_defaults(process: Process, path: str) -> None:
    """Raises Refused where motion names a tool or frame that is not declared."""
    tools, frames = {FLANGE, *process.tools}, {BASE, *process.frames}
    motions: list[Motion] = [process.defaults.motion]
    motions += [layer.motion for layer in process.layers.values()]
    wrong = {("tool", m.tool) for m in motions if m.tool not in tools}
    wrong |= {("frame", m.frame) for m in motions if m.frame not in frames}
    if wrong:
        raise Refused(
            *(UNKNOWN_DEFAULT(path=path, what=w, name=shown(n)) for w, n in sorted(wrong))
        )


def ucs_of(document: Drawing, path: str) -> tuple[Diagnostic, ...]:
    """Return a finding if the drawing uses a user coordinate system.

    Entities are stored in world coordinates in any case; but the screen shows other coordinates to
    a reader.
    """
    axes = (("$UCSORG", (0, 0, 0)), ("$UCSXDIR", (1, 0, 0)), ("$UCSYDIR", (0, 1, 0)))
    world = all(np.allclose(tuple(document.header.get(name, usual)), usual) for name, usual in axes)
    return () if world else (OTHER_UCS(path=path, place="header"),)
