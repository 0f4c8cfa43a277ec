"""Shape of a contour in words: what it is for the people who read the program.

A closed contour inside an odd number of other edges is a hole (round), a slot or an opening; any
other one is an outline, or a circle if it is round and holds nothing. One that may be no edge of
the part, such as a bead, is a circle or a closed contour (`work_words`). The size of a round one is
its diameter. Open contours have no shape: the name of their layer says what they are, and their
ends are in the order in which they are given. Sizes and positions are mm in the axes of the
drawing, so that a reader finds the contour there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose, Vector
from assistant.sources.contours.chains import Contour
from assistant.sources.contours.contour_order import GroupNesting, polygon_outline, view_axes
from assistant.sources.contours.curves import Arc, Line, Points

_ROUND_PART: Final = 0.01
"""Part of its radius that a circle of chords may be off its arc: 22 chords or more."""
_FEWEST_CORNERS: Final = 6
_HALF_TURN_TOLERANCE: Final = 1.0
"""Degrees that the ends of a slot may differ from half circles."""
_DECIMALS: Final = 2
"""Decimals of mm of sizes and positions."""


@dataclass(frozen=True, slots=True)
class ContourShape:
    """kind: a word for names, empty of an open contour. text: what the contour is, on one line."""

    kind: str
    text: str


def contour_shapes(
    contours: Sequence[Contour],
    nesting: GroupNesting,
    direction: Vector,
    placement: Pose | None,
    tolerance: float,
) -> list[ContourShape]:
    """Return the shapes of the contours of a layer.

    direction: of the tool. placement: of the drawing, None if it is not placed. tolerance: mm.
    """
    back = (placement or Pose()).inverse()
    return [
        _shape(contour, _Nesting(inside, holds), direction, back, tolerance)
        for contour, inside, holds in zip(contours, nesting.inside, nesting.holds, strict=True)
    ]


@dataclass(frozen=True, slots=True)
class _Nesting:
    """inside: see `GroupNesting`. holds: others lie inside it."""

    inside: bool | None
    holds: bool


def _shape(
    contour: Contour, nesting: _Nesting, direction: Vector, back: Pose, tolerance: float
) -> ContourShape:
    """back: from the default frame into the axes of the drawing."""
    if not contour.closed:
        start, end = (_place(np.array(p), back, tolerance) for p in (contour.start, contour.end))
        return ContourShape("", f"{number_text(contour.length)} mm, from {start} to {end}")
    outline = polygon_outline(contour, tolerance)
    drawn = _in_drawing(outline, back)
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    middle = _place(0.5 * (low + high), Pose(), tolerance)
    if (circle := _circle(outline, direction, tolerance)) is not None:
        centre, radius = circle
        outer = "outline" if nesting.holds and nesting.inside is False else "circle"
        kind = "hole" if nesting.inside else outer
        return ContourShape(
            kind, f"{kind} dia. {number_text(2.0 * radius)} at {_place(centre, back, tolerance)}"
        )
    slot = None if nesting.inside is None else _slot(contour, tolerance)
    if slot is not None:
        return ContourShape(
            "slot", f"slot {number_text(slot[0])} x {number_text(slot[1])} at {middle}"
        )
    # Along the two axes of the drawing in which it is widest.
    size = " x ".join(
        number_text((high - low)[axis]) for axis in sorted(np.argsort(low - high)[:2])
    )
    if nesting.inside is None:
        return ContourShape("closed", f"closed contour {size} at {middle}")
    kind = "opening" if nesting.inside else "outline"
    return ContourShape(kind, f"{kind} {size}" + (f" at {middle}" if nesting.inside else ""))


def _circle(outline: Points, direction: Vector, tolerance: float) -> tuple[Points, float] | None:
    """Centre (3,) and radius of a round outline; None of any other."""
    if len(outline) < _FEWEST_CORNERS:
        return None
    axes = view_axes(direction)
    flat = outline @ axes.T
    mean = flat.mean(axis=0)
    # Circle of least squares: x² + y² = 2 a x + 2 b y + c.
    x, y = (flat - mean).T
    columns = np.stack([2.0 * x, 2.0 * y, np.ones_like(x)], axis=1)
    (a, b, c), *_ = np.linalg.lstsq(columns, x * x + y * y, rcond=None)
    radius = float(np.sqrt(max(c + a * a + b * b, 0.0)))
    centre = mean + np.array([a, b])
    # Middles of chords are on the circle only if the chords are short.
    middles = 0.5 * (flat + np.roll(flat, -1, axis=0))
    off, sagitta = (
        float(np.abs(np.linalg.norm(points - centre, axis=1) - radius).max())
        for points in (flat, middles)
    )
    if radius <= tolerance or off > tolerance or sagitta > max(tolerance, _ROUND_PART * radius):
        return None
    height = outline.mean(axis=0) - mean @ axes
    return np.asarray(centre @ axes + height), radius


def _slot(contour: Contour, tolerance: float) -> tuple[float, float] | None:
    """Length and width of two parallel lines between half circles; None of any other contour."""
    arcs = [curve for curve in contour.curves if isinstance(curve, Arc)]
    lines = [curve for curve in contour.curves if isinstance(curve, Line)]
    if not len(arcs) == len(lines) == 2 == len(contour.curves) - 2:
        return None
    half = all(abs(arc.sweep - 180.0) <= _HALF_TURN_TOLERANCE for arc in arcs)
    if not half or abs(arcs[0].radius - arcs[1].radius) > tolerance:
        return None
    return lines[0].length + 2.0 * arcs[0].radius, 2.0 * arcs[0].radius


def _in_drawing(points: Points, back: Pose) -> Points:
    return rotations.rotate(back.quaternion, points) + back.position


def _place(point: Points, back: Pose, tolerance: float) -> str:
    """A point as it is drawn; its height only where there is one."""
    x, y, z = _in_drawing(point[None], back)[0].tolist()
    return ", ".join(map(number_text, (x, y, z) if abs(z) > tolerance else (x, y)))


def number_text(value: float) -> str:
    """A number as people write it: `6.6`, `200`."""
    said = f"{value:.{_DECIMALS}f}".rstrip("0").rstrip(".")
    return "0" if said == "-0" else said
