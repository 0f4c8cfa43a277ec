"""Contours in the order that a drawing states: as drawn, or by the numbers beside them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, error, warning
from assistant.program.geometry import Vector
from assistant.program.settings_tables import shown
from assistant.sources.contours.chaining import Contour
from assistant.sources.contours.curves import Line, sample
from assistant.sources.contours.ordering import FREE_CONTOUR, ContourOrder, travel_length

HOLDER_FIRST = warning(
    "CT224",
    "{count} contours of layer {layer!r} come before others that lie inside them; what is cut out"
    " falls before its holes are done",
    "number or draw the inner ones first, or say inside_first = false",
)
NO_NUMBER = warning(
    "CT225",
    "{count} of {all} contours of layer {layer!r} have no number beside them and come last, in the"
    " order of drawing",
    "write a text with a whole number beside each, on that layer",
)
TWO_NUMBERS = error(
    "CT226",
    "the numbers {one} and {other} on layer {layer!r} stand beside the same contour",
    "move each text to its own contour: the nearest one to its insertion point",
)
SAME_NUMBER = error(
    "CT227",
    "the number {one} stands beside two contours of layer {layer!r}",
    "give each contour a number of its own",
)
NUMBER_BETWEEN_CONTOURS = error(
    "CT228",
    "the number {one} on layer {layer!r} stands as near to one contour as to another",
    "move it nearer to its own one",
)

NUMBER_TEXT: Final = re.compile(r"[#(\s]*(\d{1,9})[.):\s]*")
"""A text that numbers a contour: `3`, `3.`, `(3)`, `#3`."""
LEAST_DISTANCE_GAP: Final = 0.1
"""mm by which the nearest contour has to be nearer than the next one."""
OUTLINE_CHORDS: Final = 64
"""Of each curve that is no line, to which a text's distance is measured."""


@dataclass(frozen=True, slots=True)
class LayerText:
    """A text on a drawing's layer. at: its insertion point, mm in the drawing's world."""

    text: str
    at: Vector
    layer: str
    handle: str = ""

    @property
    def number(self) -> int | None:
        """What it numbers a contour by, None for a text that is no number."""
        found = NUMBER_TEXT.fullmatch(self.text)
        return None if found is None else int(found[1])


OrderFindings = tuple[Diagnostic, ...]


def stated_order(
    contours: Sequence[Contour],
    drawn: Sequence[Contour],
    holders: Sequence[int],
    order: Literal["drawing", "text"],
    texts: Sequence[LayerText] = (),
) -> tuple[ContourOrder, OrderFindings]:
    """The contours as the drawing has them: none is turned, or started elsewhere.

    drawn: what each of them was, beside which the texts stand.
    holders: for each contour the one that it lies in, or -1; none: nobody minds. texts: those of
    the layer.
    """
    rows, findings = list(range(len(contours))), list[Diagnostic]()
    if order == "text":
        numbers, findings = _numbers_of_contours(drawn, texts)
        rows.sort(key=lambda i: (numbers.get(i, math.inf), i))
    place = {row: at for at, row in enumerate(rows)}
    early = {h for i, h in enumerate(holders) if h != FREE_CONTOUR and place[h] < place[i]}
    if early:
        findings.append(HOLDER_FIRST(count=len(early), layer=shown(contours[0].layer)))
    made = tuple(contours[row] for row in rows)
    return ContourOrder(made, travel_length(contours), travel_length(made)), tuple(findings)


def _numbers_of_contours(
    contours: Sequence[Contour], texts: Sequence[LayerText]
) -> tuple[dict[int, int], list[Diagnostic]]:
    """The number of each contour that has one, and what is wrong."""
    findings: list[Diagnostic] = []
    layer = shown(contours[0].layer)
    numbers: dict[int, int] = {}
    outlines = [_sampled_outline(contour) for contour in contours]
    for one in texts:
        if (number := one.number) is None:
            continue
        place = f"entity {one.handle}" if one.handle else None
        apart = np.array([_distance_to_outline(one.at, outline) for outline in outlines])
        nearest = int(apart.argmin())
        if (
            np.partition(apart, 1)[1] - apart[nearest] < LEAST_DISTANCE_GAP
            if len(apart) > 1
            else False
        ):
            findings.append(NUMBER_BETWEEN_CONTOURS(place=place, layer=layer, one=number))
        elif nearest in numbers:
            findings.append(
                TWO_NUMBERS(place=place, layer=layer, one=numbers[nearest], other=number)
            )
        elif number in numbers.values():
            findings.append(SAME_NUMBER(place=place, layer=layer, one=number))
        else:
            numbers[nearest] = number
    if without := len(contours) - len(numbers):
        findings.append(NO_NUMBER(layer=layer, count=without, all=len(contours)))
    return numbers, findings


def _sampled_outline(contour: Contour) -> Floats:
    """Points (n, 3) of a line along it."""
    points = []
    for curve in contour.curves:
        count = 2 if isinstance(curve, Line) else OUTLINE_CHORDS + 1
        points.append(sample([curve], np.linspace(0.0, 1.0, count))[0])
    return np.concatenate(points)


def _distance_to_outline(at: Vector, outline: Floats) -> float:
    """Mm from a point to a line through points (n, 3)."""
    first, step = outline[:-1], np.diff(outline, axis=0)
    size = (step**2).sum(axis=1)
    to = np.asarray(at) - first
    part = np.clip((to * step).sum(axis=1) / np.where(size > 0.0, size, 1.0), 0.0, 1.0)
    return float(np.linalg.norm(to - part[:, None] * step, axis=1).min())
