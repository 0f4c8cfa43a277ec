"""A picture of contours: as drawn, as the tool follows them, and where findings are.

What is left out of the work is pale and dashed.

Also the lines of a drawing as points (n, 3) mm in the robot's base, for pages that show them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.base.length_units import known_unit
from assistant.base.source_text import visible
from assistant.program.geometry import BASE, IDENTITY, Pose
from assistant.program.program import Program, walk
from assistant.program.statements import Follow, Move
from assistant.report.figures import new_figure, picture
from assistant.report.label_positions import label_positions
from assistant.report.track import Way, ways
from assistant.sources import process_of

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

    from assistant.sources.contours.curves import Curve
    from assistant.sources.drawing.contents import Contents
    from assistant.sources.process import Process
    from assistant.sources.process.placement import DrawingPlacement


_DRAWING_SUFFIX: Final = ".dxf"


@dataclass(frozen=True, slots=True, eq=False)
class DrawnLine:
    """A curve of a drawing as points (n, 3) mm in the robot's base. layer: that it is on.

    handle: of its entity, empty if it has none. left: True if nothing follows it, as it is drafting
    or left out.
    """

    layer: str
    points: Floats
    handle: str = ""
    left: bool = False


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
    from assistant.sources.drawing import read_contents

    chosen = process_of(path, process)
    if unit is not None:
        chosen = replace(chosen, unit=known_unit(unit))
    if placement is not None:
        chosen = replace(chosen, placement=placement.pose)
    frame = chosen.standing_frame()
    return [] if frame is None else lines_of(read_contents(path, chosen), chosen, frame)


def lines_of(contents: Contents, process: Process, pose: Pose = IDENTITY) -> list[DrawnLine]:
    """Return the curves of a drawing in order, drafting last. pose: of their frame."""
    from assistant.sources.contours.curves import chorded

    left = _left_contours(contents, process)
    found = []
    for number, curve in enumerate((*contents.curves, *contents.aside)):
        aside = number >= len(contents.curves) or process.leaves_out(curve.layer)
        out = aside or (bool(left) and _curve_key(curve) in left)
        points = pose.moved(chorded(curve, process.tolerance))
        found.append(DrawnLine(curve.layer, points, curve.handle or "", out))
    return found


def _left_contours(contents: Contents, process: Process) -> set[_CurveKey]:
    """Return the curves of the single contours that are left out."""
    from assistant.sources.contours.layer_program import contour_choice

    if not process.left_out:
        return set()
    try:
        choice = contour_choice(contents.curves, process, contents.marks, contents.texts)
    except Refused:  # no program is made of them
        return set()
    contours = [choice.layers[layer][place] for layer, place in choice.left]
    return {_curve_key(curve) for contour in contours for curve in contour.curves}


_CurveKey = tuple[str, str | None, frozenset[tuple[float, ...]]]


def _curve_key(curve: Curve) -> _CurveKey:
    """Identify a curve of a drawing, whichever way round it is."""
    from assistant.sources.contours.curves import sample

    ends = sample([curve], (0.0, 1.0))[0].round(3)
    return curve.layer.casefold(), curve.handle, frozenset(map(tuple, ends.tolist()))


_POINTS_PER_INCH: Final = 72.0
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
    parts = [
        (sheet.add_subplot(rows, columns, place), drawing)
        for place, drawing in enumerate(drawings, start=1)
    ]
    starts = [_draw_program(axes, drawing) for axes, drawing in parts]
    shown: dict[str, Artist] = {}
    for axes, _ in parts:
        handles, labels = axes.get_legend_handles_labels()
        shown |= dict(zip(labels, handles, strict=True))
    if shown:
        sheet.legend(
            list(shown.values()), list(shown), loc="outside lower center", ncols=4, fontsize=9
        )
    # Only now the axes have their size, by which numbers find room.
    sheet.draw_without_rendering()
    for (axes, _), each in zip(parts, starts, strict=True):
        _write_numbers(axes, each)
    return picture(sheet, format)


_STYLES: Final[Mapping[str, Mapping[str, Any]]] = {
    "left out": {"color": "0.7", "linestyle": "--", "linewidth": 0.8},
    "drawn work": {"color": "0.25", "linewidth": 1.4},
    "travel": {"color": "C1", "linestyle": ":", "linewidth": 0.8},
    "path of the tool": {"color": "C0", "linewidth": 1.0},
}
"""How kinds of lines are drawn, those first that are below others; by their names in the legend."""
_NUMBER_POINTS: Final = (8.0, 6.0)
"""Typographic points of the digits of numbers: of few, and of more than `_FEW`."""
_FEW: Final = 40
_DIGIT_PART: Final = 0.64
"""Width of a digit by the size of its type."""
_NEAR: Final = 12.0
"""Points up to which a number needs no line to its contour."""


@dataclass(slots=True, eq=False)
class _Start:
    """Start of contours at one point. path: (n, 3) mm of the first of them. numbers: of all."""

    path: Floats
    numbers: list[int]

    @property
    def text(self) -> str:
        first, last = self.numbers[0], self.numbers[-1]
        return f"{first}" if first == last else f"{first}–{last}"


def _draw_program(axes: Axes, drawing: Drawing) -> list[_Start]:
    """Draw all but the numbers; return the points where contours start, which have them."""
    name, frame = _common_frame(drawing.program)
    back = frame.inverse()
    found = [] if drawing.program is None else list(ways(drawing.program))
    followed = [Way(way.name, back.moved(way.positions)) for way in found if way.name is not None]
    lines = {
        "left out": [back.moved(line.points) for line in drawing.drawn if line.left],
        "drawn work": [back.moved(line.points) for line in drawing.drawn if not line.left],
        "travel": [back.moved(way.positions) for way in found if way.name is None],
        "path of the tool": [way.positions for way in followed],
    }
    for kind, style in _STYLES.items():
        for row, points in enumerate(lines[kind]):
            axes.plot(*points.T[:2], label="" if row else kind, **style)
    starts: dict[tuple[float, ...], _Start] = {}
    for number, way in enumerate(followed, start=1):
        _draw_arrow(axes, way.positions)
        key = tuple(way.positions[0, :2].round(1).tolist())
        starts.setdefault(key, _Start(way.positions, [])).numbers.append(number)
    for x, y in starts:
        axes.plot(x, y, marker="o", markersize=3, color="C0")
    _mark_findings(axes, drawing, back)
    where = "the robot's base" if name == BASE else name
    axes.set(
        aspect="equal",
        title=visible(drawing.title).replace("$", r"\$"),
        xlabel=f"x in {where}, mm",
        ylabel="y, mm",
    )
    return list(starts.values()) if len(followed) <= _MOST_NUMBERED else []


def _write_numbers(axes: Axes, starts: Sequence[_Start]) -> None:
    """Write numbers near the points where contours start, where they cover no line."""
    if not starts:
        return
    sheet = axes.get_figure(root=True)
    assert sheet is not None
    scale = _POINTS_PER_INCH / sheet.dpi
    to_points = axes.transData
    homes = [to_points.transform(start.path[:, :2]) * scale for start in starts]
    anchors = np.array([home[0] for home in homes])
    digits = _NUMBER_POINTS[len(starts) > _FEW]
    sizes = np.array([(_DIGIT_PART * digits * len(one.text), 0.8 * digits) for one in starts])
    lines = [to_points.transform(line.get_xydata()) * scale for line in axes.get_lines()]
    low, high = np.array(axes.get_window_extent().get_points()) * scale
    centres = label_positions(anchors, sizes, homes, lines, low, high)
    for start, off in zip(starts, centres - anchors, strict=True):
        far = float(np.linalg.norm(off)) > _NEAR
        pointer = {"arrowstyle": "-", "color": "C0", "linewidth": 0.4, "shrinkA": 0, "shrinkB": 1}
        written = axes.annotate(
            start.text,
            (float(start.path[0, 0]), float(start.path[0, 1])),
            (float(off[0]), float(off[1])),
            textcoords="offset points",
            color="C0",
            fontsize=digits,
            ha="center",
            va="center",
            arrowprops=pointer if far else None,
        )
        written.set_in_layout(False)  # the axes keep the size by which it has its place


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
