"""A picture of contours: as drawn, as the tool follows them, and where findings are.

Also the lines of a drawing as points (n, 3) mm in the robot's base, for pages that show them.
"""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Severity
from assistant.base.length_units import known_unit
from assistant.base.source_text import visible
from assistant.program.geometry import BASE, IDENTITY, Frame, Pose
from assistant.program.program import Program, walk
from assistant.program.statements import Follow, Move
from assistant.report.figures import new_figure, picture
from assistant.report.track import Way, ways
from assistant.sources import process_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from assistant.sources.process.placement import DrawingPlacement


_DRAWING_SUFFIX: Final = ".dxf"


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
    if path.suffix.lower() != _DRAWING_SUFFIX:
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
    contents = read_contents(path, chosen)
    for curve in (*contents.curves, *contents.aside):
        points = chorded(curve, chosen.tolerance)
        found.append(DrawnLine(curve.layer, frame.pose.moved(points), curve.handle or ""))
    return found


_PICTURE_INCHES: Final = 8.0
"""Inches of the picture of one program."""
_MOST_NUMBERED: Final = 400
"""Contours over which a picture has no numbers: nobody could read them."""
_ENTITY_MARK: Final = re.compile(r"\bentity (\w+)")
_SEVERITY_COLOURS: Final = {Severity.ERROR: "#c62828", Severity.WARNING: "#ef6c00"}


@dataclass(frozen=True, slots=True)
class Drawing:
    """program: None where none could be made. drawn: the lines of its source. found: what of it."""

    title: str
    program: Program | None
    drawn: Sequence[DrawnLine]
    found: Sequence[Diagnostic]


def contour_plot(drawings: Sequence[Drawing], format: str) -> bytes:
    """A picture with a part for each program, as seen along z of the frame that it is drawn in.

    format: `png` or `svg`. Raises Refused without matplotlib.
    """
    columns = math.ceil(math.sqrt(len(drawings)))
    rows = math.ceil(len(drawings) / columns)
    sheet = new_figure(_PICTURE_INCHES * columns, _PICTURE_INCHES * rows)
    for place, drawing in enumerate(drawings, start=1):
        _draw_program(sheet.add_subplot(rows, columns, place), drawing)
    return picture(sheet, format)


def _draw_program(axes: Axes, drawing: Drawing) -> None:
    name, frame = _common_frame(drawing.program)
    back = frame.inverse()
    for line in drawing.drawn:
        axes.plot(*back.moved(line.points).T[:2], color="0.25", linewidth=1.4)
    found = [] if drawing.program is None else list(ways(drawing.program))
    travel = [back.moved(way.positions) for way in found if way.name is None]
    for points in travel:
        axes.plot(*points.T[:2], color="C1", linestyle=":", linewidth=0.8)
    followed = [Way(way.name, back.moved(way.positions)) for way in found if way.name is not None]
    numbers: dict[tuple[float, float], list[int]] = defaultdict(list)
    for number, way in enumerate(followed, start=1):
        axes.plot(*way.positions.T[:2], color="C0", linewidth=1.0)
        _draw_arrow(axes, way.positions)
        x, y = way.positions[0, :2].round(1).tolist()
        numbers[x, y].append(number)
    for (x, y), those in numbers.items():
        axes.plot(x, y, marker="o", markersize=3, color="C0")
        if len(followed) <= _MOST_NUMBERED:
            said = f"{those[0]}" if len(those) == 1 else f"{those[0]}–{those[-1]}"
            axes.annotate(said, (x, y), (3, 3), textcoords="offset points", color="C0", fontsize=8)
    _mark_findings(axes, drawing, back)
    where = "the robot's base" if name == BASE else name
    axes.set(
        aspect="equal",
        title=visible(drawing.title).replace("$", r"\$"),
        xlabel=f"x in {where}, mm",
        ylabel="y, mm",
    )


def _draw_arrow(axes: Axes, points: Floats) -> None:
    """An arrow in the middle of a way, where it shows its direction."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    if way[-1] <= 0.0:
        return
    ends = np.array([0.5, 0.502]) * way[-1]
    x, y = (np.interp(ends, way, column).tolist() for column in points.T[:2])
    style = {"arrowstyle": "-|>", "color": "C0"}
    axes.annotate("", (x[1], y[1]), (x[0], y[0]), arrowprops=style)


def _mark_findings(axes: Axes, drawing: Drawing, back: Pose) -> None:
    """Write the codes of findings next to the entities that they are about."""
    lines = {line.handle: line for line in drawing.drawn if line.handle}
    for one in drawing.found:
        colour = _SEVERITY_COLOURS.get(one.severity)
        for handle in _ENTITY_MARK.findall(one.place or "") if colour else ():
            if handle in lines:
                points = back.moved(lines[handle].points)
                x, y = points[len(points) // 2, :2].tolist()
                axes.plot(x, y, marker="x", color=colour)
                axes.annotate(
                    one.code, (x, y), (4, -8), textcoords="offset points", color=colour, fontsize=7
                )


def _common_frame(program: Program | None) -> tuple[str, Pose]:
    """The frame that the first contour or target is in, that stands still."""
    for procedure in program.procedures if program else ():
        for statement in walk(procedure.body):
            name = None
            if isinstance(statement, Follow) and statement.path.frames:
                name = statement.path.frames[0]
            elif isinstance(statement, Move):
                name = statement.motion.frame
            if name is not None and program is not None:
                frame = program.frames.get(name)
                return (
                    (name, frame.pose) if frame is not None and name != BASE else (BASE, IDENTITY)
                )
    return BASE, IDENTITY
