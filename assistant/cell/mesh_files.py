"""Read files of triangles (STL, OBJ, PLY, 3MF, glTF) as meshes in mm."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.arrays import Floats, Ints, norms
from assistant.base.diagnostics import Diagnostic, Refused, Unreadable
from assistant.base.length_units import UNITS
from assistant.base.source_text import read_bytes
from assistant.cell.findings import (
    INSIDE_OUT,
    NO_AREA,
    NO_LIBRARY,
    NO_MESH,
    NO_UNIT,
    OPEN_MESH,
    SIMPLIFIED,
)
from assistant.cell.scene import Convex, Mesh
from assistant.program.geometry import Vector

if TYPE_CHECKING:
    from types import ModuleType


_KINDS: Final = {".stl": "stl", ".obj": "obj", ".ply": "ply", ".3mf": "3mf", ".glb": "glb",
                ".gltf": "gltf"}  # fmt: skip
_CAD_SUFFIXES: Final = (".step", ".stp", ".iges", ".igs", ".sat", ".x_t", ".sldprt", ".ipt")
_IN_METRES: Final = (".glb", ".gltf")
"""glTF's lengths are metres by its specification."""
_FARTHEST: Final = 1e7
"""mm of a coordinate: distances of larger ones would lose their last places."""
_MOST_BYTES: Final = 1 << 30
"""Bytes of a file."""
MOST_TRIANGLES: Final = 200_000
"""Above that a mesh is simplified."""
_MERGE_DISTANCE: Final = 1e-6
"""mm; corners that near are one: STL states each corner of each triangle anew."""


def read_mesh(
    path: FilePath,
    unit: str | None = None,
    most: int = MOST_TRIANGLES,
    scale: Vector = (1.0, 1.0, 1.0),
) -> tuple[Mesh, tuple[Diagnostic, ...]]:
    """Read the triangles of a file as one mesh, with findings.

    unit: of a file that states no unit. scale: of its coordinates; a negative one mirrors. Raises
    Unreadable for a missing file, Refused for one that is not a mesh.
    """
    trimesh = mesh_library()
    suffix, said = path.suffix.lower(), str(path)
    if suffix not in _KINDS:
        known = ", ".join(sorted(kind[1:].upper() for kind in _KINDS))
        cure = (
            f"convert it to one of {known} in a CAD program"
            if suffix in _CAD_SUFFIXES
            else f"use {known}"
        )
        raise Refused(NO_MESH(path=said, reason=f"`{suffix}` is not read", cure=cure))
    data = read_bytes(path, most=_MOST_BYTES)
    try:
        found = _loaded(trimesh, data, _KINDS[suffix], path)
        points = np.asarray(found.vertices, dtype=np.float64).reshape(-1, 3)
        triangles = np.asarray(found.faces, dtype=np.int64).reshape(-1, 3)
        stated = found.units
    except Unreadable:
        raise
    except Exception as error:  # noqa: BLE001 - of a library that raises whatever the bytes lead it to
        reason = (str(error) or type(error).__name__).split("\n", 1)[0][:120]
        raise _no_mesh(said, reason) from None
    if not len(triangles) or not np.isfinite(points).all():
        reason = "it holds no triangle" if not len(triangles) else "a corner is no number"
        raise _no_mesh(said, reason)
    factor, findings = _factor(suffix, stated, unit, said)
    points = points * factor * np.array(scale)
    if np.abs(points).max() > _FARTHEST:
        raise _no_mesh(said, f"a corner is more than {_FARTHEST:g} mm away from its origin")
    if np.prod(scale) < 0.0:
        triangles = triangles[:, ::-1]
    return cleaned_mesh(points, triangles, most, said, findings)


def read_hull(path: FilePath, unit: str | None = None) -> tuple[Convex, tuple[Diagnostic, ...]]:
    """Read the hull of the corners of a file; raises like `read_mesh`, Refused for flat ones.

    Findings about how its triangles join or face are left out: a hull has other triangles.
    """
    mesh, told = read_mesh(path, unit)
    findings = tuple(f for f in told if f.code not in (OPEN_MESH.code, INSIDE_OUT.code))
    hull = Convex(mesh.points)
    try:
        _ = hull.hull
    except Refused:
        flat = "its corners lie in one plane, so that they have no hull"
        cure = "read it as `mesh`, or give it a thickness"
        raise Refused(NO_MESH(path=str(path), reason=flat, cure=cure)) from None
    return hull, findings


def _no_mesh(path: str, reason: str) -> Refused:
    return Refused(NO_MESH(path=path, reason=reason, cure="export it again"))


