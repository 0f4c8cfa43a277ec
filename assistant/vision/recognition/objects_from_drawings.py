"""Learn an object from a DXF drawing: outline, places and lines from its layers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.length_units import known_unit
from assistant.program.geometry import Pose
from assistant.program.motion import Kind
from assistant.program.program import TakenNames, identifier
from assistant.program.settings_tables import listed, shown
from assistant.sources.contours.chains import Contour, chain_curves
from assistant.sources.contours.curves import polyline
from assistant.sources.contours.moves import as_pieces, contour_moves
from assistant.sources.drawing import Contents, read_contents
from assistant.sources.drawing.program import name_locations
from assistant.sources.process import NO_PROCESS
from assistant.vision.recognition.known_objects import KnownObject, Line, Outline, Place
from assistant.vision.recognition.outline_edges import symmetry_of
from assistant.vision.recognition.photo import signed_area
from assistant.vision.rules import (
    AMBIGUOUS_LAYER,
    BAD_OUTLINE,
    NO_LAYER,
    NO_OUTLINE,
    SYMMETRIC_OUTLINE,
)

_CHORD_TOLERANCE: Final = 0.02
"""mm that chords stand for arcs and free curves by, and over which ends are joined."""
_LEVEL_TOLERANCE: Final = 0.01
"""mm that an outline may be off a level plane."""
_SMALLEST_OUTLINE: Final = 2.0
"""mm of the longer side of an outline."""


@dataclass(frozen=True, slots=True)
class DrawnObject:
    """object: in the frame of the drawing, z 0 in the plane of its outline."""

    object: KnownObject
    findings: tuple[Diagnostic, ...]


def read_part(
    path: str | FilePath,
    name: str,
    *,
    contour: str | None = None,
    lines: Sequence[str] = (),
    height: float = 0.0,
    unit: str | None = None,
) -> DrawnObject:
    """The part of a drawing, as it is seen by who looks along -z.

    contour: the layer of its outline and holes; without one, the only one with closed contours.
    lines: layers whose curves are ways on the part. Points and blocks are places. unit: of the
    drawing, whatever it says. Raises Unreadable or Refused.
    """
    given = str(path)
    # Layers are named by the options here, whatever their names mean.
    process = replace(NO_PROCESS, follow=("*",))
    if unit is not None:
        process = replace(process, unit=known_unit(unit))
    contents = read_contents(FilePath(path), process)
    chained, joined = chain_curves(contents.curves, _CHORD_TOLERANCE * 2.5, path=given)
    if has_errors((*contents.findings, *joined)):
        raise Refused(*contents.findings, *joined)
    ways = _lines_of_layers(chained, lines, given)
    outline, level = _outline(_outline_contours(chained, contour, lines, given), given)
    places, found = _places(contents, level, given)
    known = KnownObject(
        *(name, outline, None, height, symmetry_of(outline)),
        places=places,
        lines={key: _lowered(line, level) for key, line in ways.items()},
        source=f"from {FilePath(path).name}",
    )
    told = [*contents.findings, *joined, *found, *_symmetry_findings(known, given)]
    return DrawnObject(known, tuple(told))


def _symmetry_findings(known: KnownObject, path: str) -> list[Diagnostic]:
    """Return findings about an outline that looks the same after a turn."""
    if known.symmetry == 1:
        return []
    how = f"by {360.0 / known.symmetry:g} degrees" if known.symmetry else "by any angle"
    return [SYMMETRIC_OUTLINE(path=path, name=known.name, how=how)]


def _outline_contours(
    chained: Sequence[Contour], contour: str | None, lines: Sequence[str], path: str
) -> list[Contour]:
    """The closed contours of the outline's layer."""
    taken = {one.casefold() for one in lines}
    layers: dict[str, list[Contour]] = {}
    for one in chained:
        if one.closed and one.layer.casefold() not in taken:
            layers.setdefault(one.layer.casefold(), []).append(one)
    names = listed([shown(group[0].layer) for group in layers.values()])
    if contour is None:
        if len(layers) > 1:
            raise Refused(AMBIGUOUS_LAYER(path=path, names=names), exit_status=2)
        if not layers:
            raise Refused(NO_OUTLINE(path=path, where="in the drawing", names=names))
        return next(iter(layers.values()))
    if contour.casefold() not in layers:
        where = f"on layer `{shown(contour)}`"
        raise Refused(NO_OUTLINE(path=path, where=where, names=names), exit_status=2)
    return layers[contour.casefold()]


