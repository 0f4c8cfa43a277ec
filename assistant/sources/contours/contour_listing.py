"""Contours of a drawing as people choose among them: what they are, their numbers, what drops them.

Numbers are those of the pictures of the order (`check --plot`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

from assistant.base.data_classes import dataclass
from assistant.sources.contours.chains import Contour
from assistant.sources.contours.contour_choice import ContourChoice, Row
from assistant.sources.contours.contour_order import group_nestings
from assistant.sources.contours.contour_shapes import ContourShape, contour_shapes
from assistant.sources.process import DEFAULT_MOTION, Layer, LeftOut, Process


@dataclass(frozen=True, slots=True)
class ListedContour:
    """A contour of a layer that is followed.

    at: mm in the drawing's world, what names it under `leave_out`; None if nothing does. text: what
    it is. numbers: in the picture of the order, one for each pass. left_by: entries of `leave_out`
    that drop it.
    """

    contour: Contour
    at: tuple[float, float] | None
    text: str
    numbers: tuple[int, ...]
    left_by: tuple[LeftOut, ...]


def listed_contours(
    choice: ContourChoice, order: Sequence[Row], process: Process
) -> Iterator[ListedContour]:
    """The contours of a program by layers, with those that `leave_out` of its process drops.

    order: of the program, empty if it is not known.
    """
    numbers = defaultdict[Row, list[int]](list)
    for number, row in enumerate(order, start=1):
        numbers[row].append(number)
    rows = [row for row, _ in choice.rows()]
    # What is left out is around nothing, so that the others are named without it.
    kept = _shapes(choice, process, [row for row in rows if row not in choice.left])
    shapes = _shapes(choice, process, rows) if choice.left else kept
    for row, contour in choice.rows():
        shape = kept.get(row) or shapes[row]
        text = shape.text if shape.kind else f"line {shape.text}"
        left_by = tuple(choice.left.get(row, ()))
        yield ListedContour(contour, choice.naming_point(row), text, tuple(numbers[row]), left_by)


def _shapes(
    choice: ContourChoice, process: Process, rows: Sequence[Row]
) -> dict[Row, ContourShape]:
    known = {name.casefold(): layer for name, layer in process.layers.items()}
    usual = Layer("", DEFAULT_MOTION.motion)
    groups = []
    for contours in choice.layers:
        layer = known.get(contours[0].layer.casefold(), usual)
        groups.append((process.placed(layer.direction), list[Contour]()))
    for i, k in rows:
        groups[i][1].append(choice.layers[i][k])
    by_layer = [
        iter(contour_shapes(contours, nesting, direction, process.placement, process.tolerance))
        for (direction, contours), nesting in zip(
            groups, group_nestings(groups, process.tolerance), strict=True
        )
    ]
    return {row: next(by_layer[row[0]]) for row in rows}