def mesh_library() -> ModuleType:
    """trimesh; raises Refused, naming the extra, without it."""
    try:
        import trimesh
    except ImportError:
        raise Refused(NO_LIBRARY(what="meshes are", name="trimesh"), exit_status=2) from None
    return trimesh


def _loaded(trimesh: Any, data: bytes, kind: str, path: FilePath) -> Any:
    """One mesh of all that a file holds, each at its place in the file."""
    resolver = trimesh.resolvers.FilePathResolver(str(path)) if kind in ("gltf", "obj") else None
    stream = trimesh.util.wrap_as_stream(data)
    scene = trimesh.load_scene(stream, file_type=kind, resolver=resolver, process=False)
    found = scene.to_mesh()
    found.units = scene.units
    return found


def _factor(
    suffix: str, stated: str | None, unit: str | None, path: str
) -> tuple[float, list[Diagnostic]]:
    """Mm of a unit of the file."""
    if suffix in _IN_METRES:
        return 1000.0, []
    known = {"millimeters": "mm", "meters": "m", "inches": "in", "centimeters": "cm"}
    short = known.get(stated or "")
    if short is not None:
        return UNITS[short][1], []
    if unit is not None:
        return UNITS[unit][1], []
    return 1.0, [NO_UNIT(path=path, unit=UNITS["mm"][0])]


def cleaned_mesh(
    points: Floats, triangles: Ints, most: int, path: str, findings: list[Diagnostic]
) -> tuple[Mesh, tuple[Diagnostic, ...]]:
    """Build a mesh of points (n, 3) mm and triangles (m, 3), with findings.

    Coincident corners are merged, triangles without area are left out, those that face inwards are
    reversed, more than `most` are simplified. Raises Refused if no triangle is left.
    """
    given, off = len(triangles), 0.0
    if given <= most:
        points, triangles = _merged(points, triangles, _MERGE_DISTANCE)
    else:
        # About three triangles for each square of a grid that a surface goes through.
        cell = max(
            float(np.sqrt(3.0 * _areas(points, triangles).sum() / most)), 2.0 * _MERGE_DISTANCE
        )
        while len((fewer := _merged(points, triangles, cell))[1]) > most:
            cell *= _GRID_GROWTH
        points, triangles = fewer
        off = cell * float(np.sqrt(3.0))
    if off:
        kept = len(triangles)
        findings.append(SIMPLIFIED(path=path, given=given, kept=kept, mm=off))
    flat = _areas(points, triangles) <= 0.0
    if flat.any():
        count = int(flat.sum())
        findings.append(NO_AREA(path=path, count=count, total=len(triangles)))
        triangles = triangles[~flat]
    if not len(triangles):
        raise _no_mesh(path, "none of its triangles has an area")
    opened = _open_edges(triangles)
    if opened:
        triangles = _turned_alike(points, triangles)
        opened = _open_edges(triangles)
    if opened and not off:
        findings.append(OPEN_MESH(path=path, count=opened))
    elif _volume(points, triangles) < 0.0:
        findings.append(INSIDE_OUT(path=path))
        triangles = triangles[:, ::-1]
    mesh = Mesh(points, np.ascontiguousarray(triangles), not opened)
    return replace(mesh, off=off), tuple(findings)


def _merged(points: Floats, triangles: Ints, cell: float) -> tuple[Floats, Ints]:
    """Corners in one cell of a grid made one, triangles that fall together left out.

    Nothing moves by more than the diagonal of a cell. What was closed stays closed: of triangles on
    the same corners those that face one side more than the other are kept, and one each if there
    are as many, as where a thin wall becomes one sheet.
    """
    first, places = _distinct(np.round(points / cell).astype(np.int64))
    moved = places[triangles]
    a, b, c = moved.T
    kept = moved[(a != b) & (b != c) & (c != a)]
    if cell > _MERGE_DISTANCE and len(kept):
        corners = np.sort(kept, axis=1)
        a, b, c = kept.T
        up = np.where(((a < b) & (b < c)) | ((b < c) & (c < a)) | ((c < a) & (a < b)), 1, -1)
        some, same = _distinct(corners)
        net = np.bincount(same, up, len(some)).astype(np.int64)
        out = corners[some]
        ahead, behind = np.repeat(out, np.maximum(net, net == 0), axis=0), out[net <= 0]
        behind = np.repeat(behind, np.maximum(-net[net <= 0], 1), axis=0)
        kept = np.concatenate([ahead, behind[:, ::-1]])
    return points[first], kept


