"""Bodies of a drawing: a body a block that is inserted, and one a layer of what is in no block."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from dataclasses import replace as changed
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.budgets import INSERTING, within
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell.reading.drawings.rules import (
    BODY_RENAMED,
    NO_BODY_DRAWN,
    NO_SOLID,
    PARTLY_READ,
    SOLID_NOT_READ,
)
from assistant.cell.reading.drawings.solids import (
    DrawnCylinder,
    DrawnSurface,
    NoSolid,
    Solid,
    shape_of,
    solid_of,
)
from assistant.cell.reading.meshes import MOST_TRIANGLES, cleaned_mesh, shells
from assistant.cell.rules import INSIDE_OUT
from assistant.cell.scene import Body, Colour, Part
from assistant.cell.shapes import Mesh
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.program import TakenNames, identifier
from assistant.sources.drawing.assembly import name_locations
from assistant.sources.drawing.attributes import Tags
from assistant.sources.drawing.document import library_errors, open_drawing
from assistant.sources.drawing.findings import BAD_ENTITY, DEGENERATE, Tally, shown
from assistant.sources.drawing.locations import Location, Locations
from assistant.sources.drawing.primitives import Degenerate
from assistant.sources.drawing.transforms import direction, point, right_handed, scaling
from assistant.sources.drawing.traversal import Inserted, Placed, Traversal
from assistant.sources.drawing.units import unit_of
from assistant.sources.process import NO_PROCESS

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.dxfgfx import DXFGraphic

BY_BLOCK: Final = 0
BY_LAYER: Final = 256
OTHER_COLOURS: Final = 7
"""Of the numbers of colours (DXF reference, group code 62): black or white, by what is behind."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """bodies: in the drawing's world, in mm. locations: those that stand in no block."""

    bodies: tuple[Body, ...]
    locations: Mapping[str, Pose]
    findings: tuple[Diagnostic, ...]

    def as_one(self, name: str) -> Body:
        """All of it as one body, whose frame is the drawing's world.

        A location of a block is called after both where its name is there already.
        """
        parts, locations = list[Part](), dict(self.locations)
        taken = TakenNames(locations)
        for body in self.bodies:
            parts += [Part(part.shape, body.pose @ part.pose) for part in body.parts]
            for key, pose in body.locations.items():
                free = key if key.lower() not in taken.lower else f"{body.name}_{key}"
                locations[free := identifier(free, taken)] = body.pose @ pose
                taken.add(free)
        colour = self.bodies[0].colour if self.bodies else None
        return Body(name, tuple(parts), colour=colour, locations=locations)


def read_drawing(path: FilePath, unit: str | None = None) -> Drawn:
    """The bodies of a DXF drawing, and what is to be said of it.

    unit: short name of the unit that holds whatever the drawing says. Raises Unreadable or Refused
    if it cannot be gone through, or has no body.
    """
    name = str(path)
    tags = Tags.of({}, name)
    document, opened = open_drawing(path)
    _, factor, units = unit_of(document, name, unit)
    tally = Tally()
    traversal = Traversal(document, name, tags, tally, _all)
    locations = Locations(document, name, tags, NO_PROCESS, tally, attached=True)
    groups: dict[Inserted | str, _Group] = {}
    with within(INSERTING, name, traversal.count()):
        for placed in traversal.model(scaling(factor)):
            key = placed.inserted or placed.layer
            if placed.entity.dxftype() in ("POINT", "INSERT"):
                found = locations.read(placed)
                key = placed.inserted or ""
                if found is not None:
                    groups.setdefault(key, _Group()).locations.append(found)
                continue
            solid = _read_solid(placed, tally, traversal)
            if solid is not None:
                group = groups.setdefault(key, _Group(_colour(placed, document)))
                group.colour = group.colour or _colour(placed, document)
                group.solids.append(solid)
    traversal.paper()
    findings = [*opened, *units, *traversal.findings, *locations.findings]
    findings += [finding.within(name) for finding in tally.findings()]
    free = groups.pop("", _Group())
    with_solids = {key: group for key, group in groups.items() if group.solids}
    bodies = [
        _body(body, key, with_solids[key], name, findings)
        for key, body in _body_names(list(with_solids), name, findings).items()
    ]
    if not bodies:
        raise Refused(*findings, NO_BODY_DRAWN(path=name))
    alone = [
        location
        for group in (free, *(group for group in groups.values() if not group.solids))
        for location in group.locations
    ]
    return Drawn(tuple(bodies), _named_poses(alone, IDENTITY, name, findings), tuple(findings))


def _all(_: DXFGraphic) -> bool:
    """Whether it is a solid is found out, and counted, when it is read."""
    return True


@dataclass(slots=True)
class _Group:
    """What becomes one body, in the drawing's world."""

    colour: Colour | None = None
    solids: list[Solid] = field(default_factory=list)
    locations: list[Location] = field(default_factory=list)


