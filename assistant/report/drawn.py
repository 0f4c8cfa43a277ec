"""The lines of a drawing, as they stand before the robot that follows them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant.base.arrays import Floats
from assistant.base.length_units import known_unit
from assistant.program.geometry import BASE, Frame
from assistant.sources import process_of

if TYPE_CHECKING:
    from assistant.sources.process.placement import DrawingPlacement

DRAWING_SUFFIX: Final = ".dxf"


@dataclass(frozen=True, slots=True, eq=False)
class DrawnLine:
    """A curve of a drawing as points (n, 3) mm in the robot's base. layer: that it is on.

    handle: of its entity, empty if it has none.
    """

    layer: str
    points: Floats
    handle: str = ""


def drawn_lines(
    source: str | FilePath,
    process: str | FilePath | None = None,
    unit: str | None = None,
    placement: DrawingPlacement | None = None,
) -> list[DrawnLine]:
    """The curves of a drawing in order; nothing for other sources, and for a drawing whose frame
    the robot or something else carries.

    process, unit, placement: as for reading the drawing as a program. Raises Unreadable or Refused
    as that.
    """
    path = FilePath(source)
    if path.suffix.lower() != DRAWING_SUFFIX:
        return []
    from assistant.sources.contours.curves import chorded
    from assistant.sources.drawing import read_contents

    chosen = process_of(path, process)
    if unit is not None:
        chosen = replace(chosen, unit=known_unit(unit))
    if placement is not None:
        chosen = replace(chosen, placement=placement.pose)
    name = chosen.defaults.frame
    frame = Frame() if name == BASE else chosen.frames.get(name)
    if frame is None or frame.held or frame.mechanism:
        return []
    found = []
    for curve in read_contents(path, chosen).curves:
        points = chorded(curve, chosen.tolerance)
        found.append(DrawnLine(curve.layer, frame.pose.moved(points), curve.handle or ""))
    return found