def _distinct(rows: Ints) -> tuple[Ints, Ints]:
    """(k,) places of rows (n, 3) that stand for all, and (n,) which of them each row is.

    Sorted by one number a row, ten times as fast as rows are; should two share one, as rows.
    """
    x, y, z = rows.astype(np.uint64).T
    codes = (x * _HASH_FACTORS[0]) ^ (y * _HASH_FACTORS[1]) ^ (z * _HASH_FACTORS[2])
    codes ^= codes >> np.uint64(29)
    _, first, places = np.unique(codes, return_index=True, return_inverse=True)
    if not (rows[first][places] == rows).all():
        _, first, places = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, places.reshape(-1)


_HASH_FACTORS: Final = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xC2B2AE3D27D4EB4F),
    np.uint64(0x165667B19E3779F9),
)
"""Odd numbers without pattern: different rows get different codes, but for one in 10¹² files."""
_GRID_GROWTH: Final = 1.25
"""By which a grid grows that leaves too many triangles."""


def _areas(points: Floats, triangles: Ints) -> Floats:
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return norms(np.cross(b - a, c - a)) / 2.0


def _volume(points: Floats, triangles: Ints) -> float:
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6.0


def _open_edges(triangles: Ints) -> int:
    """Edges that are not met once in each direction."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    most = int(triangles.max()) + 1
    there = edges[:, 0] * most + edges[:, 1]
    back = edges[:, 1] * most + edges[:, 0]
    codes, counts = np.unique(there, return_counts=True)
    codes_back, counts_back = np.unique(back, return_counts=True)
    same = np.intersect1d(codes, codes_back, assume_unique=True)
    paired = counts[np.isin(codes, same)] == counts_back[np.isin(codes_back, same)]
    return int(len(codes) - paired.sum())


def _sides(triangles: Ints) -> tuple[Ints, Ints, Any]:
    """Pairs of triangles (k,), (k,) with a side in common that no third has.

    Also of each (k,) whether both go along it the same way, so that one faces the other way.
    """
    m = len(triangles)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    owner, forward = np.tile(np.arange(m), 3), edges[:, 0] < edges[:, 1]
    low, high = edges.min(axis=1), edges.max(axis=1)
    order = np.lexsort((high, low))
    low, high, owner, forward = low[order], high[order], owner[order], forward[order]
    first = np.flatnonzero(np.append(True, (np.diff(low) != 0) | (np.diff(high) != 0)))
    pairs = first[np.diff(np.append(first, len(low))) == 2]
    return owner[pairs], owner[pairs + 1], forward[pairs] == forward[pairs + 1]


def _turned_alike(points: Floats, triangles: Ints) -> Ints:
    """Triangles turned so that neighbours face the same side, outwards of each shell.

    Each triangle is taken twice, as it is and turned round, and joined to the neighbours that it
    agrees with: what hangs together then is a shell from one of its sides.
    """
    from scipy.sparse import coo_array  # type: ignore[import-untyped]
    from scipy.sparse.csgraph import connected_components  # type: ignore[import-untyped]

    m = len(triangles)
    one, other, against = _sides(triangles)
    shift = np.where(against, m, 0)
    rows = np.concatenate([one, one + m])
    columns = np.concatenate([other + shift, other + m - shift])
    graph = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), (2 * m, 2 * m))
    count, labels = connected_components(graph, directed=False)
    here, there = labels[:m], labels[m:]
    a, b, c = (points[triangles[:, i]] for i in range(3))
    signed = np.einsum("ij,ij->i", a, np.cross(b, c))
    volumes = np.bincount(here, signed, count) - np.bincount(there, signed, count)
    turned = (volumes[here] < volumes[there]) | ((volumes[here] == volumes[there]) & (here > there))
    out = triangles.copy()
    out[turned] = out[turned][:, ::-1]
    return out


def shells(mesh: Mesh) -> Iterator[tuple[Floats, Ints, bool]]:
    """Points, triangles and whether they are closed, of each part of a mesh that hangs together."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    a, b, c = mesh.triangles.T
    rows, columns = np.concatenate([a, b]), np.concatenate([b, c])
    size = len(mesh.points)
    graph = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), (size, size))
    _, labels = connected_components(graph, directed=False)
    own = labels[a]
    for label in dict.fromkeys(own.tolist()):
        used, places = np.unique(mesh.triangles[own == label], return_inverse=True)
        triangles = places.reshape(-1, 3)
        yield mesh.points[used], triangles, not _open_edges(triangles)
