"""Bodies of drawings (DXF): one for each inserted block, and one for each layer of the rest.

Entities become surfaces and cylinders, in the coordinates of their block or layout:

| entity                             | becomes                                               |
|------------------------------------|-------------------------------------------------------|
| 3DFACE                             | one or two triangles                                  |
| MESH, POLYLINE as polyface or mesh | triangles                                             |
| 3DSOLID, BODY                      | their flat faces with straight edges, by ezdxf        |
| CIRCLE with thickness              | a cylinder                                            |
| closed LWPOLYLINE and POLYLINE     | a prism by their thickness; arcs as chords, and       |
|                                    | thicker by their sagitta and half the width of lines  |
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from dataclasses import replace as changed
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Ints, norms
from assistant.base.budgets import INSERTING, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell.findings import (
    BODY_RENAMED,
    INSIDE_OUT,
    NO_BODY_DRAWN,
    NO_SOLID,
    PARTLY_READ,
    SOLID_NOT_READ,
)
from assistant.cell.mesh_files import MOST_TRIANGLES, cleaned_mesh, shells
from assistant.cell.scene import Body, Colour, Convex, Cylinder, Mesh, Part
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.program import TakenNames, identifier
from assistant.sources.drawing.attributes import Tags
from assistant.sources.drawing.document import library_errors, open_drawing, unit_of
from assistant.sources.drawing.entities import (
    Conic,
    Degenerate,
    Straight,
    check_coordinates,
    check_stated,
    primitives,
)
from assistant.sources.drawing.findings import BAD_ENTITY, DEGENERATE, Tally, shown
from assistant.sources.drawing.locations import Location, LocationReader
from assistant.sources.drawing.program import name_locations
from assistant.sources.drawing.transforms import (
    direction,
    ocs_axes,
    point,
    right_handed,
    scaling,
    skews,
)
from assistant.sources.drawing.traversal import InsertedBlock, PlacedEntity, Traversal
from assistant.sources.process import NO_PROCESS

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.dxfgfx import DXFGraphic


_CHORD_ANGLE: Final = math.radians(3.0)
"""Largest angle of a chord that replaces an arc; its sagitta is 0.00034 of the radius."""
_OVAL_SIDES: Final = 120
"""Sides of the prism around a cylinder that a transform makes oval; it is 0.00034 of the radius
wider.
"""
_SELF_CROSSING: Final = 1e-6
"""Relative difference of area above which an outline crosses itself."""


class NoSolid(Exception):
    """The entity is not a body; curve: it is one for a robot to follow, and nothing is lost with
    it.
    """

    def __init__(self, reason: str, *, curve: bool = False) -> None:
        super().__init__(reason)
        self.curve = curve


@dataclass(frozen=True, slots=True, eq=False)
class DrawnSurface:
    """Triangles (m, 3) of rows of points (n, 3). off: it may be away from what was drawn by that.

    whole: it is one thing; else a piece of a surface whose other pieces are entities too.
    left: what of the entity is not in it, blank if nothing.
    """

    points: Floats
    triangles: Ints
    off: float = 0.0
    whole: bool = True
    left: str = ""

    def moved(self, matrix: Floats) -> DrawnSurface:
        points = point(matrix, self.points)
        check_coordinates(points)
        largest = float(np.linalg.norm(matrix[:3, :3], 2))
        return replace(self, points=points, off=self.off * largest)


@dataclass(frozen=True, slots=True, eq=False)
class DrawnCylinder:
    """A cylinder: the middle of one end (3,), two radii across it and the way to the other end."""

    base: Floats
    u: Floats
    v: Floats
    along: Floats
    even: bool = True
    left: str = ""

    def moved(self, matrix: Floats) -> DrawnCylinder:
        base, rest = point(matrix, self.base), direction(matrix, [self.u, self.v, self.along])
        check_coordinates(base, *rest)
        u, v, along = rest
        return DrawnCylinder(base, u, v, along, self.even and not skews(matrix), self.left)

    def part(self) -> Part:
        """A cylinder; where it is oval or leans, the hull of a prism about it."""
        if self.even:
            turn = rotations.from_matrix(right_handed(self.u, self.along))
            length = float(norms(self.along[None])[0])
            middle = Pose.of(self.base + self.along / 2.0, turn)
            return Part(Cylinder(float(norms(self.u[None])[0]), length), middle)
        angles = np.arange(_OVAL_SIDES) * math.tau / _OVAL_SIDES
        wider = 1.0 / math.cos(math.pi / _OVAL_SIDES)
        ring = wider * (np.cos(angles)[:, None] * self.u + np.sin(angles)[:, None] * self.v)
        return Part(Convex(np.concatenate([ring, ring + self.along]) + self.base))


Solid = DrawnSurface | DrawnCylinder


def solid_of(entity: DXFGraphic) -> Solid:
    """Return an entity as a solid.

    Raises NoSolid for an entity that is not a solid, Degenerate for one without area, ValueError or
    an error of ezdxf for one with invalid data.
    """
    check_stated(entity)
    kind = entity.dxftype()
    if kind in READERS:
        return READERS[kind](entity)
    if kind in _SOLID_KINDS:
        raise NoSolid("its surface is curved or another program's")
    thick = entity.dxf.is_supported("thickness") and entity.dxf.get("thickness", 0.0)
    if thick:
        raise NoSolid("only closed polylines and circles with a thickness are bodies")
    raise NoSolid("it has no thickness", curve=True)


def _face(entity: Any) -> DrawnSurface:
    corners = [np.array(corner.xyz) for corner in entity.wcs_vertices()]
    return replace(_flat_surface([corners]), whole=False)


def _mesh(entity: Any) -> DrawnSurface:
    corners = [np.array(tuple(corner), dtype=np.float64) for corner in entity.vertices]
    surface = _flat_surface([[corners[i] for i in face] for face in entity.faces])
    smooth = entity.dxf.get("subdivision_levels", 0)
    return replace(surface, left="smoothing") if smooth else surface


def _polyline(entity: Any) -> DrawnSurface:
    from ezdxf.render.mesh import MeshBuilder

    if not (entity.is_poly_face_mesh or entity.is_polygon_mesh):
        return _prism(entity)
    mesh = MeshBuilder.from_polyface(entity)
    faces: list[Iterable[Any]] = list(mesh.faces_as_vertices())
    if entity.is_polygon_mesh:
        faces += _seams(entity)
    return _flat_surface([[np.array(v.xyz) for v in face] for face in faces])


def _seams(entity: Any) -> Iterator[tuple[Any, ...]]:
    """Yield the faces that close a mesh of rows and columns, which ezdxf leaves out."""
    vertices = entity.get_mesh_vertex_cache()
    rows, columns = entity.dxf.m_count, entity.dxf.n_count
    last_row, last_column = rows - 1, columns - 1
    for m in range(rows if entity.is_m_closed else last_row) if entity.is_n_closed else ():
        n = (m + 1) % rows
        yield vertices[m, last_column], vertices[m, 0], vertices[n, 0], vertices[n, last_column]
    for n in range(last_column) if entity.is_m_closed else ():
        yield vertices[last_row, n], vertices[last_row, n + 1], vertices[0, n + 1], vertices[0, n]


def _acis_solid(entity: Any) -> DrawnSurface:
    from ezdxf.acis.const import AcisException
    from ezdxf.acis.dxf import load_dxf
    from ezdxf.acis.mesh import mesh_from_body

    try:
        bodies = load_dxf(entity)
        meshes = [mesh for body in bodies for mesh in mesh_from_body(body)]
    except AcisException as error:
        raise NoSolid(str(error) or "its data are of another kind") from None
    faces = [face for mesh in meshes for face in mesh.faces_as_vertices()]
    stated = [face for body in bodies for face in _acis_faces(body)]
    if not faces:
        raise NoSolid("none of its faces is flat with straight edges")
    surface = _flat_surface([[np.array(v.xyz) for v in face] for face in faces])
    holed = any(not face.loop.is_none and not face.loop.next_loop.is_none for face in stated)
    if len(faces) < len(stated) or holed:
        return replace(surface, left="curved faces")
    return surface


def _acis_faces(body: Any) -> Iterator[Any]:
    lump = body.lump
    while not lump.is_none:
        face = lump.shell if lump.shell.is_none else lump.shell.face
        while not face.is_none:
            yield face
            face = face.next_face
        lump = lump.next_lump


def _circle(entity: Any) -> DrawnCylinder:
    along = _thickness(entity)
    (conic,) = primitives(entity)
    assert isinstance(conic, Conic)
    return DrawnCylinder(conic.centre, conic.u, conic.v, along)


def _prism(entity: Any) -> DrawnSurface:
    """Return a closed outline extruded along its thickness.

    It is as wide as its lines: the area of a line with a width extends half the width from its
    middle at most.
    """
    along = _thickness(entity)
    pieces = primitives(entity)
    outline, off = list[Floats](), 0.0
    for piece in pieces:
        if isinstance(piece, Conic):
            count = max(2, math.ceil(piece.sweep / _CHORD_ANGLE))
            angles = np.arange(count) * piece.sweep / count
            places = np.cos(angles)[:, None] * piece.u + np.sin(angles)[:, None] * piece.v
            outline += list(piece.centre + places)
            radius = float(norms(piece.u[None])[0])
            off = max(off, radius * (1.0 - math.cos(piece.sweep / count / 2.0)))
            end = piece.centre + math.cos(piece.sweep) * piece.u + math.sin(piece.sweep) * piece.v
        else:
            assert isinstance(piece, Straight)
            outline.append(piece.start)
            end = piece.end
    if norms((end - outline[0])[None])[0] > 1e-9 * (1.0 + float(np.abs(end).max())):
        raise NoSolid("it is open")
    ring = np.array(outline)
    axes = ocs_axes(tuple(entity.dxf.extrusion))
    flat = ring @ axes[:, :2]
    triangles = _cut_polygon(flat)
    n = len(ring)
    here = np.arange(n)
    after = (here + 1) % n
    sides = np.concatenate(
        [np.stack([here, after, after + n], 1), np.stack([here, after + n, here + n], 1)]
    )
    points = np.concatenate([ring, ring + along])
    faces = np.concatenate([triangles[:, ::-1], triangles + n, sides])
    return DrawnSurface(points, faces, off + _width(entity) / 2.0)


def _width(entity: Any) -> float:
    """Mm or another unit of the drawing: the widest of its lines."""
    if entity.dxftype() == "LWPOLYLINE":
        widths = [entity.dxf.get("const_width", 0.0)]
        widths += [max(abs(one), abs(other)) for one, other in entity.get_points("se")]
    else:
        widths = [entity.dxf.get(key, 0.0) for key in ("default_start_width", "default_end_width")]
        for vertex in entity.vertices:
            widths += [vertex.dxf.get(key, 0.0) for key in ("start_width", "end_width")]
    return float(max(np.abs(widths), default=0.0))


def _thickness(entity: Any) -> Floats:
    """(3,) of the entity in its layout; raises NoSolid if it has none."""
    thickness = float(entity.dxf.get("thickness", 0.0))
    if not math.isfinite(thickness):
        raise ValueError("its thickness is not finite")
    if not thickness:
        raise NoSolid("it has no thickness", curve=True)
    return np.asarray(ocs_axes(tuple(entity.dxf.extrusion))[:, 2] * thickness)


def _flat_surface(faces: Iterable[Sequence[Floats]]) -> DrawnSurface:
    """Build a surface from flat faces with three or more corners (3,)."""
    points, triangles, start = list[Floats](), list[tuple[int, int, int]](), 0
    for face in faces:
        corners = np.array(face, dtype=np.float64).reshape(-1, 3)
        for a, b, c in _triangles(corners):
            triangles.append((start + a, start + b, start + c))
        points += list(corners)
        start += len(corners)
    if not triangles:
        raise Degenerate("without area")
    return DrawnSurface(np.array(points), np.array(triangles, dtype=np.int64))


def _triangles(corners: Floats) -> Iterable[tuple[int, int, int]]:
    match len(corners):
        case 0 | 1 | 2:
            return ()
        case 3:
            return ((0, 1, 2),)
        case 4:
            a, b, c, d = corners
            one, other = np.cross(b - a, c - a), np.cross(c - a, d - a)
            if one @ other >= 0.0:
                return ((0, 1, 2), (0, 2, 3))
            return ((0, 1, 3), (1, 2, 3))
    beyond = np.roll(corners, -1, axis=0)
    normal = np.cross(corners - corners[0], beyond - corners[0]).sum(axis=0)
    if not norms(normal[None])[0] > 0.0:
        return ()
    axes = ocs_axes(normal)
    return [(a, b, c) for a, b, c in _cut_polygon(corners @ axes[:, :2]).tolist()]


def _cut_polygon(flat: Floats) -> Ints:
    """(m, 3) triangles of a polygon (n, 2), counter-clockwise; raises Degenerate for none."""
    from ezdxf.math.triangulation import mapbox_earcut_2d

    corners = [(float(x), float(y)) for x, y in flat]
    if not np.isfinite(flat).all():
        raise ValueError("a corner is not finite")
    places = {corner: i for i, corner in reversed(list(enumerate(corners)))}
    found = [[places[v.x, v.y] for v in three] for three in mapbox_earcut_2d(corners)]
    triangles = np.array(found, dtype=np.int64).reshape(-1, 3)
    one, two = (flat[triangles[:, i]] - flat[triangles[:, 0]] for i in (1, 2))
    areas = (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) / 2.0
    ring = np.roll(flat, -1, axis=0)
    stated = float((flat[:, 0] * ring[:, 1] - flat[:, 1] * ring[:, 0]).sum()) / 2.0
    covered = float(np.abs(areas).sum())
    if not covered > 0.0:
        raise Degenerate("without area")
    if abs(covered - abs(stated)) > _SELF_CROSSING * covered:
        raise Degenerate("its outline crosses itself")
    # The order is by the outline, whichever way around earcut gives its triangles.
    turned = areas < 0.0
    triangles[turned] = triangles[turned][:, ::-1]
    return triangles if stated > 0.0 else np.ascontiguousarray(triangles[:, ::-1])


_SOLID_KINDS: Final = frozenset(
    {
        *("SURFACE", "EXTRUDEDSURFACE", "LOFTEDSURFACE", "REVOLVEDSURFACE", "SWEPTSURFACE"),
        *("PLANESURFACE", "NURBSURFACE", "REGION", "ACAD_PROXY_ENTITY"),
    }
)
"""Entity types for surfaces or solids that are not read."""
READERS: Final[dict[str, Callable[[Any], Solid]]] = {
    "3DFACE": _face,
    "MESH": _mesh,
    "POLYLINE": _polyline,
    "LWPOLYLINE": _prism,
    "CIRCLE": _circle,
    "3DSOLID": _acis_solid,
    "BODY": _acis_solid,
}
"""Entity type → its reader."""


def shape_of(mesh: Mesh) -> Mesh | Convex:
    """The same body as a hull where it is one: with a depth of contact, and faster."""
    from scipy.spatial import ConvexHull, QhullError  # type: ignore[import-untyped]

    if not mesh.solid or mesh.off or len(mesh.points) > _MOST_CORNERS:
        return mesh
    used = mesh.points[np.unique(mesh.triangles)]
    try:
        hull = ConvexHull(used)
    except QhullError:
        return mesh
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    volume = abs(float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum())) / 6.0
    return Convex(used) if volume >= hull.volume * (1.0 - _CONVEX_DIFFERENCE) else mesh


_MOST_CORNERS: Final = 2000
"""Largest number of corners of a hull; a mesh with more is faster by its triangles."""
_CONVEX_DIFFERENCE: Final = 1e-9
"""Relative difference in volume of a body and its hull, up to which it is convex."""


_BY_BLOCK: Final = 0
_BY_LAYER: Final = 256
_OTHER_COLOURS: Final = 7
"""Colour number (DXF reference, group code 62) for black or white, depending on the background."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """Bodies and locations of a drawing. bodies: in the drawing's world, in mm. locations: those
    outside blocks.
    """

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
    """Read the bodies of a DXF drawing, with findings.

    unit: short name of the unit that overrides the drawing's own. Raises Unreadable or Refused if
    the drawing cannot be traversed, or has no body.
    """
    name = str(path)
    tags = Tags.of({}, name)
    document, opened = open_drawing(path)
    _, factor, units = unit_of(document, name, unit)
    tally = Tally()
    traversal = Traversal(document, name, tags, tally, _all)
    locations = LocationReader(document, name, tags, NO_PROCESS, tally, attached=True)
    groups: dict[InsertedBlock | str, _Group] = {}
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
    """Accept every entity; whether it is a solid is determined, and counted, when it is read."""
    return True


@dataclass(slots=True)
class _Group:
    """Entities that become one body, in the drawing's world."""

    colour: Colour | None = None
    solids: list[Solid] = field(default_factory=list)
    locations: list[Location] = field(default_factory=list)


