"""List the contours of a drawing for people who choose among them.

Each has its shape in words, its numbers in the picture of the order (`check --plot`), a point that
names it under `leave_out`, and the entries there that leave it out.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

from assistant.base.data_classes import dataclass
from assistant.sources.contours.chains import Contour
from assistant.sources.contours.contour_choice import ContourChoice, Row
from assistant.sources.process import LeftOut, Process


@dataclass(frozen=True, slots=True)
class ListedContour:
    """A contour of a layer that is followed.

    at: point that names it under `leave_out`, mm in the drawing's world; None if no point names it
    alone. text: its shape in words. numbers: in the picture of the order, one for each pass.
    left_by: entries of `leave_out` that leave it out.
    """

    contour: Contour
    at: tuple[float, float] | None
    text: str
    numbers: tuple[int, ...]
    left_by: tuple[LeftOut, ...]


def listed_contours(
    choice: ContourChoice, order: Sequence[Row], process: Process
) -> Iterator[ListedContour]:
    """Yield the contours of a drawing by layers, also those that `leave_out` of its process names.

    order: of the contours in the program, empty if it is not known.
    """
    numbers = defaultdict[Row, list[int]](list)
    for number, row in enumerate(order, start=1):
        numbers[row].append(number)
    rows = [row for row, _ in choice.rows()]
    # A contour that is left out makes no other one a hole: those are named as if it were missing.
    kept = choice.shapes(process, [row for row in rows if row not in choice.left])
    shapes = choice.shapes(process, rows) if choice.left else kept
    for row, contour in choice.rows():
        shape = kept.get(row) or shapes[row]
        text = shape.text if shape.kind else f"line {shape.text}"
        left_by = tuple(choice.left.get(row, ()))
        yield ListedContour(contour, choice.naming_point(row), text, tuple(numbers[row]), left_by)
