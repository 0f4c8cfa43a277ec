"""The picture of a camera with what was found drawn over it."""

from __future__ import annotations

from types import ModuleType
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.vision.cameras.camera import Camera
from assistant.vision.recognition.objects import Line
from assistant.vision.recognition.photo import Picture
from assistant.vision.recognition.seeing import FoundObject, Recognition, face_centre, object_rim

OUTLINE_COLOUR: Final = (80, 220, 80)
AXIS_COLOURS: Final = ((60, 60, 240), (80, 200, 80), (240, 120, 60))
"""Of x, y and z; blue, green, red."""
LINE_COLOUR: Final = (220, 50, 200)
AXIS_LENGTH: Final = 20.0
"""mm of an axis."""
SUBPIXEL_BITS: Final = 4


def draw_found(cv: ModuleType, camera: Camera, picture: Picture, sight: Recognition) -> Picture:
    """Outlines, axes, names and lines; unknown things are left as they are."""
    drawn = picture.copy()
    for one in sight.found:
        for ring in _outline_rings(one):
            _draw_polygon(
                cv, drawn, camera.project(one.pose.moved(ring)), OUTLINE_COLOUR, closed=True
            )
        for line in one.object.lines.values():
            _draw_polygon(
                cv,
                drawn,
                camera.project(one.pose.moved(_line_points(line))),
                LINE_COLOUR,
                closed=False,
            )
        _draw_axes(cv, drawn, camera, one)
        at = camera.project(one.pose.moved(face_centre(one.object)[None]))[0]
        if np.isfinite(at).all():
            u, v = (int(value) for value in at)
            text = f"{one.name} {one.confidence:.2f}"
            for colour, thick in (((0, 0, 0), 3), ((255, 255, 255), 1)):
                cv.putText(drawn, text, (u - 30, v), 0, 0.5, colour, thick, cv.LINE_AA)
    return np.asarray(drawn)


def _outline_rings(one: FoundObject) -> list[Floats]:
    if one.object.outline is None:
        return [object_rim(one.object)]
    rings = one.object.outline.rings
    return [np.column_stack([ring, np.zeros(len(ring))]) for ring in rings]


def _line_points(line: Line) -> Floats:
    """Points along a line, its arcs by chords."""
    points = [line.points[:1]]
    for i in range(1, len(line.points)):
        if i in line.vias:
            continue
        if i - 1 in line.vias:
            a, b, c = line.points[i - 2 : i + 1]
            t = np.linspace(0.0, 1.0, 24)[1:, None]
            # Through the middle by a parabola: near enough to be looked at.
            points.append((1 - t) * (1 - 2 * t) * a + 4 * t * (1 - t) * b + t * (2 * t - 1) * c)
        else:
            points.append(line.points[i : i + 1])
    return np.concatenate(points)


def _draw_axes(cv: ModuleType, drawn: Picture, camera: Camera, one: FoundObject) -> None:
    tips = np.vstack([np.zeros(3), AXIS_LENGTH * np.eye(3)])
    seen = camera.project(one.pose.moved(tips))
    for number, colour in enumerate(AXIS_COLOURS, 1):
        _draw_polygon(cv, drawn, seen[[0, number]], colour, closed=False)


def _draw_polygon(
    cv: ModuleType,
    drawn: Picture,
    pixels: Floats,
    colour: tuple[int, int, int],
    *,
    closed: bool,
) -> None:
    if np.isfinite(pixels).all():
        whole = np.rint(pixels * (1 << SUBPIXEL_BITS)).astype(np.int32)
        cv.polylines(drawn, [whole], closed, colour, 2, cv.LINE_AA, SUBPIXEL_BITS)