def _read_solid(placed: PlacedEntity, tally: Tally, traversal: Traversal) -> Solid | None:
    """Read a solid in the drawing's world; count entities that are not solids, report broken
    ones.
    """
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
    keys: list[InsertedBlock | str], path: str, findings: list[Diagnostic]
) -> dict[InsertedBlock | str, str]:
    """Name bodies: blocks by their names, numbered if they are inserted several times, layers by
    theirs.

    The body of layer 0 has the name of the file.
    """
    stem = FilePath(path).stem
    given = [(stem if key == "0" else key) if isinstance(key, str) else key.block for key in keys]
    totals = Counter(name.lower() for name in given)
    counts = Counter[str]()
    taken, names = TakenNames(), dict[InsertedBlock | str, str]()
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
    name: str, key: InsertedBlock | str, group: _Group, path: str, findings: list[Diagnostic]
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


def _frame(inserted: InsertedBlock) -> Pose:
    """Return the frame of an insert: its base point, and axes as close to the insert's as a frame
    allows.
    """
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
    """Yield the shells of a surface. The orientation of its triangles has no meaning in a
    drawing.
    """
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


def _colour(placed: PlacedEntity, document: Drawing) -> Colour | None:
    """Return the colour of an entity, or of its layer."""
    from ezdxf.colors import aci2rgb, int2rgb

    entity: DXFGraphic = placed.entity
    if not entity.dxf.is_supported("color"):
        return None
    number, true = entity.dxf.get("color", _BY_LAYER), entity.dxf.get("true_color", None)
    if number in (_BY_LAYER, _BY_BLOCK) and true is None:
        if not document.layers.has_entry(placed.layer):
            return None
        layer = document.layers.get(placed.layer)
        number, true = (
            abs(layer.dxf.get("color", _OTHER_COLOURS)),
            layer.dxf.get("true_color", None),
        )
    if true is not None:
        red, green, blue = int2rgb(true)
    elif 0 < number < _BY_LAYER and number != _OTHER_COLOURS:
        red, green, blue = aci2rgb(number)
    else:
        return None
    return red, green, blue