def _read_solid(placed: Placed, tally: Tally, traversal: Traversal) -> Solid | None:
    """In the drawing's world; what is none is counted, what is broken is a finding."""
    entity = placed.entity
    kind, handle = shown(entity.dxftype()), entity.dxf.handle or ""
    try:
        with np.errstate(all="ignore"):  # what overflows is found not to be finite
            solid = solid_of(entity).moved(placed.matrix)
    except NoSolid as none:
        rule = NO_SOLID if none.curve else SOLID_NOT_READ
        tally.add(rule, kind, placed.layer, shown(str(none)), handle)
    except Degenerate as reason:
        tally.add(DEGENERATE, kind, placed.layer, str(reason), handle)
    except library_errors() as error:
        reason_shown = shown(str(error) or type(error).__name__)
        traversal.findings.append(
            BAD_ENTITY(path=traversal.path, place=placed.place, kind=kind, reason=reason_shown)
        )
    else:
        if solid.left:
            tally.add(PARTLY_READ, kind, placed.layer, solid.left, handle)
        return solid
    return None


def _body_names(
    keys: list[Inserted | str], path: str, findings: list[Diagnostic]
) -> dict[Inserted | str, str]:
    """Blocks by their names, numbered where they are inserted several times, layers by theirs.

    What is on layer 0 is called as the file is.
    """
    stem = FilePath(path).stem
    given = [(stem if key == "0" else key) if isinstance(key, str) else key.block for key in keys]
    totals = Counter(name.lower() for name in given)
    counts = Counter[str]()
    taken, names = TakenNames(), dict[Inserted | str, str]()
    for key, name in zip(keys, given, strict=True):
        counts[name.lower()] += 1
        several = totals[name.lower()] > 1
        wanted = f"{name}_{counts[name.lower()]}" if several else name
        names[key] = identifier(wanted, taken)
        taken.add(names[key])
        if names[key] != wanted:
            findings.append(BODY_RENAMED(path=path, given=shown(wanted), name=names[key]))
    return names


def _body(
    name: str, key: Inserted | str, group: _Group, path: str, findings: list[Diagnostic]
) -> Body:
    """In the frame of its block where there is one, else of the drawing's world."""
    pose = IDENTITY if isinstance(key, str) else _frame(key)
    back = _matrix(pose.inverse())
    parts, pieces = list[Part](), list[DrawnSurface]()
    for solid in group.solids:
        local = solid.moved(back)
        if isinstance(local, DrawnCylinder):
            parts.append(local.part())
        elif local.whole:
            parts += _shell_parts(local, path, name, findings)
        else:
            pieces.append(local)
    if pieces:
        parts += _shell_parts(_joined(pieces), path, name, findings)
    locations = _named_poses(group.locations, pose.inverse(), path, findings)
    return Body(name, tuple(parts), pose, colour=group.colour, locations=locations, source=path)


def _frame(inserted: Inserted) -> Pose:
    """Of an insert: its base point, and axes as near to its own as a frame can have them."""
    matrix = inserted.matrix
    x, z = direction(matrix, [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
    turn = rotations.from_matrix(right_handed(x, z))
    return Pose.of(point(matrix, inserted.base), turn)


def _matrix(pose: Pose) -> Floats:
    out = np.eye(4)
    out[:3, :3] = rotations.to_matrix(np.array(pose.quaternion))
    out[:3, 3] = pose.position
    return out


def _joined(pieces: list[DrawnSurface]) -> DrawnSurface:
    starts = np.cumsum([0, *(len(piece.points) for piece in pieces)])
    return DrawnSurface(
        np.concatenate([piece.points for piece in pieces]),
        np.concatenate(
            [piece.triangles + start for piece, start in zip(pieces, starts, strict=False)]
        ),
        max(piece.off for piece in pieces),
    )


def _shell_parts(
    surface: DrawnSurface, path: str, name: str, findings: list[Diagnostic]
) -> Iterable[Part]:
    """The shells of a surface. Which way around its triangles go says nothing in a drawing."""
    try:
        mesh, said = cleaned_mesh(surface.points, surface.triangles, MOST_TRIANGLES, path, [])
    except Refused as refused:
        findings += [changed(one, about=name) for one in refused.findings]
        return
    findings += [changed(one, about=name) for one in said if one.code != INSIDE_OUT.code]
    for points, triangles, solid in shells(mesh):
        piece = Mesh(points, triangles, solid, mesh.off + surface.off)
        yield Part(shape_of(piece))


def _named_poses(
    locations: list[Location], back: Pose, path: str, findings: list[Diagnostic]
) -> dict[str, Pose]:
    """Poses by name in the frame that `back` leads to."""
    names = name_locations(locations, TakenNames(), path)
    findings += names.findings
    return {
        name: back @ location.pose for name, location in zip(names.names, locations, strict=True)
    }


def _colour(placed: Placed, document: Drawing) -> Colour | None:
    """Of an entity, or of its layer."""
    from ezdxf.colors import aci2rgb, int2rgb

    entity: DXFGraphic = placed.entity
    if not entity.dxf.is_supported("color"):
        return None
    number, true = entity.dxf.get("color", BY_LAYER), entity.dxf.get("true_color", None)
    if number in (BY_LAYER, BY_BLOCK) and true is None:
        if not document.layers.has_entry(placed.layer):
            return None
        layer = document.layers.get(placed.layer)
        number, true = abs(layer.dxf.get("color", OTHER_COLOURS)), layer.dxf.get("true_color", None)
    if true is not None:
        red, green, blue = int2rgb(true)
    elif 0 < number < BY_LAYER and number != OTHER_COLOURS:
        red, green, blue = aci2rgb(number)
    else:
        return None
    return red, green, blue