def _outline(contours: Sequence[Contour], path: str) -> tuple[Outline, float]:
    """The rings of an outline, and the height that they are drawn at."""
    from shapely.geometry import Polygon

    rings: list[Floats] = []
    heights: list[float] = []
    for one in contours:
        pieces = as_pieces(one, _CHORD_TOLERANCE).pieces
        if not pieces:
            raise _bad_outline(path, "cannot be followed", "draw it with lines, arcs and splines")
        heights += [z for piece in pieces for z in (piece.start[2], piece.end[2])]
        rings.append(polyline(pieces, _CHORD_TOLERANCE, closed=True))
    if np.ptp(heights) > _LEVEL_TOLERANCE:
        raise _bad_outline(
            path, f"is not flat: z differs by {np.ptp(heights):.3g} mm", "draw it in one z"
        )
    rings.sort(key=lambda ring: -abs(signed_area(ring)))
    outer = Polygon(rings[0])
    if not outer.is_valid:
        raise _bad_outline(path, "crosses itself", "mend it in the drawing")
    if max(np.ptp(rings[0], axis=0)) < _SMALLEST_OUTLINE:
        raise _bad_outline(
            path, f"is smaller than {_SMALLEST_OUTLINE:g} mm", "look at the unit of the drawing"
        )
    for ring in rings[1:]:
        hole = Polygon(ring)
        if not hole.is_valid or not outer.contains(hole):
            raise _bad_outline(
                path, "is not the only one: there is another contour beside it",
                "give each part a drawing, or a layer that --contour names",
            )  # fmt: skip
    turned = [ring if (signed_area(ring) > 0.0) == (i == 0) else ring[::-1].copy()
              for i, ring in enumerate(rings)]  # fmt: skip
    return Outline(tuple(turned)), float(np.mean(heights))


def _bad_outline(path: str, what: str, cure: str) -> Refused:
    return Refused(BAD_OUTLINE(path=path, what=what, cure=cure))


def _lines_of_layers(
    chained: Sequence[Contour], lines: Sequence[str], path: str
) -> dict[str, Line]:
    """Lines by the names of their layers, numbered where a layer has several."""
    found: dict[str, Line] = {}
    taken = TakenNames()
    known = {one.layer.casefold(): one.layer for one in chained}
    for layer in lines:
        group = [one for one in chained if one.layer.casefold() == layer.casefold()]
        if not group:
            names = listed([shown(name) for name in known.values()])
            raise Refused(NO_LAYER(path=path, name=shown(layer), names=names), exit_status=2)
        for number, one in enumerate(group, 1):
            stem = layer.lower() if len(group) == 1 else f"{layer.lower()}_{number}"
            name = identifier(stem, taken)
            taken.add(name)
            rows = contour_moves(one, _CHORD_TOLERANCE)
            vias = np.nonzero(rows.kinds == Kind.VIA)[0] + 1
            points = np.vstack([rows.start, rows.positions])
            found[name] = Line(points, frozenset(int(v) for v in vias))
    return found


def _lowered(line: Line, level: float) -> Line:
    return replace(line, points=line.points - np.array([0.0, 0.0, level]))


def _places(
    contents: Contents, level: float, path: str
) -> tuple[dict[str, Place], list[Diagnostic]]:
    """Locations of the drawing, in the plane of the outline."""
    names = name_locations(contents.locations, TakenNames(), path)
    places = {}
    for name, location in zip(names.names, contents.locations, strict=True):
        x, y, z = location.pose.position
        turn = rotations.canonical(np.array(location.pose.quaternion))
        places[name] = Place(Pose.of(np.array([x, y, z - level]), turn))
    return places, list(names.findings)
