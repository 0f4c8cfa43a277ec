"""Find layers of dimensions with loose extension lines: drafting that no name tells.

Who draws extension lines by hand, to dimension corners that are cut off, draws them on the layer of
the dimensions. Such a layer holds dimensions and no more lines than these, no end of which meets
another one, and each runs along an extension line of a dimension. If each also goes a little beyond
a point of it, as extension lines do, the lines are drafting. A seam begins and ends where it is
dimensioned, so lines that end at such points may be work: the user is asked.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass

if TYPE_CHECKING:
    from ezdxf.entities.dxfgfx import DXFGraphic

_MOST_LINES: Final = 200
"""Lines over which a layer is no layer of dimensions."""
_NEAR_PART: Final = 0.002
"""Part of a line's length within which a point is on it, and ends of two lines meet."""
_PARALLEL: Final = 0.002
"""Sine of the angle between parallel directions, at most."""
_BEYOND: Final = (0.01, 0.1)
"""Parts of its length by which an extension line goes beyond a point, at least and at most."""
_LINEAR: Final = (0, 1)
"""Types of dimensions with extension lines that are parallel: rotated and aligned ones."""
_NOT_CURVES: Final = frozenset({"TEXT", "MTEXT", "LEADER", "MULTILEADER", "POINT", "TOLERANCE"})


@dataclass(frozen=True, slots=True)
class ExtensionLines:
    """Lines on a layer of dimensions. handles: of them. dimensions: on that layer. sure: they are
    drafting; they may be work without it.
    """

    layer: str
    handles: frozenset[str]
    dimensions: int
    sure: bool


def find_extension_lines(entities: Iterable[DXFGraphic]) -> Iterator[ExtensionLines]:
    """Yield the layers whose lines are, or may be, extension lines of their dimensions.

    entities: of the model space. What is in blocks does not count.
    """
    by_layer: dict[str, list[Any]] = defaultdict(list)
    dimensions: dict[str, list[Any]] = defaultdict(list)
    for one in entities:
        kind = one.dxftype()
        if not one.dxf.is_supported("layer"):
            continue  # of a type that is only stored, and never followed
        layer = str(one.dxf.get("layer", "0")).casefold()
        if kind == "DIMENSION":
            dimensions[layer].append(one)
        elif kind not in _NOT_CURVES:
            by_layer[layer].append(one)
    for layer, there in dimensions.items():
        lines = by_layer[layer]
        most = min(len(there), _MOST_LINES)
        if not 0 < len(lines) <= most or any(one.dxftype() != "LINE" for one in lines):
            continue
        ends = np.array([(one.dxf.start.xyz[:2], one.dxf.end.xyz[:2]) for one in lines])
        points, directions = _extensions(there)
        if not len(points) or not np.isfinite(ends).all() or _meet(ends):
            continue
        along, beyond = _runs_along(ends, points, directions)
        if along.all() or beyond.any():
            handles = frozenset(str(one.dxf.handle) for one in lines)
            name = str(cast("Any", lines[0]).dxf.layer)
            yield ExtensionLines(name, handles, len(there), bool(beyond.all()))


def _extensions(dimensions: Iterable[Any]) -> tuple[Floats, Floats]:
    """Return points (n, 2) on the extension lines of dimensions, and the unit directions (n, 2) of
    these.
    """
    points, directions = [], []
    for one in dimensions:
        if one.dimtype not in _LINEAR:
            continue
        names = ("defpoint", "defpoint2", "defpoint3")
        stated = [one.dxf.get(name) for name in names]
        if any(point is None for point in stated):
            continue
        foot, first, second = (np.array(point.xyz[:2]) for point in stated)
        if one.dimtype == 1:
            measured = second - first
        else:
            turn = np.radians(one.dxf.get("angle", 0.0))
            measured = np.array([np.cos(turn), np.sin(turn)])
        size = float(np.linalg.norm(measured))
        if not size > 0.0:
            continue
        out = np.array([-measured[1], measured[0]]) / size
        # The dimension line runs through `foot`; the extension lines go from both points to it.
        ends = [point + out * ((foot - point) @ out) for point in (first, second)]
        points += [first, second, *ends]
        directions += [out] * 4
    return np.array(points).reshape(-1, 2), np.array(directions).reshape(-1, 2)


def _meet(ends: Floats) -> bool:
    """True if an end of one of the lines (n, 2, 2) is on another one's end, or a line is a point.

    They are joined to a path then.
    """
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    if not (lengths > 0.0).all():
        return True
    near = _NEAR_PART * float(lengths.min())
    flat = ends.reshape(-1, 2)
    gaps = np.linalg.norm(flat[:, None] - flat[None], axis=2)
    np.fill_diagonal(gaps, np.inf)
    return bool(gaps.min() <= near)


def _runs_along(ends: Floats, points: Floats, directions: Floats) -> tuple[Floats, Floats]:
    """Return two flags for each line (n, 2, 2): True if it runs along an extension line, and if it
    also goes a little beyond one of its points.
    """
    way = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(way, axis=1)
    unit = way / length[:, None]
    from_start = points[None] - ends[:, :1]
    at = np.einsum("nmc,nc->nm", from_start, unit) / length[:, None]
    cross = from_start[..., 0] * unit[:, None, 1] - from_start[..., 1] * unit[:, None, 0]
    outs = np.stack([directions[:, 1], -directions[:, 0]])
    near = (np.abs(cross) <= _NEAR_PART * length[:, None]) & (np.abs(unit @ outs) <= _PARALLEL)
    on = near & (at >= -_NEAR_PART) & (at <= 1.0 + _NEAR_PART)
    rest = np.minimum(at, 1.0 - at)
    beyond = on & (rest >= _BEYOND[0]) & (rest <= _BEYOND[1])
    return on.any(axis=1), beyond.any(axis=1)
