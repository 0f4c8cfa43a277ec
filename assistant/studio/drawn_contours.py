"""Contours of a drawing for the page, on which a click leaves one out or takes it back.

A point on its line identifies a contour, as `leave_out` of the process file names it, so that a
page that is older than the file changes no other one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.budgets import CONTOURS, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.program.settings_tables import Wrong
from assistant.sources.contours.contour_choice import ContourChoice, Row
from assistant.sources.contours.contour_listing import ListedContour, listed_contours
from assistant.sources.contours.curves import Curve, chorded, sample
from assistant.sources.contours.layer_program import contour_choice, contour_program
from assistant.sources.drawing import read_contents
from assistant.sources.drawing.contents import Contents
from assistant.sources.process import LeftOut, Process, read_left_out
from assistant.studio.route_answers import Question, not_asked

_MOST_DRAWN_POINTS: Final = 20_000
"""Most points in the picture of a drawing."""
_MOST_ORDERED: Final = 3_000
"""Curves over which contours are listed without their numbers in the order."""
_CHORD_SHARE: Final = 0.0002
"""Deviation of chords in the picture by the size of the drawing; nobody sees it."""


@dataclass(frozen=True, slots=True)
class DrawnContours:
    """Contours of the layers that are followed, and the other curves of a drawing.

    views: groups of contours that may be views of a part, each with its size and its contours.
    """

    contours: tuple[ListedContour, ...]
    others: tuple[Curve, ...]
    process: Process
    views: tuple[dict[str, Any], ...] = ()

    @staticmethod
    def of(drawing: FilePath, process: Process) -> DrawnContours:
        """Return the contours of a drawing; none if no program can be made of them."""
        contents = read_contents(drawing, process)
        contours: tuple[ListedContour, ...] = ()
        views: tuple[dict[str, Any], ...] = ()
        try:
            with within(CONTOURS, str(drawing), len(contents.curves)):
                choice, order = _choice_and_order(contents, process)
                contours = tuple(listed_contours(choice, order, process))
                views = tuple(_view_records(choice))
        except Refused:
            pass
        layers = {one.contour.layer.casefold() for one in contours}
        curves = [one for one in contents.curves if one.layer.casefold() not in layers]
        return DrawnContours(contours, (*curves, *contents.aside), process, views)

    def records(self, *, numbered: bool) -> dict[str, Any]:
        """Return contours and lines for the page; a line of a contour has its index in the list."""
        return {
            "contours": [
                {
                    "layer": one.contour.layer,
                    "at": one.at,
                    "what": one.text,
                    "numbers": list(one.numbers) if numbered else [],
                    "left": bool(one.left_by),
                }
                for one in self.contours
            ],
            "lines": list(self._lines()),
            "views": list(self.views),
        }

    def _lines(self) -> Iterator[dict[str, Any]]:
        """Yield curves from above, in mm of the drawing, up to a number of points."""
        rows = [*(one.contour.curves for one in self.contours), *((one,) for one in self.others)]
        if not rows:
            return
        curves = [curve for row in rows for curve in row]
        size = np.ptp(sample(curves, (0.0, 0.3, 0.6, 1.0))[..., :2], axis=(0, 1)).max()
        off = max(float(size) * _CHORD_SHARE, self.process.tolerance)
        room = _MOST_DRAWN_POINTS
        for place, row in enumerate(rows):
            points = self._seen(np.concatenate([chorded(curve, off) for curve in row]))
            room -= len(points)
            if room < 0:
                return
            line = {"layer": row[0].layer, "points": np.round(points, 3).tolist()}
            yield line | ({"contour": place} if place < len(self.contours) else {})

    def _seen(self, points: Floats) -> Floats:
        placement = self.process.placement
        return (points if placement is None else placement.inverse().moved(points))[:, :2]


def _choice_and_order(
    contents: Contents, process: Process
) -> tuple[ContourChoice, tuple[Row, ...]]:
    """Return the choice of contours and their order, which is empty for a large drawing."""
    curves, marks, texts = contents.curves, contents.marks, contents.texts
    if len(curves) > _MOST_ORDERED:
        return contour_choice(curves, process, marks, texts), ()
    made = contour_program(curves, process, taken=set(), marks=marks, texts=texts)
    return made.choice, made.order


def _view_records(choice: ContourChoice) -> Iterator[dict[str, Any]]:
    places = {row: place for place, (row, _) in enumerate(choice.rows())}
    for one in choice.views():
        size = [round(float(side), 1) for side in one.size]
        yield {"size": size, "contours": sorted(places[row] for row in one.rows)}


def with_choices(entries: Sequence[Any], drawn: DrawnContours, choices: Any) -> list[Any]:
    """Return the entries of `leave_out` after contours were left out or taken back.

    choices: of the page, `{"layer": …, "at": [x, y], "used": …}`. If a contour of a group is taken
    back, entries for the other ones replace that of the group. Raises Refused for a choice that is
    not a contour of the drawing.
    """
    entries = list(entries)
    known = {(one.contour.layer.casefold(), one.at): one for one in drawn.contours if one.at}
    chosen = [_read_choice(one) for one in choices] if isinstance(choices, list) else []
    back = {(layer, at) for layer, at, used in chosen if used}
    for layer, at, used in chosen:
        one = known.get((layer, at))
        if one is None:
            raise not_asked("`contours` has one that is not in the drawing")
        if not used and not one.left_by:
            entries.append(_entry(one))
        for entry in one.left_by if used else ():
            held = [i for i, text in enumerate(entries) if _is_entry(text, entry)]
            for i in reversed(held):
                del entries[i]
            if held and entry.group is not None:
                entries += [
                    _entry(other)
                    for key, other in known.items()
                    if entry in other.left_by and key not in back
                ]
    return entries


def _read_choice(value: Any) -> tuple[str, tuple[float, float], bool]:
    asked = Question(value if isinstance(value, dict) else {})
    at = asked.values.get("at")
    if not isinstance(at, list) or len(at) != 2:
        raise not_asked("`at` is no point")
    x, y = (Question({"at": one}).number("at") for one in at)
    return asked.text("layer").casefold(), (x, y), asked.truth("used")


def _entry(one: ListedContour) -> dict[str, Any]:
    return {"layer": one.contour.layer, "at": list(one.at or ())}


def _is_entry(value: Any, entry: LeftOut) -> bool:
    return left_out_entries([value]) == (entry,)


def left_out_entries(values: Sequence[Any]) -> tuple[LeftOut, ...]:
    """Return the entries of `leave_out` that are valid tables."""
    found: list[LeftOut] = []
    for value in values:
        try:
            found += [one for one in read_left_out([value]) if isinstance(one, LeftOut)]
        except Wrong:
            continue
    return tuple(found)
